//! Noticed: what of a file was left out or is odd, one warning per kind with a count.

use std::collections::BTreeMap;

/// What can be wrong with lines without making geometry doubtful.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    NamelessMaterial,
    FewCorners,
    MoreOfVertex,
    UnusedVertex,
    Normal,
    TextureCoordinate,
    Bent,
    Crossing,
}

/// How often, and the line of the first time.
#[derive(Debug, Default)]
pub(super) struct Noticed(BTreeMap<Kind, (usize, usize)>);

impl Noticed {
    /// Counts one more, on a line.
    pub fn add(&mut self, kind: Kind, line: usize) {
        self.0.entry(kind).or_insert((0, line)).0 += 1;
    }

    /// A sentence per kind.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(kind, &(times, line))| {
            let (one, many, then) = match kind {
                Kind::NamelessMaterial => (
                    "usemtl without a name",
                    "lines usemtl without a name",
                    "what follows counts as without a material",
                ),
                Kind::FewCorners => {
                    ("face of one or two corners", "faces of one or two corners", "left out")
                }
                Kind::MoreOfVertex => (
                    "vertex with more than a place, a weight or a colour",
                    "vertices with more than a place, a weight or a colour",
                    "the rest is left out",
                ),
                Kind::UnusedVertex => (
                    "malformed vertex that no face uses",
                    "malformed vertices that no face uses",
                    "left out",
                ),
                Kind::Normal => (
                    "missing or malformed normal (vn)",
                    "missing or malformed normals (vn)",
                    "faces are drawn flat there",
                ),
                Kind::TextureCoordinate => (
                    "missing or malformed texture coordinate (vt)",
                    "missing or malformed texture coordinates (vt)",
                    "faces take the mean of their picture there",
                ),
                Kind::Bent => (
                    "polygon that is not flat",
                    "polygons that are not flat",
                    "divided as seen from the front; triangulate them where the model is made if their shape matters",
                ),
                Kind::Crossing => (
                    "polygon whose border crosses itself",
                    "polygons whose borders cross themselves",
                    "their triangles may overlap; divide them where the model is made",
                ),
            };
            match times {
                1 => format!("1 {one} (line {line}): {then}"),
                _ => format!("{times} {many} (the first in line {line}): {then}"),
            }
        })
    }
}
