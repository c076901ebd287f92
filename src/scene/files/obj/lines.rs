//! Lines: an OBJ text, every line checked once and put in the plain form that `tobj` reads without surprises.
//!
//! Points come before faces, corners count from the start, colours of vertices and all that is no surface are
//! gone, polygons are triangles, and every face has a material, texture coordinates and normals: where the
//! file gives none, those of [`NONE`], no numbers and a zero vector. Where no face has texture coordinates
//! there are none at all.
//!
//! What makes geometry doubtful is an error; what can be done without is left out, and noticed.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;
use std::io::{BufRead, Read};
use std::path::Path;

use glam::DVec3;

use super::noticed::{Kind, Noticed};
use super::polygon::{Divided, divide};
use crate::scene::files::mtl::NONE;
use crate::scene::files::text::{and_more, lines, named, numbers, split, uncommented};
use crate::scene::{FARTHEST, FARTHEST_ON_PICTURE, SceneError, is_near};

/// A face of more corners than this is refused.
const MOST_CORNERS: usize = 1 << 17;

/// Corners of a polygon that are farther than this from a plane, as a share of its extent, are spoken of.
const BENT: f64 = 0.01;

/// An OBJ text whose every line makes sense.
#[derive(Default)]
pub(super) struct Lines {
    /// What the lines say that name material libraries, each once, and the same as a set.
    pub libraries: Vec<String>,
    known_libraries: HashSet<String>,
    /// Materials that faces ask for, in the order of their first mention, and the same as a set.
    pub materials: Vec<String>,
    known_materials: HashSet<String>,
    /// Per triangle the number of its polygon, and the vertices of its corners.
    pub polygons: Vec<u32>,
    pub triangles: Vec<[usize; 3]>,
    /// Per vertex, red, green and blue where the line gives them.
    pub colours: Vec<Option<[f64; 3]>>,
    pub noticed: Noticed,
    vertices: Vec<DVec3>,
    /// Vertices that make no sense, with their line and what is wrong, and whether a face asks for them.
    wrong: BTreeMap<usize, (usize, String, bool)>,
    points: String,
    faces: String,
    /// How many vertices, texture coordinates and normals there are in all, and up to this line.
    totals: [usize; 3],
    so_far: [usize; 3],
    count_of_polygons: u32,
}

impl Lines {
    /// Checks `text`; `path` is for messages. All lines are looked at before one is refused.
    pub fn check(path: &Path, text: &str) -> Result<Self, SceneError> {
        let mut taken = Lines::default();
        let mut refused: Vec<(usize, String)> = Vec::new();
        let mut refuse =
            |line: usize, outcome: Result<(), String>| refused.extend(outcome.err().map(|e| (line, e)));
        for (number, line) in lines(text) {
            let (key, rest) = split(&line);
            refuse(number, taken.take_point(number, key, rest));
        }
        taken.totals = taken.so_far;
        taken.so_far = [0; 3];
        for (number, line) in lines(text) {
            let (key, rest) = split(&line);
            refuse(number, taken.take_other(number, key, rest));
        }
        for (_, (line, message, is_used)) in std::mem::take(&mut taken.wrong) {
            match is_used {
                true => refused.push((line, message)),
                false => taken.noticed.add(Kind::UnusedVertex, line),
            }
        }
        refused.sort_unstable_by_key(|&(line, _)| line);
        let more = refused.len().saturating_sub(1);
        match refused.into_iter().next() {
            None => Ok(taken),
            Some((line, message)) => {
                let message = message + &and_more(more);
                Err(SceneError::Parse { path: path.to_path_buf(), line, message })
            }
        }
    }

    /// The text for `tobj`.
    pub fn reader(&self) -> impl BufRead {
        // It asks for a library once, and takes a zero vector for the first normal.
        const HEAD: &str = "mtllib\nvn 0 0 0\nvt nan nan\n";
        HEAD.as_bytes().chain(self.points.as_bytes()).chain(self.faces.as_bytes())
    }

