//! A mesh that grows polygon by polygon, and the sides of upright boxes it is mostly made of.

use Side::*;

pub type Point = [f64; 3];
pub type Quad = [Point; 4];

/// A side of an upright box. Left to right is +x, bottom to top +y, back to front +z.
#[derive(Clone, Copy)]
pub enum Side {
    Left,
    Right,
    Bottom,
    Top,
    Back,
    Front,
}

pub const ALL: [Side; 6] = [Left, Right, Bottom, Top, Back, Front];
/// What shows of a box that stands on something.
pub const STANDING: [Side; 5] = [Left, Right, Top, Back, Front];
/// What shows of a box that stands under something too.
pub const UPRIGHT: [Side; 4] = [Left, Right, Back, Front];

/// One side of the box from `low` to `high`, its front outward.
pub fn outside(low: Point, high: Point, side: Side) -> Quad {
    let ([a, b, c], [d, e, f]) = (low, high);
    match side {
        Left => [[a, b, c], [a, b, f], [a, e, f], [a, e, c]],
        Right => [[d, b, f], [d, b, c], [d, e, c], [d, e, f]],
        Bottom => [[a, b, c], [d, b, c], [d, b, f], [a, b, f]],
        Top => [[a, e, f], [d, e, f], [d, e, c], [a, e, c]],
        Back => [[d, b, c], [a, b, c], [a, e, c], [d, e, c]],
        Front => [[a, b, f], [d, b, f], [d, e, f], [a, e, f]],
    }
}

/// The same side with its front inward.
pub fn inside(low: Point, high: Point, side: Side) -> Quad {
    reversed(outside(low, high, side))
}

/// The same quad from the other side: its back becomes its front.
pub fn reversed([a, b, c, d]: Quad) -> Quad {
    [a, d, c, b]
}

/// A mesh that grows polygon by polygon. What is added gets the object and material last given
/// to [`Mesh::paint`]; equal points become one vertex.
#[derive(Default)]
pub struct Mesh {
    pub vertices: Vec<Point>,
    pub polygons: Vec<Polygon>,
    /// Texture coordinates.
    pub coordinates: Vec<[f64; 2]>,
    object: &'static str,
    material: &'static str,
    place: Option<Place>,
}

pub struct Polygon {
    pub object: &'static str,
    pub material: &'static str,
    pub corners: Vec<usize>,
    /// Places in `coordinates`, one a corner; empty where no picture lies on it.
    pub coordinates: Vec<usize>,
}

/// Where a piece of furniture stands, and the horizontal unit vector (x, z) it faces.
#[derive(Clone, Copy)]
struct Place {
    origin: Point,
    facing: [f64; 2],
}

impl Place {
    fn apply(&self, [x, y, z]: Point) -> Point {
        let ([ox, oy, oz], [fx, fz]) = (self.origin, self.facing);
        [ox + x * fz + z * fx, oy + y, oz - x * fx + z * fz]
    }
}

impl Mesh {
    /// What follows belongs to this object and is made of this material.
    pub fn paint(&mut self, object: &'static str, material: &'static str) -> &mut Mesh {
        (self.object, self.material) = (object, material);
        self
    }

    /// Builds something in its own coordinates at another place, facing another way.
    pub fn placed(&mut self, origin: Point, facing: [f64; 2], build: impl FnOnce(&mut Mesh) -> f64) -> f64 {
        self.place = Some(Place { origin, facing });
        let area = build(self);
        self.place = None;
        area
    }

    /// One polygon, counter-clockwise seen from its front.
    pub fn face(&mut self, corners: &[Point]) {
        let corners = corners.iter().map(|&point| self.vertex(point)).collect();
        let (object, material, coordinates) = (self.object, self.material, Vec::new());
        self.polygons.push(Polygon { object, material, corners, coordinates });
    }

    /// A quad on which a picture lies, so many times from its first corner to the second and from there to
    /// the third.
    pub fn mapped(&mut self, quad: &Quad, [across, up]: [f64; 2]) {
        self.face(quad);
        let coordinates = [[0.0, 0.0], [across, 0.0], [across, up], [0.0, up]];
        let places = coordinates.map(|at| self.coordinate(at)).to_vec();
        self.polygons.last_mut().expect("the quad").coordinates = places;
    }

