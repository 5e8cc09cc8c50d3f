//! Fuzzes URDF files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::read_urdf;

fuzz_target!(|data: &[u8]| read_urdf(data));
