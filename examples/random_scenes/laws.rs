//! What must hold for the answer to one random scene.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use nalgebra::DMatrix;
use radiosity::measure::{Answer, Energy, ErrorBars, ErrorBudget, ErrorPart, Verdict};
use radiosity::patches::{FaceRow, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Scene, Side};
use radiosity::solve::{CgOptions, NeumannOptions, Problem, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions, TransportError};

use super::generator::{Lift, RandomScene};

/// Patches and rays per patch of the answers that are tested; the answers they are held against have 4 times
/// the patches and 16 times the rays.
const BASE: (usize, u32) = (500, 128);
const FINE: (usize, u32) = (4 * BASE.0, 16 * BASE.1);

/// What iterative solvers are asked for.
const TOLERANCE: f64 = 1e-6;

/// How far an answer may be from that of the lifted scene, beside noise.
const AS_IF_LIFTED: f64 = 0.005;

/// A law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Law {
    /// The scene is solved, or refused by the names of its materials because all light is trapped.
    Solved,
    /// Every term of the energy balance is there, to rounding.
    EnergyDirect,
    /// The same of iterative solvers, to ten times their tolerance.
    EnergyIterative,
    /// Solvers agree to ten times their tolerance.
    SolversAgree,
    /// Coincident surfaces answer as if one were lifted.
    AsIfLifted,
    /// A finer answer lies within the sum of both error bounds; in most scenes.
    Bound,
    /// The same over the faces that no warning names; in all scenes that have a warning.
    BoundOfUnnamed,
}

/// How one scene fared.
pub struct Outcome {
    pub seed: u64,
    pub seconds: f64,
    pub features: BTreeSet<&'static str>,
    /// The laws that were broken, and how.
    pub broken: Vec<(Law, String)>,
    /// What the user is warned of.
    pub warnings: Vec<String>,
    /// Whether the scene was rightly refused.
    pub is_refused: bool,
}

/// Tests all laws on the scenes of these seeds, as many at a time as there are processors; `see` is shown
/// every outcome as it comes.
///
/// # Errors
/// If the folder can't be written.
pub fn check_all(
    seeds: Range<u64>,
    folder: &Path,
    see: impl Fn(&Outcome) + Sync,
) -> io::Result<Vec<Outcome>> {
    let next = AtomicU64::new(seeds.start);
    let processors = thread::available_parallelism()?.get();
    let workers = processors.min(seeds.clone().count()).max(1);
    let work = || -> io::Result<Vec<Outcome>> {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(processors / workers);
        let pool = threads.build().map_err(io::Error::other)?;
        let taken = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|seed| seeds.contains(seed));
        std::iter::from_fn(taken)
            .map(|seed| pool.install(|| check(seed, folder)).inspect(|outcome| see(outcome)))
            .collect()
    };
    let found: Vec<io::Result<Vec<Outcome>>> = thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().expect("no panic")).collect()
    });
    let mut outcomes: Vec<Outcome> =
        found.into_iter().collect::<io::Result<Vec<_>>>()?.into_iter().flatten().collect();
    outcomes.sort_by_key(|outcome| outcome.seed);
    Ok(outcomes)
}

/// Writes the scene of a seed to a folder of its own and tests all laws on it.
fn check(seed: u64, folder: &Path) -> io::Result<Outcome> {
    let began = Instant::now();
    let random = RandomScene::new(seed, Lift::Flush);
    let folder = folder.join(format!("seed_{seed}"));
    std::fs::create_dir_all(&folder)?;
    let path = random.write(&folder)?;
    let mut outcome = Outcome {
        seed,
        seconds: 0.0,
        features: random.features.clone(),
        broken: Vec::new(),
        warnings: Vec::new(),
        is_refused: false,
    };
    if let Err(failure) = test(&random, &path, &mut outcome) {
        match failure.downcast_ref() {
            Some(radiosity::Error::Transport(TransportError::Unsolvable { materials }))
                if !materials.is_empty() =>
            {
                outcome.is_refused = true;
            }
            _ => outcome.broken.push((Law::Solved, failure.to_string())),
        }
    }
    outcome.seconds = began.elapsed().as_secs_f64();
    Ok(outcome)
}

type Failure = Box<dyn std::error::Error>;

