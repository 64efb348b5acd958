//! How a field is written in text: fields apart by blanks, records by line ends, comments after `#`.

use super::Why;
use super::block::Block;
use super::digits::{leading_decimal, leading_whole};
use super::excerpt::{clipped, cut};
use super::source::{Fault, Layout, Listed, Source};
use crate::camera::Model;
use crate::scene::{ImageId, Point3DId, SensorKind};

/// Whole records of a text file, or the file's start or end.
pub struct Text<'a> {
    bytes: &'a [u8],
    /// Where in the file the bytes start.
    offset: usize,
    /// The byte to read next, and the start of the field read last, counted from the start of the bytes.
    at: usize,
    mark: usize,
}

/// Some editors put this in front of UTF-8.
pub const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

impl<'a> Text<'a> {
    /// Text from this block.
    pub fn new(block: &'a Block) -> Result<Self, Fault> {
        let (bytes, offset) = (&block.bytes[..], block.offset);
        if offset == 0 && (bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff")) {
            return Err(Fault::new(0, Why::Utf16));
        }
        let has_mark = offset == 0 && bytes.starts_with(BYTE_ORDER_MARK);
        let at = if has_mark { BYTE_ORDER_MARK.len() } else { 0 };
        Ok(Self { bytes, offset, at, mark: at })
    }

    /// What is left of the bytes.
    #[inline]
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// This reason, at the byte to read next.
    #[cold]
    fn fault_here(&self, why: Why) -> Fault {
        Fault::new(self.offset + self.at, why)
    }

    /// Goes to the next byte that is no blank; none at the end of the line or of the file.
    #[inline]
    fn skip_blanks(&mut self) -> Option<u8> {
        while let Some(&byte) = self.bytes.get(self.at) {
            if !byte.is_ascii_whitespace() {
                return Some(byte);
            }
            if byte == b'\n' {
                break;
            }
            self.at += 1;
        }
        None
    }

    /// Goes past this line's end; false when the bytes end first.
    fn skip_line(&mut self) -> bool {
        let length = memchr::memchr(b'\n', self.rest());
        self.at += length.map_or(self.rest().len(), |length| length + 1);
        length.is_some()
    }

    /// The line's next field, if it has one.
    fn next_token(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks()?;
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.mark = self.at;
        self.at += length;
        Some(&rest[..length])
    }

    fn token(&mut self, field: &'static str) -> Result<&'a [u8], Fault> {
        self.next_token().ok_or_else(|| self.fault_here(Why::Missing(field)))
    }

    /// The next field, if it is at most one space away and this reads it from the bytes ahead.
    #[inline(always)]
    fn quickly<T>(&mut self, read: impl Fn(&[u8]) -> Option<(T, usize)>) -> Option<T> {
        let start = self.at + usize::from(self.bytes.get(self.at) == Some(&b' '));
        let (value, length) = read(&self.bytes[start..])?;
        self.mark = start;
        self.at = start + length;
        Some(value)
    }

    /// A whole number of a type that ends at `max`.
    #[inline(always)]
    fn whole<T: TryFrom<u64>>(&mut self, field: &'static str, max: u64) -> Result<T, Fault> {
        let read = |ahead: &[u8]| {
            let (number, length) = leading_whole(ahead)?;
            Some((T::try_from(number).ok()?, length))
        };
        match self.quickly(read) {
            Some(number) => Ok(number),
            None => self.whole_from_token(field, max),
        }
    }

    #[cold]
    fn whole_from_token<T: TryFrom<u64>>(
        &mut self,
        field: &'static str,
        max: u64,
    ) -> Result<T, Fault> {
        let token = self.token(field)?;
        let number = parse_whole(token).and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| self.fault(why_not_whole(field, token, max)))
    }

    #[cold]
    fn f64_from_token(&mut self, field: &'static str) -> Result<f64, Fault> {
        let token = self.token(field)?;
        match std::str::from_utf8(token).map(str::parse::<f64>) {
            Ok(Ok(number)) if number.is_finite() => Ok(number),
            Ok(Ok(_)) => Err(self.fault(Why::NotFinite { field, text: clipped(token) })),
            _ => Err(self.fault(Why::NotANumber { field, text: clipped(token) })),
        }
    }

    /// COLMAP writes -1 for none; other programs write 2^64 - 1.
    #[cold]
    fn point_from_token(&mut self, field: &'static str) -> Result<Option<Point3DId>, Fault> {
        let token = self.token(field)?;
        match parse_whole(token) {
            Some(u64::MAX) => Ok(None),
            Some(id) => Ok(Some(Point3DId(id))),
            None if token == b"-1" => Ok(None),
            None => Err(self.fault(why_not_whole(field, token, u64::MAX - 1))),
        }
    }

