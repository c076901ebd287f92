//! Feature: what can be left out of a scene, to see what it is worth or to spare its cost.

use std::sync::Arc;

use super::light::SkyKind;
use super::material::{Sheet, Textures};
use super::photometry::luminance;
use super::{FaceState, Material, Scene, Surface};

/// Something that a scene can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Light that surfaces reflect onto others. Without it the light of a surface is what it emits, and what
    /// it reflects of light that comes straight from lamps, lights and sky.
    Interreflection,
    /// What channels differ in. Without it all colours are greys of the same luminance.
    Colour,
    /// Backs of faces. Without them a back is black, nothing comes through, and nothing is known of the light
    /// on it.
    BackSides,
    /// Light through sheets. Without it they absorb what they would let through.
    Transmission,
    /// Mirrors. Without them they are diffuse surfaces of the same reflectance.
    Mirror,
    /// Glass and water. Without them they are not there.
    Dielectric,
    /// Thin glass. Without it it is not there.
    ThinGlass,
    /// Rough metals. Without them they are diffuse surfaces of the same reflectance.
    Gloss,
    /// The coat of plastic. Without it only its diffuse base is there.
    Plastic,
    /// What colour mirrors, metals and glass give to light. Without it they are grey, by the mean of their
    /// channels.
    CarrierColour,
    /// Lights without area.
    Lights,
    /// The sky.
    Sky,
    /// Textures. Without them surfaces have the mean colour of their pictures.
    Textures,
    /// Receivers.
    Receivers,
}

impl Scene {
    /// The same scene without a feature.
    #[must_use]
    pub fn without(mut self, feature: Feature) -> Self {
        match feature {
            // Whoever simulates asks for this one.
            Feature::Interreflection => {}
            // And for backs; what comes through needs them.
            Feature::BackSides | Feature::Transmission => {
                for sheet in self.materials.iter_mut().filter_map(|material| material.sheet.as_mut()) {
                    sheet.transmittance.fill(0.0);
                }
            }
            Feature::Colour => self.turn_grey(),
            Feature::Mirror | Feature::Gloss => self.materials.iter_mut().for_each(|material| {
                let reflectance = match (&material.surface, feature) {
                    (Surface::Mirror { reflectance }, Feature::Mirror) => reflectance,
                    (Surface::Conductor { reflectance, .. }, Feature::Gloss) => reflectance,
                    _ => return,
                };
                *material = Material::diffuse(material.name.clone(), reflectance);
            }),
            Feature::Dielectric => self.leave_out(|surface| matches!(surface, Surface::Dielectric { .. })),
            Feature::ThinGlass => self.leave_out(|surface| matches!(surface, Surface::Pane { .. })),
            Feature::Plastic => {
                let plastic = |m: &&mut Material| matches!(m.surface, Surface::Plastic { .. });
                self.materials.iter_mut().filter(plastic).for_each(|m| m.surface = Surface::Diffuse);
            }
            Feature::CarrierColour => {
                for colour in self.materials.iter_mut().filter_map(|material| material.surface.colour_mut()) {
                    let mean = colour.iter().sum::<f64>() / colour.len() as f64;
                    colour.fill(mean);
                }
            }
            Feature::Lights => self.lights.clear(),
            Feature::Sky => self.sky = None,
            Feature::Textures => self.average_textures(),
            Feature::Receivers => self.receivers.clear(),
        }
        self.left_out.push(feature);
        self
    }

    /// Whether a feature was left out.
    pub fn is_without(&self, feature: Feature) -> bool {
        self.left_out.contains(&feature)
    }

    /// Whether light may go from surface to surface: some emit, reflect or let it through, and
    /// interreflection is not left out. Else nothing asks for form factors.
    pub fn has_exchange(&self) -> bool {
        let sends = |m: &Material| m.emits() || m.reflects() || m.transmittance().is_some();
        !self.is_without(Feature::Interreflection) && self.materials.iter().any(sends)
    }

    fn leave_out(&mut self, is: impl Fn(&Surface) -> bool) {
        for face in self.faces.iter_mut().filter(|face| face.state == FaceState::Kept) {
            if is(&self.materials[face.material as usize].surface) {
                face.state = FaceState::LeftOut;
            }
        }
    }

    fn average_textures(&mut self) {
        for material in &mut self.materials {
            let Textures { reflectance, emission } = std::mem::take(&mut material.textures);
            for (colour, picture) in
                [(&mut material.reflectance, reflectance), (&mut material.emission, emission)]
            {
                let mean = picture.map_or([1.0; 3], |picture| picture.pixels.mean());
                colour.iter_mut().zip(mean).for_each(|(colour, factor)| *colour *= factor);
            }
        }
        self.texture_coordinates.clear();
    }

    fn turn_grey(&mut self) {
        let grey = |colour: &mut Vec<f64>| *colour = vec![luminance(colour)];
        for material in &mut self.materials {
            grey(&mut material.reflectance);
            grey(&mut material.emission);
            material.surface.colour_mut().into_iter().for_each(grey);
            material.sheet.iter_mut().flat_map(Sheet::colours_mut).for_each(grey);
            let Textures { reflectance, emission } = &mut material.textures;
            let pictures = reflectance.iter_mut().chain(emission);
            pictures.for_each(|picture| picture.pixels = Arc::new(picture.pixels.grey()));
        }
        self.lights.iter_mut().for_each(|light| grey(light.power_mut()));
        if let Some(sky) = &mut self.sky {
            grey(&mut sky.zenith);
            if let SkyKind::Environment(environment) = &mut sky.kind {
                *environment = Arc::new(environment.grey());
            }
        }
        self.channels = 1;
    }
}
