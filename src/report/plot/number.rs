//! Numbers as a reader of plots wants them: few digits, a real minus sign, powers of ten as such.

/// The value with this many significant digits.
pub fn significant(value: f64, digits: usize) -> String {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = text.split_once('e') else { return minus(&text) };
    let Ok(exponent) = exponent.parse::<i32>() else { return minus(&text) };
    if !(-4..7).contains(&exponent) {
        let mantissa = if exponent == 0 {
            mantissa.to_owned()
        } else {
            format!("{mantissa}×{}", power(exponent))
        };
        return minus(&mantissa);
    }
    let wanted = i32::try_from(digits).unwrap_or(i32::MAX) - 1 - exponent;
    fixed(value, usize::try_from(wanted).unwrap_or(0))
}

/// The value in full where that is short, else with six significant digits.
pub fn short(value: f64) -> String {
    const SHORT: usize = 9;
    let full = format!("{value}");
    if full.len() <= SHORT { minus(&full) } else { significant(value, 6) }
}

/// The value with this many decimals.
pub fn fixed(value: f64, decimals: usize) -> String {
    minus(&format!("{value:.decimals$}"))
}

/// 10 to this power.
pub fn power(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁰',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// The text with spaces at which no line breaks: a number must not lose its name or its unit.
pub fn unbroken(text: &str) -> String {
    text.replace(' ', "\u{A0}")
}

fn minus(text: &str) -> String {
    let is_zero = !text.contains(|c: char| c.is_ascii_digit() && c != '0');
    let text = if is_zero { text.trim_start_matches('-') } else { text };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_kept_where_they_are_zero() {
        let cases = [
            (149.03, "149.0"),
            (-0.01759, "−0.01759"),
            (3890.4, "3890"),
            (0.0, "0.000"),
            (-0.0, "0.000"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value, 4), text);
        }
        assert_eq!(significant(1.5e-9, 3), "1.50×10⁻⁹");
        assert_eq!(significant(-2.25e12, 3), "−2.25×10¹²");
    }

    #[test]
    fn short_numbers_are_exact() {
        assert_eq!(
            [376.0, 376.5, -0.27, 1.0 / 3.0].map(short),
            ["376", "376.5", "−0.27", "0.333333"]
        );
    }
}
