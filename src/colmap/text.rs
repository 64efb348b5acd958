//! How a field is written in text: fields apart by blanks, records by line ends, comments after `#`.

use super::Why;
use super::excerpt::{clipped, cut};
use super::source::{Fault, Listed, Source};
use crate::camera::Model;
use crate::scene::{ImageId, Point3DId, SensorKind};

/// A text file, read from its start to its end.
pub struct Text<'a> {
    bytes: &'a [u8],
    /// The byte to read next.
    at: usize,
    mark: usize,
}

/// Some editors put this in front of UTF-8.
pub const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

impl<'a> Text<'a> {
    /// Text from these bytes.
    pub fn new(bytes: &'a [u8]) -> Result<Self, Fault> {
        if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
            return Err(Fault::new(0, Why::Utf16));
        }
        let at = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
        Ok(Self { bytes, at, mark: at })
    }

    /// Goes to the next byte that is no blank; none at the end of the line or of the file.
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

    /// Goes past this line's end; false when the file ends here.
    fn skip_line(&mut self) -> bool {
        match self.bytes[self.at..].iter().position(|&byte| byte == b'\n') {
            Some(length) => self.at += length + 1,
            None => self.at = self.bytes.len(),
        }
        self.at < self.bytes.len()
    }

    /// The line's next field, if it has one.
    fn next_token(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks()?;
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.mark = self.at;
        self.at += length;
        Some(&rest[..length])
    }

    fn token(&mut self, field: &'static str) -> Result<&'a [u8], Fault> {
        self.next_token().ok_or_else(|| Fault::new(self.at, Why::Missing(field)))
    }

    /// A whole number of a type that ends at `max`.
    fn whole<T: TryFrom<u64>>(&mut self, field: &'static str, max: u64) -> Result<T, Fault> {
        let token = self.token(field)?;
        let number = parse_whole(token).and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| self.fault(why_not_whole(field, token, max)))
    }

    /// How many fields the line has left, and where field number `index` of them starts; the cursor stays.
    fn count_fields(&self, index: usize) -> (usize, usize) {
        let mut ahead = Text { ..*self };
        let (mut count, mut start) = (0, self.at);
        while ahead.next_token().is_some() {
            if count == index {
                start = ahead.mark;
            }
            count += 1;
        }
        (count, start)
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

    fn mark(&self) -> usize {
        self.mark
    }

    fn u8(&mut self, field: &'static str) -> Result<u8, Fault> {
        self.whole(field, u8::MAX.into())
    }

    fn u32(&mut self, field: &'static str) -> Result<u32, Fault> {
        self.whole(field, u32::MAX.into())
    }

    fn u64(&mut self, field: &'static str) -> Result<u64, Fault> {
        self.whole(field, u64::MAX)
    }

    fn f64(&mut self, field: &'static str) -> Result<f64, Fault> {
        let token = self.token(field)?;
        match std::str::from_utf8(token).map(str::parse::<f64>) {
            Ok(Ok(number)) if number.is_finite() => Ok(number),
            Ok(Ok(_)) => Err(self.fault(Why::NotFinite { field, text: clipped(token) })),
            _ => Err(self.fault(Why::NotANumber { field, text: clipped(token) })),
        }
    }

    fn model(&mut self) -> Result<&'static Model, Fault> {
        let name = cut(self.token("camera model")?);
        Model::named(&name).map_err(|error| self.fault(Why::Camera(error)))
    }

    fn param_count(&mut self, _: &Model) -> usize {
        self.count_fields(0).0
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
            return Err(Fault::new(self.at, Why::Missing(field)));
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.mark = self.at;
        self.at += length;
        let name = rest[..length].trim_ascii_end();
        std::str::from_utf8(name)
            .map_err(|error| Fault::new(self.mark + error.valid_up_to(), Why::NotUtf8(field)))
    }

    /// COLMAP writes -1 for none; other programs write 2^64 - 1.
    fn point(&mut self, field: &'static str) -> Result<Option<Point3DId>, Fault> {
        let token = self.token(field)?;
        match parse_whole(token) {
            Some(u64::MAX) => Ok(None),
            Some(id) => Ok(Some(Point3DId(id))),
            None if token == b"-1" => Ok(None),
            None => Err(self.fault(why_not_whole(field, token, u64::MAX - 1))),
        }
    }

    fn second_line(&mut self, image: ImageId) -> Result<(), Fault> {
        if self.skip_line() { Ok(()) } else { Err(Fault::new(self.at, Why::NoSecondLine(image))) }
    }

    fn list(&mut self, listed: &Listed) -> Result<usize, Fault> {
        let each = listed.fields;
        let (fields, _) = self.count_fields(0);
        if fields % each != 0 {
            let (_, odd_one) = self.count_fields(fields - fields % each);
            return Err(Fault::new(odd_one, Why::Uneven { items: listed.name, fields, each }));
        }
        Ok(fields / each)
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

    fn numbers(line: &str) -> Vec<f64> {
        let mut text = Text::new(line.as_bytes()).unwrap();
        let (count, _) = text.count_fields(0);
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
        let bytes = b"\xef\xbb\xbf# 9\r\n\r\n  \t\n \t1\t2 \r\n  # 9 9\n3 4";
        let mut text = Text::new(bytes).unwrap();
        let mut read = Vec::new();
        while text.next_record(&LIST).unwrap() {
            read.push((text.u64("a").unwrap(), text.u64("b").unwrap()));
            text.end_record().unwrap();
        }
        assert_eq!(read, [(1, 2), (3, 4)]);
    }

    #[test]
    fn a_name_is_all_that_is_left_of_the_line() {
        let mut text = Text::new(b"7  my photos/a b.jpg \r\n\r\n8").unwrap();
        assert_eq!(text.u8("id").unwrap(), 7);
        assert_eq!(text.name("name").unwrap(), "my photos/a b.jpg");
        text.second_line(ImageId(7)).unwrap();
        assert_eq!(text.list(&LIST).unwrap(), 0);
        text.end_record().unwrap();
        assert!(text.next_record(&LIST).unwrap());
        assert_eq!(text.u8("id").unwrap(), 8);
    }

    #[test]
    fn no_point_is_minus_one_or_two_to_the_64_minus_one() {
        let mut text = Text::new(b"-1 18446744073709551615 0 18446744073709551614").unwrap();
        let points: Vec<_> = (0..4).map(|_| text.point("point").unwrap()).collect();
        assert_eq!(points, [None, None, Some(Point3DId(0)), Some(Point3DId(u64::MAX - 1))]);
    }

    #[test]
    fn whole_numbers_end_where_their_type_does() {
        let read = |token: &str| Text::new(token.as_bytes()).unwrap().u32("id").map_err(|f| *f.why);
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