    fn coordinate(&mut self, at: [f64; 2]) -> usize {
        self.coordinates.iter().position(|known| *known == at).unwrap_or_else(|| {
            self.coordinates.push(at);
            self.coordinates.len() - 1
        })
    }

    fn vertex(&mut self, point: Point) -> usize {
        // Round to 12 decimals, so that points meant to be one are one.
        let point = self.place.map_or(point, |place| place.apply(point));
        let point = point.map(|x| (x * 1e12).round() / 1e12 + 0.0);
        self.vertices.iter().position(|v| *v == point).unwrap_or_else(|| {
            self.vertices.push(point);
            self.vertices.len() - 1
        })
    }

    /// The given sides of a box, fronts outward.
    pub fn solid(&mut self, low: Point, high: Point, sides: &[Side]) {
        for &side in sides {
            self.face(&outside(low, high, side));
        }
    }

    /// The given sides of a box, fronts inward.
    pub fn room(&mut self, low: Point, high: Point, sides: &[Side]) {
        for &side in sides {
            self.face(&inside(low, high, side));
        }
    }

    /// Fills the ring between a quad and a hole in it with four quads, mitred like a picture
    /// frame: each has one edge of the quad and one of the hole, so nothing meets in mid-edge.
    /// The hole's corners come in the order of the quad's.
    pub fn surround(&mut self, outer: Quad, hole: Quad) {
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            self.face(&[outer[i], outer[j], hole[j], hole[i]]);
        }
    }

    /// The top of an upright block and its walls down to the floor.
    pub fn block(&mut self, top: Quad) {
        let floor = top.map(|[x, _, z]| [x, 0.0, z]);
        self.face(&top);
        for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            self.face(&[floor[i], floor[j], top[j], top[i]]);
        }
    }

    /// Four square legs from the floor to an underside; their outer corners are at (±x, ±z).
    pub fn four_legs(&mut self, x: f64, z: f64, thickness: f64, height: f64) {
        for x in [-x, x - thickness] {
            for z in [-z, z - thickness] {
                self.solid([x, 0.0, z], [x + thickness, height, z + thickness], &UPRIGHT);
            }
        }
    }

    /// The unit sphere from inside: an icosahedron with every triangle cut in four, `cuts` times.
    pub fn icosphere(&mut self, cuts: u32) {
        // The icosahedron's corners are (0, ±1, ±φ) and its rotations; all its edges have length 2,
        // and any three corners that far apart from each other are a face.
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let mut corners = Vec::new();
        for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
            corners.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
        }
        let edge = |a: Point, b: Point| (length(minus(a, b)) - 2.0).abs() < 1e-9;
        for (i, &a) in corners.iter().enumerate() {
            for (j, &b) in corners.iter().enumerate().skip(i + 1) {
                for &c in &corners[j + 1..] {
                    if edge(a, b) && edge(b, c) && edge(c, a) {
                        self.spherical_triangle([a, b, c].map(unit), cuts);
                    }
                }
            }
        }
    }

    fn spherical_triangle(&mut self, [a, b, c]: [Point; 3], cuts: u32) {
        if cuts > 0 {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| unit(plus(p, q)));
            for part in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
                self.spherical_triangle(part, cuts - 1);
            }
        } else if dot(cross(minus(b, a), minus(c, a)), a) < 0.0 {
            self.face(&[a, b, c]);
        } else {
            self.face(&[a, c, b]);
        }
    }

    /// How many triangles the polygons make once they are fanned.
    pub fn face_count(&self) -> usize {
        self.polygons.iter().map(|p| p.corners.len() - 2).sum()
    }

    pub fn area(&self) -> f64 {
        let fan = |p: &Polygon| -> f64 {
            let first = self.vertices[p.corners[0]];
            let spokes: Vec<_> = p.corners[1..].iter().map(|&i| minus(self.vertices[i], first)).collect();
            spokes.windows(2).map(|s| length(cross(s[0], s[1])) / 2.0).sum()
        };
        self.polygons.iter().map(fan).sum()
    }
}

pub fn plus(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: Point) -> Point {
    a.map(|x| x / length(a))
}
