//! More rays: what was traced already, and as much again, as if all had been one.

use rayon::prelude::*;

use super::FormFactors;
use super::options::{Keep, TraceOptions};
use crate::patches::{Basis, Patches};
use crate::trace::Tracer;
use crate::transport::TransportError;
use crate::transport::rows::{BATCHES, Caustics, LampShare, Look, RayCount, Recipe, Row, RowOptions, Rows};

impl FormFactors {
    /// Adds the rays of `options` to those that each patch has sent: half the noise for four times as many in
    /// all. The seed must be another. For constant elements.
    ///
    /// # Errors
    /// `NoRays` unless the rays were kept; else as [`FormFactors::trace`].
    ///
    /// # Panics
    /// For linear elements, whose rays are known by the seed that sent them.
    pub fn with_more_rays(
        self,
        tracer: &Tracer,
        patches: &mut Patches,
        options: &TraceOptions,
    ) -> Result<Self, TransportError> {
        assert_eq!(self.basis(), Basis::Constant, "constant elements");
        let mut known = self.into_rows().ok_or(TransportError::NoRays)?;
        let recipe = options.recipe(patches.len(), &known.tones)?;
        let count = RayCount {
            rays: known.recipe.count.rays + recipe.count.rays,
            lamp_rays: known.recipe.count.lamp_rays + recipe.count.lamp_rays,
        };
        options.check_rays(patches.len(), count.rays, known.tones.len())?;
        let &TraceOptions { caustics: shots, progress, .. } = options;
        let rows = RowOptions { recipe, tones: known.tones.clone(), shots, progress };
        let more = Rows::trace(tracer, patches, rows)?;
        // Sides that the new rays were the first to find send the old ones too.
        known.adapt(tracer, patches, options.progress)?;
        let rows = known.joined(more, count);
        Ok(Self::balance(rows, patches, options.storage, Keep::Rays, options.progress)?)
    }
}

impl Rows {
    /// These rows' rays and those of `other`, batch by batch. Rows that only one of them has are left out.
    fn joined(self, other: Self, count: RayCount) -> Self {
        let share = f64::from(self.recipe.count.rays) / f64::from(count.rays);
        let both = self.all().par_iter().filter_map(|row| Some(joined(row, other.of(row.slot)?, share)));
        let rows = both.collect();
        let caustics = self.caustics.joined(&other.caustics);
        let recipe = Recipe { count, ..self.recipe };
        Self::new((recipe, self.tones), self.lamp_faces, rows, caustics)
    }
}

/// One row of both; `share` is the first one's part of all rays.
fn joined(a: &Row, b: &Row, share: f64) -> Row {
    let landings = interleaved(&a.landings, &b.landings);
    let survivors = interleaved(&a.survivors, &b.survivors);
    let scaled = |row: &Row, by: f64| -> Vec<LampShare> {
        row.lamps.shares.iter().map(|s| LampShare { share: (f64::from(s.share) * by) as f32, ..*s }).collect()
    };
    let mut shares = scaled(a, share);
    shares.extend(scaled(b, 1.0 - share));
    shares.sort_by_key(|s| (s.batch, s.slot));
    shares.dedup_by(|next, kept| {
        let same = (next.batch, next.slot) == (kept.batch, kept.slot);
        if same {
            kept.share += next.share;
        }
        same
    });
    let excess = std::array::from_fn(|batch| {
        (share * f64::from(a.lamps.excess[batch]) + (1.0 - share) * f64::from(b.lamps.excess[batch])) as f32
    });
    Row {
        slot: a.slot,
        landings,
        survivors,
        spots: Vec::new(),
        lamps: Look { shares, moments: Vec::new(), excess },
    }
}

/// Of each batch first the one's, then the other's.
fn interleaved<T: Copy>(a: &[T], b: &[T]) -> Vec<T> {
    let batches = BATCHES as usize;
    let stretch = |all: &[T], batch: usize| {
        let size = all.len() / batches;
        batch * size..(batch + 1) * size
    };
    let mut all = Vec::with_capacity(a.len() + b.len());
    for batch in 0..batches {
        all.extend_from_slice(&a[stretch(a, batch)]);
        all.extend_from_slice(&b[stretch(b, batch)]);
    }
    all
}

impl Caustics {
    /// What both found.
    fn joined(&self, other: &Self) -> Self {
        let ((shots, found), (more_shots, more)) = (self.parts(), other.parts());
        let mut all = [found, more].concat();
        all.sort_by_key(|caustic| (caustic.receiver, caustic.lamp));
        Self::from_parts(shots + more_shots, all)
    }
}
