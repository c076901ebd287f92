//! Material libraries beside a square.

#![no_main]

use libfuzzer_sys::fuzz_target;
use radiosity_fuzz::load_beside_square;

fuzz_target!(|data: &[u8]| load_beside_square("a.mtl", data));
