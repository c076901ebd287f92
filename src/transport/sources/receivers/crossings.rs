//! Crossings: light from points and suns that mirrors, metals and glass throw through a receiver.
//!
//! A receiver's points stand in the way of nothing, and no ray that starts in one finds such light. So lights
//! shoot rays as at patches, and every point has the mean over its cell of the grid: the flux that crosses it
//! from the front, by the cell's area.

use glam::{DMat2, DVec2, DVec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::super::{LightOptions, PARTS, TASK};
use crate::progress::Cancelled;
use crate::scene::Receiver;
use crate::trace::sampling::{SEQUENCE_END, Sampler, Sequence, Stream};
use crate::trace::{Destination, Hit, Lights, Ray, SpecularPath, Targets, Tint, Tracer};
use crate::transport::rows::Shots;

/// Fewest and most sequences of shots from all lights.
const SEQUENCES: [usize; 2] = [8, 64];

/// The cells of a receiver, normalised frame.
struct Grid {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    receiver: Receiver,
    /// From scalar products with the edges to coordinates along them.
    inverse: DMat2,
    counts: [usize; 2],
}

impl Grid {
    fn new(tracer: &Tracer, receiver: &Receiver) -> Self {
        let edges = receiver.edges.map(|edge| edge / tracer.frame().scale());
        let [a, b] = edges;
        let products = DMat2::from_cols(DVec2::new(a.dot(a), a.dot(b)), DVec2::new(a.dot(b), b.dot(b)));
        Self {
            corner: tracer.frame().from_world(receiver.corner),
            edges,
            normal: receiver.normal(),
            receiver: receiver.clone(),
            inverse: products.inverse(),
            counts: receiver.counts,
        }
    }

    /// The area of a cell.
    fn cell(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length() / (self.counts[0] * self.counts[1]) as f64
    }

    /// The cell that a ray crosses within this distance, and what part of its flux by the cell's area counts.
    #[inline]
    fn crossed(&self, ray: &Ray, distance: f64) -> Option<(usize, f64)> {
        let along = ray.direction.dot(self.normal);
        let to_plane = (self.corner - ray.origin).dot(self.normal) / along;
        let response = self.receiver.response(-ray.direction);
        if response <= 0.0 || !(to_plane > 0.0 && to_plane < distance) {
            return None;
        }
        let from_corner = ray.origin + to_plane * ray.direction - self.corner;
        let [x, y] = (self.inverse * DVec2::from(self.edges.map(|edge| edge.dot(from_corner)))).to_array();
        let [columns, rows] = self.counts;
        let inside = (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y);
        let counts = self.receiver.maintenance * response / along.abs();
        inside.then(|| ((y * rows as f64) as usize * columns + (x * columns as f64) as usize, counts))
    }
}

/// Adds to the irradiance of a receiver's points (m × c, W·m⁻²) what lights throw through its cells; answers
/// by how much more each eighth of the shots finds by itself, or nothing where there are no such shots.
pub fn add_crossings(
    tracer: &Tracer,
    lights: &Lights,
    receiver: &Receiver,
    options: &LightOptions,
    irradiance: &mut DMatrix<f64>,
) -> Result<Vec<DMatrix<f64>>, Cancelled> {
    let Some(targets) = Targets::new(tracer, lights).filter(|_| options.caustics == Shots::Shot) else {
        return Ok(Vec::new());
    };
    let grid = Grid::new(tracer, receiver);
    let channels = tracer.scene().channels();
    let wanted = receiver.len() * options.rays as usize / SEQUENCE_END as usize;
    let [fewest, most] = SEQUENCES;
    let sequences = wanted.clamp(fewest, most).div_ceil(lights.len().max(1)).next_multiple_of(PARTS) as u64;
    let worth = 1.0 / (grid.cell() * (sequences * u64::from(SEQUENCE_END)) as f64);
    let shoot = |light: usize, sequence: Sequence, task: u32| {
        let mut found = Vec::new();
        let mut left = vec![1.0; channels];
        for point in task * TASK..(task + 1) * TASK {
            let Some(shot) = targets.shot(tracer, lights, light, sequence.point(point)) else { continue };
            left.fill(1.0);
            let numbers = Sampler { sequence, point, set: 1 };
            let worth = worth * shot.worth;
            let power = lights.power(light);
            let mut flight = Flight {
                tracer,
                grid: &grid,
                power,
                worth,
                numbers,
                left: &mut left,
                is_straight: true,
                leg: None,
                found: &mut found,
            };
            let end = tracer.follow_path(shot.met, &mut flight);
            flight.end(end);
        }
        found
    };
    let mut parts = vec![DMatrix::zeros(irradiance.nrows(), channels); PARTS];
    for light in 0..lights.len() {
        for index in 0..sequences {
            options.progress.at("receive", 1.0)?;
            let sequence = Stream::Crossings.sequence(options.seed, light as u32, index);
            let tasks = (0..SEQUENCE_END / TASK).into_par_iter();
            let found: Vec<_> = tasks.map(|task| shoot(light, sequence, task)).collect();
            // Sum up in a fixed order.
            let part = &mut parts[index as usize % PARTS];
            for (cell, flux) in found.into_iter().flatten() {
                flux.into_iter().enumerate().for_each(|(c, flux)| part[(cell, c)] += flux);
            }
        }
    }
    let whole = parts.iter().fold(0.0 * &*irradiance, |sum, part| sum + part);
    *irradiance += &whole;
    Ok(parts.into_iter().map(|part| part * PARTS as f64 - &whole).collect())
}

/// A shot on its way over carriers.
struct Flight<'a> {
    tracer: &'a Tracer<'a>,
    grid: &'a Grid,
    /// Per channel, W.
    power: &'a [f64],
    /// Irradiance of a cell that it crosses, per unit of power.
    worth: f64,
    numbers: Sampler,
    /// What carriers leave of it, per channel.
    left: &'a mut [f64],
    is_straight: bool,
    /// The ray that it is on, once a carrier has turned it.
    leg: Option<Ray>,
    /// Cells that were crossed, and their irradiance per channel.
    found: &'a mut Vec<(usize, Vec<f64>)>,
}

