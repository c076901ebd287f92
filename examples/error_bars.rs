//! Are error bars true? Answers at many settings, what they say of their own error, and what it is against an
//! independent renderer (Mitsuba 3.9.1).
//!
//! ```text
//! cargo run --release --example error_bars               # a few settings
//! cargo run --release --example error_bars -- --all      # all of them, both bases, three seeds
//! ```

use std::time::Instant;

use radiosity::measure::{self, ErrorBars, Goal, RelativeRms, Tolerated};
use radiosity::patches::{Basis, FaceRow, PatchSize, Patches, Tessellation};
use radiosity::progress::Progress;
use radiosity::reference::ReferenceRow;
use radiosity::scene::Scene;
use radiosity::solve::{CgOptions, Problem, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, TraceOptions};

type Failure = Box<dyn std::error::Error>;

/// Scenes with a reference: where they are, and how many patches are a coarse, a usual and a fine cut.
const SCENES: [(&str, &str, [usize; 3]); 7] = [
    ("cornell", "tests/data/cornell.obj", [1000, 4000, 8000]),
    ("cornell_fine", "tests/data/cornell_fine.obj", [4000, 8000, 16000]),
    ("gallery", "tests/data/gallery.obj", [2500, 4000, 8000]),
    ("mirror_room", "tests/data/mirror_room.obj", [2000, 4000, 8000]),
    ("corridor", "tests/data/corridor.obj", [300, 1200, 4000]),
    ("glass_balls", "meshes/glass_balls.obj", [1000, 4000, 8000]),
    ("furnished_room", "meshes/furnished_room.obj", [2000, 4000, 8000]),
];

fn main() -> Result<(), Failure> {
    let all = std::env::args().any(|argument| argument == "--all");
    let bases: &[Basis] = if all { &[Basis::Constant, Basis::Linear] } else { &[Basis::Constant] };
    let (cuts, rays, seeds) = if all { (3, &[64, 256][..], 3) } else { (2, &[64][..], 1) };
    let mut score = Score::default();
    println!("scene         basis     patches  rays   error  estimate  95 % bound   within 1 σ  time for it");
    for (name, path, counts) in SCENES {
        let setting = Setting::read(name, path)?;
        let tracer = Tracer::new(&setting.scene);
        for &basis in bases {
            for &count in &counts[..cuts] {
                for &rays in rays {
                    (0..seeds).try_for_each(|seed| {
                        setting.run(&tracer, basis, Cut { count, rays, seed }, &mut score)
                    })?;
                }
            }
        }
    }
    let Score { runs, held, tight, covering, covered } = score;
    let mean = 100.0 * covered / runs as f64;
    println!(
        "{runs} runs: the bound holds in {held}, is within 3 × the error in {tight}; {mean:.0} % of bars cover, 60 to 85 % in {covering}\n"
    );
    assert!(10 * held >= 9 * runs, "bounds should hold in nine of ten runs");

    println!("accuracy      scene           patches  rays  seconds   error");
    for (name, path, _) in SCENES {
        let setting = Setting::read(name, path)?;
        for share in if all { &[0.02, 0.01, 0.005][..] } else { &[0.02][..] } {
            (0..seeds).try_for_each(|seed| setting.reach(*share, seed))?;
        }
    }
    Ok(())
}

#[derive(Default)]
struct Score {
    runs: usize,
    held: usize,
    tight: usize,
    covering: usize,
    covered: f64,
}

struct Setting {
    name: &'static str,
    scene: Scene,
    reference: Vec<ReferenceRow>,
}

/// How finely a scene is cut and traced.
struct Cut {
    count: usize,
    rays: u32,
    seed: u64,
}

impl Setting {
    fn read(name: &'static str, path: &str) -> Result<Self, Failure> {
        let folder = env!("CARGO_MANIFEST_DIR");
        let reference = ReferenceRow::read(format!("{folder}/tests/data/{name}.csv"))?;
        Ok(Self { name, scene: Scene::load(format!("{folder}/{path}"))?, reference })
    }

