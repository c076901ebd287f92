//! Conclusions: what a study's rows say, as numbers; words are made of them elsewhere.

use serde::Serialize;

use super::constants::{
    ACCURACIES, AS_GOOD, FEWEST_VALUES, LEAST_LOG_TIME, NO_GAIN, ORDER_ENOUGH, ORDER_LACKS,
    ORDER_LACKS_ERRORS, SAME_TIME, TRUNCATION_APART,
};
use super::front::front;
use super::reference::StudyReference;
use super::row::{Reading, StudyRow, StudySolver};
use super::trend::{Slope, Trend};

/// What the rows of a study say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conclusions {
    /// Relative noise of the reference.
    pub noise: f64,
    /// Errors below this can't be told from nothing, because of that noise.
    pub resolution: f64,
    /// Numbers of the matrix rows that no other matrix row beats in both time and error, the quickest first.
    pub front: Vec<usize>,
    /// The row with the least error: the second witness beside the reference, which shares nothing with it
    /// but the scene and the tracer.
    pub best: Option<usize>,
    /// Error against patches, rays at their best.
    pub patches: Option<Trend>,
    /// Error against rays, patches at their best.
    pub rays: Option<Trend>,
    /// The series, on the best cell.
    pub order: Option<OrderTrend>,
    /// Time of solving.
    pub solving: Solving,
    /// Error of light paths against seconds.
    pub paths: Option<Slope>,
    /// The cheapest settings for each accuracy that some matrix row has.
    pub targets: Vec<Target>,
}

/// How the series comes near the solution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderTrend {
    /// Numbers of the rows, by ascending order.
    pub rows: Vec<usize>,
    /// Number of the row that solves to the end on the same patches and rays.
    pub converged: usize,
    /// What each order leaves of the error of truncation; none if too few orders tell.
    pub factor: Option<f64>,
    /// The first order in the study whose error exceeds that of the whole solution by less than a tenth, if
    /// there is one.
    pub enough: Option<usize>,
}

/// What solving takes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Solving {
    /// Of the best cell: conjugate gradients' part of all seconds.
    pub share: f64,
    /// Seconds of factoring and solving against patches.
    pub direct: Option<Slope>,
    /// Seconds of conjugate gradients against patches.
    pub cg: Option<Slope>,
    /// The largest difference between the errors of both on the same cell.
    pub difference: f64,
}

/// The way to one accuracy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// The error asked for.
    pub accuracy: f64,
    /// Number of the quickest matrix row that is known to be no worse; of rows as quick for all that one can
    /// tell, one that is solved to the end.
    pub row: usize,
    /// Seconds that light paths would take for it.
    pub paths_seconds: Option<f64>,
    /// Which knob to turn from there for less error.
    pub turn: Option<Turn>,
}

/// A knob to turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Turn {
    /// More patches.
    Patches,
    /// More rays.
    Rays,
    /// Either helps as much as the other for the same time.
    Both,
    /// A higher order, or a solver that goes on to the end.
    Order,
}

impl Conclusions {
    /// Looks at all rows.
    pub fn new(rows: &[StudyRow], reference: &StudyReference) -> Self {
        let matrix = |row: &StudyRow| row.solver != StudySolver::Paths;
        let best = best(rows);
        let paths: Vec<[f64; 3]> = rows
            .iter()
            .filter(|row| !matrix(row) && matches!(row.reading(), Reading::Resolved(_)))
            .map(|row| [row.seconds, row.error, row.error_se])
            .collect();
        let paths = Slope::fit(&paths);
        let target = |accuracy: f64| {
            let enough = |row: &StudyRow| matrix(row) && row.reading().most() <= accuracy;
            let quickest = front(rows, enough).first().copied()?;
            let seconds = rows.iter().filter(|row| enough(row)).map(|row| row.seconds);
            let least = seconds.fold(f64::INFINITY, f64::min);
            let as_quick = |row: &StudyRow| row.seconds <= SAME_TIME * least;
            let to_the_end = |row: &StudyRow| row.solver == StudySolver::Cg && enough(row) && as_quick(row);
            let row = rows.iter().position(to_the_end).unwrap_or(quickest);
            // Light paths err as 1/√time; the fitted slope is only there to be looked at.
            let price = price_of_paths(rows).map(|price| price / accuracy.powi(2));
            Some(Target { accuracy, row, paths_seconds: price, turn: turn(rows, row) })
        };
        let mut targets: Vec<Target> = ACCURACIES.into_iter().filter_map(target).collect();
        // Of accuracies that the quickest row has anyway only the last says anything.
        let trivial = targets.windows(2).take_while(|pair| pair[0].row == pair[1].row).count();
        targets.drain(..trivial);
        Self {
            noise: reference.noise(),
            resolution: reference.resolution(),
            front: front(rows, matrix),
            best,
            patches: trend(rows, |row| row.rays as usize, |row| row.patches),
            rays: trend(rows, |row| row.asked, |row| row.rays as usize),
            order: best.and_then(|best| order(rows, best)),
            solving: solving(rows, best),
            paths,
            targets,
        }
    }
}

