//! Raw exchange areas, before they are balanced, and what becomes of the rays that tell them.

use nalgebra::DVector;

use super::storage::Storage;
use crate::patches::Patches;
use crate::transport::rows::{ABSORBED, ESCAPED, End, LOST, Rows};

/// The rays of rows that count.
#[derive(Clone, Copy)]
pub struct Selection<'a> {
    pub rows: &'a Rows,
    pub patches: &'a Patches<'a>,
    /// In a tone.
    pub tone: usize,
    /// All batches but this, if there is one.
    pub left_out: Option<u32>,
}

/// Raw exchange areas: symmetric, not yet balanced.
pub struct Raw {
    pub storage: Storage,
    /// What ends elsewhere than on patches, per coefficient.
    pub leaving: Leaving,
    /// Which coefficients are those of lamps, known better than the rest.
    pub is_lamp: Vec<bool>,
}

/// What ends elsewhere than on patches, in units of exchange areas.
pub struct Leaving {
    /// All of it, per coefficient.
    pub all: DVector<f64>,
    /// Which shares of it carriers absorb and paths lose that are cut short, per coefficient; none without
    /// carriers.
    pub in_carriers: Option<[DVector<f64>; 2]>,
}

impl Leaving {
    /// Puts together what escapes, is absorbed and is lost per coefficient.
    pub fn new(parts: &[[f64; 3]], has_carriers: bool) -> Self {
        let n = parts.len();
        let all = DVector::from_fn(n, |i, _| parts[i].iter().sum());
        let share = |kind: usize| {
            DVector::from_fn(n, |i, _| if all[i] > 0.0 { parts[i][kind] / all[i] } else { 0.0 })
        };
        let in_carriers = has_carriers.then(|| [share(ABSORBED), share(LOST)]);
        Self { all, in_carriers }
    }
}

/// What becomes of a ray from a patch, once slots have become patches.
pub enum Outcome {
    /// It meets this patch, by way of carriers or straight.
    Met { patch: u32, carried: bool },
    /// It counts to one kind of what leaves.
    Left(usize),
}

impl Outcome {
    /// A side without light is as good as outside.
    #[inline]
    pub fn of(end: End, patches: &Patches) -> Self {
        match end.slot().map(|slot| patches.patch_of_slot(slot)) {
            Some(Some(patch)) => Self::Met { patch, carried: end.is_carried() },
            Some(None) => Self::Left(ESCAPED),
            None if end == End::ABSORBED => Self::Left(ABSORBED),
            None if end == End::LOST => Self::Left(LOST),
            None => Self::Left(ESCAPED),
        }
    }
}

/// Whether there is any carrier or coat in the scene.
pub fn has_carriers(patches: &Patches) -> bool {
    let scene = patches.scene();
    (0..scene.faces().len()).any(|face| scene.passes_on(face))
}
