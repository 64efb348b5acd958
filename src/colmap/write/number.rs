//! A double as COLMAP prints it: C's `%.17g`, by which every double comes back to the last bit.

use std::io::{self, Write};

/// Digits that tell any two doubles apart.
const DIGITS: usize = 17;
/// `%g` turns to an exponent below this power of ten, and from `DIGITS` on.
const LEAST_POWER: i32 = -4;
/// Room for the longest number with so many digits: 1.2345678901234567e-308.
const LONGEST: usize = 24;

/// Appends a finite number as `%.17g` does: 0.1 is 0.10000000000000001, 1e-5 is 1.0000000000000001e-05.
pub fn push_17_digits(out: &mut Vec<u8>, value: f64) -> io::Result<()> {
    let mut buffer = [0; LONGEST];
    let mut free = &mut buffer[..];
    write!(free, "{:.*e}", DIGITS - 1, value.abs())?;
    let length = LONGEST - free.len();
    // One digit, the point, all other digits, e, the power of ten.
    let not_finite = || io::Error::other(format!("{value} is not a finite number"));
    let at_e = buffer[..length].iter().position(|&byte| byte == b'e').ok_or_else(not_finite)?;
    let power = std::str::from_utf8(&buffer[at_e + 1..length]).map_err(io::Error::other)?;
    let power: i32 = power.parse().map_err(io::Error::other)?;
    let mut digits = [0; DIGITS];
    digits[0] = buffer[0];
    digits[1..].copy_from_slice(&buffer[2..at_e]);
    let zeros = digits.iter().rev().take_while(|&&digit| digit == b'0').count();
    let digits = &digits[..(DIGITS - zeros).max(1)];
    if value.is_sign_negative() {
        out.push(b'-');
    }
    match usize::try_from(power) {
        Ok(power) if power < DIGITS => push_above_one(out, digits, power),
        Err(_) if power >= LEAST_POWER => {
            out.extend_from_slice(b"0.");
            out.extend((power + 1..0).map(|_| b'0'));
            out.extend_from_slice(digits);
        }
        _ => {
            push_above_one(out, digits, 0);
            let sign = if power < 0 { '-' } else { '+' };
            write!(out, "e{sign}{:02}", power.abs())?;
        }
    }
    Ok(())
}

/// The digits with the point after the one of this power of ten.
fn push_above_one(out: &mut Vec<u8>, digits: &[u8], power: usize) {
    let whole = digits.len().min(power + 1);
    out.extend_from_slice(&digits[..whole]);
    out.extend((whole..=power).map(|_| b'0'));
    if whole < digits.len() {
        out.push(b'.');
        out.extend_from_slice(&digits[whole..]);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn shown(value: f64) -> String {
        let mut out = Vec::new();
        push_17_digits(&mut out, value).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// What the C library prints for `%.17g`.
    #[test]
    fn numbers_look_as_c_prints_them() {
        let cases = [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (-640.0, "-640"),
            (0.1, "0.10000000000000001"),
            (0.5, "0.5"),
            (-2.25, "-2.25"),
            (100.5, "100.5"),
            (1e-4, "0.0001"),
            (0.00012345, "0.00012344999999999999"),
            (f64::from_bits(0x3f1a_36e2_eb1c_432c), "9.9999999999999991e-05"),
            (1e-5, "1.0000000000000001e-05"),
            (1e16, "10000000000000000"),
            (12345678901234568.0, "12345678901234568"),
            (1e17, "1e+17"),
            (123456789012345680.0, "1.2345678901234568e+17"),
            // Halfway between two numbers of 17 digits: the even one.
            (1125899906842625.0 + 0.25, "1125899906842625.2"),
            (1125899906842625.0 + 0.75, "1125899906842625.8"),
            (1e22, "1e+22"),
            (1e308, "1e+308"),
            (f64::MAX, "1.7976931348623157e+308"),
            (f64::MIN_POSITIVE, "2.2250738585072014e-308"),
            (f64::from_bits(1), "4.9406564584124654e-324"),
            (-1.0 / 3.0, "-0.33333333333333331"),
        ];
        for (value, want) in cases {
            assert_eq!(shown(value), want, "{value:e}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(push_17_digits(&mut Vec::new(), value).is_err());
        }
    }

    proptest! {
        #[test]
        fn every_double_comes_back_to_the_last_bit(bits: u64) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(shown(value).parse::<f64>().unwrap().to_bits(), bits);
        }
    }
}
