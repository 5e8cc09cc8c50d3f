//! Fuzzes Arrow IPC, files and streams.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::{keys::USUAL, read_log};

fuzz_target!(|data: &[u8]| read_log(data, USUAL));
