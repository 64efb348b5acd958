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

const fn opaque(red: u8, green: u8, blue: u8) -> Color {
    Color { rgb: (red, green, blue), alpha: 1.0 }
}

impl Color {
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
