//! Numbers as COLMAP writes them, read eight digits at a time.
//!
//! Knows `123`, `-0.5`, `1234.5678901234567`; of every other notation it says nothing, and the long way through `str::parse`
//! decides. What it does say is what `str::parse` says, to the last bit.

/// The whole number that these bytes start with, and its length; none unless it has at most 15 digits and a blank follows.
#[inline(always)]
pub fn leading_whole(bytes: &[u8]) -> Option<(u64, usize)> {
    let first = Digits::at(bytes, 0)?;
    if first.count < CHUNK {
        return (first.count > 0 && first.is_blank_next()).then_some((first.value, first.count));
    }
    let rest = Digits::at(bytes, CHUNK)?;
    let number = first.value * POWERS_OF_TEN[rest.count] + rest.value;
    rest.is_blank_next().then_some((number, CHUNK + rest.count))
}

/// The decimal number that these bytes start with, and its length; none unless it is short, has no exponent, a blank follows,
/// and it is plain to which `f64` it rounds.
#[inline(always)]
pub fn leading_decimal(bytes: &[u8]) -> Option<(f64, usize)> {
    let is_negative = *bytes.first()? == b'-';
    let whole_at = usize::from(is_negative);
    let whole = Digits::at(bytes, whole_at)?;
    if whole.count == 0 || whole.count == CHUNK {
        return None;
    }
    let fraction_at = whole_at + whole.count + 1;
    let (number, fraction_count) = if bytes[fraction_at - 1] == b'.' {
        fraction(bytes, fraction_at, whole)?
    } else {
        // As if the point that is not there had been stepped over.
        return whole
            .is_blank_next()
            .then(|| (signed(whole.value as f64, is_negative), fraction_at - 1));
    };
    let magnitude = over_power_of_ten(number, fraction_count)?;
    Some((signed(magnitude, is_negative), fraction_at + fraction_count))
}

/// The number without its point, and how many of its digits stood after it.
#[inline(always)]
fn fraction(bytes: &[u8], at: usize, whole: Digits) -> Option<(u64, usize)> {
    // Where a chunk starts depends on no chunk but the whole part, so that a processor reads them side by side.
    let first = Digits::at(bytes, at)?;
    if first.count < CHUNK {
        let is_number = first.count > 0 && first.is_blank_next();
        return is_number.then(|| (first.after(whole.value), first.count));
    }
    let second = Digits::at(bytes, at + CHUNK)?;
    let number = second.after(first.after(whole.value));
    let (number, count, last) = if second.count < CHUNK {
        (number, CHUNK + second.count, second)
    } else {
        let third = Digits::at(bytes, at + 2 * CHUNK)?;
        (third.after(number), 2 * CHUNK + third.count, third)
    };
    let digit_count = count + if whole.value == 0 { 0 } else { whole.count };
    (digit_count <= MOST_DIGITS && last.is_blank_next()).then_some((number, count))
}

#[inline(always)]
fn signed(magnitude: f64, is_negative: bool) -> f64 {
    f64::from_bits(magnitude.to_bits() | u64::from(is_negative) << 63)
}

/// Digits read at once.
const CHUNK: usize = 8;

/// All numbers of this many digits fit in 64 bits.
const MOST_DIGITS: usize = 19;

const POWERS_OF_TEN: [u64; CHUNK + 1] =
    [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Up to eight digits.
#[derive(Clone, Copy)]
struct Digits {
    value: u64,
    count: usize,
    /// The eight bytes, the first one lowest.
    bytes: u64,
}

impl Digits {
    /// The digits from here on; none at the very end of the bytes.
    #[inline(always)]
    fn at(bytes: &[u8], at: usize) -> Option<Self> {
        const EACH: u64 = 0x0101_0101_0101_0101;
        let bytes = u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?);
        let values = bytes ^ (EACH * 0x30);
        // A byte above 9 gets its highest bit set. It may carry, but only into bytes after the first such one.
        let others = (values.wrapping_add(EACH * (0x80 - 10)) | values) & (EACH * 0x80);
        let count = others.trailing_zeros() / 8;
        // The last digit to the highest byte: zeros come in at the front, and what follows the digits falls out.
        let values = values.unbounded_shl(64 - 8 * count);
        let pairs = values.wrapping_mul(10).wrapping_add(values >> 8);
        const PAIR: u64 = 0x0000_00ff_0000_00ff;
        let upper = (pairs & PAIR).wrapping_mul(100 + (1_000_000 << 32));
        let lower = (pairs >> 16 & PAIR).wrapping_mul(1 + (10_000 << 32));
        Some(Self { value: upper.wrapping_add(lower) >> 32, count: count as usize, bytes })
    }

    /// Whether the byte after the digits is one of the eight and a blank.
    #[inline(always)]
    fn is_blank_next(self) -> bool {
        self.count < CHUNK && (self.bytes.to_le_bytes()[self.count]).is_ascii_whitespace()
    }

    /// These digits written after a number.
    #[inline(always)]
    fn after(self, number: u64) -> u64 {
        number.wrapping_mul(POWERS_OF_TEN[self.count]).wrapping_add(self.value)
    }
}

