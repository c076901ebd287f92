//! The main job in thirty lines: solve a scene both ways and make a picture.
//!
//! `cargo run --release --example quickstart [SCENE.obj [PICTURE.png]]`

use radiosity::measure::Energy;
use radiosity::patches::{Patches, Tessellation};
use radiosity::render::{self, RenderOptions};
use radiosity::scene::Scene;
use radiosity::solve::{NeumannOptions, Problem};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, LightOptions, TraceOptions};

fn main() -> Result<(), radiosity::Error> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().map_or_else(|| Ok(Scene::cornell_box()), Scene::load)?;

    let tracer = Tracer::new(&scene);
    let mut patches = Patches::new(&tracer, &Tessellation::default())?;
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default())?;
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default())?;
    println!("{}: {} patches, {} rays each", scene.name(), patches.len(), factors.rays());

    let exact = problem.direct(&Default::default())?;
    for order in [0, 1, 2, 4, 8, 16] {
        let options = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
        let series = problem.neumann(&options)?.solution;
        let error = (&series.radiance - &exact.radiance).amax() / exact.radiance.amax();
        println!("order {order:>2}: error {error:.1e}, guaranteed below {:.1e}", series.report.bound);
    }
    let energy = Energy::of(&problem, &exact.radiance);
    println!("emitted {:.3?} W, energy imbalance {:.0e}", energy.emitted, energy.imbalance);

    if let Some(path) = arguments.next() {
        let camera = scene.camera().copied().unwrap_or_else(|| render::default_camera(&tracer, &patches));
        let look = RenderOptions { carried: problem.carried(), ..Default::default() };
        let picture = render::picture(&tracer, &patches, &exact.radiance, &camera, &look)?;
        picture.save_png(path, picture.exposure())?;
    }
    Ok(())
}
