//! What the fuzzer feeds to the readers, and what must hold of it: the same as in the package's own tests.

#[path = "../../tests/hostile_files/holds.rs"]
mod holds;

pub use holds::{one_file, whole_model};
