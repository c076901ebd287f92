//! Illuminance at the points of the cases by quadrature: midpoint sums over what shines, and nothing of the
//! library.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

pub type Vector = [f64; 3];

/// A point and the direction it looks in.
#[derive(Clone, Copy)]
pub struct Place {
    pub point: Vector,
    pub normal: Vector,
}

/// A parallelogram.
#[derive(Clone, Copy)]
pub struct Area {
    pub corner: Vector,
    pub edges: [Vector; 2],
}

/// Steps along each edge of what shines.
const STEPS: usize = 1000;

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn plus(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// ∫ L cos θ dω at a place over the directions towards an area, for a luminance by direction.
pub fn illuminance(place: Place, area: Area, luminance: impl Fn(Vector, Vector) -> f64) -> f64 {
    let across = cross(area.edges[0], area.edges[1]);
    let whole = dot(across, across).sqrt();
    let step = 1.0 / STEPS as f64;
    let mut sum = 0.0;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let [u, v] = [i, j].map(|k| (k as f64 + 0.5) * step);
            let at = plus(plus(area.corner, u, area.edges[0]), v, area.edges[1]);
            let to = plus(at, -1.0, place.point);
            let squared = dot(to, to);
            let direction = to.map(|x| x / squared.sqrt());
            let here = dot(direction, place.normal);
            if here > 0.0 {
                let there = (dot(direction, across) / whole).abs();
                sum += luminance(direction, at) * here * there / squared;
            }
        }
    }
    sum * whole * step * step
}

/// The part of an area over a height, and that under it; y is up, and the area's second edge is vertical.
pub fn split(area: Area, height: f64) -> Vec<Area> {
    let (low, rise) = (area.corner[1], area.edges[1][1]);
    let at = ((height - low) / rise).clamp(0.0, 1.0);
    let part = |from: f64, to: f64| Area {
        corner: plus(area.corner, from, area.edges[1]),
        edges: [area.edges[0], area.edges[1].map(|x| x * (to - from))],
    };
    [part(0.0, at), part(at, 1.0)].into_iter().filter(|part| part.edges[1][1] > 1e-12).collect()
}

/// a, b, c, d and e of the CIE standard general skies (CIE S 011/E:2003).
const SKIES: [[f64; 5]; 15] = [
    [4.0, -0.7, 0.0, -1.0, 0.0],
    [4.0, -0.7, 2.0, -1.5, 0.15],
    [1.1, -0.8, 0.0, -1.0, 0.0],
    [1.1, -0.8, 2.0, -1.5, 0.15],
    [0.0, -1.0, 0.0, -1.0, 0.0],
    [0.0, -1.0, 2.0, -1.5, 0.15],
    [0.0, -1.0, 5.0, -2.5, 0.3],
    [0.0, -1.0, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.3],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.3],
    [-1.0, -0.15, 16.0, -3.0, 0.3],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// Luminance by direction of a sky that sends `horizontal` lux on open ground, which reflects `ground` of it.
pub fn sky(number: usize, sun: Vector, horizontal: f64, ground: f64) -> impl Fn(Vector) -> f64 {
    let relative = move |d: Vector| {
        let height = d[1].max(1e-12);
        if number == 16 {
            return 1.0 + 2.0 * height;
        }
        let [a, b, c, k, e] = SKIES[number - 1];
        let angle = dot(d, sun).clamp(-1.0, 1.0).acos();
        let scattering = 1.0 + c * ((k * angle).exp() - (k * FRAC_PI_2).exp()) + e * angle.cos().powi(2);
        (1.0 + a * (b / height).exp()) * scattering
    };
    let mut whole = 0.0;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let height = (i as f64 + 0.5) / STEPS as f64;
            let angle = (j as f64 + 0.5) / STEPS as f64 * TAU;
            let radius = (1.0 - height * height).sqrt();
            whole += relative([radius * angle.cos(), height, radius * angle.sin()]) * height;
        }
    }
    let zenith = horizontal / (whole * TAU / (STEPS * STEPS) as f64);
    move |d: Vector| if d[1] > 0.0 { zenith * relative(d) } else { ground * horizontal / PI }
}

/// The part of light that a pane lets through at this cosine, by Fresnel's equations for both polarizations:
/// all reflections between its surfaces included, and what its glass absorbs on each way across.
pub fn pane(cosine: f64, index: f64, filter: f64) -> f64 {
    let sine = (1.0 - cosine * cosine).sqrt() / index;
    let inner = (1.0 - sine * sine).sqrt();
    let across = ((cosine - index * inner) / (cosine + index * inner)).powi(2);
    let along = ((index * cosine - inner) / (index * cosine + inner)).powi(2);
    let through = |once: f64| filter * (1.0 - once).powi(2) / (1.0 - (filter * once).powi(2));
    0.5 * (through(across) + through(along))
}
