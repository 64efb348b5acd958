//! The mathematics that lenses share: rays onto a plane, bending the plane, unbending it, plane to pixels.
//!
//! Everything comes with its derivatives, so that a model states its formula once.

mod angle;
mod bend;
mod division;
mod fold;
mod pixels;
mod plane;
mod unbend;
mod unified;

pub use bend::{
    Bent, brown, brown_at_once, decentring, grows, radial, radial_at_once, straight, unfolded,
};
pub use division::{division, division_angle, division_equation, undo_division};
pub use fold::{ENDLESS, fisheye_fold, largest, pinhole_fold};
pub use pixels::{Linearized, one_focal, two_focals, undo_one_focal, undo_two_focals};
pub use plane::{
    Seen, equidistant, equidistant_at_once, over, over_at_once, pinhole, pinhole_at_once,
    pinhole_behind, undo_equidistant, undo_equidistant_at_once,
};
pub use unbend::{unbend, unbend_brown_at_once, unbend_radial, unbend_radial_at_once};
pub use unified::{undo_unified, unified, unified_angle, unified_denominator};