/// `number / 10^power`, rounded to the nearest `f64`; none where rounding needs more digits than are computed here.
///
/// The method of D. Lemire, Number parsing at a gigabyte per second, 2021, without its second multiplication.
#[inline(always)]
fn over_power_of_ten(number: u64, power: usize) -> Option<f64> {
    if number >> f64::MANTISSA_DIGITS == 0 {
        // Both are exact, so the division rounds once. 10^22 is the last power that is.
        return Some(number as f64 / EXACT_POWERS_OF_TEN[power]);
    }
    // number = normal / 2^zeros, and 10^-power lies from factor / 2^scale up to (factor + 1) / 2^scale:
    // the quotient times 2^(zeros + scale - 64) lies from high up to high + 2. It has 63 or 64 bits, 10 or 11 too many.
    let zeros = number.leading_zeros();
    let Inverse { factor, scale } = INVERSES[power];
    let (_, high) = (number << zeros).carrying_mul(factor, 0);
    let spare = 10 + (high >> 63);
    let (rest, half) = (high & ((1 << spare) - 1), 1 << (spare - 1));
    if rest == half || rest + 1 == half {
        return None;
    }
    let mantissa = (high >> spare) + u64::from(rest > half);
    // The highest bit of the mantissa adds one to the exponent; so does another bit when it was rounded up to a power of two.
    let exponent = 1074 + 64 + spare - u64::from(zeros) - scale;
    Some(f64::from_bits((exponent << 52) + mantissa))
}

const EXACT_POWERS_OF_TEN: [f64; MOST_DIGITS + 1] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19,
];

/// 10^-power, cut off after 64 bits: `factor / 2^scale`.
#[derive(Clone, Copy)]
struct Inverse {
    factor: u64,
    scale: u64,
}

#[allow(clippy::cast_possible_truncation)] // the scale makes factors of 64 bits
const INVERSES: [Inverse; MOST_DIGITS + 1] = {
    // 10^0 is not needed: without a fraction there are fewer than eight digits.
    let mut inverses = [Inverse { factor: 0, scale: 0 }; MOST_DIGITS + 1];
    let (mut power, mut ten_to_the) = (1, 10_u128);
    while power <= MOST_DIGITS {
        let scale = 64 + ten_to_the.ilog2() as u64;
        inverses[power] = Inverse { factor: ((1 << scale) / ten_to_the) as u64, scale };
        (power, ten_to_the) = (power + 1, 10 * ten_to_the);
    }
    inverses
};

#[cfg(test)]
mod tests {
    use proptest::test_runner::{Config, TestRunner};

    use super::*;

    /// Whether the short way knew the field; what it says must be what std says.
    fn is_known(field: &str) -> bool {
        let line = format!("{field} 12345678");
        match leading_decimal(line.as_bytes()) {
            Some((number, length)) => {
                let wanted: f64 = field.parse().unwrap();
                assert_eq!((number.to_bits(), length), (wanted.to_bits(), field.len()), "{field}");
                true
            }
            None => false,
        }
    }

    #[test]
    fn decimals_as_colmap_writes_them_are_what_std_reads() {
        let mut runner = TestRunner::new_with_rng(
            Config { cases: 300_000, ..Config::default() },
            proptest::test_runner::TestRng::deterministic_rng(Default::default()),
        );
        let known = std::cell::Cell::new(0);
        let pixels = (-1e5..1e5, 0..18_usize);
        runner
            .run(&pixels, |(number, precision)| {
                known.set(known.get() + usize::from(is_known(&format!("{number:.precision$}"))));
                Ok(())
            })
            .unwrap();
        // All but those of 20 digits or more, and one in some hundreds whose rounding is not plain.
        assert!(known.get() > 250_000, "{}", known.get());
    }

