//! Colours of vertices: the reflectance of faces without a material, the mean of their corners'.

use std::collections::HashSet;

use glam::DVec2;

use super::lines::Lines;
use crate::scene::SceneParts;
use crate::scene::grouped::Names;
use crate::scene::material::{Pixels, Texture};

/// Reflectance of faces that say nothing.
const GREY: [f64; 3] = [0.5; 3];

/// Gives the materials of these names, which nothing defines, the colours of vertices, and says what became
/// of them.
pub(super) fn paint(lines: &Lines, unknown: &[&str], parts: &mut SceneParts) {
    let colour = factor(lines).map(|factor| {
        move |corners: &[usize; 3]| {
            let [a, b, c] = corners.map(|corner| lines.colours[corner]);
            let (a, b, c) = (a?, b?, c?);
            Some([0, 1, 2].map(|k| (factor * (a[k] + ((b[k] - a[k]) + (c[k] - a[k])) / 3.0)).clamp(0.0, 1.0)))
        }
    });
    let [mut grey, mut painted] = [Names::default(), Names::default()];
    let mut faces_of: Vec<Vec<usize>> = vec![Vec::new(); parts.materials.len()];
    parts.faces.iter().enumerate().for_each(|(k, face)| faces_of[face.material as usize].push(k));
    let unknown: HashSet<&str> = unknown.iter().copied().collect();
    for (material, faces) in faces_of.into_iter().enumerate() {
        let name = parts.materials[material].name.clone();
        if !unknown.contains(name.as_str()) {
            continue;
        }
        let colours: Vec<Option<[f64; 3]>> = match &colour {
            Some(colour) => faces.iter().map(|&face| colour(&lines.triangles[face])).collect(),
            None => Vec::new(),
        };
        if colours.iter().all(Option::is_none) {
            grey.add(&name);
            continue;
        }
        painted.add(&name);
        let colours: Vec<[f64; 3]> = colours.into_iter().map(|colour| colour.unwrap_or(GREY)).collect();
        let material = &mut parts.materials[material];
        if colours.iter().all(|colour| *colour == colours[0]) {
            material.reflectance = colours[0].to_vec();
            continue;
        }
        // A picture with a texel for each face, of which the face shows the middle.
        let width = (colours.len() as f64).sqrt().ceil() as usize;
        let height = colours.len().div_ceil(width);
        let mut texels: Vec<[f32; 3]> = colours.iter().map(|colour| colour.map(|x| x as f32)).collect();
        texels.resize(width * height, [0.0; 3]);
        material.reflectance = vec![1.0; 3];
        material.textures.reflectance = Some(Texture::new(Pixels::new(width, height, texels)));
        for (k, face) in faces.into_iter().enumerate() {
            let middle = DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
            let [u, v] = [middle.x / width as f64, 1.0 - middle.y / height as f64];
            parts.texture_coordinates[face] = Some([DVec2::new(u, v); 3]);
        }
    }
    if !painted.is_empty() {
        parts.warnings.push(format!(
            "no library defines {painted}: the faces take the colours of their vertices as reflectance, or grey 0.5 without"
        ));
    }
    if !grey.is_empty() {
        parts.warnings.push(format!("taken as grey 0.5, for no library defines it: {grey}"));
    }
}

/// By what the file's colours are multiplied: some count to 255. None if there are none, or all are white, as
/// some programs write them that know no colours.
fn factor(lines: &Lines) -> Option<f64> {
    let given = || lines.colours.iter().flatten().flatten().copied();
    let (lowest, highest) =
        given().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
    match highest {
        _ if lowest >= highest && matches!(highest, 1.0 | 255.0) => None,
        highest if highest <= 1.0 => (lowest <= highest).then_some(1.0),
        highest if highest <= 255.0 => Some(1.0 / 255.0),
        _ => None,
    }
}
