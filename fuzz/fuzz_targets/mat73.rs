//! Fuzzes MATLAB files of version 7.3.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::{keys::MATLAB, read_log_file};

fuzz_target!(|data: &[u8]| read_log_file(data, MATLAB));
