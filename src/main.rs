//! The command line; `cli` is all of it.

fn main() {}
