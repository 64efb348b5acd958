//! Ways to damage a file.

use crate::random::Random;

/// Damages a file in one way.
type Mutation = fn(&mut Vec<u8>, &mut Random);

/// All of them; binary files have no words or lines to speak of, and suffer from what is meant for them all the same.
pub const MUTATIONS: &[(&str, Mutation)] = &[
    ("flip a bit", |file, random| {
        if let Some(byte) = any_byte(file, random) {
            *byte ^= 1 << random.below(8);
        }
    }),
    ("set a byte", |file, random| {
        let value = random.number().to_le_bytes()[0];
        if let Some(byte) = any_byte(file, random) {
            *byte = value;
        }
    }),
    ("delete a piece", |file, random| {
        let piece = random.piece(file.len(), 24);
        file.drain(piece);
    }),
    ("insert bytes", |file, random| {
        let at = random.below(file.len() + 1);
        let count = 1 + random.below(8);
        let bytes: Vec<u8> = (0..count).map(|_| random.number().to_le_bytes()[0]).collect();
        file.splice(at..at, bytes);
    }),
    ("copy a piece", |file, random| {
        let piece = random.piece(file.len(), 100);
        let piece = file[piece].to_vec();
        let at = random.below(file.len() + 1);
        file.splice(at..at, piece);
    }),
    ("cut the end off", |file, random| file.truncate(random.below(file.len() + 1))),
    ("double the file", |file, _| file.extend_from_within(..)),
    ("empty the file", |file, _| file.clear()),
    ("swap two lines", |file, random| {
        let lines = lines(file);
        let (one, other) = (random.below(lines.len()), random.below(lines.len()));
        let mut order: Vec<usize> = (0..lines.len()).collect();
        order.swap(one, other);
        *file = order.into_iter().flat_map(|index| lines[index].clone()).collect();
    }),
    ("delete a line", |file, random| {
        let mut lines = lines(file);
        lines.remove(random.below(lines.len()));
        *file = lines.concat();
    }),
    ("repeat a line", |file, random| {
        let mut lines = lines(file);
        let line = random.pick(&lines).clone();
        lines.insert(random.below(lines.len() + 1), line);
        *file = lines.concat();
    }),
    ("replace a word", |file, random| replace_word(file, random.pick(WORDS).as_bytes(), random)),
    ("replace a word by another of the file", |file, random| {
        let words: Vec<&[u8]> = file.split(u8::is_ascii_whitespace).collect();
        let word = random.pick(&words).to_vec();
        replace_word(file, &word, random);
    }),
    ("change a digit", |file, random| {
        let digit = b'0' + u8::try_from(random.below(10)).unwrap();
        let places: Vec<usize> = (0..file.len()).filter(|&at| file[at].is_ascii_digit()).collect();
        if !places.is_empty() {
            file[*random.pick(&places)] = digit;
        }
    }),
    ("overwrite four bytes", |file, random| {
        let count = *random.pick(&[0, 1, 2, 1 << 16, 1 << 31, u32::MAX - 1, u32::MAX]);
        overwrite(file, &count.to_le_bytes(), random);
    }),
    ("overwrite eight bytes", |file, random| {
        let bits = *random.pick(EIGHT_BYTES);
        overwrite(file, &bits.to_le_bytes(), random);
    }),
    ("replace what may be a count", |file, random| {
        let is_count =
            |file: &[u8], at: usize| file[at] > 0 && file[at + 2..at + 8].iter().all(|&b| b == 0);
        replace_count(file, is_count, random);
    }),
    ("replace the count after a name", |file, random| {
        let is_count = |file: &[u8], at: usize| {
            at > 1 && file[at - 1] == 0 && file[at - 2].is_ascii_alphabetic()
        };
        replace_count(file, is_count, random);
    }),
    ("announce more records", |file, random| {
        let count = *random.pick(EIGHT_BYTES);
        let end = file.len().min(8);
        file[..end].copy_from_slice(&count.to_le_bytes()[..end]);
    }),
];

const WORDS: &[&str] = &[
    "",
    "-",
    "-1",
    "0",
    "-0",
    "1",
    "2",
    "7",
    "nan",
    "-inf",
    "1e999",
    "1e-999",
    "1e308",
    "5e-324",
    "0x10",
    "1.5",
    "255",
    "256",
    "4294967294",
    "4294967295",
    "4294967296",
    "9223372036854775808",
    "18446744073709551614",
    "18446744073709551615",
    "18446744073709551616",
    "#",
    "CAMERA",
    "IMU",
    "OPENCV",
    "PINHOLE",
    "OPENCV_FISHEY",
    "RADTAN",
    "EQUIRECTANGULAR",
    "a b",
    "\u{feff}",
    "\0",
    "\r",
    "\n",
    "\n\n",
    "0.1000000000000000055511151231257827021181583404541015625",
];

/// Counts, ids, and doubles by their bits: infinity, NaN, -0, the smallest and the largest.
const EIGHT_BYTES: &[u64] = &[
    0,
    1,
    2,
    100,
    1_000,
    30_000,
    1 << 32,
    1 << 61,
    u64::MAX - 1,
    u64::MAX,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    1 << 63,
    0x7fef_ffff_ffff_ffff,
];

fn any_byte<'a>(file: &'a mut [u8], random: &mut Random) -> Option<&'a mut u8> {
    let at = random.below(file.len().max(1));
    file.get_mut(at)
}

/// The lines with their ends; at least one, though empty.
fn lines(file: &[u8]) -> Vec<Vec<u8>> {
    file.split_inclusive(|&byte| byte == b'\n')
        .map(<[u8]>::to_vec)
        .chain(file.is_empty().then(Vec::new))
        .collect()
}

/// Puts a word in place of one that is not in a comment above the records, if there is one.
fn replace_word(file: &mut Vec<u8>, word: &[u8], random: &mut Random) {
    let is_blank = |at: usize| file[at].is_ascii_whitespace();
    let starts: Vec<usize> =
        (0..file.len()).filter(|&at| !is_blank(at) && (at == 0 || is_blank(at - 1))).collect();
    if starts.is_empty() {
        return;
    }
    let start = *random.pick(&starts);
    let length = file[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
    file.splice(start..start + length, word.iter().copied());
}

/// Puts a count where, for all that its bytes tell, one is.
fn replace_count(file: &mut [u8], is_count: impl Fn(&[u8], usize) -> bool, random: &mut Random) {
    let places: Vec<usize> =
        (0..file.len().saturating_sub(7)).filter(|&at| is_count(file, at)).collect();
    if !places.is_empty() {
        let (at, count) = (*random.pick(&places), *random.pick(EIGHT_BYTES));
        file[at..at + 8].copy_from_slice(&count.to_le_bytes());
    }
}

fn overwrite(file: &mut [u8], bytes: &[u8], random: &mut Random) {
    if let Some(last) = file.len().checked_sub(bytes.len()) {
        let at = random.below(last + 1);
        file[at..at + bytes.len()].copy_from_slice(bytes);
    }
}
