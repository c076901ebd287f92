//! Random scenes: one to seven boxes in a room, as ugly as other people's scenes are; a scene for every seed.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};

use super::mesh::{self, Block, Finish, Object, flipped};

/// By how much coincident surfaces are moved apart in lifted scenes, m.
const LIFT: f64 = 1e-4;

/// Surfaces that coincide in some scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// A rug in the plane of the floor.
    Rug,
    /// A lamp in the plane of the ceiling.
    FlushLamp,
    /// One box twice, of two materials.
    Doubled,
    /// Two boxes that overlap in part, their tops and bottoms in one plane.
    Partial,
    /// Two sheets back to back.
    BackToBack,
}

impl Overlap {
    const ALL: [Self; 5] = [Self::Rug, Self::FlushLamp, Self::Doubled, Self::Partial, Self::BackToBack];

    fn name(self) -> &'static str {
        match self {
            Self::Rug => "rug",
            Self::FlushLamp => "flush lamp",
            Self::Doubled => "doubled box",
            Self::Partial => "partial overlap",
            Self::BackToBack => "back to back",
        }
    }
}

/// Whether coincident surfaces stay where they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lift {
    /// They do.
    Flush,
    /// The one that is on top is [`LIFT`] before the other.
    Lifted,
}

/// A scene, before it is written to files.
#[derive(Clone, Debug)]
pub struct RandomScene {
    pub objects: Vec<Object>,
    /// What is ugly about it.
    pub features: BTreeSet<&'static str>,
    /// Whether some of its surfaces coincide.
    pub overlap: Option<Overlap>,
}

impl RandomScene {
    /// The scene of a seed.
    pub fn new(seed: u64, lift: Lift) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5eed);
        let size = DVec3::from([0; 3].map(|_| random.between(2.0, 6.0)));
        let style = Style::new(&mut random);
        let mut making = Making { random, style, size, objects: Vec::new(), features: BTreeSet::new() };
        making.room();
        making.boxes();
        making.lamps();
        let overlap = making.overlap(lift);
        if making.style.is_coloured {
            making.features.insert("colour");
        }
        making.features.extend(overlap.map(Overlap::name));
        Self { objects: making.objects, features: making.features, overlap }
    }

    /// Writes `scene.obj`, `scene.mtl` and `scene.toml` to a folder; answers the path of the first.
    pub fn write(&self, folder: &Path) -> std::io::Result<PathBuf> {
        let path = folder.join("scene.obj");
        std::fs::write(&path, mesh::obj(&self.objects))?;
        std::fs::write(folder.join("scene.mtl"), mesh::mtl(&self.objects))?;
        std::fs::write(folder.join("scene.toml"), mesh::toml(&self.objects))?;
        Ok(path)
    }
}

/// What all surfaces of a scene have in common.
#[derive(Clone, Copy, Debug)]
struct Style {
    /// Whether channels differ.
    is_coloured: bool,
    /// The reflectance of everything, where it is one.
    all: Option<f64>,
}

impl Style {
    fn new(random: &mut Random) -> Self {
        let is_coloured = random.chance(0.25);
        let all = match random.pick(30) {
            0 => Some(0.0),
            1 => Some(0.999),
            2 => Some(1.0),
            _ => None,
        };
        Self { is_coloured, all }
    }
}

/// A scene in the making.
struct Making {
    random: Random,
    style: Style,
    /// Of the room, from the origin, y up.
    size: DVec3,
    objects: Vec<Object>,
    features: BTreeSet<&'static str>,
}

/// How a box lies to the room and to the box before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Hanging,
    Standing,
    Intersecting,
    SharedCorner,
    SharedEdge,
    Flush,
    ThroughWall,
}

impl Making {
    fn add(&mut self, name: &str, finish: Finish, quads: Vec<mesh::Quad>) {
        let name = format!("{name}_{}", self.objects.len());
        self.objects.push(Object { name, finish, quads });
    }

    /// A random reflectance; of all channels where the scene is grey.
    fn colour(&mut self) -> [f64; 3] {
        let random = &mut self.random;
        let level = self.style.all.unwrap_or_else(|| match random.pick(12) {
            0 => 0.0,
            1 => 1.0,
            2 => 0.999,
            _ => random.between(0.0, 0.95),
        });
        match self.style {
            Style { is_coloured: true, all: None } => [0; 3].map(|_| level * random.between(0.5, 1.0)),
            _ => [level; 3],
        }
    }

    /// The six walls front inward; some may be missing. The floor may be of its own colour.
    fn room(&mut self) {
        let walls = Block::upright(DVec3::ZERO, self.size).sides().map(flipped);
        let missing = match self.random.pick(3) {
            0 => 1 + self.random.pick(2),
            _ => 0,
        };
        let mut open = BTreeSet::new();
        (0..missing).for_each(|_| {
            open.insert([0, 2, 3, 4, 5][self.random.pick(5)]);
        });
        if missing > 0 {
            self.features.insert("open");
        }
        let (floor, other) = (self.colour(), self.colour());
        self.add("floor", Finish::Diffuse(floor), vec![walls[1]]);
        let kept = (0..6).filter(|k| *k != 1 && !open.contains(k)).map(|k| walls[k]).collect();
        self.add("walls", Finish::Diffuse(other), kept);
    }

