//! Fuzzes `experiment.toml`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::read_experiment;

fuzz_target!(|data: &[u8]| read_experiment(data));
