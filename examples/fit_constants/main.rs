//! Fits the constants of error bars: solves scenes that nothing else looks at, again and again, and holds
//! what each answer says of its own error against what the error is.
//!
//! ```text
//! cargo run --release --example fit_constants            # all scenes: some minutes
//! cargo run --release --example fit_constants -- boxes   # those whose names begin so
//! ```
//!
//! A line for each scene and cut: how far answers with other rays lie apart and what each says of that; how
//! far their mean lies from a fine answer and what each says of that; how many faces lie within their bars at
//! 95 %, and how much wider the bars are than the errors. Then the constants that follow, beside those in use
//! (`src/measure/error_bars/constants.rs`). It fails where fewer than four of five faces lie within their
//! bars.

mod scenes;

use radiosity::measure::{ErrorBars, ErrorBudget, ErrorPart, FITTED};
use radiosity::patches::{FaceRow, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::Scene;
use radiosity::solve::{CgOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions};

type Failure = Box<dyn std::error::Error>;

/// Patches and rays of the answers that are judged.
const CUTS: [(usize, u32); 2] = [(600, 128), (2000, 256)];

/// Answers with other rays on each cut.
const SEEDS: u64 = 6;

/// Patches, rays and answers of what they are held against.
const FINE: (usize, u32) = (12_000, 512);
const FINE_SEEDS: u64 = 2;

/// What a bound at 95 % is of one standard error.
const BOUND: f64 = 1.96;

fn main() -> Result<(), Failure> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|start| name.starts_with(start));
    let mut tally = Tally::default();
    println!(
        "{:10} {:>7} {:>16} {:>6} {:>16} {:>6} {:>7} {:>6}",
        "scene", "patches", "noise (told)", "ratio", "mesh (told)", "ratio", "within", "width"
    );
    for (name, scene) in scenes::all()?.iter().filter(|(name, _)| is_wanted(name)) {
        let fine = fine(scene)?;
        for cut in CUTS {
            println!("{name:10} {}", judge(scene, cut, &fine, &mut tally)?);
        }
    }
    let covered = tally.print();
    assert!(covered > 0.8, "bars should cover nearly all faces");
    Ok(())
}

/// Irradiance by face and what it is known to.
struct Answer {
    faces: Vec<FaceRow>,
    bars: Vec<FaceRow>,
    budget: ErrorBudget,
    patches: usize,
}

fn answer(scene: &Scene, (count, rays): (usize, u32), seed: u64) -> Result<Answer, Failure> {
    let tracer = Tracer::new(scene);
    let size = PatchSize::Count(count);
    let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() })?;
    let options = TraceOptions { rays: Some(rays), seed, keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options)?;
    let light = LightOptions { rays, seed, ..Default::default() };
    let problem = Problem::new(&tracer, &patches, &factors, &light)?;
    let solution = problem.conjugate_gradients(&CgOptions::default())?;
    let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default())?;
    let faces = patches.average_by_face(&solution.means().irradiance);
    Ok(Answer { faces, bars: bars.faces, budget: bars.budget, patches: patches.len() })
}

/// The mean of some answers on a fine cut, and the error of each face by its bars.
fn fine(scene: &Scene) -> Result<Vec<(FaceRow, f64)>, Failure> {
    let answers: Vec<Answer> =
        (0..FINE_SEEDS).map(|seed| answer(scene, FINE, 1000 + seed)).collect::<Result<_, _>>()?;
    let first = &answers[0];
    let mean = |row: &FaceRow, bar: &FaceRow| {
        let all = answers.iter().filter_map(|answer| value(&answer.faces, row));
        let (sum, count) = all.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
        (FaceRow { mean: vec![sum / count], ..row.clone() }, bar.mean[0])
    };
    Ok(first.faces.iter().zip(&first.bars).map(|(row, bar)| mean(row, bar)).collect())
}

/// What a table has for the face and side of a row.
fn value(rows: &[FaceRow], of: &FaceRow) -> Option<f64> {
    rows.iter().find(|row| (row.face, row.side) == (of.face, of.side)).map(|row| row.mean[0])
}

/// Ratios of what errors are to what is told of them, one a scene and cut or a face.
#[derive(Default)]
struct Tally {
    mesh: Vec<f64>,
    /// The same of scenes with lights without area alone: with a sky, and without.
    noise_of_lights: [Vec<f64>; 2],
    /// Per answer, its error over all faces as a part of the bound on it.
    of_bound: Vec<f64>,
    /// Per face: the error squared, what bars hold beside their common part, and that part by its constant,
    /// squared.
    faces: Vec<[f64; 3]>,
}

