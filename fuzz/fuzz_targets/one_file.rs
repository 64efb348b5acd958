//! Any bytes as one file of a model whose other files are sound.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| calibstab_fuzz::one_file(data));
