//! The verdict on an answer: good on sound scenes, and raised, by its cause, by each fault that is put in on
//! purpose.

mod answers; // damaged answers: numbers, energy, the equation, truncation
mod form_factors; // rows that do not close, escape, directions
mod lamps; // light that is missing
mod overlaps; // faces in one plane
mod sound; // no reasons on sound scenes
mod wording; // a reason in one line

use nalgebra::{DMatrix, DVector};
use radiosity::measure::{Answer, Cause, Energy, ErrorBudget, Level, Reason, Verdict};
use radiosity::patches::{Basis, Patches};
use radiosity::scene::{Material, Scene};
use radiosity::solve::{Method, Problem, Solution, SolveOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{Exchange, FormFactors, Keep, LightOptions, Sources, Storage, TraceOptions};

use crate::scenes::{cut_into, quads, room};

/// An answer and all that it was made from; tests damage one of them at a time.
struct Case<'s> {
    tracer: Tracer<'s>,
    patches: Patches<'s>,
    factors: FormFactors,
    sources: Sources,
    tolerance: f64,
    order: usize,
    budget: Option<ErrorBudget>,
}

impl<'s> Case<'s> {
    fn new(scene: &'s Scene, patches: usize, rays: u32, basis: Basis) -> Self {
        let tracer = Tracer::new(scene);
        let mut patches = cut_into(&tracer, patches);
        let options = TraceOptions { rays: Some(rays), basis, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let light = LightOptions { rays, ..Default::default() };
        let sources = Sources::trace(&tracer, &patches, basis, &light).unwrap();
        Self { tracer, patches, factors, sources, tolerance: 1e-6, order: 1000, budget: None }
    }

    fn problem(&self) -> Problem {
        Problem::unlit(&self.patches, &self.factors).unwrap().under(self.sources.clone())
    }

    fn solve(&self, method: Method) -> Solution {
        let options =
            SolveOptions { method, order: self.order, tolerance: self.tolerance, ..Default::default() };
        self.problem().solve(&options).unwrap()
    }

    fn energy(&self, solution: &Solution) -> Energy {
        Energy::of(&self.problem(), &solution.radiance)
    }

    fn judge(&self, solution: &Solution) -> Verdict {
        self.judge_with(solution, &self.energy(solution))
    }

    fn judge_with(&self, solution: &Solution, energy: &Energy) -> Verdict {
        Verdict::of(&Answer {
            tracer: &self.tracer,
            patches: &self.patches,
            problem: &self.problem(),
            solution,
            energy,
            budget: self.budget.as_ref(),
            tolerance: self.tolerance,
        })
    }

    /// Exchange areas and escape in full, to be damaged.
    fn exchange(&self) -> (DMatrix<f32>, DVector<f64>) {
        let exchange = self.factors.exchange();
        let n = exchange.len();
        let areas = DMatrix::from_fn(n, n, |i, j| exchange.exchange_area(i, j) as f32);
        (areas, DVector::from_fn(n, |i, _| exchange.escape(i)))
    }

    fn put_back(&mut self, (areas, escape): (DMatrix<f32>, DVector<f64>)) {
        let mass = self.factors.exchange().mass().clone();
        self.factors = Exchange::unbalanced(Storage::Dense(areas), escape, mass).into();
    }

    /// A patch of the front of this face.
    fn patch_of(&self, face: usize) -> usize {
        (0..self.patches.len()).find(|&i| self.patches.place(i).face == face).unwrap()
    }
}

/// The one reason of a verdict, which must be of this cause and level and say where and what to do.
#[track_caller]
fn only(verdict: &Verdict, cause: Cause, level: Level) -> Reason {
    assert_eq!(verdict.level, level, "{verdict:#?}");
    let [reason] = &verdict.reasons[..] else { panic!("one reason: {verdict:#?}") };
    assert_eq!((reason.cause, reason.level), (cause, level), "{verdict:#?}");
    assert!(!reason.remedy.is_empty() && reason.to_string().starts_with(cause.name()), "{reason}");
    reason.clone()
}

/// A closed room of 12 faces with a small lamp, faces 12 and 13, below its ceiling.
fn lit_room() -> Scene {
    let walls = room([0.0; 3], [2.0, 3.0, 2.5]).map(|wall| (wall, 0));
    quads(&[&walls[..], &[(LAMP, 1)]].concat(), materials())
}

/// A lamp that shines downwards.
const LAMP: [[f64; 3]; 4] = [[0.8, 1.2, 2.4], [0.8, 1.6, 2.4], [1.2, 1.6, 2.4], [1.2, 1.2, 2.4]];

fn materials() -> Vec<Material> {
    vec![Material::diffuse("wall", &[0.6]), Material::lamp("lamp", &[0.0], &[10.0])]
}
