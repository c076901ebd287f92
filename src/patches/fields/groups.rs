//! Groups: patches on one side of surfaces, taken together by face, material or object, or each on its own.

use crate::patches::Patches;
use crate::patches::reach::{FaceSide, Facing, Members};
use crate::scene::{Scene, Side};

/// What is taken together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupBy {
    /// Nothing: every patch is a group.
    Patch,
    /// The patches of one side of a face.
    Face,
    /// The patches of one side of a material.
    Material,
    /// The patches of one side of an object.
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

/// The patches on one side of some faces, under one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// The name of the object or material, with ` (back)` added for its back; of a face its number and side,
    /// such as `3 front`; of a patch the same and the number of its cell, such as `3 front 0`.
    pub name: String,
    /// Which side.
    pub side: Side,
    /// Its area, m²: of objects and materials the whole area of their diffuse faces, whether these see
    /// anything or not.
    pub area: f64,
    /// The part of its étendue that its patches have, 0 to 1. The rest provably sees nothing, where the group
    /// [sends](Group::sends).
    pub seeing: f64,
    /// Whether form factors from it are asked for. What does not send is only received on.
    pub sends: bool,
}

/// Every patch in one group, and each group on one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    by: GroupBy,
    groups: Vec<Group>,
    of_patch: Vec<usize>,
    facing: Facing,
    members: Vec<Members>,
}

impl Groups {
    /// Groups patches, in order of faces, sides and cells, or of materials or objects, front before back. A
    /// front of these has its group even where it has no patch, as long as it has diffuse faces; a back that
    /// provably sees nothing only where its front does not send.
    ///
    /// A group sends if `sends` says so of any of its faces' sides.
    pub fn new(patches: &Patches, by: GroupBy, sends: impl Fn(usize, Side) -> bool) -> Self {
        let scene = patches.scene();
        let facing = Facing::new(scene, &patches.frame);
        let (mut groups, of_patch, sides) = match by {
            GroupBy::Patch => each(patches, |i| (i, patches.place(i).cell.to_string())),
            GroupBy::Face => each(patches, |i| {
                let place = patches.place(i);
                (2 * place.face + usize::from(place.side == Side::Back), String::new())
            }),
            GroupBy::Material => {
                let names = scene.materials().iter().map(|material| material.name.clone());
                named(patches, names.collect(), |face| scene.faces()[face].material, &sends)
            }
            GroupBy::Object => {
                named(patches, scene.objects().to_vec(), |face| scene.faces()[face].object, &sends)
            }
        };
        let mut seeing = vec![0.0; groups.len()];
        let mut areas = vec![0.0; groups.len()];
        for (i, &group) in of_patch.iter().enumerate() {
            seeing[group] += patches.etendue(i);
            areas[group] += patches.area(i);
        }
        for (k, (group, sides)) in groups.iter_mut().zip(&sides).enumerate() {
            group.sends = sides.iter().any(|&(face, side)| sends(face, side));
            let all = match by {
                GroupBy::Patch | GroupBy::Face => [areas[k], seeing[k]],
                GroupBy::Material | GroupBy::Object => patches.extent_of(sides),
            };
            group.area = all[0];
            // Sums that differ by rounding are the same.
            group.seeing = if seeing[k] < (1.0 - 1e-12) * all[1] { seeing[k] / all[1] } else { 1.0 };
        }
        let members = sides.into_iter().map(|sides| facing.members(sides)).collect();
        Self { by, groups, of_patch, facing, members }
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

    /// Whether light may go from group a to b. Where not, that is proven: all of one lies behind the planes
    /// of the other.
    pub fn may_exchange(&self, a: usize, b: usize) -> bool {
        self.facing.may_exchange(&self.members[a], &self.members[b])
    }
}

/// Groups, the group of every patch, and the sides of faces in every group.
type Grouped = (Vec<Group>, Vec<usize>, Vec<Vec<FaceSide>>);

/// A group whose size is still to be found.
fn empty(name: String, side: Side) -> Group {
    Group { name, side, area: 0.0, seeing: 0.0, sends: false }
}

/// A group for every run of patches of the same key, named after face, side and what `key` adds.
fn each(patches: &Patches, key: impl Fn(usize) -> (usize, String)) -> Grouped {
    let (mut groups, mut of_patch, mut sides) =
        (Vec::new(), Vec::with_capacity(patches.len()), Vec::<Vec<FaceSide>>::new());
    let mut last = None;
    for i in 0..patches.len() {
        let (key, rest) = key(i);
        if last.replace(key) != Some(key) {
            let place = patches.place(i);
            let name = format!("{} {} {rest}", place.face, place.side.name());
            groups.push(empty(name.trim_end().to_owned(), place.side));
            sides.push(vec![(place.face, place.side)]);
        }
        of_patch.push(groups.len() - 1);
    }
    (groups, of_patch, sides)
}

/// A group for each side of each of `names` that a diffuse face belongs to, by `of`.
fn named(
    patches: &Patches,
    names: Vec<String>,
    of: impl Fn(usize) -> u32,
    sends: impl Fn(usize, Side) -> bool,
) -> Grouped {
    let scene = patches.scene();
    let mut faces: Vec<Vec<usize>> = vec![Vec::new(); names.len()];
    let diffuse = (0..scene.faces().len()).filter(|&face| scene.is_diffuse(face));
    diffuse.for_each(|face| faces[of(face) as usize].push(face));
    let mut number = vec![[0; 2]; names.len()];
    let (mut groups, mut sides) = (Vec::new(), Vec::new());
    for (k, name) in names.into_iter().enumerate().filter(|&(k, _)| !faces[k].is_empty()) {
        let any = |side: Side| faces[k].iter().any(|&face| sends(face, side));
        let is_met = |side: Side| faces[k].iter().any(|&face| !patches.patches_of(face, side).is_empty());
        for side in Side::BOTH {
            let alone = any(side) && (side == Side::Front || !any(Side::Front));
            if alone || is_met(side) {
                number[k][usize::from(side == Side::Back)] = groups.len();
                let name = if side == Side::Front { name.clone() } else { format!("{name} (back)") };
                groups.push(empty(name, side));
                sides.push(faces[k].iter().map(|&face| (face, side)).collect());
            }
        }
    }
    let group_of = |i: usize| {
        let place = patches.place(i);
        number[of(place.face) as usize][usize::from(place.side == Side::Back)]
    };
    let of_patch = (0..patches.len()).map(group_of).collect();
    (groups, of_patch, sides)
}

impl Patches<'_> {
    /// Area and étendue by π of whole sides of faces, m², less what other faces cover.
    fn extent_of(&self, sides: &[FaceSide]) -> [f64; 2] {
        let square = self.frame.scale().powi(2);
        let of_side = |&(face, side): &FaceSide| {
            let area = square * self.bare_area(face, side);
            let per_area = |slot: u32| self.per_area.get(slot as usize).copied().unwrap_or(1.0);
            let share = |slot: u32| self.cell_share(slot) * per_area(slot);
            let bare = self.slots_of(face, side).filter(|&slot| !self.is_covered(slot));
            let etendue = match self.per_area.is_empty() {
                true => area,
                false => square * self.face_area(face) * bare.map(share).sum::<f64>(),
            };
            [area, etendue]
        };
        sides.iter().map(of_side).fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }
}
