//! Sheets that let light through: closed forms, energy, every solver, light paths, bad input.

mod changes; // saved form factors, the plan, switches
mod closed_forms; // furnaces, joined spheres, trapped light
mod files; // settings, pictures, bad input
mod light_paths; // against the matrix, and in every shading
mod sides; // what each reflects, and what comes through
mod solvers; // the same light, none lost, bounds, the same bits

use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::scene::{Material, Scene};
use radiosity::solve::Solution;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::{every_solver_to, quads, room, traced};

/// Every solver's answer, to a residual of 1e-11.
fn every_solver(k: &Transport, e: &DMatrix<f64>) -> [Solution; 3] {
    every_solver_to(1e-11, k, e)
}

/// Two cubes of 1 m that share a wall, the first with material 0 and a lamp 2 in its ceiling, the second with
/// material 1; the shared wall has material 3 and fronts the first.
fn two_cubes(materials: [Material; 4]) -> Scene {
    let mut faces: Vec<_> = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0)).to_vec();
    // Of the second cube without the wall at x = 1.
    faces.extend(room([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]).into_iter().skip(1).map(|quad| (quad, 1)));
    // The wall at x = 1 of the first.
    faces[3].1 = 3;
    let lamp = [[0.3, 0.8, 0.3], [0.7, 0.8, 0.3], [0.7, 0.8, 0.7], [0.3, 0.8, 0.7]];
    faces.push((lamp, 2));
    quads(&faces, materials.to_vec())
}

/// Two cubes as they usually are here, around this wall.
fn around(wall: Material) -> Scene {
    let first = Material::diffuse("first", &[0.7, 0.5, 0.3]);
    let second = Material::diffuse("second", &[0.4, 0.6, 0.8]);
    two_cubes([first, second, Material::lamp("lamp", &[0.0; 3], &[3.0, 2.0, 1.0]), wall])
}

fn paper() -> Material {
    Material::diffuse("paper", &[0.5, 0.4, 0.3]).with_sheet(&[0.2, 0.4, 0.6], &[0.25, 0.3, 0.2])
}

/// Lets through more than it reflects.
fn gauze() -> Material {
    Material::diffuse("gauze", &[0.1, 0.0, 0.2]).with_sheet(&[0.0, 0.05, 0.2], &[0.8, 0.7, 0.6])
}

fn factors<'s>(scene: &'s Scene, size: PatchSize, (basis, rays): (Basis, u32)) -> (Patches<'s>, FormFactors) {
    traced(scene, size, &TraceOptions { rays: Some(rays), basis, ..Default::default() })
}