    /// One answer with its error bars, beside the reference.
    fn run(
        &self,
        tracer: &Tracer,
        basis: Basis,
        Cut { count, rays, seed }: Cut,
        score: &mut Score,
    ) -> Result<(), Failure> {
        let began = Instant::now();
        let size = PatchSize::Count(count);
        let mut patches = Patches::new(tracer, &Tessellation { size, seed, ..Default::default() })?;
        let options = TraceOptions { rays: Some(rays), seed, basis, keep: Keep::Rays, ..Default::default() };
        let factors = FormFactors::trace(tracer, &mut patches, &options)?;
        let (problem, solution) = solved(tracer, &patches, &factors, seed)?;
        let answered = began.elapsed().as_secs_f64();
        let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default())?;
        let more = began.elapsed().as_secs_f64() / answered - 1.0;
        let faces = patches.average_by_face(&solution.means().irradiance);
        let error = RelativeRms::of(&faces, &self.reference).value;
        let covered = self.covered(&faces, &bars);
        let (estimate, bound) = (bars.budget.relative_rms, bars.budget.upper95);
        score.runs += 1;
        score.held += usize::from(bound >= error);
        score.tight += usize::from(bound <= 3.0 * error);
        score.covering += usize::from((0.6..=0.85).contains(&covered));
        score.covered += covered;
        println!(
            "{:12}  {:8}  {:7}  {rays:4}  {:4.2} %    {:4.2} %      {:4.2} %         {:3.0} %        {:3.0} %",
            self.name,
            basis.name(),
            patches.len(),
            100.0 * error,
            100.0 * estimate,
            100.0 * bound,
            100.0 * covered,
            100.0 * more
        );
        Ok(())
    }

    /// The share of faces and channels that lie within one standard error, the reference's own included.
    fn covered(&self, faces: &[FaceRow], bars: &ErrorBars) -> f64 {
        let (mut covered, mut all) = (0, 0);
        for row in &self.reference {
            let Some(f) = faces.iter().position(|f| (f.face, f.side) == (row.face, row.side)) else {
                continue;
            };
            for c in 0..faces[f].mean.len() {
                if row.standard_error[c] < 0.2 * row.mean[c] {
                    let off = (faces[f].mean[c] - row.mean[c]).abs();
                    covered += usize::from(off < bars.faces[f].mean[c].hypot(row.standard_error[c]));
                    all += 1;
                }
            }
        }
        f64::from(covered as u32) / f64::from(all)
    }

    /// Asks for an accuracy, and sees what comes of it.
    fn reach(&self, share: f64, seed: u64) -> Result<(), Failure> {
        let began = Instant::now();
        let tracer = Tracer::new(&self.scene);
        let goal = Goal { error: Some(Tolerated::Relative(share)), seconds: None };
        let (tessellation, trace) =
            (Tessellation { seed, ..Default::default() }, TraceOptions { seed, ..Default::default() });
        let found = measure::reach(&tracer, goal, &tessellation, &trace)?;
        let seconds = began.elapsed().as_secs_f64();
        let (_, solution) = solved(&tracer, &found.patches, &found.factors, seed)?;
        let faces = found.patches.average_by_face(&solution.irradiance);
        let error = RelativeRms::of(&faces, &self.reference).value;
        println!(
            "{:6.1} %      {:14}  {:7}  {:4}  {seconds:7.2}  {:4.2} %",
            100.0 * share,
            self.name,
            found.patches.len(),
            found.factors.rays(),
            100.0 * error
        );
        Ok(())
    }
}

fn solved(
    tracer: &Tracer,
    patches: &Patches,
    factors: &FormFactors,
    seed: u64,
) -> Result<(Problem, Solution), Failure> {
    let light = LightOptions { rays: factors.rays(), seed, ..Default::default() };
    let problem = Problem::new(tracer, patches, factors, &light)?;
    let solution = problem.conjugate_gradients(&CgOptions::default())?;
    Ok((problem, solution))
}
