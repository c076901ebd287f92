//! Files of form factors, their checksums made right: whatever a file says, nothing panics, and what is
//! accepted closes.

#![no_main]

use std::io::Cursor;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::scene::Scene;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, StorageKind, TraceOptions};
use xxhash_rust::xxh3::xxh3_64;

static SCENE: LazyLock<Scene> = LazyLock::new(Scene::cornell_box);

fn cut() -> Tessellation<'static> {
    Tessellation { size: PatchSize::Count(60), ..Default::default() }
}

/// A file as it should be.
static SOUND: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let tracer = Tracer::new(&SCENE);
    let mut patches = Patches::new(&tracer, &cut()).expect("the built-in scene can be cut");
    let options = TraceOptions { rays: Some(8), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).expect("it can be traced");
    let mut file = Vec::new();
    factors.save(&patches, &mut file).expect("memory can be written to");
    file
});

/// Makes checksums right where there are sections.
fn seal(file: &mut [u8]) {
    let mut at = 12;
    while let Some(length) = file.get(at..at + 8) {
        let length = u64::from_le_bytes(length.try_into().expect("eight bytes")) as usize;
        let Some(end) = (at + 8).checked_add(length).filter(|end| end + 8 <= file.len()) else { return };
        let sum = xxh3_64(&file[at + 8..end]);
        file[end..end + 8].copy_from_slice(&sum.to_le_bytes());
        at = end + 8;
    }
}

fuzz_target!(|changes: Vec<(u16, u8)>| {
    let mut file = SOUND.clone();
    for (place, byte) in changes {
        let place = place as usize % file.len();
        file[place] = byte;
    }
    seal(&mut file);
    let tracer = Tracer::new(&SCENE);
    let loaded = FormFactors::load(&mut Cursor::new(file), &tracer, &cut(), StorageKind::Auto, Keep::Rays);
    if let Ok((_, factors, _)) = loaded {
        assert!(factors.exchange().closure_error() < 1e-8);
    }
});