    /// Takes a line that gives a point.
    fn take_point(&mut self, number: usize, key: &str, rest: &str) -> Result<(), String> {
        match key {
            "v" => {
                let (vertex, colour) = self.vertex(number, rest).unwrap_or_else(|message| {
                    self.wrong.insert(self.vertices.len(), (number, message, false));
                    (DVec3::ZERO, None)
                });
                self.vertices.push(vertex);
                self.colours.push(colour);
                push(&mut self.points, "v", vertex);
            }
            "vn" => {
                let normal = self.normal(number, rest);
                push(&mut self.points, "vn", normal);
            }
            "vt" => {
                let [u, v] = self.texture_coordinates(number, rest)?;
                let _ = writeln!(self.points, "vt {u:e} {v:e}");
            }
            _ => {}
        }
        self.count(key);
        Ok(())
    }

    /// Takes a line that gives no point.
    fn take_other(&mut self, number: usize, key: &str, rest: &str) -> Result<(), String> {
        match key {
            "f" | "fo" => self.take_face(number, rest)?,
            "o" | "g" => self.faces.extend([key, " ", named(rest), "\n"]),
            "mtllib" if self.known_libraries.insert(rest.to_owned()) => self.libraries.push(rest.to_owned()),
            "usemtl" => self.take_material(number, rest),
            _ => self.count(key),
        }
        Ok(())
    }

    fn count(&mut self, key: &str) {
        if let Some(slot) = ["v", "vt", "vn"].iter().position(|&known| known == key) {
            self.so_far[slot] += 1;
        }
    }

    fn take_material(&mut self, number: usize, name: &str) {
        if name.is_empty() {
            self.noticed.add(Kind::NamelessMaterial, number);
        }
        self.use_material(if name.is_empty() { NONE } else { name });
    }

    fn use_material(&mut self, name: &str) {
        if self.known_materials.insert(name.to_owned()) {
            self.materials.push(name.to_owned());
        }
        self.faces.extend(["usemtl ", name, "\n"]);
    }

    fn take_face(&mut self, number: usize, words: &str) -> Result<(), String> {
        if uncommented(words).nth(MOST_CORNERS).is_some() {
            return Err(format!("a face may have up to {MOST_CORNERS} corners"));
        }
        let corners: Vec<[Option<usize>; 3]> =
            uncommented(words).map(|word| self.corner(number, word)).collect::<Result<_, _>>()?;
        if corners.len() < 3 {
            self.noticed.add(Kind::FewCorners, number);
            return Ok(());
        }
        if self.materials.is_empty() {
            self.use_material(NONE);
        }
        let places: Vec<usize> = corners.iter().map(|corner| corner[0].unwrap_or(1) - 1).collect();
        for place in &places {
            if let Some((.., is_used)) = self.wrong.get_mut(place) {
                *is_used = true;
            }
        }
        let Divided { triangles, bend, crosses } =
            divide(&places.iter().map(|&place| self.vertices[place]).collect::<Vec<_>>());
        if crosses {
            self.noticed.add(Kind::Crossing, number);
        } else if bend > BENT {
            self.noticed.add(Kind::Bent, number);
        }
        let has_texture = self.totals[1] > 0;
        let has_normals = corners.iter().all(|corner| corner[2].is_some());
        for triangle in triangles {
            self.faces.push('f');
            for [vertex, texture, normal] in triangle.map(|corner| corners[corner]) {
                let normal = normal.filter(|_| has_normals).map_or(1, |normal| normal + 1);
                let vertex = vertex.unwrap_or_default();
                let _ = match has_texture {
                    true => {
                        write!(self.faces, " {vertex}/{}/{normal}", texture.map_or(1, |texture| texture + 1))
                    }
                    false => write!(self.faces, " {vertex}//{normal}"),
                };
            }
            self.faces.push('\n');
            self.polygons.push(self.count_of_polygons);
            self.triangles.push(triangle.map(|corner| places[corner]));
        }
        self.count_of_polygons += 1;
        Ok(())
    }

