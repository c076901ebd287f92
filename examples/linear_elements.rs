//! Constant and linear elements on the same patches and rays, against an independent renderer (Mitsuba
//! 3.9.1): a folded white corridor, where light turns corners, and two rooms joined by a door.
//!
//! `cargo run --release --example linear_elements`

use std::time::Instant;

use radiosity::measure::RelativeRms;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::reference::ReferenceRow;
use radiosity::scene::Scene;
use radiosity::solve::{CgOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, TraceOptions};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "scene     patches  basis     seconds  megabytes  relative RMS error by face  (noise of the reference)"
    );
    let corridor = [1.0, 0.5, 0.25].map(|edge| ("corridor", PatchSize::Edge(edge), 0.5));
    for (name, size, part) in corridor.into_iter().chain([("gallery", PatchSize::Count(8000), 1.0)]) {
        let [constant, linear] = [Basis::Constant, Basis::Linear].map(|basis| error(name, size, 512, basis));
        let (constant, linear) = (constant?, linear?);
        assert!(linear < part * constant, "{name}: linear elements should err less than constant ones");
    }
    println!("\nthe quickest settings found that err by 1 %");
    for (name, size, rays, basis) in [
        ("corridor", PatchSize::Edge(0.4), 64, Basis::Constant),
        ("corridor", PatchSize::Edge(1.0), 512, Basis::Linear),
        ("gallery", PatchSize::Count(8000), 128, Basis::Constant),
        ("gallery", PatchSize::Count(2500), 384, Basis::Linear),
    ] {
        let error = error(name, size, rays, basis)?;
        assert!(error < 0.0125, "{name}: {error}");
    }
    Ok(())
}

/// Solves a scene and compares irradiance by face.
fn error(name: &str, size: PatchSize, rays: u32, basis: Basis) -> Result<f64, Box<dyn std::error::Error>> {
    let reference = ReferenceRow::read(format!("{FOLDER}/{name}.csv"))?;
    let start = Instant::now();
    let scene = Scene::load(format!("{FOLDER}/{name}.obj"))?;
    let tracer = Tracer::new(&scene);
    let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() })?;
    let options = TraceOptions { basis, rays: Some(rays), ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options)?;
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default())?;
    let solution = problem.conjugate_gradients(&CgOptions::default())?.means();
    let seconds = start.elapsed().as_secs_f64();
    let rms = RelativeRms::of(&patches.average_by_face(&solution.irradiance), &reference);
    let (n, megabytes) = (patches.len(), factors.exchange().bytes() as f64 / 1e6);
    let (error, noise) = (100.0 * rms.value, 100.0 * rms.noise);
    println!(
        "{name:8}  {n:7}  {:8}  {seconds:7.3}  {megabytes:9.1}  {error:24.2} %  {noise:.2} %",
        basis.name()
    );
    Ok(rms.value)
}
