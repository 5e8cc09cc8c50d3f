//! Fuzzes a definition of ROS messages, and messages in CDR.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::{bag_of, keys::STATES, read_log};

fuzz_target!(|data: &[u8]| read_log(&bag_of(data), STATES));
