//! Plan: which effects a scene calls for, which of them are simulated, and what each will cost.

mod constants;
mod density;
mod exposure;
mod forecast;
mod switches;
mod texels;

use serde::Serialize;

use crate::scene::{Material, Scene, Surface};
pub(crate) use forecast::is_quickly_factored;
pub use forecast::{Cost, Forecast, Solving, StageCost, Work};
pub use switches::{Switches, SwitchesError};

/// One effect: whether it is simulated, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// Its name, such as `interreflection`.
    pub effect: &'static str,
    /// Whether it is simulated.
    pub on: bool,
    /// Why, in a few words.
    pub reason: String,
    /// What it is predicted to cost: what would be saved without it. Nothing where it is off, or before
    /// [`Plan::foretold`].
    #[serde(flatten)]
    pub cost: Cost,
}

impl Effect {
    fn new(effect: &'static str, on: bool, reason: impl Into<String>) -> Self {
        Self { effect, on, reason: reason.into(), cost: Cost::default() }
    }
}

/// Light looked for on lamps, beside what rays find of them.
fn lamps(used: &[&Material]) -> Effect {
    let names: Vec<&str> = used.iter().filter(|m| m.emits()).map(|m| m.name.as_str()).collect();
    let reason =
        if names.is_empty() { "no lamp".into() } else { format!("shadow rays towards {}", names.join(", ")) };
    Effect::new("lamps", !names.is_empty(), reason)
}

/// Lights that have a place or a direction.
fn lights(scene: &Scene) -> Effect {
    let number = scene.lights().count();
    let reason = match number {
        0 => "no light without area".into(),
        1 => "the scene has a light without area".into(),
        _ => format!("the scene has {number} lights without area"),
    };
    Effect::new("lights", number > 0, reason)
}

fn sky(scene: &Scene) -> Effect {
    let reason = if scene.sky().is_some() { "the scene has a sky" } else { "no sky" };
    Effect::new("sky", scene.sky().is_some(), reason)
}

fn textures(used: &[&Material]) -> Effect {
    let names: Vec<&str> = used.iter().filter(|m| m.is_textured()).map(|m| m.name.as_str()).collect();
    let reason = if names.is_empty() { "no texture".into() } else { names.join(", ") };
    Effect::new("textures", !names.is_empty(), reason)
}

fn receivers(scene: &Scene) -> Effect {
    let names: Vec<&str> = scene.receivers().iter().map(|receiver| receiver.name.as_str()).collect();
    let reason = if names.is_empty() { "no receiver".into() } else { names.join(", ") };
    Effect::new("receivers", !names.is_empty(), reason)
}

/// Light that is shot at what passes it on.
fn caustics(scene: &Scene, used: &[&Material]) -> Effect {
    if !used.iter().any(|m| m.surface.passes_on()) {
        return Effect::new("caustics", false, "no mirror, metal, glass or plastic");
    }
    let senders = [
        (used.iter().any(|m| m.emits()), "lamps"),
        (scene.lights().next().is_some(), "lights without area"),
        (scene.sky().is_some(), "the sky"),
    ];
    let names: Vec<&str> = senders.into_iter().filter(|(sends, _)| *sends).map(|(_, name)| name).collect();
    match names.as_slice() {
        [] => Effect::new("caustics", false, "no lamp, no light without area and no sky"),
        names => {
            let names = names.join(" and ");
            Effect::new(
                "caustics",
                true,
                format!("light shot from {names} at mirrors, metals, glass and coats"),
            )
        }
    }
}

fn transmission(used: &[&Material]) -> Effect {
    let through = used.iter().filter(|m| m.transmittance().is_some());
    let names: Vec<&str> = through.map(|m| m.name.as_str()).collect();
    let reason = match names.len() {
        0 => "no surface lets light through diffusely".into(),
        _ => format!("both sides of what lets light through diffusely: {}", names.join(", ")),
    };
    Effect::new("transmission", !names.is_empty(), reason)
}

/// What a run simulates.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Plan {
    /// All effects, simulated or not.
    pub effects: Vec<Effect>,
}

