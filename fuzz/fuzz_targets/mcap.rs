//! Fuzzes MCAP bags.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::{keys::TOPICS, read_log};

fuzz_target!(|data: &[u8]| read_log(data, TOPICS));
