//! Switches: effects that are left out though a scene calls for them.

use std::str::FromStr;

use super::Plan;
use crate::scene::{Feature, Scene};
use crate::transport::form_factors::{Occlusion, TraceOptions};
use crate::transport::rows::Shots;
use crate::transport::sources::LightOptions;

/// Effects that can be left out, what each loses, and what is left out of the scene for it, if that is all.
const SWITCHES: [(&str, &str, Option<Feature>); 17] = [
    (
        "interreflection",
        "surfaces light no others: what comes straight from lamps, lights and sky is all there is",
        Some(Feature::Interreflection),
    ),
    (OCCLUSION_RAYS, "", None),
    (
        "back sides",
        "the backs of surfaces are black, nothing comes through, and nothing is told of them",
        Some(Feature::BackSides),
    ),
    ("lamps", "lamps are found by the rays of rows alone: direct light is noisier", None),
    ("colour", "everything is grey, of the luminance of its colour", Some(Feature::Colour)),
    ("lights", "lights without area do not shine", Some(Feature::Lights)),
    ("sky", "no light comes from outside", Some(Feature::Sky)),
    ("textures", "surfaces have the mean colour of their pictures", Some(Feature::Textures)),
    ("receivers", "nothing is measured beside the faces", Some(Feature::Receivers)),
    ("mirror", "mirrors are diffuse surfaces of the same reflectance", Some(Feature::Mirror)),
    (
        "dielectric",
        "glass and water are not there: light passes straight on, unfiltered",
        Some(Feature::Dielectric),
    ),
    ("thin glass", "thin glass is not there: light passes unfiltered", Some(Feature::ThinGlass)),
    ("gloss", "rough metals are diffuse surfaces of the same reflectance", Some(Feature::Gloss)),
    (TRANSMISSION, "sheets absorb what they would let through", Some(Feature::Transmission)),
    ("plastic", "plastic is the diffuse surface under its coat", Some(Feature::Plastic)),
    (
        "carrier colour",
        "mirrors, metals and glass are grey, by the mean of their channels",
        Some(Feature::CarrierColour),
    ),
    (
        "caustics",
        "light by way of mirrors and glass is found by rays from the surfaces that it lights alone: it is noisier, and that of lights without area is lost",
        None,
    ),
];

/// What needs back sides.
const TRANSMISSION: &str = "transmission";

/// What can be insisted on, and is left out by itself where it can be.
const OCCLUSION_RAYS: &str = "occlusion rays";

/// Which effects to switch off, and which not to; the rest is as a scene calls for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    off: Vec<&'static str>,
    on: Vec<&'static str>,
}

/// Why a list of effects makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}; write auto, or +effect and -effect separated by commas, of: {}", Switches::names())]
pub struct SwitchesError {
    /// What is wrong.
    what: String,
}

impl SwitchesError {
    fn new(what: String) -> Self {
        Self { what }
    }
}

impl FromStr for Switches {
    type Err = SwitchesError;

    /// Reads `auto`, or `+effect` and `-effect` separated by commas.
    fn from_str(text: &str) -> Result<Self, SwitchesError> {
        let mut switches = Self::default();
        for part in text.split(',').map(str::trim).filter(|&part| part != "auto") {
            let (list, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
                (Some(name), _) => (&mut switches.on, name),
                (_, Some(name)) => (&mut switches.off, name),
                _ => return Err(SwitchesError::new(format!("{part:?} has neither + nor - before it"))),
            };
            let known = SWITCHES.into_iter().find(|(known, ..)| *known == name.replace('-', " "));
            let Some((known, ..)) = known else {
                return Err(SwitchesError::new(format!("no effect is called {name:?}")));
            };
            list.push(known);
        }
        if let Some(both) = switches.off.iter().find(|name| switches.on.contains(name)) {
            return Err(SwitchesError::new(format!("{both} is to be both on and off")));
        }
        Ok(switches)
    }
}

impl Switches {
    /// The names of all effects that can be left out, as they are written.
    pub fn names() -> String {
        SWITCHES.map(|(name, ..)| name.replace(' ', "-")).join(", ")
    }

    /// Whether an effect is to be left out.
    pub fn leave_out(&self, effect: &str) -> bool {
        self.off.contains(&effect)
    }

    /// The scene with what is switched off left out, the plan for it, and what the user should know of
    /// either.
    pub fn apply(&self, mut scene: Scene) -> (Scene, Plan, Vec<String>) {
        let mut plan = Plan::new(&scene);
        let mut told = Vec::new();
        for (name, lost, feature) in SWITCHES {
            let Some(effect) = plan.effects.iter_mut().find(|effect| effect.effect == name) else { continue };
            if name == OCCLUSION_RAYS {
                if self.off.contains(&name) {
                    told.push(format!("{name} are left out by themselves where a scene is empty and convex, and nowhere else"));
                }
                continue;
            }
            if name == TRANSMISSION && effect.on && scene.is_without(Feature::BackSides) {
                effect.on = false;
                effect.reason = "nothing comes through without back sides".into();
            }
            match (effect.on, self.off.contains(&name), self.on.contains(&name)) {
                (true, true, _) => {
                    told.push(format!("{name} is switched off: {lost}"));
                    effect.on = false;
                    effect.reason = format!("switched off: {lost}");
                    scene = feature.into_iter().fold(scene, Scene::without);
                }
                (false, true, _) => told.push(format!("{name} is off anyway: {}", effect.reason)),
                (false, _, true) => told.push(format!("{name} can't be switched on: {}", effect.reason)),
                _ => {}
            }
        }
        (scene, plan, told)
    }

    /// The same way to trace, without what is switched off.
    pub fn trace<'a>(&self, options: TraceOptions<'a>) -> TraceOptions<'a> {
        let lamp_rays = if self.leave_out("lamps") { Some(0) } else { options.lamp_rays };
        let caustics = if self.leave_out("caustics") { Shots::Skipped } else { options.caustics };
        let occlusion = if self.on.contains(&OCCLUSION_RAYS) { Occlusion::Always } else { options.occlusion };
        TraceOptions { lamp_rays, caustics, occlusion, ..options }
    }

    /// The same way to look for lights, without what is switched off.
    pub fn light<'a>(&self, options: LightOptions<'a>) -> LightOptions<'a> {
        let caustics = if self.leave_out("caustics") { Shots::Skipped } else { options.caustics };
        let lamp_rays = if self.leave_out("lamps") { Some(0) } else { options.lamp_rays };
        LightOptions { caustics, lamp_rays, ..options }
    }
}
