//! The colours of the plots.

use plotters_backend::{BackendColor, BackendStyle};

/// A colour, and how much of what lies below it is covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Color {
    rgb: (u8, u8, u8),
    alpha: f64,
}

/// Words, frames and medians.
pub const INK: Color = opaque(0x22, 0x22, 0x22);
/// What explains: notes, tick labels.
pub const GREY: Color = opaque(0x59, 0x59, 0x59);
/// Lines that only guide the eye.
pub const GUIDE: Color = opaque(0xE3, 0xE3, 0xE3);
/// The page.
pub const PAPER: Color = opaque(0xFF, 0xFF, 0xFF);

/// One a group, told apart by colour-blind readers: M. Okabe and K. Ito, Color Universal Design, 2008,
/// without its yellow, which white paper swallows.
pub const GROUPS: [Color; 7] = [
    opaque(0x00, 0x72, 0xB2),
    opaque(0xD5, 0x5E, 0x00),
    opaque(0x00, 0x9E, 0x73),
    opaque(0xCC, 0x79, 0xA7),
    opaque(0x56, 0xB4, 0xE9),
    opaque(0xE6, 0x9F, 0x00),
    opaque(0x00, 0x00, 0x00),
];

pub const fn opaque(red: u8, green: u8, blue: u8) -> Color {
    Color { rgb: (red, green, blue), alpha: 1.0 }
}

impl Color {
    /// This share of the way to another colour.
    pub fn toward(self, other: Self, share: f64) -> Self {
        let between = |from: u8, to: u8| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            // between two bytes
            let value = (f64::from(from) + share * (f64::from(to) - f64::from(from))).round() as u8;
            value
        };
        let ((r0, g0, b0), (r1, g1, b1)) = (self.rgb, other.rgb);
        Self { rgb: (between(r0, r1), between(g0, g1), between(b0, b1)), alpha: self.alpha }
    }

    /// CIE 1976 L*: 0 is black, 100 is paper.
    pub fn lightness(self) -> f64 {
        let linear = |byte: u8| {
            let value = f64::from(byte) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        let (red, green, blue) = self.rgb;
        let luminance = 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue);
        if luminance <= 216.0 / 24389.0 {
            luminance * 24389.0 / 27.0
        } else {
            116.0 * luminance.cbrt() - 16.0
        }
    }

    /// The same colour, letting light through.
    pub fn faded(self, alpha: f64) -> Self {
        Self { alpha: self.alpha * alpha, ..self }
    }
}

impl BackendStyle for Color {
    fn color(&self) -> BackendColor {
        BackendColor { alpha: self.alpha, rgb: self.rgb }
    }
}