impl Plan {
    /// Reads the scene and decides.
    pub fn new(scene: &Scene) -> Self {
        let effect = |effect, on, reason: &str| Effect::new(effect, on, reason);
        let reflects = scene.materials().iter().any(|m| m.reflects() || m.transmittance().is_some());
        let used: Vec<&Material> = {
            let on_faces = |k: &usize| scene.faces().iter().any(|face| face.material as usize == *k);
            (0..scene.materials().len()).filter(on_faces).map(|k| &scene.materials()[k]).collect()
        };
        let carrier = |effect, what: &str, is: fn(&Surface) -> bool| {
            let names: Vec<&str> = used.iter().filter(|m| is(&m.surface)).map(|m| m.name.as_str()).collect();
            let reason = if names.is_empty() { format!("no {what}") } else { names.join(", ") };
            Effect::new(effect, !names.is_empty(), reason)
        };
        let caustics = caustics(scene, &used);
        let coloured: Vec<&str> = used
            .iter()
            .filter(|m| m.surface.colour().is_some_and(|colour| colour.iter().any(|&x| x != colour[0])))
            .map(|m| m.name.as_str())
            .collect();
        let carrier_colour = match coloured.len() {
            0 => effect("carrier colour", false, "no coloured mirror, metal or glass"),
            _ => Effect::new(
                "carrier colour",
                true,
                format!("exchange areas of their own for channels that differ: {}", coloured.join(", ")),
            ),
        };
        Self {
            effects: vec![
                effect(
                    "interreflection",
                    reflects,
                    if reflects { "some surfaces reflect" } else { "every surface is black" },
                ),
                effect("occlusion rays", true, "rays look for what stands between surfaces"),
                effect("back sides", true, "where light reaches them"),
                lamps(&used),
                effect(
                    "colour",
                    scene.channels() > 1,
                    if scene.channels() > 1 {
                        "channels differ"
                    } else {
                        "all channels agree: one is solved"
                    },
                ),
                lights(scene),
                sky(scene),
                receivers(scene),
                carrier("mirror", "mirror", |surface| matches!(surface, Surface::Mirror { .. })),
                carrier("dielectric", "glass or water", |surface| {
                    matches!(surface, Surface::Dielectric { .. })
                }),
                caustics,
                carrier_colour,
                carrier("thin glass", "thin glass", |surface| matches!(surface, Surface::Pane { .. })),
                carrier("gloss", "rough metal", |surface| matches!(surface, Surface::Conductor { .. })),
                transmission(&used),
                carrier("plastic", "plastic", |surface| matches!(surface, Surface::Plastic { .. })),
                textures(&used),
            ],
        }
    }

    /// The same plan with what every effect that is simulated is predicted to cost.
    pub fn foretold(mut self, forecast: &Forecast) -> Self {
        let parts = &forecast.parts;
        for effect in self.effects.iter_mut().filter(|effect| effect.on) {
            effect.cost = match effect.effect {
                "interreflection" => parts.interreflection,
                "occlusion rays" => match &forecast.rays_because {
                    Some(why) => {
                        effect.reason.clone_from(why);
                        parts.rows
                    }
                    None => {
                        effect.on = false;
                        effect.reason =
                            "empty and convex seen from inside: exact form factors between polygons".into();
                        Cost::default()
                    }
                },
                "colour" => parts.colour,
                "transmission" => parts.transmission,
                "back sides" => {
                    let backs = parts.backs.round();
                    effect.on = backs > 0.0;
                    effect.reason = match effect.on {
                        true => format!(
                            "some {backs} of {} patches are backs that light may reach",
                            forecast.patches
                        ),
                        false => "light reaches no back, as far as shape tells".into(),
                    };
                    parts.back_sides
                }
                "lamps" => parts.lamps,
                "lights" => parts.lights,
                "sky" => parts.sky,
                "receivers" => parts.receivers,
                "mirror" | "dielectric" => parts.carriers,
                "plastic" => parts.coats,
                "caustics" => parts.caustics,
                _ => Cost::default(),
            };
        }
        self
    }
}
