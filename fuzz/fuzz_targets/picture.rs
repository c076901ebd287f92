//! Pictures on a square.

#![no_main]

use libfuzzer_sys::fuzz_target;
use radiosity::scene::Scene;

const FILES: [(&str, &str); 2] = [
    (
        "a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n",
    ),
    ("a.mtl", "newmtl m\nKe 1\nmap_Kd a.png\n"),
];

fuzz_target!(|data: &[u8]| {
    let Ok(folder) = tempfile::tempdir() else { return };
    for (name, text) in FILES {
        std::fs::write(folder.path().join(name), text).expect("a temporary folder can be written to");
    }
    std::fs::write(folder.path().join("a.png"), data).expect("a temporary folder can be written to");
    let _ = Scene::load(folder.path().join("a.obj"));
});
