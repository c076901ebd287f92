//! The cases: scenes as the library has them, and what shines in them as quadrature has it.

use std::f64::consts::PI;

use radiosity::scene::{
    Face, FaceState, GeneralSky, Light, Material, Receiver, Scene, SceneParts, Sky, SkyKind,
};

use crate::quadrature::{self, Area, Place, Vector};

/// Lumens per watt.
const EFFICACY: f64 = 683.0;

/// Horizontal illuminance of every sky, and of the sun, lx.
const HORIZONTAL: f64 = 10_000.0;

/// Index of refraction of panes, and what their glass leaves of light.
const PANE: (f64, f64) = (1.52, 0.9584);

/// Reflectance of the ground outside.
const GROUND: f64 = 0.3;

/// Towards the sun of skies that depend on it: 60° high.
const SUN: Vector = [0.0, 0.866_025_403_784_438_6, 0.5];

type Quad = [Vector; 4];

/// A scene, and illuminance (lx) at any place in it.
pub struct Case {
    /// Number in CIE 171:2006, and what is varied.
    pub name: String,
    pub scene: Scene,
    exact: Box<dyn Fn(Place) -> f64 + Sync>,
}

impl Case {
    /// The exact illuminance of each point of each receiver, lx.
    pub fn exact(&self) -> Vec<Vec<f64>> {
        let receivers = self.scene.receivers().iter();
        let of_receiver = |receiver: &Receiver| {
            let normal = receiver.normal().to_array();
            receiver.points().map(|point| (self.exact)(Place { point: point.to_array(), normal })).collect()
        };
        receivers.map(of_receiver).collect()
    }
}

/// What a scene has besides its surfaces.
#[derive(Default)]
struct Besides {
    lights: Vec<Light>,
    sky: Option<Sky>,
    receivers: Vec<Receiver>,
}

fn scene(name: &str, quads: &[(Quad, usize)], materials: Vec<Material>, light: Besides) -> Scene {
    let mut parts = SceneParts {
        name: name.into(),
        materials,
        objects: vec!["all".into()],
        lights: light.lights,
        sky: light.sky,
        receivers: light.receivers,
        ..Default::default()
    };
    for (quad, material) in quads {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(quad.map(glam::DVec3::from));
        for k in [1, 2] {
            parts.faces.push(Face {
                vertices: [first, first + k, first + k + 1],
                normals: None,
                material: *material as u32,
                object: 0,
                state: FaceState::Kept,
            });
        }
    }
    Scene::new(parts).expect("the scene is sound")
}

fn black() -> Material {
    Material::diffuse("black", &[0.0])
}

/// Points up the back wall, and along the floor.
fn inside() -> Vec<Receiver> {
    let receiver = |name: &str, corner: Vector, edges: [Vector; 2], counts| {
        Receiver::grid(name, corner.into(), edges.map(Into::into), counts)
    };
    vec![
        receiver("wall", [1.9995, 0.0, -3.9999], [[0.001, 0.0, 0.0], [0.0, 3.0, 0.0]], [1, 6]),
        receiver("floor", [1.9995, 0.0001, -4.0], [[0.0, 0.0, 4.0], [0.001, 0.0, 0.0]], [8, 1]),
    ]
}

/// A rectangle in the plane y = 3, looking down, or z = 0, looking inwards.
fn roof([x0, x1]: [f64; 2], [z0, z1]: [f64; 2]) -> Quad {
    [[x0, 3.0, z1], [x0, 3.0, z0], [x1, 3.0, z0], [x1, 3.0, z1]]
}

