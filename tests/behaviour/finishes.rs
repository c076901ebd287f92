//! What is asked of every finish alike: a furnace, a lit room, pictures.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use radiosity::measure::{Difference, Energy};
use radiosity::patches::{PatchSize, Patches};
use radiosity::reference::PathTracer;
use radiosity::render::{self, RenderOptions, Shading};
use radiosity::scene::{Camera, Material, Scene};
use radiosity::solve::{self, Solution, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Plan, TraceOptions, Transport};

use crate::scenes::{cut, direct, flipped, paths, quads, room};

/// A closed cube that glows and reflects half, with a block of this material in it, and a floor of it.
pub fn furnace_with(finish: Material) -> Scene {
    let mut walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    walls[1].1 = 1;
    let block = room([0.3, 0.35, 0.25], [0.7, 0.6, 0.65]).map(|quad| (flipped(quad), 1));
    quads(&[walls, block].concat(), vec![Material::lamp("wall", &[0.5], &[1.0]), finish])
}

/// The direct solver's answer and its energy, which must balance.
#[track_caller]
pub fn balanced(patches: &Patches, factors: &FormFactors) -> (Solution, Energy) {
    let k = Transport::of(factors, patches).unwrap();
    let e = factors.basis().coefficients_of(&patches.emitted_radiance());
    let solution = direct(&k, &e);
    let energy = Energy::new(&k, &e, &solution.radiance);
    assert!(energy.imbalance < 1e-9, "{energy:?}");
    (solution, energy)
}

/// How many standard errors the flux that light paths find on all patches is from that of radiance 2 all
/// over.
pub fn light_paths_from_two(tracer: &Tracer, count: u64) -> f64 {
    let patches = cut(tracer, PatchSize::Count(100));
    let traced = PathTracer::new(tracer).irradiance(&patches, &paths(count)).unwrap();
    let sum = |f: &dyn Fn(usize) -> f64| (0..traced.len()).map(f).sum::<f64>();
    let off = sum(&|i| traced.area(i) * (traced.irradiance(i, 0).mean - 2.0 * PI));
    let variance = sum(&|i| (traced.area(i) * traced.irradiance(i, 0).standard_error).powi(2));
    off / variance.sqrt()
}

/// How far the matrix is from light paths in a room with a floor and a wall of this material, and a block of
/// it or of what the walls are.
pub fn difference_in_a_room(material: Material, is_of_block: bool) -> Difference {
    let mut walls = room([0.0; 3], [1.0, 0.8, 0.9]).map(|quad| (quad, 0));
    walls[1].1 = 1;
    walls[5].1 = 1;
    let lamp = [[0.3, 0.79, 0.2], [0.6, 0.79, 0.2], [0.6, 0.79, 0.4], [0.3, 0.79, 0.4]];
    let block = room([0.6, 0.0, 0.5], [0.8, 0.4, 0.7]).map(|quad| (flipped(quad), u32::from(is_of_block)));
    let faces = [&walls[..], &[(lamp, 2)], &block].concat();
    let materials =
        vec![Material::diffuse("wall", &[0.6]), material, Material::lamp("lamp", &[0.0], &[10.0])];
    let scene = quads(&faces, materials);
    let tracer = Tracer::new(&scene);
    let mut patches = cut(&tracer, PatchSize::Count(1500));
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let k = Transport::of(&factors, &patches).unwrap();
    let solution = solve::solve(&k, &patches.emitted_radiance(), &SolveOptions::default()).unwrap();
    let traced = PathTracer::new(&tracer).irradiance(&patches, &paths(600_000)).unwrap();
    Difference::new(&solution.irradiance, &traced)
}

/// A small lamp over a sheet of this material.
pub fn lamp_over(sheet: Material) -> Scene {
    let below = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0]];
    let lamp = [[-0.1, 1.0, -0.1], [0.1, 1.0, -0.1], [0.1, 1.0, 0.1], [-0.1, 1.0, 0.1]];
    quads(&[(below, 0), (lamp, 1)], vec![sheet, Material::lamp("lamp", &[0.0], &[100.0])])
}

/// A solved scene that is looked at.
pub struct Look<'a> {
    pub tracer: &'a Tracer<'a>,
    pub patches: &'a Patches<'a>,
    pub radiance: &'a DMatrix<f64>,
    pub camera: Camera,
}

impl Look<'_> {
    /// The mean over the pixels of a small picture.
    pub fn mean(&self, shading: Shading, samples: u32) -> f64 {
        let options = RenderOptions { width: 16, height: 12, shading, samples, ..Default::default() };
        let picture =
            render::picture(self.tracer, self.patches, self.radiance, &self.camera, &options).unwrap();
        picture.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 192.0
    }

    /// Every shading shows this radiance.
    #[track_caller]
    pub fn is_of(&self, radiance: f64) {
        for (shading, samples) in
            [(Shading::Flat, 4), (Shading::Smooth, 4), (Shading::Gather, 64), (Shading::Path, 64)]
        {
            let mean = self.mean(shading, samples);
            assert!((mean - radiance).abs() < 0.02, "{shading:?}: {mean}");
        }
    }

    /// Every shading shows as much as light paths do, which is more than `least`.
    #[track_caller]
    pub fn is_as_light_paths_show_it(&self, least: f64) {
        let reference = self.mean(Shading::Path, 1024);
        assert!(reference > least, "{reference}");
        for (shading, samples) in [(Shading::Flat, 1), (Shading::Smooth, 1), (Shading::Gather, 64)] {
            let mean = self.mean(shading, samples);
            assert!((mean / reference - 1.0).abs() < 0.02, "{shading:?}: {mean} {reference}");
        }
    }
}

/// A look at the block and the floor of a furnace.
pub fn in_the_furnace() -> Camera {
    Camera {
        position: [0.15, 0.5, 0.5].into(),
        target: [0.5, 0.3, 0.4].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov: 60.0,
    }
}

/// A look at the highlight of a small lamp on a sheet.
pub fn at_the_highlight() -> Camera {
    Camera {
        position: [0.0, 1.0, 1.5].into(),
        target: [0.0, 0.0, 0.7].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov: 30.0,
    }
}

/// The effects that a plan simulates.
pub fn simulated(plan: &Plan) -> Vec<&str> {
    plan.effects.iter().filter(|e| e.on).map(|e| e.effect).collect()
}
