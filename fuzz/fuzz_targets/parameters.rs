//! Fuzzes parameter files in TOML.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::results::read_parameters;

fuzz_target!(|data: &[u8]| read_parameters(data));
