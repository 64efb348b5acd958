//! Files made to break the readers: damaged at random, or found by the fuzzer.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod corpus;
mod holds;
mod memory;
mod mutants;
mod mutation;
mod random;
