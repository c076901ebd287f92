//! What targets share.

use radiosity::scene::Scene;

/// A square with a picture, its material and the lines that name them.
const FILES: [(&str, &str); 2] = [
    (
        "a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n",
    ),
    ("a.mtl", "newmtl m\nKe 1\nmap_Kd a.png\n"),
];

/// Loads the square with a file of this name and content in its folder.
pub fn load_beside_square(name: &str, content: &[u8]) {
    let Ok(folder) = tempfile::tempdir() else { return };
    let files = FILES.iter().map(|(name, text)| (*name, text.as_bytes())).chain([(name, content)]);
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("a temporary folder can be written to");
    }
    let _ = Scene::load(folder.path().join("a.obj"));
}