impl Flight<'_> {
    fn cross(&mut self, ray: &Ray, distance: f64) {
        if let Some((cell, counts)) = self.grid.crossed(ray, distance) {
            let irradiance =
                self.power.iter().zip(&*self.left).map(|(power, left)| counts * self.worth * power * left);
            self.found.push((cell, irradiance.collect()));
        }
    }

    /// Counts the last leg.
    fn end(mut self, end: Destination) {
        let Some(ray) = self.leg.take() else { return };
        let distance = match end {
            Destination::Diffuse { hit, .. } => hit.distance,
            Destination::Away(_) => f64::INFINITY,
            Destination::Absorbed | Destination::Lost => {
                self.tracer.closest_hit(&ray).map_or(f64::INFINITY, |hit| hit.distance)
            }
        };
        self.cross(&ray, distance);
    }
}

impl SpecularPath for Flight<'_> {
    fn numbers(&mut self) -> [f64; 4] {
        self.numbers.next()
    }

    /// Here the leg ends that led there.
    fn meets(&mut self, ray: &Ray, hit: &Hit) {
        if self.leg.take().is_some() {
            self.cross(ray, hit.distance);
        }
    }

    fn survives(&mut self, colour: Tint, _chance: f64) -> bool {
        self.left.iter_mut().zip(colour.parts()).for_each(|(left, part)| *left *= part);
        self.left.iter().any(|&left| left > 0.0)
    }

    fn goes_on(&mut self, before: &Ray, hit: &Hit, after: &Ray) {
        self.is_straight &= self.tracer.goes_straight(before, hit, after);
        self.leg = (!self.is_straight).then_some(*after);
    }
}