    /// How many fields the line has from this byte on, and where field number `index` of them starts; the cursor stays.
    fn count_fields(&self, from: usize, index: usize) -> (usize, usize) {
        let mut ahead = Text { at: from, ..*self };
        let (mut count, mut start) = (0, from);
        while ahead.next_token().is_some() {
            if count == index {
                start = ahead.mark;
            }
            count += 1;
        }
        (count, start)
    }

    /// That the list which starts here does not come out even, if so: then its fields are not what they seem.
    #[cold]
    fn unevenness(&self, start: usize, listed: &Listed) -> Option<Fault> {
        let (items, each) = (listed.name, listed.fields);
        let (fields, _) = self.count_fields(start, 0);
        let (_, odd_one) = self.count_fields(start, fields - fields % each);
        let why = Why::Uneven { items, fields, each };
        (fields % each != 0).then(|| Fault::new(self.offset + odd_one, why))
    }
}

impl Source for Text<'_> {
    fn next_record(&mut self, _: &Listed) -> Result<bool, Fault> {
        loop {
            match self.skip_blanks() {
                Some(b'#') => _ = self.skip_line(),
                Some(_) => return Ok(true),
                None if self.at < self.bytes.len() => self.at += 1,
                None => return Ok(false),
            }
        }
    }

    fn skip_record(&mut self, layout: &Layout) -> bool {
        let starts = matches!(self.next_record(&layout.records), Ok(true));
        starts && (0..layout.lines).all(|_| self.skip_line())
    }

    fn records_left(&self) -> Option<usize> {
        None
    }

    fn at(&self) -> usize {
        self.at
    }

    fn mark(&self) -> usize {
        self.offset + self.mark
    }

    fn u8(&mut self, field: &'static str) -> Result<u8, Fault> {
        self.whole(field, u8::MAX.into())
    }

    #[inline(always)]
    fn u32(&mut self, field: &'static str) -> Result<u32, Fault> {
        self.whole(field, u32::MAX.into())
    }

    fn u64(&mut self, field: &'static str) -> Result<u64, Fault> {
        self.whole(field, u64::MAX)
    }

    #[inline(always)]
    fn f64(&mut self, field: &'static str) -> Result<f64, Fault> {
        match self.quickly(leading_decimal) {
            Some(number) => Ok(number),
            None => self.f64_from_token(field),
        }
    }

    fn model(&mut self) -> Result<&'static Model, Fault> {
        let name = cut(self.token("camera model")?);
        Model::named(&name).map_err(|error| self.fault(Why::Camera(error.into())))
    }

    fn param_count(&mut self, _: &Model) -> usize {
        self.count_fields(self.at, 0).0
    }

    fn sensor_kind(&mut self) -> Result<SensorKind, Fault> {
        match self.token("sensor type")? {
            b"CAMERA" => Ok(SensorKind::Camera),
            b"IMU" => Ok(SensorKind::Imu),
            other => Err(self.fault(Why::SensorKind(clipped(other)))),
        }
    }

    /// With its blanks: COLMAP itself would cut the name at the first one.
    fn name(&mut self, field: &'static str) -> Result<&str, Fault> {
        if self.skip_blanks().is_none() {
            return Err(self.fault_here(Why::Missing(field)));
        }
        let rest = self.rest();
        let length = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        self.mark = self.at;
        self.at += length;
        let name = rest[..length].trim_ascii_end();
        std::str::from_utf8(name)
            .map_err(|error| Fault::new(self.mark() + error.valid_up_to(), Why::NotUtf8(field)))
    }

    #[inline(always)]
    fn point(&mut self, field: &'static str) -> Result<Option<Point3DId>, Fault> {
        let read = |ahead: &[u8]| match ahead {
            [b'-', b'1', blank, ..] if blank.is_ascii_whitespace() => Some((None, 2)),
            _ => leading_whole(ahead).map(|(id, length)| (Some(Point3DId(id)), length)),
        };
        match self.quickly(read) {
            Some(point) => Ok(point),
            None => self.point_from_token(field),
        }
    }

    fn second_line(&mut self, image: ImageId) -> Result<(), Fault> {
        _ = self.skip_line();
        if self.rest().is_empty() { Err(self.fault_here(Why::NoSecondLine(image))) } else { Ok(()) }
    }

    #[inline]
    fn items(
        &mut self,
        listed: &Listed,
        mut read: impl FnMut(&mut Self, usize) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let start = self.at;
        let mut index = 0;
        while self.skip_blanks().is_some() {
            read(self, index).map_err(|fault| self.unevenness(start, listed).unwrap_or(fault))?;
            index += 1;
        }
        Ok(())
    }

    fn end_record(&mut self) -> Result<(), Fault> {
        match self.next_token() {
            Some(token) => Err(self.fault(Why::TrailingText(clipped(token)))),
            None => Ok(()),
        }
    }
}

