//! Runs: one cell of the grid solved every way, each timed as a user would pay for it alone.
//!
//! The ways of solving share patches and form factors, and each is charged for them.

use std::time::Instant;

use super::StudyOptions;
use super::constants::{FEWER_PATHS, FIRST_PATHS, ORDERS, PATHS_STEP};
use super::grid::Cell;
use super::reference::StudyReference;
use super::row::{StudyRow, StudySolver};
use crate::measure::{Answer, Energy, MeasureError, Verdict};
use crate::patches::{FaceRow, PatchSize, Patches, Tessellation};
use crate::progress::Progress;
use crate::reference::{Budget, PathOptions, PathTracer};
use crate::solve::{self, Method, Problem, SolveOptions};
use crate::trace::Tracer;
use crate::transport::{FormFactors, LightOptions, TraceOptions};

/// Sets the seed of light paths apart from that of the reference, against which they are held.
const PATHS: u64 = 1 << 60;

/// One way of solving, over all repeats.
struct Way {
    solver: StudySolver,
    order: Option<usize>,
    iterations: usize,
    bytes: u64,
    /// Per repeat: seconds before solving, and of solving.
    seconds: Vec<[f64; 2]>,
    answers: Vec<Vec<FaceRow>>,
}

impl Way {
    fn new(solver: StudySolver, order: Option<usize>) -> Self {
        Self { solver, order, iterations: 0, bytes: 0, seconds: Vec::new(), answers: Vec::new() }
    }

    fn row(self, patches: usize, rays: u32, asked: usize, reference: &StudyReference) -> StudyRow {
        let error = reference.error_of(&self.answers);
        let [seconds, solve_seconds]: [fn(&[f64; 2]) -> f64; 2] = [|s| s[0] + s[1], |s| s[1]];
        StudyRow {
            patches,
            rays,
            solver: self.solver,
            order: self.order,
            seconds: median(self.seconds.iter().map(seconds).collect()),
            bytes: self.bytes,
            error: error.error,
            error_se: error.error_se,
            bias: error.bias,
            leak: error.leak,
            solve_seconds: median(self.seconds.iter().map(solve_seconds).collect()),
            iterations: self.iterations,
            repeats: self.answers.len(),
            asked,
        }
    }
}

/// Solves one cell every way, as often as it is to be repeated; also answers whether what conjugate gradients
/// find first can be relied on.
pub(super) fn measure_cell(
    tracer: &Tracer,
    cell: Cell,
    reference: &StudyReference,
    options: &StudyOptions,
    progress: Progress,
) -> Result<(Vec<StudyRow>, Verdict), MeasureError> {
    let mut verdict = Verdict::default();
    let mut ways = vec![Way::new(StudySolver::Cg, None)];
    ways.extend(ORDERS.map(|order| Way::new(StudySolver::Neumann, Some(order))));
    let mut patches = 0;
    for repeat in 0..cell.repeats() {
        let seed = seed_of(options.seed, repeat);
        let began = Instant::now();
        let size = PatchSize::Count(cell.patches);
        let cut = Tessellation { size, seed, memory: options.memory, progress, ..Tessellation::default() };
        let mut cut = Patches::new(tracer, &cut)?;
        let (basis, memory) = (options.basis, options.memory);
        let trace =
            TraceOptions { rays: Some(cell.rays), seed, basis, memory, progress, ..TraceOptions::default() };
        let factors = FormFactors::trace(tracer, &mut cut, &trace)?;
        let light = LightOptions { rays: cell.rays, seed, progress, ..Default::default() };
        let problem = Problem::new(tracer, &cut, &factors, &light)?;
        let before = began.elapsed().as_secs_f64();
        if repeat == 0 {
            patches = cut.len();
            if solve::is_quick(problem.operator(), memory) {
                ways.insert(1, Way::new(StudySolver::Direct, None));
            }
        }
        for way in &mut ways {
            let began = Instant::now();
            let solve_options = solve_options(way, memory, progress);
            let solved = problem.solve(&solve_options)?;
            way.seconds.push([before, began.elapsed().as_secs_f64()]);
            way.iterations = solved.report.iterations;
            if repeat == 0 && way.solver == StudySolver::Cg {
                verdict = Verdict::of(&Answer {
                    tracer,
                    patches: &cut,
                    problem: &problem,
                    solution: &solved,
                    energy: &Energy::of(&problem, &solved.radiance),
                    budget: None,
                    tolerance: solve_options.tolerance,
                });
            }
            way.bytes = factors.exchange().bytes();
            if way.solver == StudySolver::Direct {
                way.bytes += solve::factor_bytes(problem.operator());
            }
            way.answers.push(cut.average_by_face(&solved.means().irradiance));
        }
    }
    let rows = ways.into_iter().map(|way| way.row(patches, cell.rays, cell.patches, reference));
    Ok((rows.collect(), verdict))
}

fn solve_options<'a>(way: &Way, memory: u64, progress: Progress<'a>) -> SolveOptions<'a> {
    let usual = SolveOptions { memory, progress, ..SolveOptions::default() };
    match (way.solver, way.order) {
        (StudySolver::Direct, _) => SolveOptions { method: Method::Direct, ..usual },
        // No residual is small enough, so that the series goes on to its order.
        (_, Some(order)) => SolveOptions { method: Method::Neumann, tolerance: 0.0, order, ..usual },
        (_, None) => SolveOptions { method: Method::ConjugateGradients, ..usual },
    }
}

/// Light paths of their own against those of the reference, from few to as many as still stand out from its
/// noise; none where that is so noisy that even few do not.
pub(super) fn measure_paths(
    tracer: &Tracer,
    sides: &Patches,
    reference: &StudyReference,
    options: &StudyOptions,
    progress: Progress,
) -> Result<Vec<StudyRow>, MeasureError> {
    let tracer = PathTracer::new(tracer);
    let mut rows = Vec::new();
    let mut per_side = FIRST_PATHS;
    while FEWER_PATHS * per_side * sides.len() as u64 <= reference.paths {
        let mut way = Way::new(StudySolver::Paths, None);
        let mut paths = 0;
        for repeat in 0..(Cell { patches: sides.len(), rays: per_side as u32 }).repeats() {
            let began = Instant::now();
            let budget = Budget { paths: Some(per_side * sides.len() as u64), ..Budget::default() };
            let seed = seed_of(options.seed ^ PATHS, repeat);
            let found = tracer.irradiance(
                sides,
                &PathOptions { budget, bounces: 0, seed, progress, ..PathOptions::default() },
            )?;
            way.answers.push(sides.average_by_face(&found.means()));
            way.seconds.push([0.0, began.elapsed().as_secs_f64()]);
            way.bytes = found.bytes();
            paths = found.paths();
        }
        let mean = paths as f64 / sides.len() as f64;
        rows.push(way.row(sides.len(), mean.round() as u32, 0, reference));
        per_side *= PATHS_STEP;
    }
    Ok(rows)
}

/// The seed of a repeat; the first has the study's own.
fn seed_of(seed: u64, repeat: usize) -> u64 {
    seed ^ ((repeat as u64) << 48)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let (low, high) = (values[(values.len() - 1) / 2], values[values.len() / 2]);
    0.5 * (low + high)
}
