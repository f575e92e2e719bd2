#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| clearway_fuzz_targets::mesh(bytes));