/// A number of digits alone, if it fits.
fn parse_whole(token: &[u8]) -> Option<u64> {
    let mut number = 0_u64;
    for byte in token {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        number = number.checked_mul(10)?.checked_add(digit.into())?;
    }
    (!token.is_empty()).then_some(number)
}

#[cold]
fn why_not_whole(field: &'static str, token: &[u8], max: u64) -> Why {
    let text = clipped(token);
    let is_number = |digits: &[u8]| !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    match token.strip_prefix(b"-") {
        Some(digits) if is_number(digits) => Why::Negative { field, text },
        None if is_number(token) => Why::TooLarge { field, text, max },
        _ => Why::NotWhole { field, text },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: Listed = Listed { name: "pairs", count: "count", fields: 2, min_bytes: 2 };

    fn block(bytes: impl AsRef<[u8]>) -> Block {
        let bytes = bytes.as_ref().to_vec();
        Block { file_length: bytes.len(), bytes, ..Block::default() }
    }

    fn numbers(line: &str) -> Vec<f64> {
        let block = block(line);
        let mut text = Text::new(&block).unwrap();
        let (count, _) = text.count_fields(0, 0);
        (0..count).map(|_| text.f64("number").unwrap()).collect()
    }

    #[test]
    fn numbers_are_read_to_the_last_bit_in_every_notation() {
        let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        let read =
            numbers("6.4e2 1.5e-002 +3 -0 .5 5. 1E3 0.1 9007199254740993 4.9406564584124654e-324");
        let wanted = vec![
            640.0,
            0.015,
            3.0,
            -0.0,
            0.5,
            5.0,
            1000.0,
            0.1,
            9007199254740992.0,
            f64::from_bits(1),
        ];
        assert_eq!(bits(read), bits(wanted));
    }

    #[test]
    fn comments_blank_lines_tabs_and_line_ends_of_any_kind_are_passed_over() {
        let block = block(b"\xef\xbb\xbf# 9\r\n\r\n  \t\n \t1\t2 \r\n  # 9 9\n3 4");
        let mut text = Text::new(&block).unwrap();
        let mut read = Vec::new();
        while text.next_record(&LIST).unwrap() {
            read.push((text.u64("a").unwrap(), text.u64("b").unwrap()));
            text.end_record().unwrap();
        }
        assert_eq!(read, [(1, 2), (3, 4)]);
    }

    #[test]
    fn a_name_is_all_that_is_left_of_the_line() {
        let block = block("7  my photos/a b.jpg \r\n\r\n8");
        let mut text = Text::new(&block).unwrap();
        assert_eq!(text.u8("id").unwrap(), 7);
        assert_eq!(text.name("name").unwrap(), "my photos/a b.jpg");
        text.second_line(ImageId(7)).unwrap();
        text.items(&LIST, |_, _| panic!("an item on an empty line")).unwrap();
        text.end_record().unwrap();
        assert!(text.next_record(&LIST).unwrap());
        assert_eq!(text.u8("id").unwrap(), 8);
    }

    #[test]
    fn no_point_is_minus_one_or_two_to_the_64_minus_one() {
        let block = block("-1 18446744073709551615 0 18446744073709551614");
        let mut text = Text::new(&block).unwrap();
        let points: Vec<_> = (0..4).map(|_| text.point("point").unwrap()).collect();
        assert_eq!(points, [None, None, Some(Point3DId(0)), Some(Point3DId(u64::MAX - 1))]);
    }

    #[test]
    fn whole_numbers_end_where_their_type_does() {
        let read = |token: &str| Text::new(&block(token)).unwrap().u32("id").map_err(|f| *f.why);
        assert_eq!(read("4294967295"), Ok(u32::MAX));
        let why = |token: &str| read(token).unwrap_err();
        let (field, max) = ("id", u64::from(u32::MAX));
        for text in ["4294967296", "99999999999999999999999"].map(str::to_owned) {
            assert_eq!(why(&text), Why::TooLarge { field, text: text.clone(), max });
        }
        for text in ["-1", "-99999999999999999999999"].map(str::to_owned) {
            assert_eq!(why(&text), Why::Negative { field, text: text.clone() });
        }
        for text in ["-", "+1", "0x1", "1.", "1e3", "1_0", "١"].map(str::to_owned) {
            assert_eq!(why(&text), Why::NotWhole { field, text: text.clone() });
        }
    }
}
