//! Material: how a surface reflects and emits.

mod glass;
mod pixels;
mod sheet;
mod texture;
mod textured;

use super::spelled::spelled;
use super::{LARGEST, Side};
pub(super) use glass::warn_of_missing_insides;
pub use pixels::{Beyond, Pixels};
pub use sheet::Sheet;
pub use texture::{FaceTexture, Texture, Textures};
pub(super) use textured::warn_of_missing_coordinates;

/// How a surface passes light on.
///
/// Mirrors, dielectrics and conductors are *carriers*: light goes on from them in one direction or two, or in
/// a lobe, so that they are no patches but part of the way between patches.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Lambertian: radiance leaves equally in every direction.
    Diffuse,
    /// Perfect mirror (`illum 3`), on both sides.
    Mirror {
        /// Reflectance Ks per channel, 0 to 1.
        reflectance: Vec<f64>,
    },
    /// Smooth glass or water (`illum 4`, `6`, `7` or `9`), bounded by closed surfaces that front outward.
    /// Solids may lie in each other.
    Dielectric {
        /// Index of refraction Ni of what lies behind the front; 1 outside of all such solids.
        index: f64,
        /// Which part of the light Tf passes at each crossing of the surface, per channel, 0 to 1.
        filter: Vec<f64>,
    },
    /// Thin glass (`thin = true` for such a dielectric in the scene's `.toml`): a sheet that stands for both
    /// of its surfaces. Light goes straight through, or is reflected, with all reflections inside.
    Pane {
        /// Index of refraction, relative to what lies around it.
        index: f64,
        /// Which part of the light is left on one way through, per channel, 0 to 1: Tf² where Tf passes each
        /// surface.
        filter: Vec<f64>,
    },
    /// Rough conductor (`Pm` and `Pr`, or `illum 5`), on both sides: light goes on in a lobe around the
    /// mirror's direction, GGX with all reflections among its facets, so that a white one absorbs nothing.
    Conductor {
        /// Reflectance at normal incidence per channel, 0 to 1; towards grazing it rises to 1.
        reflectance: Vec<f64>,
        /// Roughness Pr, the root of GGX's α, 0 (a mirror to the eye) to 1.
        roughness: f64,
    },
    /// Plastic, or anything varnished (`Pr`, or `illum 5` with Kd): the diffuse reflectance under a clear
    /// coat, on both sides. The coat is a dielectric with GGX's facets that reflects by Fresnel's formulas;
    /// what it does not reflect gets under it. Nothing is lost. It emits nothing.
    Plastic {
        /// Index of refraction of the coat, 1 (no coat) to 10.
        index: f64,
        /// Roughness Pr of the coat, the root of GGX's α, 0 (smooth) to 1.
        roughness: f64,
    },
}

impl Surface {
    /// Whether light goes on from it without being spread diffusely.
    pub fn is_carrier(&self) -> bool {
        match self {
            Self::Mirror { .. } | Self::Dielectric { .. } | Self::Pane { .. } | Self::Conductor { .. } => {
                true
            }
            Self::Diffuse | Self::Plastic { .. } => false,
        }
    }

    /// Whether some light goes on from it without being spread diffusely: from carriers all, from plastic
    /// what its coat reflects.
    pub fn passes_on(&self) -> bool {
        self.is_carrier() || matches!(self, Self::Plastic { .. })
    }

    /// What it does to light's colour, per channel; nothing for surfaces that are no carriers.
    pub fn colour(&self) -> Option<&[f64]> {
        match self {
            Self::Mirror { reflectance } | Self::Conductor { reflectance, .. } => Some(reflectance),
            Self::Dielectric { filter, .. } | Self::Pane { filter, .. } => Some(filter),
            Self::Diffuse | Self::Plastic { .. } => None,
        }
    }

