//! Damaged models: each damage is refused with its own reason, at its own place.

mod binary;
mod small_model;
mod text;
