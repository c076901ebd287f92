//! Scenes of any size and files with any damage: loaded or refused, and nothing panics.

use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::FaceState;
use radiosity::trace::Tracer;

use super::{LAMP, Random, cut, load, loaded};

#[test]
fn huge_and_tiny_scenes_are_cut_like_any_other() {
    let text = include_str!("../../../meshes/cornell_box.obj").replace("cornell_box.mtl", "a.mtl");
    let patches_of = |unit: &str| {
        let library = include_str!("../../../meshes/cornell_box.mtl");
        let scene =
            loaded(&[("a.obj", text.as_str()), ("a.mtl", library), ("a.toml", &format!("unit = {unit}\n"))]);
        let tracer = Tracer::new(&scene);
        cut(&tracer, Reach::Light).len()
    };
    let ordinary = patches_of("1.0");
    for unit in ["1e27", "1e-30"] {
        assert_eq!(patches_of(unit), ordinary, "unit {unit}");
    }
}

#[test]
fn where_nothing_is_reached_nothing_is_cut_ever_finer() {
    // A lone sliver, so that even the finest cut ends soon.
    let sliver = loaded(&[("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1e-5 0\nf 1 2 3\n")]);
    let tracer = Tracer::new(&sliver);
    for reach in [Reach::Light, Reach::Everything] {
        let patches = cut(&tracer, reach);
        assert!(patches.is_empty(), "{reach:?}");
        assert!(patches.edge() > 1e-3, "{reach:?}: cut into legs of {} m for 60 patches", patches.edge());
    }
}

#[test]
fn coordinates_of_any_size_never_panic() {
    for far in ["1e30", "-1e30", "1e-30", "1e154", "1e200", "1.7e308", "1e-160", "1e-200", "5e-324"] {
        for corner in ["X 0 0", "X X X", "0 X 0", "X 1 0"] {
            for others in
                ["v 0 0 0\nv 0 0 1\n", "v 0 0 0\nv 0 0 X\n", "v 1 X 1\nv 2 X 2\n", "v -X -X 0\nv -X X 0\n"]
            {
                let text = format!(
                    "mtllib a.mtl\nv {corner}\n{others}v 0 1 0\nv 1 0 0\nusemtl m\nf 1 2 3 4\nf 2 4 5\n"
                );
                survives(text.replace('X', far).replace("--", ""), LAMP, "");
            }
        }
    }
}

#[test]
fn three_hundred_damaged_scenes_never_panic() {
    let [scene, library, settings] = [
        include_str!("../../../meshes/cornell_box.obj"),
        include_str!("../../../meshes/cornell_box.mtl"),
        include_str!("../../../meshes/cornell_box.toml"),
    ];
    let scene = scene.replace("cornell_box.mtl", "a.mtl");
    let mut refused = 0;
    for seed in 0..300 {
        let damaged = damage(seed, scene.as_bytes());
        refused += usize::from(!survives(damaged, library, settings));
        // Libraries and settings are short: one hit in three runs each.
        match seed % 3 {
            0 => survives(&scene, damage(seed, library.as_bytes()), settings),
            1 => survives(&scene, library, damage(seed, settings.as_bytes())),
            _ => true,
        };
    }
    assert!(
        (30..=270).contains(&refused),
        "{refused} of 300 refused: the damage is too great or too small to tell"
    );
}

/// Loads a scene and cuts it if it has light; whether it loads is the answer, a panic fails the test.
fn survives(scene: impl AsRef<[u8]>, library: impl AsRef<[u8]>, settings: impl AsRef<[u8]>) -> bool {
    let files = [("a.obj", scene.as_ref()), ("a.mtl", library.as_ref()), ("a.toml", settings.as_ref())];
    let Ok(scene) = load(&files) else { return false };
    if scene.require_light().is_ok() {
        let tracer = Tracer::new(&scene);
        let size = PatchSize::Count(60);
        if let Ok(patches) = Patches::new(&tracer, &Tessellation { size, ..Default::default() }) {
            let faces = (0..patches.len()).map(|i| &scene.faces()[patches.place(i).face]);
            assert!(faces.into_iter().all(|face| face.state == FaceState::Kept));
        }
    }
    true
}

/// Deletes, doubles or alters a few stretches of bytes.
fn damage(seed: u64, bytes: &[u8]) -> Vec<u8> {
    const WORDS: [&str; 12] = [
        "nan",
        "-1",
        "0",
        "1e300",
        "1e-300",
        "\n",
        " ",
        "f 1 2 3\n",
        "//",
        "99999999999999999999",
        "\u{feff}",
        "#",
    ];
    let mut bytes = bytes.to_vec();
    let mut random = Random(seed);
    for _ in 0..1 + seed % 4 {
        let start = random.below(bytes.len());
        let end = (start + 1 + random.below(12)).min(bytes.len());
        match random.below(4) {
            0 => drop(bytes.drain(start..end)),
            1 => bytes.splice(start..start, bytes[start..end].to_vec()).for_each(drop),
            2 => bytes[start] = random.below(256) as u8,
            _ => bytes.splice(start..start, WORDS[random.below(WORDS.len())].bytes()).for_each(drop),
        }
    }
    bytes
}