    pub(crate) fn colour_mut(&mut self) -> Option<&mut Vec<f64>> {
        match self {
            Self::Mirror { reflectance } | Self::Conductor { reflectance, .. } => Some(reflectance),
            Self::Dielectric { filter, .. } | Self::Pane { filter, .. } => Some(filter),
            Self::Diffuse | Self::Plastic { .. } => None,
        }
    }

    /// What is not physical about it, if anything.
    fn check(&self) -> Result<(), String> {
        let outside = |values: &[f64]| values.iter().copied().find(|x| !(0.0..=1.0).contains(x));
        match self {
            Self::Mirror { reflectance } => outside(reflectance).map_or(Ok(()), |r| {
                Err(format!("mirror reflectance {r} (Ks in MTL files) must lie between 0 and 1"))
            }),
            Self::Conductor { roughness, .. } if !(0.0..=1.0).contains(roughness) => Err(format!(
                "roughness {roughness} (Pr in MTL files) must lie between 0, a mirror, and 1, the roughest metal"
            )),
            Self::Conductor { reflectance, .. } => outside(reflectance).map_or(Ok(()), |r| {
                Err(format!(
                    "reflectance {r} of a metal (Ks in MTL files, or Kd with Pm) must lie between 0 and 1"
                ))
            }),
            Self::Dielectric { index, .. } | Self::Pane { index, .. }
                if !(index.is_finite() && *index > 0.0) =>
            {
                Err(format!(
                    "index of refraction {index} (Ni in MTL files) must be positive; glass has 1.5, water 1.33"
                ))
            }
            Self::Dielectric { filter, .. } | Self::Pane { filter, .. } => outside(filter)
                .map_or(Ok(()), |t| {
                    Err(format!("transmission filter {t} (Tf in MTL files) must lie between 0 and 1"))
                }),
            Self::Plastic { index, .. } if !(1.0..=10.0).contains(index) => Err(format!(
                "index of refraction {index} of a coat (Ni in MTL files) must lie between 1 and 10; varnish has 1.5"
            )),
            Self::Plastic { roughness, .. } if !(0.0..=1.0).contains(roughness) => Err(format!(
                "roughness {roughness} (Pr in MTL files) must lie between 0, a smooth coat, and 1, the roughest"
            )),
            Self::Diffuse | Self::Plastic { .. } => Ok(()),
        }
    }
}

/// A surface's reflectance and emission, one value per channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, as faces refer to it.
    pub name: String,
    /// Diffuse reflectance (albedo) ρ of both sides, or of the front where a sheet's back has its own, per
    /// channel, 0 to 1.
    pub reflectance: Vec<f64>,
    /// Emitted radiance Lₑ of the front side, per channel, W·sr⁻¹·m⁻².
    pub emission: Vec<f64>,
    /// How the surface passes light on. Carriers neither reflect diffusely nor emit.
    pub surface: Surface,
    /// What diffuse surfaces let through, and what their back reflects, where that is not nothing and as the
    /// front does.
    pub sheet: Option<Sheet>,
    /// Pictures by which reflectance and emission vary over faces; what they say is multiplied by these.
    /// Carriers have none.
    pub textures: Textures,
}

impl Material {
    /// A diffuse surface with the given reflectance that emits nothing.
    pub fn diffuse(name: impl Into<String>, reflectance: &[f64]) -> Self {
        Self {
            name: name.into(),
            reflectance: reflectance.to_vec(),
            emission: vec![0.0; reflectance.len()],
            surface: Surface::Diffuse,
            sheet: None,
            textures: Textures::default(),
        }
    }

    /// A diffuse lamp: reflectance and emitted radiance (W·sr⁻¹·m⁻²) per channel.
    pub fn lamp(name: impl Into<String>, reflectance: &[f64], emission: &[f64]) -> Self {
        Self { emission: emission.to_vec(), ..Self::diffuse(name, reflectance) }
    }

    /// A perfect mirror that reflects this part of the light, per channel.
    pub fn mirror(name: impl Into<String>, reflectance: &[f64]) -> Self {
        let surface = Surface::Mirror { reflectance: reflectance.to_vec() };
        Self { surface, ..Self::diffuse(name, &vec![0.0; reflectance.len()]) }
    }

