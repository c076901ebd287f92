//! What materials were taken for, in a line.

use radiosity::scene::{Scene, Surface};

use crate::terminal::first_few;

/// So many names are written out.
const NAMED: usize = 4;

/// How many materials that faces use are diffuse, and which are anything else.
pub fn line(scene: &Scene) -> String {
    let mut used: Vec<u32> = scene.faces().iter().map(|face| face.material).collect();
    used.sort_unstable();
    used.dedup();
    let mut kinds: Vec<(&str, Vec<&str>)> = KINDS.map(|kind| (kind, Vec::new())).to_vec();
    for material in used.into_iter().map(|number| &scene.materials()[number as usize]) {
        let kind = match &material.surface {
            Surface::Diffuse if material.emits() => "lamp",
            Surface::Diffuse if material.sheet.is_some() => "sheet",
            Surface::Diffuse => "diffuse",
            Surface::Plastic { .. } => "plastic",
            Surface::Conductor { .. } => "metal",
            Surface::Mirror { .. } => "mirror",
            Surface::Dielectric { .. } => "glass",
            Surface::Pane { .. } => "thin glass",
        };
        kinds
            .iter_mut()
            .filter(|(known, _)| *known == kind)
            .for_each(|(_, names)| names.push(&material.name));
    }
    let told = |(kind, names): &(&str, Vec<&str>)| match names.len() {
        0 => None,
        count if *kind == "diffuse" => Some(format!("{count} {kind}")),
        count => Some(format!("{count} {kind} ({})", first_few(names, NAMED))),
    };
    kinds.iter().filter_map(told).collect::<Vec<_>>().join(", ")
}

/// In the order in which they are told.
const KINDS: [&str; 8] = ["diffuse", "lamp", "sheet", "plastic", "metal", "mirror", "glass", "thin glass"];
