//! Irradiance of every face against an independent renderer: four scenes at default settings, as per-face
//! irradiance with standard errors that a path tracer (Mitsuba 3.9.1) found.
//!
//! `cargo run --release --example reference`

use std::time::Instant;

use radiosity::measure::RelativeRms;
use radiosity::patches::{Patches, Tessellation};
use radiosity::reference::ReferenceRow;
use radiosity::scene::Scene;
use radiosity::solve::{NeumannOptions, Problem, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, TraceOptions};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("scene         faces  patches  seconds  relative RMS error  (noise of the reference)");
    let mut worst = 0.0f64;
    for name in ["cornell", "cornell_fine", "gallery", "mirror_room"] {
        let mut reference = ReferenceRow::read(format!("{FOLDER}/{name}.csv"))?;
        let start = Instant::now();
        let scene = Scene::load(format!("{FOLDER}/{name}.obj"))?;
        let tracer = Tracer::new(&scene);
        let mut patches = Patches::new(&tracer, &Tessellation::default())?;
        let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default())?;
        let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default())?;
        let solution = problem.solve(&SolveOptions::default())?;
        problem.neumann(&NeumannOptions::default())?;
        let seconds = start.elapsed().as_secs_f64();
        // What lands on a mirror is no patch's.
        reference.retain(|row| scene.is_diffuse(row.face));
        let rms = RelativeRms::of(&patches.average_by_face(&solution.irradiance), &reference);
        let (faces, n) = (scene.faces().len(), patches.len());
        let (error, noise) = (100.0 * rms.value, 100.0 * rms.noise);
        println!("{name:12} {faces:6}  {n:7}  {seconds:7.2}  {error:16.2} %  {noise:.2} %");
        worst = worst.max(rms.value);
    }
    assert!(worst <= 0.01, "an ordinary room should come out within 1 % per face");
    Ok(())
}