    fn boxes(&mut self) {
        let mut last: Option<Block> = None;
        let mut has_glass = false;
        for _ in 0..1 + self.random.pick(7) {
            let (block, place) = self.block(last);
            let is_whole = !self.random.chance(0.2);
            let is_apart = matches!(place, Place::Hanging | Place::Standing) && is_whole;
            let mut finish = self.finish();
            if matches!(finish, Finish::Glass(_)) && (has_glass || !is_apart || place == Place::Standing) {
                finish = Finish::Diffuse(self.colour());
            }
            has_glass |= matches!(finish, Finish::Glass(_));
            self.features.insert(match finish {
                Finish::Mirror(_) => "mirror",
                Finish::Glass(_) => "glass",
                Finish::Pane(_) => "pane",
                Finish::Metal(..) => "metal",
                Finish::Plastic(..) => "plastic",
                Finish::Sheet(..) => "sheet",
                _ => "diffuse",
            });
            let left_out = match () {
                _ if !is_whole => Some(self.random.pick(6)),
                // A box on the floor has a bottom or none.
                _ if place == Place::Standing && self.random.chance(0.5) => Some(1),
                _ => None,
            };
            if !is_whole {
                self.features.insert("open box");
            }
            let sides = block.sides().into_iter().enumerate();
            let quads = sides.filter(|(k, _)| Some(*k) != left_out).map(|(_, quad)| quad).collect();
            self.add("box", finish, quads);
            last = Some(block);
        }
    }

    /// A box, and how it lies.
    fn block(&mut self, last: Option<Block>) -> (Block, Place) {
        let random = &mut self.random;
        let mut half = DVec3::from([0; 3].map(|_| random.between(0.1, 0.7)));
        if random.chance(0.3) {
            let axis = random.pick(3);
            half[axis] = 0.5 * 10f64.powf(random.between(-6.0, -1.0));
            self.features.insert("thin");
        }
        let places =
            [Place::Intersecting, Place::SharedCorner, Place::SharedEdge, Place::Flush, Place::Hanging];
        let alone = [Place::Standing, Place::Hanging, Place::ThroughWall];
        let place = match last {
            Some(_) if random.chance(0.6) => places[random.pick(5)],
            _ => alone[random.pick(3)],
        };
        let inside = |random: &mut Random| self.size * DVec3::from([0; 3].map(|_| random.between(0.2, 0.8)));
        let upright = |random: &mut Random| match random.chance(0.5) {
            true => DMat3::from_rotation_y(random.between(0.0, TAU)),
            false => DMat3::IDENTITY,
        };
        let turned = |random: &mut Random| match random.chance(0.5) {
            true => random.rotation(),
            false => upright(random),
        };
        let alone = |origin, axes| Block { origin, axes, low: -half, high: half };
        let block = match (place, last) {
            (Place::Hanging, _) => alone(inside(random), turned(random)),
            (Place::ThroughWall, _) => {
                let mut origin = inside(random);
                let axis = random.pick(3);
                origin[axis] = if random.chance(0.5) { 0.0 } else { self.size[axis] };
                origin[axis] += random.between(-0.5, 0.5) * half[axis];
                alone(origin, turned(random))
            }
            (Place::Standing, _) | (_, None) => {
                let origin = inside(random);
                alone(DVec3::new(origin.x, half.y, origin.z), upright(random))
            }
            (Place::Intersecting, Some(last)) => {
                let within = last.low.lerp(last.high, random.between(0.0, 1.0));
                alone(last.origin + last.axes * within, turned(random))
            }
            (_, Some(last)) => beside(random, place, last, half),
        };
        self.features.insert(match place {
            Place::Hanging => "hanging",
            Place::Standing => "standing",
            Place::Intersecting => "intersecting",
            Place::SharedCorner => "shared corner",
            Place::SharedEdge => "shared edge",
            Place::Flush => "flush",
            Place::ThroughWall => "through wall",
        });
        (block, place)
    }

    fn finish(&mut self) -> Finish {
        let colour = self.colour();
        let roughness = self.random.between(0.05, 1.0);
        match self.random.pick(20) {
            0 => Finish::Mirror(colour),
            1 => Finish::Glass(self.clear()),
            2 => Finish::Pane(self.clear()),
            3 => Finish::Metal(colour, roughness),
            4 => Finish::Plastic(colour, roughness),
            5 => {
                let share = self.random.between(0.1, 1.0);
                Finish::Sheet(colour.map(|x| share * x), colour.map(|x| (1.0 - share) * x))
            }
            _ => Finish::Diffuse(colour),
        }
    }

    /// The filter of glass, which may be white however dark the scene is.
    fn clear(&mut self) -> [f64; 3] {
        if self.random.chance(0.5) { [1.0; 3] } else { self.colour() }
    }

