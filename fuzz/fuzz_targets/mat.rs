//! Fuzzes MATLAB files of versions 5 to 7.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::{keys::MATLAB, read_log};

fuzz_target!(|data: &[u8]| read_log(data, MATLAB));