    #[test]
    fn every_length_of_whole_and_fraction_is_what_std_reads() {
        let (digits, zeros, nines) = ("98765432109876543210987", "0".repeat(23), "9".repeat(23));
        let (mut checked, mut known) = (0, 0);
        for source in [digits, &zeros, &nines, &zeros.replace("0", "01")] {
            for whole in 0..=20 {
                for fraction in 0..=23 {
                    for sign in ["", "-", "+"] {
                        let field = format!("{sign}{}.{}", &source[..whole], &source[..fraction]);
                        known += usize::from(is_known(&field));
                        known += usize::from(is_known(field.trim_end_matches('.')));
                        checked += 2;
                    }
                }
            }
        }
        assert_eq!(checked, 4 * 21 * 24 * 3 * 2);
        // Whole parts of 1 to 7 digits, fractions of up to 19 less these, with and without minus.
        assert!(known > 4 * 7 * 12 * 2 * 2, "{known}");
    }

    /// Numbers half-way between two doubles, and those beside them, are where a wrong rounding shows.
    #[test]
    fn numbers_near_the_middle_of_two_doubles_are_what_std_reads() {
        let (mut checked, mut known) = (0, 0);
        for power in 1..=19 {
            for step in 0..20_000_u64 {
                let bits = 0x4000_0000_0000_0000_u64
                    + step.wrapping_mul(0x9e37_79b9_7f4a_7c15) % (1 << 55);
                let double = f64::from_bits(bits);
                let middle = double + (f64::from_bits(bits + 1) - double) / 2.0;
                let above = f64::from_bits(bits + 1);
                for number in [double, middle, above] {
                    let digits = format!("{number:.power$}");
                    known += usize::from(is_known(&digits));
                    checked += 1;
                }
                // What lies exactly in the middle, cut to 19 digits: the nearest decimals on both sides.
                let exact = exact_middle(bits);
                let kept: String = exact.chars().take(20.min(power + 2)).collect();
                known += usize::from(is_known(&kept));
                checked += 1;
            }
        }
        assert_eq!(checked, 19 * 20_000 * 4);
        assert!(known > checked / 2, "{known} of {checked}");
    }

    /// The decimal digits of the middle between this double, which is 2 or more, and the next one.
    #[allow(clippy::cast_possible_truncation)] // whole numbers that fit
    fn exact_middle(bits: u64) -> String {
        let double = f64::from_bits(bits);
        let unit = f64::from_bits(bits + 1) - double;
        let whole = double.trunc();
        // The rest is a multiple of 2^-53: in units of 2^-54 the middle is a whole number.
        let mut rest =
            ((double - whole) * 2.0_f64.powi(54)) as u128 + (unit * 2.0_f64.powi(53)) as u128;
        let mut text = format!("{whole}.");
        for _ in 0..20 {
            rest *= 10;
            text.push(char::from(b'0' + (rest >> 54) as u8));
            rest &= (1 << 54) - 1;
        }
        text
    }

    #[test]
    fn whole_numbers_are_known_up_to_fifteen_digits() {
        let known = |field: &str| leading_whole(format!("{field}\t12345678").as_bytes());
        let digits = "987654321098765432";
        for length in 1..=18 {
            let wanted = digits[..length].parse().ok().filter(|_| length < 16);
            assert_eq!(known(&digits[..length]), wanted.map(|number| (number, length)));
            let zeros = "0".repeat(length);
            assert_eq!(known(&zeros).is_some(), length < 16);
        }
        for field in ["", "-1", "+1", "1.", "1e3", "1_0", "12345678x", "1\u{661}"] {
            assert_eq!(known(field), None, "{field}");
        }
    }

    #[test]
    fn nothing_is_said_of_other_notations_nor_at_the_end_of_the_bytes() {
        let others = [
            "",
            "-",
            "+1",
            ".5",
            "5.",
            "-.5",
            "1e3",
            "1.5e-002",
            "1.5f",
            "0x1",
            "nan",
            "inf",
            "1,5",
            "1.2.3",
            "--1",
            "1.-2",
            "12345678",
            "0.12345678901234567890",
            "\u{661}",
            "1.\u{661}",
        ];
        for other in others {
            assert!(!is_known(other), "{other}");
        }
        for end in 0.."123.4567 1234567".len() {
            let bytes = &b"123.4567 1234567"[..end];
            assert!(
                leading_decimal(bytes)
                    .is_none_or(|(number, _)| number.to_bits() == 123.4567_f64.to_bits())
            );
        }
        assert_eq!(leading_decimal(b"7"), None);
        assert_eq!(leading_whole(b"7"), None);
    }
}