    /// One lamp or two, of 1 mm to 0.5 m, at any angle: bare quads and sealed boxes.
    fn lamps(&mut self) {
        for _ in 0..1 + usize::from(self.random.chance(0.3)) {
            let random = &mut self.random;
            let half = 0.5 * 10f64.powf(random.between(-3.0, -0.3));
            let origin = self.size * DVec3::from([0; 3].map(|_| random.between(0.1, 0.9)));
            let is_turned = random.chance(0.7);
            let axes = if is_turned { random.rotation() } else { DMat3::IDENTITY };
            let depth = half * random.between(0.1, 1.0);
            let extent = DVec3::new(half, depth, half * random.between(0.3, 1.0));
            let block = Block { origin, axes, low: -extent, high: extent };
            let is_box = random.chance(0.25);
            let power = 10f64.powf(random.between(0.0, 1.0));
            let quads = if is_box { block.sides().to_vec() } else { vec![block.sides()[1]] };
            let features = [(half < 0.015, "tiny lamp"), (is_turned, "turned lamp"), (is_box, "box lamp")];
            self.features.extend(features.into_iter().filter(|(is, _)| *is).map(|(_, name)| name));
            self.lamp(power, quads);
        }
    }

    /// Adds a lamp of this power, W.
    fn lamp(&mut self, power: f64, quads: Vec<mesh::Quad>) {
        let area: f64 = quads.iter().map(|[a, b, _, d]| (*b - *a).cross(*d - *a).length()).sum();
        let colour = self.colour();
        self.add("lamp", Finish::Lamp(colour, [power / (PI * area); 3]), quads);
    }

    /// Adds coincident surfaces to some scenes.
    fn overlap(&mut self, lift: Lift) -> Option<Overlap> {
        let is_there = self.random.chance(0.16);
        let overlap = Overlap::ALL[self.random.pick(5)];
        let by = if lift == Lift::Lifted { LIFT } else { 0.0 };
        let [first, second] = [0, 1].map(|_| Finish::Diffuse(self.colour()));
        let random = &mut self.random;
        let half = DVec3::from([0; 3].map(|_| random.between(0.1, 0.3)));
        let centre = self.size * DVec3::from([0; 3].map(|_| random.between(0.3, 0.7)));
        let step = half * DVec3::new(random.between(0.5, 1.2), 0.0, random.between(0.5, 1.2));
        let hanging = Block::upright(centre - half, centre + half);
        let flat = |y: f64| {
            let [low, high] = [hanging.low, hanging.high].map(|p| DVec3::new(p.x, y, p.z));
            Block::upright(low, high).sides()
        };
        if !is_there {
            return None;
        }
        match overlap {
            Overlap::Rug => self.add("rug", first, vec![flat(by)[4]]),
            Overlap::FlushLamp => self.lamp(3.0, vec![flat(self.size.y - by)[1]]),
            Overlap::Doubled => {
                self.add("outer", first, hanging.sides().to_vec());
                // Of equal ones the first in the file is on top. Cut along the other diagonal, no face is
                // there twice.
                let inner = hanging.grown(DVec3::splat(-by)).sides().map(|[a, b, c, d]| [b, c, d, a]);
                self.add("inner", second, inner.to_vec());
            }
            Overlap::Partial => {
                self.add("large", first, hanging.sides().to_vec());
                // The smaller one is on top.
                let small = Block { low: hanging.low + step, high: hanging.high + 0.9 * step, ..hanging };
                self.add("small", second, small.grown(by * DVec3::Y).sides().to_vec());
            }
            Overlap::BackToBack => {
                self.add("upper", first, vec![flat(centre.y + by)[4]]);
                self.add("lower", second, vec![flat(centre.y)[1]]);
            }
        }
        Some(overlap)
    }
}

/// A box beside another, along the same axes: it shares a corner, an edge, or part of a plane.
fn beside(random: &mut Random, place: Place, last: Block, half: DVec3) -> Block {
    let [x, y, z] = match random.pick(3) {
        0 => [0, 1, 2],
        1 => [1, 2, 0],
        _ => [2, 0, 1],
    };
    let (mut low, mut high) = (last.high, last.high + 2.0 * half);
    if place != Place::SharedCorner {
        (low[y], high[y]) = (last.low[y], last.high[y]);
    }
    if place == Place::Flush {
        // Beside it, set off along two axes.
        (low[z], high[z]) = (last.low[z], last.low[z] + 2.0 * half[z]);
        let off = random.between(-1.0, 1.0) * half[y];
        (low[y], high[y]) = (last.low[y] + off, last.low[y] + off + 2.0 * half[y]);
    }
    debug_assert_eq!(low[x], last.high[x]);
    Block { low, high, ..last }
}

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 * 2f64.powi(-53)
    }

    fn pick(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn chance(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    /// Uniform over all rotations (Shoemake 1992).
    fn rotation(&mut self) -> DMat3 {
        let (u, v, w) = (self.between(0.0, 1.0), self.between(0.0, TAU), self.between(0.0, TAU));
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        DMat3::from_quat(DQuat::from_xyzw(a * v.sin(), a * v.cos(), b * w.sin(), b * w.cos()))
    }
}