fn test(random: &RandomScene, path: &Path, outcome: &mut Outcome) -> Result<(), Failure> {
    let scene = Scene::load(path)?;
    let seed = outcome.seed;
    let base = Solved::of(&scene, BASE, seed, |problem| {
        outcome.broken.extend(energy_and_solvers(problem));
    })?;
    outcome.warnings = base.warnings.clone();
    let fine = Solved::of(&scene, FINE, seed + 1, |_| {})?;
    let (apart, bound) = (fine.distance(&base, |_, _| true), base.budget.upper95 + fine.budget.upper95);
    if exceeds(apart, bound) {
        outcome.broken.push((Law::Bound, format!("{} apart, bounds {}", percent(apart), percent(bound))));
    }
    if !base.named.is_empty() {
        let apart = fine.distance(&base, |face, _| !base.named.contains(&face));
        if exceeds(apart, bound) {
            outcome
                .broken
                .push((Law::BoundOfUnnamed, format!("{} apart, bounds {}", percent(apart), percent(bound))));
        }
    }
    if random.overlap.is_some() {
        let folder = tempfile::tempdir()?;
        let lifted = RandomScene::new(seed, Lift::Lifted).write(folder.path())?;
        let lifted = Solved::of(&Scene::load(lifted)?, FINE, seed + 1, |_| {})?;
        // Between sheets that are apart there are two sides more, and white ones hold light there however
        // narrow the gap is.
        let apart = lifted.distance(&fine, |face, side| fine.has(face, side));
        let allowed = AS_IF_LIFTED + 2.0 * fine.noise().hypot(lifted.noise());
        if exceeds(apart, allowed) {
            let found = format!("{} from the lifted scene, allowed {}", percent(apart), percent(allowed));
            outcome.broken.push((Law::AsIfLifted, found));
        }
    }
    Ok(())
}

/// Whether a number is too large, or none.
fn exceeds(x: f64, limit: f64) -> bool {
    x.is_nan() || x > limit
}

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// Irradiance by face, and what is said of its error.
struct Solved {
    faces: Vec<FaceRow>,
    budget: ErrorBudget,
    /// What the user is warned of.
    warnings: Vec<String>,
    /// The faces that warnings name.
    named: BTreeSet<usize>,
}

impl Solved {
    /// Solves a scene directly, and has `look` at the problem.
    fn of(
        scene: &Scene,
        (count, rays): (usize, u32),
        seed: u64,
        look: impl FnOnce(&Problem),
    ) -> Result<Self, radiosity::Error> {
        let tracer = Tracer::new(scene);
        let size = PatchSize::Count(count);
        let mut patches = Patches::new(&tracer, &Tessellation { size, seed, ..Default::default() })?;
        let options = TraceOptions { rays: Some(rays), seed, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options)?;
        let light = LightOptions { seed, ..Default::default() };
        let problem = Problem::new(&tracer, &patches, &factors, &light)?;
        look(&problem);
        let solution = problem.direct(&Default::default())?;
        let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default())?;
        let verdict = Verdict::of(&Answer {
            tracer: &tracer,
            patches: &patches,
            problem: &problem,
            solution: &solution,
            energy: &Energy::of(&problem, &solution.radiance),
            budget: Some(&bars.budget),
            tolerance: TOLERANCE,
        });
        let reasons = verdict.reasons.iter();
        Ok(Self {
            faces: patches.average_by_face(&solution.irradiance),
            budget: bars.budget,
            warnings: reasons.clone().map(ToString::to_string).chain(scene.warnings().to_vec()).collect(),
            named: reasons.flat_map(|reason| reason.faces.iter().copied()).collect(),
        })
    }

    /// Whether a side has patches.
    fn has(&self, face: usize, side: Side) -> bool {
        self.faces.iter().any(|row| (row.face, row.side) == (face, side))
    }

    /// How far the flux on faces is from that of another answer, relative to this one: √(ΣΔΦ²/A) / √(ΣΦ²/A)
    /// over all channels and over those sides that are wanted. Where a side has no patches there is no light.
    fn distance(&self, other: &Self, is_wanted: impl Fn(usize, Side) -> bool) -> f64 {
        let mut sides: BTreeMap<(usize, Side), [Option<&FaceRow>; 2]> = BTreeMap::new();
        for (k, answer) in [self, other].into_iter().enumerate() {
            let rows = answer.faces.iter().filter(|row| is_wanted(row.face, row.side));
            rows.for_each(|row| sides.entry((row.face, row.side)).or_default()[k] = Some(row));
        }
        let flux = |row: Option<&FaceRow>, c: usize| row.map_or(0.0, |row| row.area * row.mean[c]);
        let (mut apart, mut whole) = (0.0, 0.0);
        for rows in sides.into_values() {
            let Some(known) = rows[0].or(rows[1]) else { continue };
            for c in 0..known.mean.len() {
                let [mine, theirs] = rows.map(|row| flux(row, c));
                apart += (mine - theirs).powi(2) / known.area;
                whole += mine.powi(2) / known.area;
            }
        }
        if apart == 0.0 { 0.0 } else { (apart / whole).sqrt() }
    }

    /// The part of the error to be expected that is noise.
    fn noise(&self) -> f64 {
        self.budget.part(ErrorPart::RAYS).hypot(self.budget.part(ErrorPart::LAMPS))
    }
}

