//! Cutter: cuts one scene into patches, as often as it is asked to.
//!
//! Most of the work of a cut is to find where surfaces touch and where light reaches. A cutter remembers the
//! one, and takes the other from a cut that was made before.

use rayon::prelude::*;

use super::fineness::Fineness;
use super::parts::Parting;
use super::size::fineness_for;
use crate::patches::reach::Reach;
use crate::patches::{PatchError, PatchSize, Patches, Slot, Tessellation, reach};
use crate::trace::Tracer;

/// Cuts a scene into patches of whatever size.
pub struct Cutter<'t, 's> {
    tracer: &'t Tracer<'s>,
    parting: Parting<'t>,
}

impl<'t, 's> Cutter<'t, 's> {
    /// Makes one for the tracer's scene.
    ///
    /// # Errors
    /// `TooManyOverlaps`.
    pub fn new(tracer: &'t Tracer<'s>) -> Result<Self, PatchError> {
        Ok(Self { tracer, parting: Parting::new(tracer)? })
    }

    /// Cuts the scene and finds the sides that light reaches.
    ///
    /// # Errors
    /// `Size`, `TooMany` or `Cancelled`.
    pub fn cut(&mut self, options: &Tessellation) -> Result<Patches<'s>, PatchError> {
        options.progress.at("patch", 0.0)?;
        match options.size {
            PatchSize::Edge(metres) if metres.is_finite() && metres > 0.0 => {
                let fineness = Fineness::even(metres / self.tracer.frame().scale());
                self.cut_as(fineness, options)
            }
            PatchSize::Count(count) if count > 0 => self.cut_into(count, options),
            PatchSize::Edge(metres) => Err(PatchError::Size(format!("an edge of {metres} m"))),
            PatchSize::Count(count) => Err(PatchError::Size(format!("{count} patches"))),
        }
    }

    /// Cuts so that about `count` slots are reached: once coarsely, to see which sides are, then as fine as
    /// that says.
    fn cut_into(&mut self, count: usize, options: &Tessellation) -> Result<Patches<'s>, PatchError> {
        const COARSE: usize = 1000;
        /// A cut that has not the expected number of patches, because finer patches see more, is made once
        /// more.
        const ATTEMPTS: usize = 2;
        let (tracer, parting) = (self.tracer, &mut self.parting);
        let (mut fineness, _) = fineness_for(tracer, count.min(COARSE), parting, |_| [1.0; 2]);
        let mut patches = Patches::cut(tracer, fineness, parting, options)?;
        patches.reach(tracer, options, reach::GLANCE)?;
        for _ in 0..ATTEMPTS {
            if patches.is_empty() && options.reach == Reach::Light {
                break;
            }
            let share = |f: usize| if patches.is_empty() { [1.0; 2] } else { patches.reached_share(f) };
            let shares: Vec<_> = (0..tracer.scene().faces().len()).map(share).collect();
            let expected;
            (fineness, expected) = fineness_for(tracer, count, parting, |face| shares[face]);
            patches = Patches::cut(tracer, fineness, parting, options)?;
            patches.reach(tracer, options, reach::LOOK)?;
            if (patches.len() as f64 / expected - 1.0).abs() < 0.1 {
                break;
            }
        }
        Ok(patches)
    }

    /// Cuts the scene of `known` into patches whose legs are so many times as long.
    ///
    /// # Errors
    /// `TooMany` or `Cancelled`.
    pub fn scale(
        &mut self,
        known: &Patches<'s>,
        factor: f64,
        options: &Tessellation,
    ) -> Result<Patches<'s>, PatchError> {
        options.progress.at("patch", 0.0)?;
        self.cut_as(known.fineness().scaled(factor), options)
    }

    /// Cuts so finely, and finds the sides that light reaches.
    fn cut_as(&mut self, fineness: Fineness, options: &Tessellation) -> Result<Patches<'s>, PatchError> {
        let mut patches = Patches::cut(self.tracer, fineness, &mut self.parting, options)?;
        patches.reach(self.tracer, options, reach::LOOK)?;
        Ok(patches)
    }

    /// Cuts the scene of `known` into about `count` patches. Light is looked for only where it is known to
    /// reach; what it reaches besides is found by the rays that land on it.
    ///
    /// # Errors
    /// `TooMany` or `Cancelled`.
    pub fn resize(
        &mut self,
        known: &Patches<'s>,
        count: usize,
        options: &Tessellation,
    ) -> Result<Patches<'s>, PatchError> {
        options.progress.at("patch", 0.0)?;
        let (fineness, _) = self.fineness_like(known, count);
        let mut patches = Patches::cut(self.tracer, fineness, &mut self.parting, options)?;
        let is_likely = |&slot: &u32| {
            let Slot { face, side, cell } = patches.slot(slot);
            let [a, b, c] = patches.cuts.corners(face, cell);
            known.patch_at(face, side, [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0)).is_some()
        };
        let likely: Vec<u32> = (0..patches.slots() as u32).into_par_iter().filter(is_likely).collect();
        patches.reach_likely(self.tracer, options, &likely)?;
        Ok(patches)
    }

    /// About how many patches [`Cutter::resize`] would make: faces are cut in whole steps, and all of a mesh
    /// at once where they are alike.
    pub fn expected(&mut self, known: &Patches<'s>, count: usize) -> usize {
        self.fineness_like(known, count).1.round() as usize
    }

    /// How fine a cut has about `count` patches if light reaches what it reaches in `known`, and how many it
    /// has.
    fn fineness_like(&mut self, known: &Patches<'s>, count: usize) -> (Fineness, f64) {
        let faces = 0..self.tracer.scene().faces().len();
        let shares: Vec<_> = faces.map(|face| known.reached_share(face)).collect();
        fineness_for(self.tracer, count, &mut self.parting, |face| shares[face])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn cut<'s>(cutter: &mut Cutter<'_, 's>, count: usize) -> Patches<'s> {
        cutter.cut(&Tessellation { size: PatchSize::Count(count), ..Default::default() }).unwrap()
    }

    #[test]
    fn a_cut_of_another_size_has_about_as_many_patches_as_expected() {
        let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/corridor.obj")).unwrap();
        let tracer = Tracer::new(&scene);
        let mut cutter = Cutter::new(&tracer).unwrap();
        let coarse = cut(&mut cutter, 300);
        for count in [1000, 3000, 9000] {
            let expected = cutter.expected(&coarse, count) as f64;
            let anew = cut(&mut cutter, count).len() as f64;
            assert!((expected / anew - 1.0).abs() < 0.1, "{expected} {anew}");
        }
    }

    #[test]
    fn a_cut_of_another_size_has_the_patches_that_one_made_anew_has() {
        // Closed rooms, furniture on the floor, and a wall with two sides.
        for name in ["tests/data/gallery.obj", "meshes/two_rooms.obj", "meshes/furnished_room.obj"] {
            let scene = Scene::load(format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
            let tracer = Tracer::new(&scene);
            let mut cutter = Cutter::new(&tracer).unwrap();
            let coarse = cut(&mut cutter, 3000);
            let resized = cutter.resize(&coarse, 8000, &Tessellation::default()).unwrap();
            let edge = PatchSize::Edge(resized.edge());
            let anew = cutter.cut(&Tessellation { size: edge, ..Default::default() }).unwrap();
            let slots = |patches: &Patches| -> Vec<u32> {
                (0..patches.len()).map(|i| patches.slot_of_patch(i)).collect()
            };
            let (resized, anew) = (slots(&resized), slots(&anew));
            let common = resized.iter().filter(|slot| anew.binary_search(slot).is_ok()).count();
            let share = common as f64 / resized.len().max(anew.len()) as f64;
            assert!(share > 0.98, "{name}: {common} of {} and {}", resized.len(), anew.len());
        }
    }
}