    /// A rough conductor of this roughness, 0 to 1, and this reflectance at normal incidence per channel.
    pub fn conductor(name: impl Into<String>, roughness: f64, reflectance: &[f64]) -> Self {
        let surface = Surface::Conductor { reflectance: reflectance.to_vec(), roughness };
        Self { surface, ..Self::diffuse(name, &vec![0.0; reflectance.len()]) }
    }

    /// A diffuse surface of this reflectance per channel under a clear coat of this roughness, 0 to 1, and
    /// this index of refraction.
    pub fn plastic(name: impl Into<String>, (roughness, index): (f64, f64), reflectance: &[f64]) -> Self {
        Self { surface: Surface::Plastic { index, roughness }, ..Self::diffuse(name, reflectance) }
    }

    /// A smooth dielectric of this index of refraction, which lets this part of the light pass each of its
    /// surfaces, per channel.
    pub fn dielectric(name: impl Into<String>, index: f64, filter: &[f64]) -> Self {
        let surface = Surface::Dielectric { index, filter: filter.to_vec() };
        Self { surface, ..Self::diffuse(name, &vec![0.0; filter.len()]) }
    }

    /// A sheet of glass of this index of refraction, through which this part of the light goes that enters
    /// it, per channel.
    pub fn pane(name: impl Into<String>, index: f64, filter: &[f64]) -> Self {
        let surface = Surface::Pane { index, filter: filter.to_vec() };
        Self { surface, ..Self::diffuse(name, &vec![0.0; filter.len()]) }
    }

    /// Whether a picture varies its reflectance or emission.
    pub fn is_textured(&self) -> bool {
        self.textures.all().next().is_some()
    }

    /// Whether the front side emits in any channel, somewhere at least.
    pub fn emits(&self) -> bool {
        brightest(&self.emission, self.textures.emission.as_ref()).any(|e| e > 0.0)
    }

    /// Whether either side reflects some light in some channel, somewhere at least.
    pub fn reflects(&self) -> bool {
        Side::BOTH.into_iter().any(|side| self.reflects_on(side))
    }

    /// Whether a side reflects some light in some channel, somewhere at least.
    pub fn reflects_on(&self, side: Side) -> bool {
        brightest(self.reflectance_of(side), self.textures.reflectance.as_ref()).any(|r| r > 0.0)
    }

    /// What is not physical about it, if anything.
    pub(crate) fn check(&self) -> Result<(), String> {
        if let Some(r) = self.reflectance.iter().find(|r| !(0.0..=1.0).contains(*r)) {
            return Err(format!("reflectance {} (Kd in MTL files) must lie between 0 and 1", spelled(*r)));
        }
        if let Some(e) = self.emission.iter().find(|e| !(0.0..=LARGEST).contains(*e)) {
            return Err(format!(
                "emission {} (Ke in MTL files) must be at most {LARGEST:e}, and not negative",
                spelled(*e)
            ));
        }
        let brightest_lamp = brightest(&self.emission, self.textures.emission.as_ref()).fold(0.0, f64::max);
        if brightest_lamp > LARGEST {
            return Err(format!(
                "its picture makes emission as high as {}, and it must be at most {LARGEST:e}",
                spelled(brightest_lamp)
            ));
        }
        if self.is_textured() && !matches!(self.reflectance.len(), 1 | 3) {
            return Err(
                "pictures have red, green and blue: a material with textures has 1 channel or 3".into()
            );
        }
        let highest = brightest(&self.reflectance, self.textures.reflectance.as_ref()).fold(0.0, f64::max);
        if highest > 1.0 {
            return Err(format!(
                "its picture makes reflectance as high as {highest} (Kd times map_Kd in MTL files), and it must lie between 0 and 1; \
                 lower Kd or the picture"
            ));
        }
        if self.surface.is_carrier() && (self.emits() || self.reflects()) {
            return Err(
                "a mirror, metal or glass neither emits nor reflects diffusely; give that to a material of its own"
                    .into(),
            );
        }
        if let Some(sheet) = &self.sheet {
            if self.surface != Surface::Diffuse {
                return Err(
                    "only diffuse surfaces let light through diffusely or have a back of another colour; remove `transmittance` and \
                     `reflectance_back`, or give them to a material of its own"
                        .into(),
                );
            }
            let picture = self.textures.reflectance.as_ref();
            let highest = picture.map_or([1.0; 3], |texture| texture.pixels.highest());
            sheet.check(&self.reflectance, highest)?;
        }
        if matches!(self.surface, Surface::Plastic { .. }) && self.emits() {
            return Err("plastic emits nothing; give the light to a material of its own".into());
        }
        self.surface.check()
    }