/// Judges answers on one cut.
fn judge(
    scene: &Scene,
    cut: (usize, u32),
    fine: &[(FaceRow, f64)],
    tally: &mut Tally,
) -> Result<String, Failure> {
    let answers: Vec<Answer> = (0..SEEDS).map(|seed| answer(scene, cut, seed)).collect::<Result<_, _>>()?;
    let [mut spread, mut shifted, mut light] = [0.0; 3];
    let (mut within, mut all, mut errors, mut bounds) = (0.0, 0.0, 0.0, 0.0);
    let mut off = vec![0.0; answers.len()];
    for (row, known) in fine {
        let found: Option<Vec<[f64; 2]>> = answers
            .iter()
            .map(|answer| Some([value(&answer.faces, row)?, value(&answer.bars, row)?]))
            .collect();
        let Some(found) = found else { continue };
        let seeds = found.len() as f64;
        let mean = found.iter().map(|[x, _]| x).sum::<f64>() / seeds;
        let variance = found.iter().map(|[x, _]| (x - mean).powi(2)).sum::<f64>() / (seeds - 1.0);
        let truth = row.mean[0];
        light += row.area * truth * truth;
        spread += row.area * variance;
        shifted += row.area * ((mean - truth).powi(2) - variance / seeds - known * known);
        for (answer, ([x, bar], off)) in answers.iter().zip(found.into_iter().zip(&mut off)) {
            *off += row.area * (x - truth).powi(2);
            let (error, bar) = ((x - truth).powi(2), (bar * bar + known * known).sqrt());
            within += f64::from(u8::from(error <= (BOUND * bar).powi(2)));
            all += 1.0;
            errors += row.area * error;
            bounds += row.area * (BOUND * bar).powi(2);
            let common = (answer.budget.part(ErrorPart::MESH) * x).powi(2);
            tally.faces.push([error, bar * bar - FITTED.common.powi(2) * common, common]);
        }
    }
    let told = |of: &dyn Fn(&ErrorBudget) -> f64| {
        (answers.iter().map(|answer| of(&answer.budget).powi(2)).sum::<f64>() / answers.len() as f64).sqrt()
    };
    let noise_of = |b: &ErrorBudget| b.part(ErrorPart::RAYS).hypot(b.part(ErrorPart::LAMPS));
    let [noise, mesh] = [(spread / light).sqrt(), (shifted.max(0.0) / light).sqrt()];
    let [noise_told, mesh_told] = [told(&noise_of), told(&|b| b.part(ErrorPart::MESH))];
    let ratios = [noise / noise_told, mesh / mesh_told];
    // Where noise hides the mesh error nothing is learned of it.
    if mesh > noise / (answers.len() as f64).sqrt() {
        tally.mesh.push(ratios[1]);
    }
    if scene.materials().iter().all(|material| !material.emits()) && scene.sky().is_none() {
        tally.noise_of_lights[1].push(ratios[0]);
    }
    if scene.sky().is_some() && scene.lights().next().is_none() {
        tally.noise_of_lights[0].push(ratios[0]);
    }
    let off = answers.iter().zip(&off);
    tally.of_bound.extend(off.map(|(answer, off)| (off / light).sqrt() / answer.budget.upper95));
    let percent = |x: f64, y: f64| format!("{:.3} ({:.3}) %", 100.0 * x, 100.0 * y);
    Ok(format!(
        "{:7} {:>16} {:6.2} {:>16} {:6.2} {:5.1} % {:6.2}",
        answers[0].patches,
        percent(noise, noise_told),
        ratios[0],
        percent(mesh, mesh_told),
        ratios[1],
        100.0 * within / all,
        (bounds / errors).sqrt()
    ))
}

impl Tally {
    /// Prints what follows; the share of faces within their bars.
    fn print(&mut self) -> f64 {
        let middle = |values: &[f64]| {
            let logs: f64 = values.iter().map(|x| x.max(1e-3).ln()).sum();
            (logs / values.len().max(1) as f64).exp()
        };
        let line = |name: &str, fits: f64, now: f64| println!("{name:14} {fits:6.2}, in use {now:.2}");
        println!();
        // Skies and other lights share this constant; parts of skies are made smaller beforehand.
        for (name, ratios) in ["EVENNESS: sky", "and lights"].into_iter().zip(&self.noise_of_lights) {
            if !ratios.is_empty() {
                line(name, FITTED.evenness / middle(ratios), FITTED.evenness);
            }
        }
        println!("{:14} {:6.2} of what is told, in the middle", "mesh error", middle(&self.mesh));
        line("MESH_AT_MOST", quantile(&mut self.mesh), FITTED.mesh_at_most);
        // The least common part with which nineteen of twenty faces lie within their bars.
        let covered = |common: f64| {
            let is_within =
                |&&[error, rest, part]: &&[f64; 3]| error <= BOUND * BOUND * (rest + common * common * part);
            self.faces.iter().filter(is_within).count() as f64 / self.faces.len().max(1) as f64
        };
        let common = (0..=40).map(|k| 0.05 * f64::from(k)).find(|&common| covered(common) >= 0.95);
        line("COMMON", common.unwrap_or(f64::INFINITY), FITTED.common);
        let in_use = covered(FITTED.common);
        println!("with what is in use {:.1} % of faces lie within their bars", 100.0 * in_use);
        let exceeded = self.of_bound.iter().filter(|&&part| part > 1.0).count();
        let squares: f64 = self.of_bound.iter().map(|part| part * part).sum();
        println!(
            "bounds on all faces are exceeded {exceeded} times in {}, and {:.2} times the error",
            self.of_bound.len(),
            (self.of_bound.len() as f64 / squares).sqrt()
        );
        in_use
    }
}

/// What nineteen of twenty values do not exceed.
fn quantile(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((0.95 * values.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}
