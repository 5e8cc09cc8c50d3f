//! Fuzzes `identification.json` and `validation.json`: comparison, exports, samples.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::results::read_identification;

fuzz_target!(|data: &[u8]| read_identification(data));
