//! Scenes that no test, table or picture looks at: rooms of every kind, made of random numbers that are
//! always the same.

use glam::DVec3;
use radiosity::scene::{Face, FaceState, Light, Material, Scene, SceneError, SceneParts, Sky, SkyKind};

/// A scene and what it is called.
pub type Named = (&'static str, Scene);

/// All of them.
pub fn all() -> Result<Vec<Named>, SceneError> {
    let mut all = Vec::new();
    for (name, seed) in [("boxes_a", 11), ("boxes_b", 12), ("boxes_c", 13)] {
        all.push((name, boxes(seed)?));
    }
    for (name, seed) in [("hall_a", 21), ("hall_b", 22)] {
        all.push((name, corner_hall(seed)?));
    }
    for (name, seed) in [("window_a", 31), ("window_b", 32)] {
        all.push((name, window_room(seed)?));
    }
    for (name, seed) in [("court_a", 41), ("court_b", 42)] {
        all.push((name, court(seed)?));
    }
    for (name, seed) in [("spots_a", 51), ("spots_b", 52)] {
        all.push((name, spots(seed)?));
    }
    for (name, seed) in [("table_a", 61), ("table_b", 62)] {
        all.push((name, table_room(seed)?));
    }
    all.push(("two_rooms", two_rooms(71)?));
    all.push(("on_ground", on_ground(81)?));
    all.push(("glass", glass(91)?));
    Ok(all)
}

/// Numbers in [0, 1) that are always the same.
struct Numbers(u64);

impl Numbers {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

/// A scene in the making.
struct Builder {
    parts: SceneParts,
    numbers: Numbers,
}

impl Builder {
    fn new(seed: u64) -> Self {
        let parts = SceneParts { name: "scene".into(), ..Default::default() };
        let mut builder = Self { parts, numbers: Numbers(seed) };
        (0..20).for_each(|_| _ = builder.numbers.between(0.0, 1.0));
        builder
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.numbers.between(low, high)
    }

    /// A material of a random reflectance.
    fn paint(&mut self, low: f64, high: f64) -> u32 {
        let reflectance = self.between(low, high);
        self.material(Material::diffuse(format!("paint {}", self.parts.materials.len()), &[reflectance]))
    }

    fn material(&mut self, material: Material) -> u32 {
        self.parts.materials.push(material);
        self.parts.materials.len() as u32 - 1
    }

    /// A quadrilateral, counter-clockwise seen from the front, as an object of its own or a part of the last.
    fn quad(&mut self, corners: [[f64; 3]; 4], material: u32, is_new: bool) {
        if is_new || self.parts.objects.is_empty() {
            self.parts.objects.push(format!("object {}", self.parts.objects.len()));
        }
        let (first, object) = (self.parts.vertices.len() as u32, self.parts.objects.len() as u32 - 1);
        self.parts.vertices.extend(corners.map(DVec3::from));
        for k in [1, 2] {
            let vertices = [first, first + k, first + k + 1];
            self.parts.faces.push(Face { vertices, normals: None, material, object, state: FaceState::Kept });
        }
    }

    /// A box, its fronts inside (a room) or outside (a solid); some sides may be left out: x, y, z at the low
    /// end, then at the high end.
    fn cuboid(&mut self, [a, b]: [[f64; 3]; 2], material: u32, is_room: bool, without: &[usize]) {
        let sides = [
            [[a[0], a[1], a[2]], [a[0], b[1], a[2]], [a[0], b[1], b[2]], [a[0], a[1], b[2]]],
            [[a[0], a[1], a[2]], [a[0], a[1], b[2]], [b[0], a[1], b[2]], [b[0], a[1], a[2]]],
            [[a[0], a[1], a[2]], [b[0], a[1], a[2]], [b[0], b[1], a[2]], [a[0], b[1], a[2]]],
            [[b[0], a[1], a[2]], [b[0], a[1], b[2]], [b[0], b[1], b[2]], [b[0], b[1], a[2]]],
            [[a[0], b[1], a[2]], [b[0], b[1], a[2]], [b[0], b[1], b[2]], [a[0], b[1], b[2]]],
            [[a[0], a[1], b[2]], [a[0], b[1], b[2]], [b[0], b[1], b[2]], [b[0], a[1], b[2]]],
        ];
        for (k, [p, q, r, s]) in sides.into_iter().enumerate().filter(|(k, _)| !without.contains(k)) {
            let corners = if is_room { [p, q, r, s] } else { [p, s, r, q] };
            self.quad(corners, material, is_room || k == 0 || self.parts.objects.is_empty());
        }
    }

    /// A wall across z with a hole, fronts towards lower z.
    fn wall_with_hole(&mut self, z: f64, [low, high]: [[f64; 2]; 2], hole: [[f64; 2]; 2], material: u32) {
        let [from, to] = hole;
        let strips = [
            [low[0], from[0], low[1], high[1]],
            [to[0], high[0], low[1], high[1]],
            [from[0], to[0], low[1], from[1]],
            [from[0], to[0], to[1], high[1]],
        ];
        let mut is_new = true;
        for [x0, x1, y0, y1] in strips.into_iter().filter(|[x0, x1, y0, y1]| x1 > x0 && y1 > y0) {
            self.quad([[x0, y0, z], [x0, y1, z], [x1, y1, z], [x1, y0, z]], material, is_new);
            is_new = false;
        }
    }

    /// A lamp of this half-width that faces down.
    fn lamp(&mut self, [x, y, z]: [f64; 3], half: f64, emission: f64) {
        let material = self.material(Material::lamp("lamp", &[0.0], &[emission]));
        let at = |dx: f64, dz: f64| [x + dx * half, y, z + dz * half];
        self.quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)], material, true);
    }

    /// Some boxes that stand on the ground within a room of this size.
    fn furnish(&mut self, count: usize, size: [f64; 3], material: u32) {
        for _ in 0..count {
            let [w, h, d] =
                [self.between(0.2, 0.9), self.between(0.2, 0.5 * size[1]), self.between(0.2, 0.9)];
            let [x, z] = [self.between(0.1, size[0] - w - 0.1), self.between(0.1, size[2] - d - 0.1)];
            // A hair over the ground, and so no part of it.
            self.cuboid([[x, 0.003, z], [x + w, h, z + d]], material, false, &[]);
        }
    }

    fn sky(&mut self, kind: SkyKind) {
        self.parts.sky = Some(Sky { kind, up: DVec3::Y, zenith: vec![1.0], ground: 0.2 });
    }

    fn sun(&mut self) {
        let direction = DVec3::new(self.between(-0.5, 0.5), -1.0, self.between(-1.2, -0.5)).normalize();
        self.parts.lights.push(Light::Sun { direction, irradiance: vec![8.0], diameter: 0.533 });
    }

    fn scene(self) -> Result<Scene, SceneError> {
        Scene::new(self.parts)
    }
}