/// Solves by every solver, and tests the balance of energy and whether they agree.
fn energy_and_solvers(problem: &Problem) -> Vec<(Law, String)> {
    let direct = match problem.direct(&Default::default()) {
        Ok(solution) => solution,
        Err(error) => return vec![(Law::Solved, error.to_string())],
    };
    let mut broken = Vec::new();
    // An identity to rounding, which what goes round amplifies.
    let share = share_lost(problem, &direct.radiance);
    let off = Energy::of(problem, &direct.radiance).imbalance;
    let allowed = if share >= 1e-3 { 1e-9 } else { 1e-12 / share };
    if exceeds(off, allowed) {
        broken.push((Law::EnergyDirect, format!("{off:.1e} of {allowed:.0e}, {share:.1e} is lost a bounce")));
    }
    let mut compare = |found: &Solution| {
        let name = found.report.name;
        let off = Energy::of(problem, &found.radiance).imbalance;
        if exceeds(off, 10.0 * TOLERANCE) {
            broken.push((Law::EnergyIterative, format!("{name}: {off:.1e}")));
        }
        let apart = farthest(problem, &found.irradiance, &direct.irradiance);
        if exceeds(apart, 10.0 * TOLERANCE) {
            broken.push((Law::SolversAgree, format!("{name}: {apart:.1e} apart")));
        }
    };
    let mut failed = None;
    match problem.conjugate_gradients(&CgOptions { tolerance: TOLERANCE, ..Default::default() }) {
        Ok(found) => compare(&found),
        Err(error) => failed = Some(error),
    }
    let options = NeumannOptions { tolerance: TOLERANCE, ..Default::default() };
    match problem.neumann(&options) {
        // A series that its cap ends says so.
        Ok(series) if series.order() == options.order => {}
        Ok(series) => compare(&series.solution),
        Err(error) => failed = Some(error),
    }
    broken.extend(failed.map(|error| (Law::Solved, error.to_string())));
    broken
}

/// The share of light that is absorbed or escapes per bounce, the least over channels: emitted power by all
/// that leaves.
fn share_lost(problem: &Problem, radiance: &DMatrix<f64>) -> f64 {
    let mass = problem.operator().mass();
    let areas = mass.areas();
    let leaves = radiance.column_iter().map(|column| PI * areas.dot(&column));
    let shares = problem.sources().flux(mass).into_iter().zip(leaves).map(|(starts, leaves)| starts / leaves);
    shares.fold(1.0, f64::min)
}

/// The largest |ΔH_i| / max(H_i, 10⁻³ H_rms).
fn farthest(problem: &Problem, found: &DMatrix<f64>, known: &DMatrix<f64>) -> f64 {
    let mass = problem.operator().mass();
    let mut farthest = 0.0;
    for (found, known) in found.column_iter().zip(known.column_iter()) {
        let typical = mass.root_mean_square(known.as_view());
        for (found, known) in found.iter().zip(known.iter()).filter(|_| typical > 0.0) {
            let apart = (found - known).abs() / known.max(1e-3 * typical);
            farthest = if apart.is_nan() { f64::NAN } else { f64::max(farthest, apart) };
        }
    }
    farthest
}