fn facade([x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> Quad {
    [[x0, y0, 0.0], [x0, y1, 0.0], [x1, y1, 0.0], [x1, y0, 0.0]]
}

/// A black room of 4 x 3 x 4 m whose roof has a square opening of this width, if any, or whose front has one
/// of these extents.
fn room(roof_opening: Option<f64>, front: Option<[[f64; 2]; 2]>) -> Vec<(Quad, usize)> {
    let mut quads = vec![
        [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, -4.0], [0.0, 0.0, -4.0]],
        [[0.0, 0.0, -4.0], [4.0, 0.0, -4.0], [4.0, 3.0, -4.0], [0.0, 3.0, -4.0]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, -4.0], [0.0, 3.0, -4.0], [0.0, 3.0, 0.0]],
        [[4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [4.0, 3.0, -4.0], [4.0, 0.0, -4.0]],
    ];
    match roof_opening.map(|width| 0.5 * width) {
        None => quads.push(roof([0.0, 4.0], [-4.0, 0.0])),
        Some(half) if half < 2.0 => {
            let (low, high) = (2.0 - half, 2.0 + half);
            quads.extend([
                roof([0.0, low], [-4.0, 0.0]),
                roof([high, 4.0], [-4.0, 0.0]),
                roof([low, high], [-4.0, -high]),
                roof([low, high], [-low, 0.0]),
            ]);
        }
        Some(_) => {}
    }
    match front {
        None => quads.push(facade([0.0, 4.0], [0.0, 3.0])),
        Some([[x0, x1], [y0, y1]]) => {
            let around = [
                ([0.0, x0], [0.0, 3.0]),
                ([x1, 4.0], [0.0, 3.0]),
                ([x0, x1], [0.0, y0]),
                ([x0, x1], [y1, 3.0]),
            ];
            let wide = around.into_iter().filter(|(x, y)| x[1] > x[0] && y[1] > y[0]);
            quads.extend(wide.map(|(x, y)| facade(x, y)));
        }
    }
    quads.into_iter().map(|quad| (quad, 0)).collect()
}

fn sky(number: usize, ground: f64) -> Sky {
    let kind = match GeneralSky::new(number, SUN.into()) {
        Some(general) => SkyKind::General(general),
        None => SkyKind::Overcast,
    };
    let sky = Sky { kind, up: [0.0, 1.0, 0.0].into(), zenith: vec![0.0], ground };
    let zenith = HORIZONTAL / EFFICACY / sky.horizontal();
    Sky { zenith: vec![zenith], ..sky }
}

/// Every case, in the order of the report.
pub fn all() -> Vec<Case> {
    let mut cases = vec![point_lamp(), area_lamp()];
    cases.extend([0.0, 40.0, 60.0, 70.0, 80.0].map(glass));
    cases.extend([0.5, 4.0].map(reflection));
    cases.push(obstructed());
    for number in [1, 5, 8, 12, 15, 16] {
        for width in [1.0, 4.0] {
            cases.extend([false, true].map(|is_glazed| under_roof(number, width, is_glazed)));
        }
        for front in [[[1.0, 3.0], [1.0, 2.0]], [[0.0, 4.0], [0.0, 3.0]]] {
            cases.extend([false, true].map(|is_glazed| behind_facade(number, front, is_glazed, Mask::None)));
        }
        let front = [[1.0, 3.0], [1.0, 2.0]];
        cases.extend([Mask::Above, Mask::Before].map(|mask| behind_facade(number, front, false, mask)));
    }
    cases
}

/// 5.2: a point of 10 000 lm under the ceiling.
fn point_lamp() -> Case {
    let candelas = 10_000.0 / (4.0 * PI);
    let position = [2.0, 2.9, -2.0];
    let light = Light::Point { position: position.into(), intensity: vec![candelas / EFFICACY] };
    let light = Besides { lights: vec![light], receivers: inside(), ..Default::default() };
    let exact = move |place: Place| {
        let to = [0, 1, 2].map(|k| position[k] - place.point[k]);
        let squared: f64 = to.iter().map(|x| x * x).sum();
        let cosine = (0..3).map(|k| to[k] * place.normal[k]).sum::<f64>() / squared.sqrt();
        candelas * cosine.max(0.0) / squared
    };
    let name = "5.2 point lamp".to_owned();
    Case { scene: scene(&name, &room(None, None), vec![black()], light), name, exact: Box::new(exact) }
}

/// 5.3: a lamp of 1 x 1 m in the ceiling.
fn area_lamp() -> Case {
    let luminance = 1000.0;
    let mut quads = room(Some(1.0), None);
    quads.push((roof([1.5, 2.5], [-2.5, -1.5]), 1));
    let materials = vec![black(), Material::lamp("lamp", &[0.0], &[luminance / EFFICACY])];
    let light = Besides { receivers: inside(), ..Default::default() };
    let area = roof_area(1.0);
    let exact = move |place| quadrature::illuminance(place, area, |_, _| luminance);
    let name = "5.3 area lamp".to_owned();
    Case { scene: scene(&name, &quads, materials, light), name, exact: Box::new(exact) }
}

fn roof_area(width: f64) -> Area {
    let low = 2.0 - 0.5 * width;
    Area { corner: [low, 3.0, -low - width], edges: [[width, 0.0, 0.0], [0.0, 0.0, width]] }
}

/// 5.5: sun at this angle through a pane.
fn glass(degrees: f64) -> Case {
    let (index, filter) = PANE;
    let angle = degrees.to_radians();
    let pane: Quad = [[-9.0, 1.0, -9.0], [-9.0, 1.0, 9.0], [9.0, 1.0, 9.0], [9.0, 1.0, -9.0]];
    let floor: Quad = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
    let direction = [angle.sin(), -angle.cos(), 0.0];
    let sun =
        Light::Sun { direction: direction.into(), irradiance: vec![HORIZONTAL / EFFICACY], diameter: 0.0 };
    let receiver = Receiver::grid(
        "under",
        [-0.5, 0.5, -0.5].into(),
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(Into::into),
        [2, 2],
    );
    let light = Besides { lights: vec![sun], receivers: vec![receiver], ..Default::default() };
    let materials = vec![black(), Material::pane("pane", index, &[filter])];
    let exact = move |_| HORIZONTAL * angle.cos() * quadrature::pane(angle.cos(), index, filter);
    let name = format!("5.5 pane at {degrees} degrees");
    Case { scene: scene(&name, &[(floor, 0), (pane, 1)], materials, light), name, exact: Box::new(exact) }
}

/// A square of this width on the floor's middle.
fn spot(width: f64) -> (Quad, Area) {
    let (low, high) = (2.0 - 0.5 * width, 2.0 + 0.5 * width);
    let quad = [[low, 0.0, -low], [high, 0.0, -low], [high, 0.0, -high], [low, 0.0, -high]];
    (quad, Area { corner: [low, 0.0, -high], edges: [[width, 0.0, 0.0], [0.0, 0.0, width]] })
}

/// Points on a wall at x = 2.0005 that looks at the spot, and on a ceiling.
fn above() -> Vec<Receiver> {
    let receiver = |name: &str, corner: Vector, edges: [Vector; 2], counts| {
        Receiver::grid(name, corner.into(), edges.map(Into::into), counts)
    };
    vec![
        receiver("wall", [2.0005, 0.0, 0.0], [[-0.001, 0.0, 0.0], [0.0, 3.0, 0.0]], [1, 6]),
        receiver("ceiling", [1.9995, 3.0, 0.0], [[0.0, 0.0, -4.0], [0.001, 0.0, 0.0]], [8, 1]),
    ]
}

fn noon() -> Light {
    Light::Sun { direction: [0.0, -1.0, 0.0].into(), irradiance: vec![HORIZONTAL / EFFICACY], diameter: 0.0 }
}

/// 5.6: light that a sunlit square of this width reflects.
fn reflection(width: f64) -> Case {
    const REFLECTANCE: f64 = 0.8;
    let (quad, area) = spot(width);
    let light = Besides { lights: vec![noon()], receivers: above(), ..Default::default() };
    let exact = move |place| quadrature::illuminance(place, area, |_, _| REFLECTANCE * HORIZONTAL / PI);
    let name = format!("5.6 diffuse reflection, {width} m");
    let materials = vec![Material::diffuse("spot", &[REFLECTANCE])];
    Case { scene: scene(&name, &[(quad, 0)], materials, light), name, exact: Box::new(exact) }
}

/// 5.7: the same square of 4 m, with a black screen in the way that shades nothing of it.
fn obstructed() -> Case {
    const REFLECTANCE: f64 = 0.8;
    let (quad, area) = spot(4.0);
    // Upright at z = -1, from the floor up to 1 m.
    let screen: Quad = [[0.0, 0.0, -1.0], [4.0, 0.0, -1.0], [4.0, 1.0, -1.0], [0.0, 1.0, -1.0]];
    let light = Besides { lights: vec![noon()], receivers: above(), ..Default::default() };
    let exact = move |place: Place| {
        let point = place.point;
        quadrature::illuminance(place, area, |direction, at| {
            // Where the way from the point to the floor passes z = -1.
            let along = (-1.0 - point[2]) / direction[2];
            let [x, y] = [0, 1].map(|k| point[k] + along * direction[k]);
            let is_between = (point[2] + 1.0) * (at[2] + 1.0) < 0.0;
            let is_hidden = is_between && (0.0..1.0).contains(&y) && (0.0..4.0).contains(&x);
            if is_hidden { 0.0 } else { REFLECTANCE * HORIZONTAL / PI }
        })
    };
    let name = "5.7 internal obstruction".to_owned();
    let materials = vec![Material::diffuse("spot", &[REFLECTANCE]), black()];
    let quads = [(quad, 0), (screen, 1)];
    Case { scene: scene(&name, &quads, materials, light), name, exact: Box::new(exact) }
}

/// 5.9 and 5.10: sky through an opening in the roof.
fn under_roof(number: usize, width: f64, is_glazed: bool) -> Case {
    let mut quads = room(Some(width), None);
    let half = 0.5 * width;
    if is_glazed {
        quads.push((roof([2.0 - half, 2.0 + half], [-2.0 - half, -2.0 + half]), 1));
    }
    let (index, filter) = PANE;
    let materials = vec![black(), Material::pane("pane", index, &[filter])];
    let light = Besides { sky: Some(sky(number, 0.0)), receivers: inside(), ..Default::default() };
    let luminance = quadrature::sky(number, SUN, HORIZONTAL, 0.0);
    let exact = move |place| {
        quadrature::illuminance(place, roof_area(width), |direction, _| {
            let glass = if is_glazed { quadrature::pane(direction[1].abs(), index, filter) } else { 1.0 };
            luminance(direction) * glass
        })
    };
    let case = if is_glazed { "5.10 glazed roof" } else { "5.9 roof opening" };
    let name = format!("{case} {width} m, sky {number}");
    Case { scene: scene(&name, &quads, materials, light), name, exact: Box::new(exact) }
}

/// What stands before a facade, black.
#[derive(Clone, Copy, PartialEq)]
enum Mask {
    None,
    /// A canopy of 1 m along the top of the opening.
    Above,
    /// A wall of 5 m height, 6 m away.
    Before,
}

/// How far masks extend to either side.
const WIDE: f64 = 200.0;

/// 5.11 to 5.14: sky and ground through an opening in the front.
fn behind_facade(number: usize, front: [[f64; 2]; 2], is_glazed: bool, mask: Mask) -> Case {
    let [x, [low, high]] = front;
    let mut quads = room(None, Some(front));
    if is_glazed {
        quads.push((facade(x, [low, high]), 1));
    }
    let sides = [-WIDE, 4.0 + WIDE];
    quads.extend(match mask {
        Mask::None => None,
        Mask::Above => {
            let [a, b] = sides;
            Some(([[a, high, 0.0], [a, high, 1.0], [b, high, 1.0], [b, high, 0.0]], 0))
        }
        Mask::Before => {
            let [a, b] = sides;
            Some(([[a, 0.0, 6.0], [b, 0.0, 6.0], [b, 5.0, 6.0], [a, 5.0, 6.0]], 0))
        }
    });
    let (index, filter) = PANE;
    let materials = vec![black(), Material::pane("pane", index, &[filter])];
    let light = Besides { sky: Some(sky(number, GROUND)), receivers: inside(), ..Default::default() };
    let luminance = quadrature::sky(number, SUN, HORIZONTAL, GROUND);
    let area = Area { corner: [x[0], low, 0.0], edges: [[x[1] - x[0], 0.0, 0.0], [0.0, high - low, 0.0]] };
    let is_masked = move |direction: Vector, at: Vector| match mask {
        Mask::None => false,
        Mask::Above => direction[1] > 0.0 && (high - at[1]) / direction[1] * direction[2] < 1.0,
        Mask::Before => (0.0..5.0).contains(&(at[1] + 6.0 / direction[2] * direction[1])),
    };
    let exact = move |place: Place| {
        let parts = quadrature::split(area, place.point[1]).into_iter();
        let of_part = |part: Area| {
            quadrature::illuminance(place, part, |direction, at| {
                let glass = if is_glazed { quadrature::pane(direction[2].abs(), index, filter) } else { 1.0 };
                if is_masked(direction, at) { 0.0 } else { luminance(direction) * glass }
            })
        };
        parts.map(of_part).sum()
    };
    let case = match (mask, is_glazed) {
        (Mask::None, false) => "5.11 facade opening",
        (Mask::None, true) => "5.12 glazed facade",
        (Mask::Above, _) => "5.13 canopy",
        (Mask::Before, _) => "5.14 wall opposite",
    };
    let name = format!("{case} {} x {} m, sky {number}", x[1] - x[0], high - low);
    Case { scene: scene(&name, &quads, materials, light), name, exact: Box::new(exact) }
}
