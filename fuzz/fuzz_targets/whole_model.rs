//! Any bytes as all files of a model.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| calibstab_fuzz::whole_model(data));
