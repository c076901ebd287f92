//! What a grey scene saves: the solve stage of two rooms joined by a door in one channel, in three that
//! agree, in three of which two agree, and in three different ones. Fails if the grey one takes more than
//! 0.45 of the last by the direct solver.

use std::time::Instant;

use radiosity::{patches::*, scene::Scene, solve, trace::Tracer, transport::*};

/// Times every case so often, in turn, and keeps its best: other work on the machine only adds.
const ROUNDS: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::load("meshes/two_rooms.obj")?;
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Count(3600);
    let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() })?;
    let rays = Some(64);
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions { rays, ..Default::default() })?;

    // Shares of the scene's own reflectance, by channel.
    let cases = [&[1.0][..], &[1.0; 3], &[1.0, 1.0, 0.8], &[1.0, 0.9, 0.8]];
    let (grey, lamp) = (patches.reflectances(), patches.emitted_radiance());
    let mut best = [[f64::INFINITY; 3]; 4];
    for _ in 0..ROUNDS {
        for (shares, best) in cases.iter().zip(&mut best) {
            let channels = shares.len();
            let e = lamp.column(0).into_owned() * nalgebra::RowDVector::repeat(channels, 1.0);
            let rho = grey.column(0).into_owned() * nalgebra::RowDVector::from_row_slice(shares);
            let k = Transport::new(&factors, rho)?;
            let mut time = |solver: usize, began: Instant| {
                best[solver] = best[solver].min(began.elapsed().as_secs_f64());
            };
            let began = Instant::now();
            solve::direct(&k, &Default::default())?.solve(&e);
            time(0, began);
            let began = Instant::now();
            solve::conjugate_gradients(&k, &e, &Default::default())?;
            time(1, began);
            let began = Instant::now();
            solve::neumann(&k, &e, &Default::default())?;
            time(2, began);
        }
    }

    println!("{} patches, seconds and share of three different channels\n", patches.len());
    println!("{:28} {:>14} {:>14} {:>14}", "reflectance by channel", "direct", "cg", "neumann");
    for (shares, seconds) in cases.iter().zip(&best) {
        let cell = |solver: usize| format!("{:.3} {:.2}", seconds[solver], seconds[solver] / best[3][solver]);
        println!("{:28} {:>14} {:>14} {:>14}", format!("{shares:?}"), cell(0), cell(1), cell(2));
    }
    let share = best[0][0] / best[3][0];
    if share > 0.45 {
        return Err(format!("a grey scene takes {share:.2} of a coloured one").into());
    }
    Ok(())
}