/// A closed room with boxes and a lamp.
fn boxes(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(3.0, 6.0), b.between(2.4, 3.2), b.between(3.0, 6.0)];
    let (walls, wood) = (b.paint(0.4, 0.8), b.paint(0.2, 0.5));
    b.cuboid([[0.0; 3], size], walls, true, &[]);
    b.furnish(4, size, wood);
    let half = b.between(0.1, 0.5);
    b.lamp([0.5 * size[0], size[1] - 0.02, 0.5 * size[2]], half, 20.0);
    b.scene()
}

/// A hall with a corner, lit at one end.
fn corner_hall(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let (w, h) = (b.between(1.4, 2.2), b.between(2.3, 3.0));
    let [long, short] = [b.between(5.0, 9.0), b.between(3.0, 6.0)];
    let white = b.paint(0.7, 0.85);
    // Along x from 0 to `long`, then along z from 0 to `short` at its far end.
    let [x, z] = [long - w, w];
    let floor = |x0: f64, x1: f64, z0: f64, z1: f64, y: f64, up: bool| match up {
        true => [[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]],
        false => [[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]],
    };
    for (y, up) in [(0.0, true), (h, false)] {
        b.quad(floor(0.0, long, 0.0, w, y, up), white, true);
        b.quad(floor(x, long, w, short + w, y, up), white, false);
    }
    let end = short + w;
    b.quad([[0.0, 0.0, 0.0], [0.0, h, 0.0], [0.0, h, w], [0.0, 0.0, w]], white, true);
    b.quad([[0.0, 0.0, 0.0], [long, 0.0, 0.0], [long, h, 0.0], [0.0, h, 0.0]], white, true);
    b.quad([[long, 0.0, 0.0], [long, 0.0, end], [long, h, end], [long, h, 0.0]], white, true);
    b.quad([[x, 0.0, end], [x, h, end], [long, h, end], [long, 0.0, end]], white, true);
    b.quad([[x, 0.0, z], [x, h, z], [x, h, end], [x, 0.0, end]], white, true);
    b.quad([[0.0, 0.0, z], [0.0, h, z], [x, h, z], [x, 0.0, z]], white, true);
    b.lamp([0.5 * w, h - 0.02, 0.5 * w], 0.3, 20.0);
    b.scene()
}

/// A furnished room with a window under sky and sun.
fn window_room(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(3.0, 6.0), b.between(2.4, 3.2), b.between(3.0, 6.0)];
    let (walls, wood) = (b.paint(0.5, 0.8), b.paint(0.2, 0.5));
    b.cuboid([[0.0; 3], size], walls, true, &[5]);
    let [from, width] = [b.between(0.4, 1.0), b.between(0.8, 1.8)];
    let [sill, top] = [b.between(0.6, 1.0), b.between(1.8, 2.2)];
    let hole = [[from, sill], [from + width, top]];
    b.wall_with_hole(size[2], [[0.0, 0.0], [size[0], size[1]]], hole, walls);
    b.furnish(3, size, wood);
    b.sky(SkyKind::Overcast);
    if seed.is_multiple_of(2) {
        b.sun();
    }
    b.scene()
}

