//! The furnace test: in a closed room where every surface emits Lₑ and reflects ρ, radiance is Lₑ/(1 − ρ)
//! everywhere, and Lₑ(1 − ρᵏ⁺¹)/(1 − ρ) after k bounces. Whatever the random rays, this program must print
//! errors that are all rounding.
//!
//! `cargo run --release --example furnace`

use nalgebra::DMatrix;
use radiosity::patches::{PatchSize, Patches, Tessellation};
use radiosity::scene::Scene;
use radiosity::solve::{self, CgOptions, NeumannOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

fn main() -> Result<(), radiosity::Error> {
    let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/meshes/furnace_cube.obj"))?;
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Count(1000);
    let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() })?;
    let options = TraceOptions { rays: Some(64), ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options)?;
    let e = patches.emitted_radiance();
    let n = patches.len();
    println!("{n} patches, 64 rays each: rows close to {:.0e}\n", factors.exchange().closure_error());

    let error = |radiance: &DMatrix<f64>, exact: f64| radiance.map(|l| l / exact - 1.0).amax();
    let mut worst = 0.0f64;
    println!("     ρ   direct  conjugate gradients  orders 0 to 10");
    for rho in [0.0, 0.5, 0.9, 0.99, 0.999] {
        let k = Transport::new(&factors, DMatrix::repeat(n, 1, rho))?;
        let exact = e[0] / (1.0 - rho);
        let direct = error(&solve::direct(&k, &Default::default())?.solve(&e).radiance, exact);
        let cg = CgOptions { tolerance: 1e-12, ..Default::default() };
        let cg = error(&solve::conjugate_gradients(&k, &e, &cg)?.radiance, exact);
        let mut orders = 0.0f64;
        for order in 0..=10 {
            let series = NeumannOptions { order, tolerance: 0.0, ..Default::default() };
            let sum = (0..=order as i32).map(|j| rho.powi(j)).sum::<f64>() * e[0];
            orders = orders.max(error(&solve::neumann(&k, &e, &series)?.solution.radiance, sum));
        }
        println!("{rho:6}  {direct:7.0e}  {cg:19.0e}  {orders:14.0e}");
        worst = worst.max(direct).max(cg).max(orders);
    }
    println!("\nlargest error against the closed form: {worst:.0e}");
    assert!(worst < 1e-8, "the furnace is not exact");
    Ok(())
}
