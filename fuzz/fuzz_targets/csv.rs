//! Any bytes as a table to be joined: an error or fields of a valid mesh, never a panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| impasto_fuzz::check_table(bytes));