/// Four walls around a yard, open above.
fn court(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(5.0, 12.0), b.between(3.0, 9.0), b.between(5.0, 12.0)];
    let (walls, stone) = (b.paint(0.4, 0.7), b.paint(0.2, 0.4));
    b.cuboid([[0.0; 3], size], walls, true, &[4]);
    b.furnish(3, size, stone);
    b.sky(SkyKind::Overcast);
    if seed.is_multiple_of(2) {
        b.sun();
    }
    b.scene()
}

/// A room under narrow spots.
fn spots(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(4.0, 7.0), b.between(2.6, 3.4), b.between(4.0, 7.0)];
    let (walls, wood) = (b.paint(0.4, 0.7), b.paint(0.2, 0.5));
    b.cuboid([[0.0; 3], size], walls, true, &[]);
    b.furnish(2, size, wood);
    for _ in 0..3 {
        let position =
            DVec3::new(b.between(0.5, size[0] - 0.5), size[1] - 0.1, b.between(0.5, size[2] - 0.5));
        let direction = DVec3::new(b.between(-0.6, 0.6), -1.0, b.between(-0.6, 0.6)).normalize();
        let (cone, penumbra) = (b.between(20.0, 50.0), b.between(0.0, 8.0));
        b.parts.lights.push(Light::Spot { position, direction, intensity: vec![5.0], cone, penumbra });
    }
    b.scene()
}

/// A room with a table and shelves, whose faces are much smaller than walls.
fn table_room(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(3.0, 6.0), b.between(2.4, 3.2), b.between(3.0, 6.0)];
    let (walls, wood) = (b.paint(0.5, 0.8), b.paint(0.2, 0.5));
    b.cuboid([[0.0; 3], size], walls, true, &[]);
    let [x, z] = [b.between(0.5, size[0] - 1.8), b.between(0.5, size[2] - 1.4)];
    b.cuboid([[x, 0.7, z], [x + 1.2, 0.74, z + 0.8]], wood, false, &[]);
    for (dx, dz) in [(0.02, 0.02), (1.12, 0.02), (0.02, 0.72), (1.12, 0.72)] {
        b.cuboid([[x + dx, 0.001, z + dz], [x + dx + 0.06, 0.699, z + dz + 0.06]], wood, false, &[]);
    }
    for k in 0..3 {
        let y = 0.5 + 0.4 * f64::from(k);
        b.cuboid([[0.01, y, 0.6], [0.26, y + 0.02, 1.8]], wood, false, &[]);
    }
    b.lamp([0.5 * size[0], size[1] - 0.02, 0.5 * size[2]], 0.25, 20.0);
    b.scene()
}

/// Two rooms with a door between, one of them dark.
fn two_rooms(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let (w, h) = (b.between(3.0, 5.0), b.between(2.4, 3.0));
    let [near, far] = [b.between(3.0, 5.0), b.between(3.0, 5.0)];
    let walls = b.paint(0.5, 0.75);
    b.cuboid([[0.0; 3], [w, h, near]], walls, true, &[5]);
    b.cuboid([[0.0, 0.0, near], [w, h, near + far]], walls, true, &[2]);
    let door = b.between(0.5, 1.5);
    b.wall_with_hole(near, [[0.0, 0.0], [w, h]], [[door, 0.0], [door + 0.9, 2.0]], walls);
    b.lamp([0.5 * w, h - 0.02, 0.5 * near], 0.3, 20.0);
    b.scene()
}

/// A room with a window on a wide ground.
fn on_ground(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(3.0, 6.0), b.between(2.4, 3.2), b.between(3.0, 6.0)];
    let (walls, grass) = (b.paint(0.4, 0.7), b.paint(0.1, 0.3));
    b.cuboid([[0.0; 3], size], walls, true, &[5]);
    b.wall_with_hole(size[2], [[0.0, 0.0], [size[0], size[1]]], [[1.0, 0.8], [2.2, 2.0]], walls);
    let g = 400.0;
    b.quad([[-g, -0.3, -g], [-g, -0.3, g], [g, -0.3, g], [g, -0.3, -g]], grass, true);
    b.sky(SkyKind::Overcast);
    b.scene()
}

/// A room with a block of glass under a lamp.
fn glass(seed: u64) -> Result<Scene, SceneError> {
    let mut b = Builder::new(seed);
    let size = [b.between(3.0, 5.0), b.between(2.4, 3.0), b.between(3.0, 5.0)];
    let walls = b.paint(0.4, 0.7);
    b.cuboid([[0.0; 3], size], walls, true, &[]);
    let clear = b.material(Material::dielectric("glass", 1.5, &[1.0]));
    let [x, z] = [0.5 * size[0], 0.5 * size[2]];
    // A ball of eight by sixteen facets.
    let at = |i: usize, j: usize| {
        let (tilt, turn) =
            (std::f64::consts::PI * i as f64 / 8.0, std::f64::consts::TAU * (j % 16) as f64 / 16.0);
        [x + 0.5 * tilt.sin() * turn.cos(), 1.0 + 0.5 * tilt.cos(), z + 0.5 * tilt.sin() * turn.sin()]
    };
    for i in 0..8 {
        for j in 0..16 {
            b.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)], clear, i == 0 && j == 0);
        }
    }
    b.lamp([x, size[1] - 0.02, z], 0.25, 20.0);
    b.scene()
}
