//! Slack: the light that is missing because rows of form factors could not be closed, and the faces it is
//! missing from.

use std::collections::{BTreeMap, HashSet};
use std::f64::consts::PI;

use nalgebra::DMatrix;

use crate::patches::Patches;
use crate::scene::{Scene, Side};
use crate::transport::{Sources, Transport};

/// Faces that lack more than this part of what they exchange are worth a warning.
const NOTABLE: f64 = 1e-3;

/// The most faces that a warning names.
const MOST_NAMED: usize = 10;

/// What one side of a face lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceSlack {
    /// The face's number.
    pub face: usize,
    /// Which side of it.
    pub side: Side,
    /// π Σ L·slack over the side's patches and all channels, relative to what all lights emit.
    pub power_share: f64,
    /// Σ slack / Σ area over the side's patches; the largest over channels. 1 for a side that rays found
    /// nothing of.
    pub area_share: f64,
}

/// What all rows together lack; see [`Exchange::slack`](crate::transport::Exchange::slack).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slack {
    /// The sides of faces that lack anything, those of the largest share of power first.
    pub faces: Vec<FaceSlack>,
    /// π Σ L·slack over all patches and channels, relative to what all lights emit.
    pub power_share: f64,
}

impl Slack {
    /// Finds what is missing of radiance `l` (N × c) under operator `k` and the lights of `sources`.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn of(patches: &Patches, k: &Transport, sources: &Sources, l: &DMatrix<f64>) -> Self {
        let channels = k.channels();
        if (0..channels).all(|c| k.exchange_of(c).closure().slack == 0.0) {
            return Self::default();
        }
        let emitted: f64 = sources.flux(k.mass()).iter().sum();
        let each = k.basis().coefficients();
        let mut sides: BTreeMap<(usize, bool), FaceSlack> = BTreeMap::new();
        for c in 0..channels {
            let exchange = k.exchange_of(c);
            let mut slack_and_area: BTreeMap<(usize, bool), [f64; 2]> = BTreeMap::new();
            for i in 0..k.len() {
                let place = patches.place(i / each);
                let key = (place.face, place.side == Side::Back);
                let slack = exchange.slack()[i];
                let sums = slack_and_area.entry(key).or_default();
                *sums = [sums[0] + slack, sums[1] + exchange.areas()[i]];
                let nothing = FaceSlack { face: key.0, side: place.side, power_share: 0.0, area_share: 0.0 };
                let power = PI * l[(i, c)] * slack;
                sides.entry(key).or_insert(nothing).power_share +=
                    if emitted > 0.0 { power / emitted } else { 0.0 };
            }
            for (key, [slack, area]) in slack_and_area {
                let side = sides.get_mut(&key).expect("entered above");
                side.area_share = side.area_share.max(slack / area);
            }
        }
        let mut faces: Vec<FaceSlack> = sides.into_values().filter(|side| side.area_share > 0.0).collect();
        faces.sort_by(|a, b| {
            b.power_share.total_cmp(&a.power_share).then(b.area_share.total_cmp(&a.area_share))
        });
        let power_share = faces.iter().map(|side| side.power_share).sum();
        Self { faces, power_share }
    }

    /// What to tell the user, if sides of faces lack more than a thousandth of what they exchange.
    pub fn warning(&self, scene: &Scene) -> Option<String> {
        let notable: Vec<&FaceSlack> = self.faces.iter().filter(|side| side.area_share > NOTABLE).collect();
        let worst = notable.first()?;
        let mut faces: Vec<usize> = notable.iter().map(|side| side.face).collect();
        let mut seen = HashSet::new();
        faces.retain(|face| seen.insert(*face));
        let noun = if faces.len() == 1 { "face" } else { "faces" };
        let named: Vec<String> = faces.iter().take(MOST_NAMED).map(usize::to_string).collect();
        let more = if faces.len() > MOST_NAMED { ", …" } else { "" };
        let object = scene.objects().get(scene.faces()[worst.face].object as usize);
        let of =
            object.filter(|name| !name.is_empty()).map_or(String::new(), |name| format!(", most in {name}"));
        let power = match 100.0 * self.power_share {
            percent if percent >= 0.01 => format!("{percent:.2}"),
            _ => "less than 0.01".to_owned(),
        };
        Some(format!(
            "{power} % of the emitted power is missing: the form factors of {} {noun} cannot be closed \
             ({noun} {}{more}{of}), so their irradiance is too low; faces that coincide or line a closed \
             pocket cause this; run `radiosity check`",
            faces.len(),
            named.join(", "),
        ))
    }
}
