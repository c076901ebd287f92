//! Grid: which numbers of patches and rays a study tries, and in which order.

use std::time::Duration;

use serde::Serialize;

use super::constants::{
    ENTRIES_PER_RAY, ENTRY_SECONDS, FEWEST_VALUES, FIRST_PATCHES, FIRST_PATCHES_PER_SIDE, FIRST_RAYS,
    MOST_PATCHES, MOST_RAYS, PATCH_SECONDS, RAY_SECONDS, RAYS_OF_REPEATS, REPEATS, STEP,
};

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
        let coarsest = (FIRST_PATCHES_PER_SIDE * sides).next_power_of_two().max(FIRST_PATCHES);
        let ladder = |first: usize| (0..FEWEST_VALUES as u32).map(move |k| first * STEP.pow(k));
        let mut grid = Self {
            patches: ladder(coarsest).collect(),
            rays: ladder(FIRST_RAYS).map(|rays| rays as u32).collect(),
        };
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
    /// once.
    pub fn repeats(&self) -> usize {
        (RAYS_OF_REPEATS / (self.patches * self.rays as usize).max(1)).clamp(REPEATS[0], REPEATS[1])
    }

    /// About what all its repeats take on two cores.
    pub(super) fn nominal_seconds(&self) -> f64 {
        let (n, rays) = (self.patches as f64, f64::from(self.rays));
        // Cutting, rays and shadow rays, and all solvers together by entries of the matrix.
        let once =
            PATCH_SECONDS * n + RAY_SECONDS * n * rays + ENTRY_SECONDS * n * n.min(ENTRIES_PER_RAY * rays);
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
            assert!(grid.patches.len() >= FEWEST_VALUES && grid.rays.len() >= FEWEST_VALUES, "{grid:?}");
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
        assert!(grid.patches[0] >= 50_000 && grid.patches.len() == FEWEST_VALUES);
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