/// The converged row with the least error, as far as it is known; of equals the quickest.
fn best(rows: &[StudyRow]) -> Option<usize> {
    front(rows, |row| row.solver == StudySolver::Cg).last().copied()
}

/// Error against `value` for the highest `other` that has three values of it or more.
fn trend(rows: &[StudyRow], other: fn(&StudyRow) -> usize, value: fn(&StudyRow) -> usize) -> Option<Trend> {
    let cg: Vec<usize> = (0..rows.len()).filter(|&k| rows[k].solver == StudySolver::Cg).collect();
    let mut others: Vec<usize> = cg.iter().map(|&k| other(&rows[k])).collect();
    others.sort();
    others.dedup();
    others.into_iter().rev().find_map(|fixed| {
        let mut along: Vec<usize> = cg.iter().copied().filter(|&k| other(&rows[k]) == fixed).collect();
        along.sort_by_key(|&k| value(&rows[k]));
        (along.len() >= FEWEST_VALUES).then(|| Trend::new(rows, along, fixed, value))
    })
}

fn order(rows: &[StudyRow], converged: usize) -> Option<OrderTrend> {
    let cell = rows[converged].cell();
    let mut along: Vec<(usize, usize)> = (0..rows.len())
        .filter(|&k| rows[k].cell() == cell)
        .filter_map(|k| Some((rows[k].order?, k)))
        .collect();
    along.sort();
    let floor = rows[converged].error;
    // What truncation adds stands apart from the rest of the error while it is much larger.
    let added: Vec<[f64; 2]> = along
        .iter()
        .map(|&(order, k)| (order, rows[k].error))
        .take_while(|&(_, error)| error > TRUNCATION_APART * floor)
        .map(|(order, error)| [order as f64, (error * error - floor * floor).sqrt()])
        .collect();
    let factor = match (added.first(), added.last()) {
        (Some(first), Some(last)) if added.len() >= 2 => {
            Some((last[1] / first[1]).powf(1.0 / (last[0] - first[0])))
        }
        _ => None,
    };
    let near =
        |k: usize| rows[k].error <= ORDER_ENOUGH * floor + rows[k].error_se.max(rows[converged].error_se);
    let settled = along.iter().rposition(|&(_, k)| !near(k)).map_or(0, |far| far + 1);
    let enough = along.get(settled).map(|&(order, _)| order);
    (!along.is_empty()).then(|| OrderTrend {
        rows: along.into_iter().map(|(_, k)| k).collect(),
        converged,
        factor,
        enough,
    })
}

fn solving(rows: &[StudyRow], best: Option<usize>) -> Solving {
    let times = |solver: StudySolver| {
        let own = rows.iter().filter(|row| row.solver == solver);
        Slope::fit(&own.map(|row| [row.patches as f64, row.solve_seconds, 0.0]).collect::<Vec<_>>())
    };
    let pairs = rows.iter().filter(|row| row.solver == StudySolver::Direct).filter_map(|direct| {
        let cg = rows.iter().find(|row| row.solver == StudySolver::Cg && row.cell() == direct.cell())?;
        Some((direct.error - cg.error).abs())
    });
    Solving {
        share: best.map_or(0.0, |best| rows[best].solve_seconds / rows[best].seconds),
        direct: times(StudySolver::Direct),
        cg: times(StudySolver::Cg),
        difference: pairs.fold(0.0, f64::max),
    }
}

/// Error² · seconds of light paths: what they cost at an error of 1.
fn price_of_paths(rows: &[StudyRow]) -> Option<f64> {
    let of_paths = rows.iter().filter(|row| row.solver == StudySolver::Paths);
    let told = of_paths.filter(|row| matches!(row.reading(), Reading::Resolved(_)));
    let prices: Vec<f64> = told.map(|row| (row.error.powi(2) * row.seconds).ln()).collect();
    (!prices.is_empty()).then(|| (prices.iter().sum::<f64>() / prices.len() as f64).exp())
}

