//! Photometric files, LM-63 and EULUMDAT.

#![no_main]

use libfuzzer_sys::fuzz_target;
use radiosity::scene::IntensityTable;

fuzz_target!(|data: &[u8]| {
    let Ok(table) = IntensityTable::parse(&String::from_utf8_lossy(data), &mut Vec::new()) else { return };
    assert!(table.flux().is_finite() && table.highest() >= 0.0);
    for k in 0..32 {
        let intensity = table.at(6.0 * f64::from(k), 29.0 * f64::from(k));
        assert!((0.0..=table.highest() * 1.000_001).contains(&intensity));
    }
});
