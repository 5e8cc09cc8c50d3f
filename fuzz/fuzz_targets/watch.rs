//! Fuzzes `watch.json`, exported as code.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::results::read_observer;

fuzz_target!(|data: &[u8]| read_observer(data));
