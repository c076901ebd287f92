//! OBJ texts: read, and cut if there is light.

#![no_main]

use libfuzzer_sys::fuzz_target;
use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::scene::{Loading, Scene};
use radiosity::trace::Tracer;

fuzz_target!(|data: &[u8]| {
    let Ok(scene) = Scene::read(data, "/nonexistent", Loading::default()) else { return };
    let tracer = Tracer::new(&scene);
    let _ = Patches::new(&tracer, &Tessellation { size: PatchSize::Count(50), ..Default::default() });
});
