//! Arrows over an image, and the round numbers by which they are drawn longer.

use super::axis::{decimal_exponent, decimal_number};
use super::color::Color;
use super::drawing::{Drawing, Point};
use super::number::significant;

/// What arrows are drawn longer by: these times a power of ten.
pub const FACTORS: [f64; 7] = [8.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0];

/// The number of one of these times a power of ten at or below this, with its label; the multiples go down to 1.
pub fn round_below(value: f64, multiples: &[f64]) -> (f64, String) {
    let exponent = decimal_exponent(value);
    let mut round = multiples.iter().map(|times| decimal_number(*times, exponent));
    let found = round.find(|round| *round <= value).unwrap_or(value);
    (found, significant(found, 1))
}

/// An arrow from here by so much; a dot where it would be shorter than its head is thick.
pub fn arrow(drawing: &mut Drawing, [x, y]: Point, [dx, dy]: Point, color: Color) {
    const HALF_SHAFT: f64 = 0.55;
    const HALF_HEAD: f64 = 2.4;
    const HEAD: f64 = 6.0;
    let length = dx.hypot(dy);
    if length < 2.0 * HALF_SHAFT {
        return drawing.disc([x, y], 2.0 * HALF_SHAFT, color);
    }
    let head = HEAD.min(0.6 * length);
    let half_head = HALF_HEAD * head / HEAD;
    let neck = length - head;
    let corner = |along: f64, across: f64| {
        let (ux, uy) = (dx / length, dy / length);
        [x + ux * along - uy * across, y + uy * along + ux * across]
    };
    let corners = [
        corner(0.0, HALF_SHAFT),
        corner(neck, HALF_SHAFT),
        corner(neck, half_head.max(HALF_SHAFT)),
        corner(length, 0.0),
        corner(neck, -half_head.max(HALF_SHAFT)),
        corner(neck, -HALF_SHAFT),
        corner(0.0, -HALF_SHAFT),
    ];
    drawing.area(&corners, color);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round_and_never_too_large() {
        for (value, label) in
            [(5.0, "5"), (4.9, "2"), (0.00123, "0.001"), (99.0, "50"), (100.0, "100"), (0.3, "0.2")]
        {
            assert_eq!(round_below(value, &[5.0, 2.0, 1.0]).1, label, "{value}");
        }
    }
}
