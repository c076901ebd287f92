//! Textures: averages over patches, light paths that read the picture itself, pictures, and what files say
//! and lack.

mod averages; // over patches, against light paths, energy
mod files; // image files, coordinates, what is missing
mod pictures; // renderings show textures in full

use glam::{DVec2, DVec3};
use radiosity::patches::{Basis, Patches};
use radiosity::scene::{Face, FaceState, Material, Pixels, Scene, SceneParts, Texture};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::{cut_into, room};

/// A picture whose channels vary each in its own way, between `low` and 1.
fn pattern(low: f32) -> Texture {
    let (width, height) = (24, 16);
    let texel = |k: usize| {
        let (i, j) = ((k % width) as f32, (k / width) as f32);
        let mix = |x: f32| low + (1.0 - low) * x;
        [
            mix(i / 23.0),
            mix(if (i as u32 / 6 + j as u32 / 4).is_multiple_of(2) { 1.0 } else { 0.0 }),
            mix(j / 15.0),
        ]
    };
    Texture::new(Pixels::new(width, height, (0..width * height).map(texel).collect()))
}

/// Quadrilaterals with a material each, over each of which a picture lies once.
fn textured(quads: &[([[f64; 3]; 4], u32)], materials: Vec<Material>) -> Scene {
    let mut parts = SceneParts { materials, objects: vec!["all".into()], ..Default::default() };
    let unit = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from);
    for (corners, material) in quads {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(corners.map(DVec3::from));
        for k in [1, 2] {
            let vertices = [first, first + k, first + k + 1];
            let state = FaceState::Kept;
            parts.faces.push(Face { vertices, normals: None, material: *material, object: 0, state });
            parts.texture_coordinates.push(Some([unit[0], unit[k as usize], unit[k as usize + 1]]));
        }
    }
    Scene::new(parts).unwrap()
}

fn painted(reflectance: [f64; 3], texture: Texture) -> Material {
    let mut material = Material::diffuse("painted", &reflectance);
    material.textures.reflectance = Some(texture);
    material
}

/// A closed room with a painted floor, and a painted lamp under its ceiling.
fn gallery() -> Scene {
    let mut lamp = Material::lamp("lamp", &[0.0; 3], &[4.0, 6.0, 9.0]);
    lamp.textures.emission = Some(pattern(0.0));
    let mut quads: Vec<_> = room([0.0; 3], [2.0, 1.5, 2.0]).map(|quad| (quad, 0)).to_vec();
    quads[1].1 = 1;
    let panel = [[0.6, 1.4, 0.5], [1.5, 1.4, 0.5], [1.5, 1.4, 1.3], [0.6, 1.4, 1.3]];
    quads.push((panel, 2));
    textured(&quads, vec![Material::diffuse("wall", &[0.6, 0.5, 0.4]), painted([0.9; 3], pattern(0.1)), lamp])
}

struct Case<'s> {
    patches: Patches<'s>,
    factors: FormFactors,
}

fn case<'s>(tracer: &Tracer<'s>, count: usize, basis: Basis) -> Case<'s> {
    let mut patches = cut_into(tracer, count);
    let options = TraceOptions { basis, ..Default::default() };
    let factors = FormFactors::trace(tracer, &mut patches, &options).unwrap();
    Case { patches, factors }
}

impl Case<'_> {
    fn solve(&self) -> solve::Solution {
        let k = Transport::of(&self.factors, &self.patches).unwrap();
        let e = self.factors.basis().coefficients_of(&self.patches.emitted_radiance());
        solve::solve(&k, &e, &Default::default()).unwrap()
    }
}
