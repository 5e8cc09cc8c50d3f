//! Fuzzes factors of logs, which many machines exchange.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::results::read_factors;

fuzz_target!(|data: &[u8]| read_factors(data));
