//! Grid: which numbers of patches and rays a study tries, and in which order.

use std::time::Duration;

use serde::Serialize;

/// Each value of a knob is so many times the one before.
const STEP: usize = 4;

/// Values of a knob that a trend can be told from.
const FEWEST: usize = 3;

/// What a study tries: every number of patches with every number of rays.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Grid {
    /// Numbers of patches to ask for, ascending.
    pub patches: Vec<usize>,
    /// Rays per patch, ascending.
    pub rays: Vec<u32>,
}

/// One number of patches with one number of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// The number of patches to ask for.
    pub patches: usize,
    /// Rays per patch.
    pub rays: u32,
}

impl Grid {
    /// A grid for a scene whose faces have so many sides that light reaches: three values a knob, and more as
    /// long as an ordinary machine gets all of them done in `time`.
    ///
    /// Depends on no clock, so that the same scene and time give the same grid anywhere.
    pub fn for_scene(sides: usize, time: Duration) -> Self {
        const MOST_PATCHES: usize = 1 << 20;
        const MOST_RAYS: u32 = 1 << 14;
        let coarsest = (2 * sides).next_power_of_two().max(128);
        let ladder = |first: usize| (0..FEWEST as u32).map(move |k| first * STEP.pow(k));
        let mut grid =
            Self { patches: ladder(coarsest).collect(), rays: ladder(16).map(|rays| rays as u32).collect() };
        // The knob with fewer values grows first; of equals patches, for their error is seldom gone while
        // that of rays still is there.
        while let (Some(&patches), Some(&rays)) = (grid.patches.last(), grid.rays.last()) {
            let mut larger = grid.clone();
            if larger.rays.len() < larger.patches.len() {
                larger.rays.push(rays * STEP as u32);
            } else {
                larger.patches.push(patches * STEP);
            }
            let fits = larger.patches.last() <= Some(&MOST_PATCHES) && larger.rays.last() <= Some(&MOST_RAYS);
            if !fits || larger.nominal_seconds() > time.as_secs_f64() {
                break;
            }
            grid = larger;
        }
        grid
    }

    /// Every cell, the quickest first.
    pub fn cells(&self) -> Vec<Cell> {
        let rays = |&patches: &usize| self.rays.iter().map(move |&rays| Cell { patches, rays });
        let mut cells: Vec<Cell> = self.patches.iter().flat_map(rays).collect();
        cells.sort_by(|a, b| a.nominal_seconds().total_cmp(&b.nominal_seconds()));
        cells
    }

    fn nominal_seconds(&self) -> f64 {
        self.cells().iter().map(Cell::nominal_seconds).sum()
    }
}

impl Cell {
    /// How often it is measured, each time with other random numbers: oftener where that costs little. Never
    /// once, for the spread between answers is part of what is measured.
    pub fn repeats(&self) -> usize {
        const RAYS_IN_ALL: usize = 1 << 21;
        (RAYS_IN_ALL / (self.patches * self.rays as usize).max(1)).clamp(2, 24)
    }

    /// About what all its repeats take on two cores.
    pub(super) fn nominal_seconds(&self) -> f64 {
        let (n, rays) = (self.patches as f64, f64::from(self.rays));
        // Cutting, rays and shadow rays, and all solvers together by entries of the matrix.
        let once = 4e-6 * n + 2.4e-7 * n * rays + 6e-8 * n * n.min(1.5 * rays);
        self.repeats() as f64 * once
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_knob_has_three_values_and_more_with_more_time() {
        let mut last = 0;
        for seconds in [0, 1, 10, 60, 600] {
            let grid = Grid::for_scene(58, Duration::from_secs(seconds));
            assert!(grid.patches.len() >= FEWEST && grid.rays.len() >= FEWEST, "{grid:?}");
            assert!(seconds < 10 || grid.nominal_seconds() <= seconds as f64, "{grid:?}");
            let cells = grid.cells();
            assert!(cells.len() >= last && cells.len() == grid.patches.len() * grid.rays.len());
            last = cells.len();
        }
        assert!(last > 20);
    }

    #[test]
    fn a_mesh_of_many_faces_is_never_asked_for_fewer_patches_than_it_has() {
        let grid = Grid::for_scene(50_000, Duration::from_secs(60));
        assert!(grid.patches[0] >= 50_000 && grid.patches.len() == FEWEST);
    }

    #[test]
    fn what_is_quick_is_repeated_and_nothing_is_measured_once() {
        for cell in Grid::for_scene(12, Duration::from_secs(600)).cells() {
            assert!((2..=24).contains(&cell.repeats()));
        }
        assert_eq!(Cell { patches: 128, rays: 16 }.repeats(), 24);
        assert_eq!(Cell { patches: 1 << 20, rays: 16 }.repeats(), 2);
    }
}