/// Which knob gives most for its time: by how many per cent a per cent more time lowers the error.
fn turn(rows: &[StudyRow], from: usize) -> Option<Turn> {
    let cell = rows[from].cell()?;
    let cg = |accept: &dyn Fn(&StudyRow) -> bool| {
        rows.iter()
            .filter(|row| row.solver == StudySolver::Cg && accept(row))
            .min_by_key(|row| (row.asked, row.rays))
    };
    let here = cg(&|row| row.cell() == Some(cell))?;
    if !rows[from].is_converged()
        && rows[from].error > ORDER_LACKS * here.error + ORDER_LACKS_ERRORS * here.error_se
    {
        return Some(Turn::Order);
    }
    let gain = |there: Option<&StudyRow>| {
        let there = there?;
        let fall = (here.reading().most() / there.reading().most()).ln();
        Some((fall / (there.seconds / here.seconds).ln().max(LEAST_LOG_TIME)).max(0.0))
    };
    let patches = gain(cg(&|row| row.rays == cell.rays && row.asked > cell.patches));
    let rays = gain(cg(&|row| row.asked == cell.patches && row.rays > cell.rays));
    match (patches?, rays?) {
        (p, r) if p.max(r) < NO_GAIN => None,
        (p, r) if p > AS_GOOD * r => Some(Turn::Patches),
        (p, r) if r > AS_GOOD * p => Some(Turn::Rays),
        _ => Some(Turn::Both),
    }
}

#[cfg(test)]
mod tests {
    use super::super::reference::ReferenceSide;
    use super::super::row::tests::row;
    use super::*;
    use crate::scene::Side;

    fn reference() -> StudyReference {
        let side = ReferenceSide {
            face: 0,
            side: Side::Front,
            area: 1.0,
            mean: vec![1.0],
            standard_error: vec![1e-4],
            degrees_of_freedom: 1e6,
        };
        StudyReference { sides: vec![side], paths: 1000, seconds: 1.0 }
    }

    /// error² = (mesh / n)² + (noise² / rays n), seconds = n · rays.
    fn rows(mesh: f64, noise: f64) -> Vec<StudyRow> {
        let mut all = Vec::new();
        for n in [100usize, 400, 1600] {
            for rays in [16u32, 64, 256] {
                let work = n as f64 * f64::from(rays);
                let error = (mesh / n as f64).hypot(noise / work.sqrt());
                all.push(row(n, rays, 1e-6 * work, error));
                for order in [1, 2, 4, 8, 16] {
                    let error = error.hypot(0.5 * 0.5f64.powi(order as i32));
                    let solver = StudySolver::Neumann;
                    all.push(StudyRow { solver, order: Some(order), ..row(n, rays, 0.9e-6 * work, error) });
                }
            }
        }
        all
    }

    #[test]
    fn conclusions_find_the_laws_that_the_rows_were_made_of() {
        let all = rows(1.0, 1e-6);
        let found = Conclusions::new(&all, &reference());
        let patches = found.patches.unwrap();
        assert!((patches.slope.unwrap().slope + 1.0).abs() < 1e-3 && patches.enough.is_none());
        let rays = found.rays.unwrap();
        assert_eq!((rays.slope, rays.enough), (None, Some(16)), "rays do nothing here");
        assert!(
            found
                .targets
                .iter()
                .all(|target| matches!(target.turn, None | Some(Turn::Patches | Turn::Order)))
        );
        let order = found.order.unwrap();
        assert!((order.factor.unwrap() - 0.5).abs() < 1e-6, "{order:?}");
        assert_eq!(order.enough, Some(16));
        let all = rows(1e-6, 1.0);
        let found = Conclusions::new(&all, &reference());
        assert!((found.rays.unwrap().slope.unwrap().slope + 0.5).abs() < 1e-3);
        assert!((found.patches.unwrap().slope.unwrap().slope + 0.5).abs() < 1e-3);
    }

    #[test]
    fn every_target_is_met_by_its_row_and_by_no_quicker_one() {
        let all = rows(1.0, 0.5);
        let found = Conclusions::new(&all, &reference());
        assert!(found.targets.len() >= 3);
        for target in &found.targets {
            assert!(all[target.row].reading().most() <= target.accuracy);
            let quicker = all.iter().filter(|row| SAME_TIME * row.seconds < all[target.row].seconds);
            assert!(quicker.filter(|row| row.error <= target.accuracy).count() == 0);
        }
        let best = found.best.unwrap();
        assert!(all.iter().all(|row| row.error >= all[best].error));
        assert_eq!(found.paths, None);
    }

    #[test]
    fn no_rows_and_one_row_give_no_conclusions() {
        let none = Conclusions::new(&[], &reference());
        assert!(none.front.is_empty() && none.best.is_none() && none.targets.is_empty());
        let one = Conclusions::new(&[row(100, 16, 1.0, 0.04)], &reference());
        assert_eq!((one.front.as_slice(), one.patches, one.rays), (&[0][..], None, None));
        assert_eq!(one.targets.len(), 1);
        assert_eq!(one.targets[0].turn, None);
    }
}