    /// Vertex, texture coordinate and normal of a corner such as `3/1/2` or `-1//-1`, counted from 1.
    fn corner(&mut self, number: usize, word: &str) -> Result<[Option<usize>; 3], String> {
        const MISSING: [Kind; 3] = [Kind::TextureCoordinate, Kind::TextureCoordinate, Kind::Normal];
        let mut corner = [None; 3];
        for (kind, part) in word.split('/').take(3).enumerate() {
            if part.is_empty() && kind > 0 {
                continue;
            }
            let index = part.parse::<i64>().ok();
            let (so_far, total) = (self.so_far[kind] as i64, self.totals[kind] as i64);
            let from_start =
                index.map(|index| if index < 0 { so_far.saturating_add(index) + 1 } else { index });
            corner[kind] = from_start.filter(|place| (1..=total).contains(place)).map(|place| place as usize);
            match index {
                _ if corner[kind].is_some() => {}
                _ if kind > 0 => self.noticed.add(MISSING[kind], number),
                Some(index) => return Err(format!("vertex {index} does not exist; there are {total}")),
                None => {
                    return Err(format!(
                        "`{word}` is not a face corner; write vertex/texture/normal numbers"
                    ));
                }
            }
        }
        Ok(corner)
    }

    /// A vertex: three numbers, perhaps a weight, which has a meaning for curves alone, or a colour.
    fn vertex(&mut self, number: usize, words: &str) -> Result<(DVec3, Option<[f64; 3]>), String> {
        let said: Vec<f64> = uncommented(words).map_while(|word| word.parse().ok()).collect();
        let all = uncommented(words).count();
        let place = match said[..] {
            [x, y, z, ..] => DVec3::new(x, y, z),
            _ => return Err("`v` must be followed by 3 numbers".into()),
        };
        let (place, colour) = match said[3..] {
            [] if all == 3 => (place, None),
            [_] if all == 4 => (place, None),
            [r, g, b] | [r, g, b, _] if all == said.len() && [r, g, b].iter().all(|c| c.is_finite()) => {
                (place, Some([r, g, b]))
            }
            _ => {
                self.noticed.add(Kind::MoreOfVertex, number);
                (place, None)
            }
        };
        match is_near(place) {
            true => Ok((place, colour)),
            false => Err(format!("`v` must be followed by 3 numbers, none beyond {FARTHEST:e}")),
        }
    }

    /// A normal; one that makes no sense is none, and is ignored later.
    fn normal(&mut self, number: usize, words: &str) -> DVec3 {
        match numbers(words).as_deref() {
            Some(&[x, y, z, ..]) => DVec3::new(x, y, z),
            _ => {
                self.noticed.add(Kind::Normal, number);
                DVec3::ZERO
            }
        }
    }

    /// Texture coordinates: one number to three, of which the third has no meaning here; a missing second is
    /// 0. What makes no sense is none.
    fn texture_coordinates(&mut self, number: usize, words: &str) -> Result<[f64; 2], String> {
        let [u, v] = match numbers(words).as_deref() {
            Some(&[u]) => [u, 0.0],
            Some(&[u, v, ..]) => [u, v],
            _ => [f64::NAN; 2],
        };
        if u.is_nan() || v.is_nan() {
            self.noticed.add(Kind::TextureCoordinate, number);
            return Ok([f64::NAN; 2]);
        }
        match u.abs().max(v.abs()) <= FARTHEST_ON_PICTURE {
            true => Ok([u, v]),
            false => Err(format!("`vt` must be followed by numbers, none beyond {FARTHEST_ON_PICTURE:e}")),
        }
    }
}

fn push(text: &mut String, key: &str, DVec3 { x, y, z }: DVec3) {
    let _ = writeln!(text, "{key} {x:e} {y:e} {z:e}");
}