    /// Whether every colour has this many channels.
    pub(crate) fn has_channels(&self, channels: usize) -> bool {
        let surface = self.surface.colour().is_none_or(|colour| colour.len() == channels);
        let colours = self.sheet.iter().flat_map(Sheet::colours);
        let mut colours = colours.chain([&self.reflectance, &self.emission]);
        colours.all(|colour| colour.len() == channels) && surface
    }

    /// Keeps the first channel only.
    pub(crate) fn keep_one_channel(&mut self) {
        self.reflectance.truncate(1);
        self.emission.truncate(1);
        self.surface.colour_mut().into_iter().for_each(|colour| colour.truncate(1));
        self.sheet.iter_mut().flat_map(Sheet::colours_mut).for_each(|colour| colour.truncate(1));
    }

    /// Whether all channels agree.
    pub(crate) fn is_grey(&self) -> bool {
        let flat = |v: &[f64]| v.iter().all(|&x| x == v[0]);
        let textures = self.textures.all().all(|texture| texture.pixels.is_grey());
        let sheet = self.sheet.iter().flat_map(Sheet::colours).all(|colour| flat(colour));
        textures
            && sheet
            && flat(&self.reflectance)
            && flat(&self.emission)
            && self.surface.colour().is_none_or(flat)
    }

    /// Makes a diffuse surface a sheet that lets this part of the light through, and whose back reflects this
    /// part, per channel.
    #[must_use]
    pub fn with_sheet(self, reflectance_back: &[f64], transmittance: &[f64]) -> Self {
        let sheet =
            Sheet { reflectance_back: reflectance_back.to_vec(), transmittance: transmittance.to_vec() };
        Self { sheet: Some(sheet), ..self }
    }

    /// Diffuse reflectance of a side, per channel; what a texture says multiplies it on both.
    #[inline]
    pub fn reflectance_of(&self, side: Side) -> &[f64] {
        match (&self.sheet, side) {
            (Some(sheet), Side::Back) => &sheet.reflectance_back,
            _ => &self.reflectance,
        }
    }

    /// Diffuse transmittance τ per channel; none where no light comes through.
    #[inline]
    pub fn transmittance(&self) -> Option<&[f64]> {
        let tau = self.sheet.as_ref().map(|sheet| sheet.transmittance.as_slice());
        tau.filter(|tau| tau.iter().any(|&t| t > 0.0))
    }

    /// The most of what arrives on a side that goes on from there, over all channels: what is reflected and
    /// what comes through.
    pub fn highest_albedo(&self, side: Side) -> f64 {
        let through = |c: usize| self.transmittance().map_or(0.0, |tau| tau[c]);
        let goes_on = |(c, rho): (usize, &f64)| rho + through(c);
        self.reflectance_of(side).iter().enumerate().map(goes_on).fold(0.0, f64::max)
    }
}

/// The highest that a colour gets under a texture, per channel.
fn brightest(colour: &[f64], texture: Option<&Texture>) -> impl Iterator<Item = f64> {
    let highest = texture.map(|texture| texture.pixels.highest());
    colour.iter().enumerate().map(move |(c, x)| highest.map_or(*x, |highest| x * highest[c]))
}
