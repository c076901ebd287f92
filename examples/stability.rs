//! How stable the solvers are: error, iterations and condition as reflectance nears 1, as faces become
//! slivers, and as their areas grow apart, against closed forms.
//!
//! Every case is a closed room in which all surfaces reflect ρ. Where all emit Lₑ too, radiance is Lₑ/(1 − ρ)
//! everywhere; where one wall emits, its mean is mean(Lₑ)/(1 − ρ). *Error* is the largest relative difference
//! from either. *Iterations* are those for light from one wall, which is not the same everywhere.
//!
//! `cargo run --release --example stability [FOLDER]` writes stability.svg and stability.md to the folder,
//! docs if none is given.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::output::{self, SmallPlot};
use radiosity::patches::{Basis, PatchSize, Patches, Reach, Tessellation};
use radiosity::scene::{Face, FaceState, Material, Scene, SceneError, SceneParts};
use radiosity::solve::{self, CgOptions, NeumannOptions, SolveError, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

/// The residual that iterative solvers go down to.
const TOLERANCE: f64 = 1e-8;

/// The highest order of the series.
const CAP: usize = 1000;

/// One solver with one basis.
#[derive(Clone, Copy, PartialEq)]
struct Way {
    basis: Basis,
    method: solve::Method,
}

/// What one of them did.
struct Found {
    error: f64,
    iterations: usize,
    condition: f64,
    converged: bool,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut table = String::new();
    let mut plots = Vec::new();

    let gaps: Vec<f64> = (0..=6).map(|k| 10f64.powi(-k)).collect();
    let cube = room(&[0.0, 1.0], None)?;
    let by_gap: Vec<_> = gaps.iter().map(|&gap| measure(&cube, 400, 1.0 - gap)).collect::<Result<_, _>>()?;
    let axis = "1 − ρ";
    plots.push(plot("Reflectance: error", [axis, "largest relative error"], &gaps, &by_gap, |f| f.error));
    plots.push(plot("Reflectance: iterations", [axis, "passes over the matrix"], &gaps, &by_gap, |f| {
        f.iterations as f64
    }));
    let axes = [axis, "bound on the condition number"];
    let mut condition = plot("Reflectance: condition", axes, &gaps, &by_gap, |f| f.condition);
    // All solvers report the same.
    condition.curves.retain(|(name, _)| name.starts_with("direct"));
    condition.curves.iter_mut().zip(["constant", "linear"]).for_each(|(curve, name)| curve.0 = name.into());
    plots.push(condition);
    rows(&mut table, "a cube, 1 − ρ", &gaps, &by_gap)?;

    let aspects: Vec<f64> = (0..=5).map(|k| 10f64.powi(k)).collect();
    let strips = aspects.iter().map(|&aspect| measure(&room(&cuts(aspect), None)?, 400, 0.9));
    let by_aspect: Vec<_> = strips.collect::<Result<_, _>>()?;
    let axis = "aspect of the thinnest faces";
    plots.push(plot("Slivers: error", [axis, "largest relative error"], &aspects, &by_aspect, |f| f.error));
    rows(&mut table, "a room with strips of aspect", &aspects, &by_aspect)?;

    let ratios: Vec<f64> = (0..=5).map(|k| 100f64.powi(k)).collect();
    let specks = ratios.iter().map(|&ratio| measure(&room(&[0.0, 1.0], Some(ratio))?, 400, 0.9));
    let by_ratio: Vec<_> = specks.collect::<Result<_, _>>()?;
    let axis = "wall's area / speck's area";
    plots.push(plot("Areas: error", [axis, "largest relative error"], &ratios, &by_ratio, |f| f.error));
    plots.push(plot("Areas: iterations", [axis, "passes over the matrix"], &ratios, &by_ratio, |f| {
        f.iterations as f64
    }));
    rows(&mut table, "a room with a speck, area ratio", &ratios, &by_ratio)?;

    let docs = || Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let folder = std::env::args().nth(1).map_or_else(docs, PathBuf::from);
    output::replace(folder.join("stability.svg"), |file| output::write_small_plots(file, &plots))?;
    let text = format!("{INTRODUCTION}{table}");
    output::replace(folder.join("stability.md"), |file| file.write_all(text.as_bytes()))?;
    println!("{table}");

    // Direct and conjugate gradients hold wherever they are; the series as long as its cap allows.
    let all = by_gap.iter().chain(&by_aspect).chain(&by_ratio).flatten();
    let worst = all.filter(|(way, _)| way.method != solve::Method::Neumann).map(|(_, f)| f.error);
    let worst = worst.fold(0.0, f64::max);
    println!("largest error of the direct solver and conjugate gradients: {worst:.0e}");
    assert!(worst < 1e-6, "a solver is not stable");
    Ok(())
}

const INTRODUCTION: &str = "# Stability of the solvers

Closed rooms in which every surface reflects ρ: where all emit Lₑ too, radiance is Lₑ/(1 − ρ) everywhere, and where one wall emits its
mean is mean(Lₑ)/(1 − ρ), whatever the random rays. *Error* is the largest relative difference from either, over all unknowns.
*Iterations* are passes over the matrix for light from one wall, to a residual of 10⁻⁸ (relative to E); a star says that it was not reached, within order 1000 of the series or at all.
*Condition* is the bound that is reported with each answer: guaranteed for constant elements, estimated for linear ones.
Slivers and specks have ρ = 0.9. Made by `cargo run --release --example stability`.

![Error, iterations and condition](stability.svg)

| case | value | elements | solver | error | iterations | condition |
|---|---|---|---|---|---|---|
";

/// Solves one room every way.
fn measure(scene: &Scene, count: usize, rho: f64) -> Result<Vec<(Way, Found)>, radiosity::Error> {
    let tracer = Tracer::new(scene);
    let mut all = Vec::new();
    for basis in [Basis::Constant, Basis::Linear] {
        let size = PatchSize::Count(count);
        let cut = Tessellation { size, reach: Reach::Light, ..Default::default() };
        let mut patches = Patches::new(&tracer, &cut)?;
        let options = TraceOptions { rays: Some(64), basis, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options)?;
        let n = patches.len();
        let k = Transport::new(&factors, DMatrix::repeat(n, 1, rho))?;
        let everywhere = DMatrix::repeat(k.len(), 1, 1.0);
        let lit = |i: usize| if patches.place(i).face < 2 { 1.0 } else { 0.0 };
        let one_wall = basis.coefficients_of(&DMatrix::from_fn(n, 1, |i, _| lit(i)));
        for method in [solve::Method::Direct, solve::Method::ConjugateGradients, solve::Method::Neumann] {
            let even = solved(&k, &everywhere, method)?;
            let uneven = solved(&k, &one_wall, method)?;
            let mean = |x: &DMatrix<f64>| k.mass().areas().dot(&x.column(0));
            let of_mean = (mean(&uneven.radiance) * (1.0 - rho) / mean(&one_wall) - 1.0).abs();
            let found = Found {
                error: even.radiance.map(|l| (l * (1.0 - rho) - 1.0).abs()).max().max(of_mean),
                iterations: uneven.report.iterations,
                condition: uneven.report.condition,
                converged: uneven.report.residual <= TOLERANCE && even.report.residual <= TOLERANCE,
            };
            all.push((Way { basis, method }, found));
        }
    }
    Ok(all)
}

/// The solution, or the best there is of it.
fn solved(k: &Transport, e: &DMatrix<f64>, method: solve::Method) -> Result<solve::Solution, SolveError> {
    let answer = match method {
        solve::Method::ConjugateGradients => {
            solve::conjugate_gradients(k, e, &CgOptions { tolerance: TOLERANCE, ..Default::default() })
        }
        solve::Method::Neumann => {
            let options = NeumannOptions { order: CAP, tolerance: TOLERANCE, ..Default::default() };
            solve::neumann(k, e, &options).map(|series| series.solution)
        }
        _ => solve::solve(k, e, &SolveOptions { method, ..Default::default() }),
    };
    match answer {
        Err(SolveError::NotConverged { best, .. }) => Ok(*best),
        other => other,
    }
}

fn name(way: Way) -> String {
    let solver = match way.method {
        solve::Method::Direct => "direct",
        solve::Method::ConjugateGradients => "cg",
        _ => "series",
    };
    if way.basis == Basis::Linear { format!("{solver}, linear") } else { solver.to_owned() }
}

/// A plot of one quantity against what was varied, a curve per way; all but the series with linear elements,
/// which is like the other.
fn plot(
    title: &str,
    axes: [&str; 2],
    values: &[f64],
    found: &[Vec<(Way, Found)>],
    quantity: fn(&Found) -> f64,
) -> SmallPlot {
    let ways: Vec<Way> = found[0].iter().map(|(way, _)| *way).collect();
    let shown = ways
        .iter()
        .enumerate()
        .filter(|(_, way)| way.basis == Basis::Constant || way.method != solve::Method::Neumann);
    let curves = shown.map(|(k, way)| {
        let points = values.iter().zip(found).map(|(&x, all)| [x, quantity(&all[k].1)]).collect();
        (name(*way), points)
    });
    let curves = curves.collect();
    SmallPlot { title: title.to_owned(), axes: axes.map(str::to_owned), curves }
}

fn rows(
    table: &mut String,
    case: &str,
    values: &[f64],
    found: &[Vec<(Way, Found)>],
) -> Result<(), std::fmt::Error> {
    for (value, all) in values.iter().zip(found) {
        for (way, Found { error, iterations, condition, converged }) in all {
            let elements = way.basis.name();
            let solver = name(Way { basis: Basis::Constant, ..*way });
            let star = if *converged { "" } else { "*" };
            writeln!(
                table,
                "| {case} | {value} | {elements} | {solver} | {} | {iterations}{star} | {condition:.1e} |",
                if *error == 0.0 { "0".into() } else { format!("{error:.0e}") }
            )?;
        }
    }
    Ok(())
}

/// Where floor and ceiling are cut so that the thinnest strip has this aspect.
fn cuts(aspect: f64) -> Vec<f64> {
    let mut cuts = vec![0.0];
    cuts.extend((0..=aspect.log10().round() as i32).rev().map(|k| 10f64.powi(-k)));
    cuts
}

/// The unit cube seen from inside, of one material that emits and reflects; floor and ceiling in strips
/// between the cuts, and perhaps with a square speck in it, so many times smaller than a wall.
fn room(cuts: &[f64], speck: Option<f64>) -> Result<Scene, SceneError> {
    type Quad = [[f64; 3]; 4];
    let walls: [Quad; 4] = [
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]],
        [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]],
    ];
    let strips = cuts.windows(2).flat_map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        [
            [[a, 0.0, 0.0], [a, 0.0, 1.0], [b, 0.0, 1.0], [b, 0.0, 0.0]],
            [[a, 1.0, 0.0], [b, 1.0, 0.0], [b, 1.0, 1.0], [a, 1.0, 1.0]],
        ]
    });
    let speck = speck.map(|ratio| {
        let (low, high) = (0.5, 0.5 + 0.5 / ratio.sqrt());
        [[low, 0.3, low], [high, 0.3, low], [high, 0.3, high], [low, 0.3, high]]
    });
    let quads: Vec<Quad> = walls.into_iter().chain(strips).chain(speck).collect();
    let mut parts = SceneParts {
        name: "room".into(),
        materials: vec![Material::lamp("all", &[0.5], &[1.0])],
        objects: vec!["room".into()],
        ..Default::default()
    };
    for quad in quads {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(quad.map(DVec3::from));
        for k in [1, 2] {
            parts.faces.push(Face {
                vertices: [first, first + k, first + k + 1],
                normals: None,
                material: 0,
                object: 0,
                state: FaceState::Kept,
            });
        }
    }
    Scene::new(parts)
}
