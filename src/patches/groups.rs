//! Groups: patches taken together by face, material or object, or each on its own.

use super::Patches;
use crate::scene::{FaceState, Scene, Side};

/// What is taken together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupBy {
    /// Nothing: every patch is a group.
    Patch,
    /// The patches of one side of a face.
    Face,
    /// The patches of one material.
    Material,
    /// The patches of one object.
    Object,
}

impl GroupBy {
    /// By object if the scene has several, else by material if its faces have several, else by face.
    pub fn usual(scene: &Scene) -> Self {
        let several = |of: &dyn Fn(usize) -> u32| (1..scene.faces().len()).any(|face| of(face) != of(0));
        if several(&|face| scene.faces()[face].object) {
            Self::Object
        } else if several(&|face| scene.faces()[face].material) {
            Self::Material
        } else {
            Self::Face
        }
    }

    /// `patch`, `face`, `material` or `object`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Patch => "patch",
            Self::Face => "face",
            Self::Material => "material",
            Self::Object => "object",
        }
    }
}

/// Some patches under one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// The name of the object or material; of a face its number and side, such as `3 front`; of a patch the same and the
    /// number of its cell, such as `3 front 0`.
    pub name: String,
    /// Area of its patches, m²; 0 where none of its sides sees anything.
    pub area: f64,
}

/// Every patch in one group.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    by: GroupBy,
    groups: Vec<Group>,
    of_patch: Vec<usize>,
}

impl Groups {
    /// Groups patches, in order of faces, sides and cells, or of materials or objects. These have their group even
    /// where it has no patch, as long as a face of theirs takes part.
    pub fn new(patches: &Patches, by: GroupBy) -> Self {
        let scene = patches.scene();
        let (mut groups, of_patch) = match by {
            GroupBy::Patch => each(patches, |i| (i, patches.place(i).cell.to_string())),
            GroupBy::Face => each(patches, |i| {
                let place = patches.place(i);
                (2 * place.face + usize::from(place.side == Side::Back), String::new())
            }),
            GroupBy::Material => {
                let names = scene.materials().iter().map(|material| material.name.clone());
                named(patches, names.collect(), |face| scene.faces()[face].material)
            }
            GroupBy::Object => named(patches, scene.objects().to_vec(), |face| scene.faces()[face].object),
        };
        of_patch.iter().enumerate().for_each(|(i, &group)| groups[group].area += patches.area(i));
        Self { by, groups, of_patch }
    }

    /// What is taken together.
    pub fn by(&self) -> GroupBy {
        self.by
    }

    /// The groups.
    pub fn all(&self) -> &[Group] {
        &self.groups
    }

    /// Number of groups g.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Per patch, its group's number, from 0.
    pub fn of_patch(&self) -> &[usize] {
        &self.of_patch
    }
}

/// A group for every run of patches of the same key, named after face, side and what `key` adds.
fn each(patches: &Patches, key: impl Fn(usize) -> (usize, String)) -> (Vec<Group>, Vec<usize>) {
    let (mut groups, mut of_patch) = (Vec::new(), Vec::with_capacity(patches.len()));
    let mut last = None;
    for i in 0..patches.len() {
        let (key, rest) = key(i);
        if last.replace(key) != Some(key) {
            let place = patches.place(i);
            let name = format!("{} {} {rest}", place.face, place.side.name());
            groups.push(Group { name: name.trim_end().to_owned(), area: 0.0 });
        }
        of_patch.push(groups.len() - 1);
    }
    (groups, of_patch)
}

/// A group for each of `names` that a face which takes part belongs to, by `of`.
fn named(patches: &Patches, names: Vec<String>, of: impl Fn(usize) -> u32) -> (Vec<Group>, Vec<usize>) {
    let faces = patches.scene().faces();
    let mut used = vec![false; names.len()];
    let kept = (0..faces.len()).filter(|&face| faces[face].state == FaceState::Kept);
    kept.for_each(|face| used[of(face) as usize] = true);
    let mut number = vec![0; names.len()];
    let mut groups = Vec::new();
    for (k, name) in names.into_iter().enumerate().filter(|&(k, _)| used[k]) {
        number[k] = groups.len();
        groups.push(Group { name, area: 0.0 });
    }
    let of_patch = (0..patches.len()).map(|i| number[of(patches.place(i).face) as usize]).collect();
    (groups, of_patch)
}
