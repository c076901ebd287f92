//! Scene files: what they mean, and how bad ones are refused. A refusal names the file, the line, the face or
//! the material, and what to do; nothing panics.

mod anything; // any size, any damage: nothing panics
mod colours; // what materials reflect and emit, and which one a face has
mod dropped_faces; // without area or there twice: counted, and the others keep their number
mod faces; // corners, normals, polygons
mod finishes; // plastic, mirrors, glass and metals, as files say them
mod libraries; // where they are found, and which of their lines make sense
mod settings; // what they change, and how bad ones are refused
mod spelling; // white space, line endings, names
mod unreadable; // files that cannot be read, or hold no scene
mod vertices; // three numbers, and what may stand behind them

use radiosity::patches::{PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::{Scene, SceneError};
use radiosity::trace::Tracer;

use crate::scratch::Scratch;

/// Three vertices, on lines 1 to 3.
const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// One face of material `m` from `a.mtl`.
const TRIANGLE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

/// A lamp of material `m`.
const LAMP: &str = "newmtl m\nKd 0.5 0.5 0.5\nKe 1 1 1\n";

/// Loads `a.obj` of a folder with these files.
fn load<C: AsRef<[u8]>>(files: &[(&str, C)]) -> Result<Scene, SceneError> {
    Scene::load(Scratch::with(files).path("a.obj"))
}

#[track_caller]
pub(crate) fn loaded<C: AsRef<[u8]>>(files: &[(&str, C)]) -> Scene {
    load(files).unwrap_or_else(|e| panic!("{e}"))
}

/// The message with which `a.obj` is refused.
#[track_caller]
fn refusal<C: AsRef<[u8]>>(files: &[(&str, C)]) -> String {
    match load(files) {
        Ok(scene) => panic!("{} faces loaded, warnings {:?}", scene.faces().len(), scene.warnings()),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn says(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "{word:?} is missing in: {message}");
    }
}

/// An OBJ text of the three corners and more lines, which begin on line 4.
fn obj(lines: &str) -> [(&'static str, String); 1] {
    [("a.obj", format!("{CORNERS}{lines}"))]
}

/// A triangle whose only material is made of these lines, which begin on line 2.
fn mtl(lines: &str) -> [(&'static str, String); 2] {
    [("a.obj", TRIANGLE.into()), ("a.mtl", format!("newmtl m\n{lines}\n"))]
}

fn cut<'s>(tracer: &Tracer<'s>, reach: Reach) -> Patches<'s> {
    let size = PatchSize::Count(60);
    Patches::new(tracer, &Tessellation { size, reach, ..Default::default() })
        .expect("a small scene can be cut")
}

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}
