//! Fuzzes meshes of a URDF in STL.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sprung_fuzz::read_mesh;

fuzz_target!(|data: &[u8]| read_mesh(data));
