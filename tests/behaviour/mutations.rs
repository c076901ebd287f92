//! Damaged files of every format: whatever is in them, they are read or refused, and soon.

use std::time::{Duration, Instant};

use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::scene::{IntensityTable, Scene};
use radiosity::trace::Tracer;
use radiosity::trace::sampling::Stream;

use crate::scratch::Scratch;

/// The seeds of the fuzz targets: every keyword once.
const OBJ: &[u8] = include_bytes!("../../fuzz/seeds/obj/all.obj");
const MTL: &[u8] = include_bytes!("../../fuzz/seeds/mtl/all.mtl");
const SETTINGS: &[u8] = include_bytes!("../../fuzz/seeds/settings/all.toml");
const LUMINAIRE: &[u8] = include_bytes!("../../fuzz/seeds/luminaire/batwing.ies");
const PICTURE: &[u8] = include_bytes!("../../fuzz/seeds/picture/a.png");

/// What is put into files: numbers that are none, too large or too small, and words that mean something.
const WORDS: [&str; 24] = [
    "nan",
    "inf",
    "-1",
    "0",
    "1e300",
    "1e31",
    "1e-300",
    "1e9",
    "18446744073709551616",
    "99999999999",
    "\n",
    " ",
    "\\\n",
    "#",
    "//",
    "f 1 2 3\n",
    "usemtl m\n",
    "[[light]]\n",
    "illum 4\n",
    "Ke 5\n",
    "-s 1e9 1e9 1 ",
    "\u{feff}",
    "\0",
    "\"",
];

/// A number below `n`, the k-th of mutation `seed`.
fn below(seed: u64, k: u32, n: usize) -> usize {
    (Stream::Callers.sequence(seed, 11, 0).point(k)[0] * n as f64) as usize
}

/// Deletes, doubles or replaces a few stretches.
fn mutated(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for hit in 0..1 + seed as u32 % 4 {
        let draw = |k: u32, n: usize| below(seed, 8 * hit + k, n);
        let start = draw(0, bytes.len().max(1)).min(bytes.len().saturating_sub(1));
        let end = (start + 1 + draw(1, 12)).min(bytes.len());
        match draw(2, 5) {
            0 => drop(bytes.drain(start..end)),
            1 => bytes.splice(start..start, bytes[start..end].to_vec()).for_each(drop),
            2 if start < bytes.len() => bytes[start] = draw(3, 256) as u8,
            3 => bytes.splice(start..end, WORDS[draw(3, WORDS.len())].bytes()).for_each(drop),
            _ => bytes.splice(start..start, WORDS[draw(3, WORDS.len())].bytes()).for_each(drop),
        }
    }
    bytes
}

#[test]
fn damaged_files_are_read_or_refused_and_soon() {
    const COUNT: u64 = 1500;
    const LONG: Duration = Duration::from_secs(10);
    let scratch = Scratch::new();
    let lamp = [OBJ, b"\nv 0 2 0\nv 1 2 0\nv 0 2 1\nusemtl lamp\nf -3 -2 -1\n"].concat();
    let library = [MTL, b"\nnewmtl lamp\nKe 1\n"].concat();
    let mut read = 0;
    for seed in 0..COUNT {
        let damaged = |which: u64, bytes: &[u8]| match seed % 4 == which {
            true => mutated(bytes, seed),
            false => bytes.to_vec(),
        };
        scratch.write("a.obj", damaged(0, &lamp));
        scratch.write("a.mtl", damaged(1, &library));
        scratch.write("a.toml", damaged(2, SETTINGS));
        scratch.write("a.png", damaged(3, PICTURE));
        let began = Instant::now();
        if let Ok(scene) = Scene::load(scratch.path("a.obj")) {
            read += 1;
            let tracer = Tracer::new(&scene);
            let size = PatchSize::Count(50);
            let _ = Patches::new(&tracer, &Tessellation { size, ..Default::default() });
        }
        assert!(began.elapsed() < LONG, "mutation {seed} takes {:?}", began.elapsed());
    }
    assert!(
        2 * read > COUNT && read < COUNT,
        "{read} of {COUNT} are read: the damage is too great or too small"
    );
}

#[test]
fn damaged_luminaires_are_read_or_refused() {
    let mut read = 0;
    for seed in 0..2000 {
        let text = String::from_utf8_lossy(&mutated(LUMINAIRE, seed)).into_owned();
        if let Ok(table) = IntensityTable::parse(&text, &mut Vec::new()) {
            read += 1;
            assert!(table.flux().is_finite() && table.at(33.0, 77.0) <= table.highest(), "mutation {seed}");
        }
    }
    assert!((100..1900).contains(&read), "{read} of 2000 are read");
}
