//! Lines: an OBJ text, every line checked once and put in the plain form that `tobj` reads without surprises.
//!
//! Points come before faces, corners count from the start, colours of vertices and all that is no surface are
//! gone, and every face has a material, texture coordinates and normals: where the file gives none, those of
//! [`NONE`], no numbers and a zero vector. Where no face has texture coordinates there are none at all.

use std::fmt::Write;
use std::io::{BufRead, Read};
use std::path::Path;

use glam::DVec3;

use super::SceneError;

/// The material of faces that name none.
pub(super) const NONE: &str = "(none)";

/// An OBJ text whose every line makes sense.
#[derive(Default)]
pub(super) struct Lines<'a> {
    /// Material libraries, each with the number of the line that names it.
    pub libraries: Vec<(usize, &'a str)>,
    /// Materials that faces ask for, in the order of their first mention.
    pub materials: Vec<&'a str>,
    points: String,
    faces: String,
    /// How many vertices, texture coordinates and normals there are in all, and up to this line.
    totals: [usize; 3],
    so_far: [usize; 3],
}

impl<'a> Lines<'a> {
    /// Checks `text`; `path` is for messages.
    pub fn check(path: &Path, text: &'a str) -> Result<Self, SceneError> {
        let mut lines = Lines::default();
        for slot in text.lines().filter_map(|line| slot(split(line).0)) {
            lines.totals[slot] += 1;
        }
        for (number, line) in (1..).zip(text.lines()) {
            lines.take(number, line).map_err(|message| SceneError::Parse {
                path: path.to_path_buf(),
                line: number,
                message,
            })?;
        }
        Ok(lines)
    }

    /// The text for `tobj`.
    pub fn reader(&self) -> impl BufRead {
        // It asks for a library once, and takes a zero vector for the first normal.
        const HEAD: &str = "mtllib\nvn 0 0 0\nvt nan nan\n";
        HEAD.as_bytes().chain(self.points.as_bytes()).chain(self.faces.as_bytes())
    }

    fn take(&mut self, number: usize, line: &'a str) -> Result<(), String> {
        let (key, rest) = split(line);
        match key {
            "v" => push(&mut self.points, "v", vertex(rest)?),
            "vn" => push(&mut self.points, "vn", normal(rest)?),
            "vt" => push_texture(&mut self.points, rest)?,
            "f" => self.take_face(rest)?,
            "o" | "g" => self.faces.extend([key, " ", rest, "\n"]),
            "mtllib" => self.libraries.push((number, rest)),
            "usemtl" if rest.is_empty() => return Err("usemtl without a name".into()),
            "usemtl" => self.take_material(rest),
            _ => {}
        }
        if let Some(slot) = slot(key) {
            self.so_far[slot] += 1;
        }
        Ok(())
    }

    fn take_material(&mut self, name: &'a str) {
        if !self.materials.contains(&name) {
            self.materials.push(name);
        }
        self.faces.extend(["usemtl ", name, "\n"]);
    }

    fn take_face(&mut self, words: &str) -> Result<(), String> {
        let corners: Vec<[Option<usize>; 3]> =
            uncommented(words).map(|word| self.corner(word)).collect::<Result<_, _>>()?;
        if corners.len() < 3 {
            return Err("a face must have at least three corners".into());
        }
        if self.materials.is_empty() {
            self.take_material(NONE);
        }
        let has_texture = self.totals[1] > 0;
        let has_normals = corners.iter().all(|corner| corner[2].is_some());
        self.faces.push('f');
        for [vertex, texture, normal] in corners {
            let normal = normal.filter(|_| has_normals).map_or(1, |normal| normal + 1);
            let vertex = vertex.unwrap_or_default();
            let _ = match has_texture {
                true => write!(self.faces, " {vertex}/{}/{normal}", texture.map_or(1, |texture| texture + 1)),
                false => write!(self.faces, " {vertex}//{normal}"),
            };
        }
        self.faces.push('\n');
        Ok(())
    }

    /// Vertex, texture coordinate and normal of a corner such as `3/1/2` or `-1//-1`, counted from 1.
    fn corner(&self, word: &str) -> Result<[Option<usize>; 3], String> {
        const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];
        let malformed = || format!("`{word}` is not a face corner; write vertex/texture/normal numbers");
        let mut corner = [None; 3];
        for (kind, part) in word.split('/').enumerate() {
            let slot = corner.get_mut(kind).ok_or_else(malformed)?;
            if part.is_empty() && kind > 0 {
                continue;
            }
            let index: i64 = part.parse().map_err(|_| malformed())?;
            let from_start = if index < 0 { self.so_far[kind] as i64 + index + 1 } else { index };
            if from_start < 1 || from_start > self.totals[kind] as i64 {
                return Err(format!(
                    "{} {index} does not exist; there are {}",
                    KINDS[kind], self.totals[kind]
                ));
            }
            *slot = Some(from_start as usize);
        }
        Ok(corner)
    }
}

/// The first word of a line, and the rest without space around it.
pub(super) fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (key, rest.trim_start())
}

/// Numbers up to a comment; none if a word is no number.
pub(super) fn numbers(words: &str) -> Option<Vec<f64>> {
    uncommented(words).map(|word| word.parse().ok()).collect()
}

fn uncommented(words: &str) -> impl Iterator<Item = &str> {
    words.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// Where points of a kind are counted.
fn slot(key: &str) -> Option<usize> {
    ["v", "vt", "vn"].iter().position(|&known| known == key)
}

fn push(text: &mut String, key: &str, DVec3 { x, y, z }: DVec3) {
    let _ = writeln!(text, "{key} {x:e} {y:e} {z:e}");
}

/// Texture coordinates: one number to three, of which the third has no meaning here; a missing second is 0.
fn push_texture(text: &mut String, words: &str) -> Result<(), String> {
    let wrong = || "`vt` must be followed by 1 to 3 numbers".to_owned();
    let numbers = numbers(words).filter(|all| (1..=3).contains(&all.len())).ok_or_else(wrong)?;
    let _ = writeln!(text, "vt {:e} {:e}", numbers[0], numbers.get(1).unwrap_or(&0.0));
    Ok(())
}

/// A vertex: three numbers, perhaps a weight that divides them or a colour.
fn vertex(words: &str) -> Result<DVec3, String> {
    let vertex =
        numbers(words).filter(|all| all.iter().all(|x| x.is_finite())).and_then(|all| match all[..] {
            [x, y, z] | [x, y, z, _, _, _] => Some(DVec3::new(x, y, z)),
            [x, y, z, weight] => Some(DVec3::new(x, y, z) / weight).filter(|p| p.is_finite()),
            _ => None,
        });
    vertex.ok_or_else(|| {
        "`v` must be followed by 3 finite numbers, and perhaps a weight other than 0 or a colour".into()
    })
}

/// A normal; one that makes no sense is ignored later.
fn normal(words: &str) -> Result<DVec3, String> {
    match numbers(words).as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err("`vn` must be followed by 3 numbers".into()),
    }
}
