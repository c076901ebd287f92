//! What accuracy costs in time: errors that fall, noise that is called noise, studies that resume,
//! conclusions that repeat.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use radiosity::measure::{
    Conclusions, Grid, MeasureError, Reading, Study, StudyOptions, StudyRow, StudySolver, Want,
};
use radiosity::output::{read_study, write_study_reference, write_study_table};
use radiosity::progress::{Observer, Progress};
use radiosity::scene::Scene;
use radiosity::trace::Tracer;

use crate::scenes::mesh;

/// With time enough on the slowest machine, and a quick reference.
fn options<'a>(noise: f64, patches: &[usize], rays: &[u32]) -> StudyOptions<'a> {
    let grid = Grid { patches: patches.to_vec(), rays: rays.to_vec() };
    StudyOptions { time: Duration::from_secs(3600), noise, grid: Some(grid), ..Default::default() }
}

/// Goes on until nothing is left to do.
fn finish(study: &mut Study) {
    while study.advance().unwrap() {}
}

/// Everything but times.
fn timeless(rows: &[StudyRow]) -> Vec<StudyRow> {
    let still = |row: &StudyRow| StudyRow { seconds: 0.0, solve_seconds: 0.0, ..row.clone() };
    rows.iter().map(still).collect()
}

/// The tables of a study, as written.
fn tables(study: &Study) -> [Vec<u8>; 2] {
    let [mut table, mut reference] = [Vec::new(), Vec::new()];
    write_study_table(&mut table, study).unwrap();
    write_study_reference(&mut reference, study, study.reference().unwrap()).unwrap();
    [table, reference]
}

#[test]
fn errors_fall_with_patches_rays_and_orders_and_conclusions_repeat_with_another_seed() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let mut found = Vec::new();
    for seed in [0, 1] {
        let grid = options(0.006, &[64, 256, 1024], &[16, 64]);
        let mut study = Study::new(&tracer, StudyOptions { seed, ..grid }).unwrap();
        finish(&mut study);
        let rows = study.rows();
        let error = |solver, order, asked, rays| {
            let of = |row: &&StudyRow| {
                (row.solver, row.order, row.asked, row.rays) == (solver, order, asked, rays)
            };
            rows.iter().find(of).unwrap_or_else(|| panic!("{asked} × {rays}: {:?}", study.left_out())).error
        };
        let cg = |asked, rays| error(StudySolver::Cg, None, asked, rays);
        for rays in [16, 64] {
            assert!(cg(64, rays) > cg(256, rays) && cg(256, rays) > cg(1024, rays));
        }
        for asked in [64, 256, 1024] {
            assert!(cg(asked, 16) > 1.3 * cg(asked, 64));
            assert!((error(StudySolver::Direct, None, asked, 64) / cg(asked, 64) - 1.0).abs() < 1e-3);
            let series = [1, 2, 4].map(|order| error(StudySolver::Neumann, Some(order), asked, 64));
            assert!(series[0] > 1.5 * series[1] && series[1] > 1.5 * series[2], "{series:?}");
        }
        let paths: Vec<&StudyRow> = rows.iter().filter(|row| row.solver == StudySolver::Paths).collect();
        assert!(paths.windows(2).all(|pair| pair[1].error < 0.75 * pair[0].error), "{paths:?}");
        let conclusions = Conclusions::new(rows, study.reference().unwrap());
        // What is named for a target is good enough for it, and nothing is that is quicker by more than times
        // can be told apart.
        for target in &conclusions.targets {
            let good_enough = |row: &&StudyRow| row.reading().most() <= target.accuracy;
            let named = &rows[target.row];
            assert!(target.accuracy >= conclusions.resolution && good_enough(&named), "{target:?}");
            let others = rows.iter().filter(|row| row.solver != StudySolver::Paths).filter(good_enough);
            let quickest = others.map(|row| row.seconds).fold(f64::INFINITY, f64::min);
            assert!(named.seconds <= 1.05 * quickest, "{target:?}: {quickest} {}", named.seconds);
        }
        found.push(conclusions);
    }
    let [first, second] = [&found[0], &found[1]];
    let slopes = [first, second].map(|c| c.patches.as_ref().unwrap().slope.unwrap());
    let apart = (slopes[0].slope - slopes[1].slope).abs();
    assert!(slopes.iter().all(|s| s.slope < -0.3 && s.slope > -1.0), "{slopes:?}");
    assert!(apart < 4.0 * slopes[0].standard_error.hypot(slopes[1].standard_error) + 0.05, "{slopes:?}");
    let factors = [first, second].map(|c| c.order.as_ref().unwrap().factor.unwrap());
    assert!((factors[0] / factors[1] - 1.0).abs() < 0.05, "{factors:?}");
    assert!(first.rays.is_none() && second.rays.is_none(), "two values are no trend");
}

#[test]
fn the_error_of_a_furnace_is_all_noise_and_said_to_be() {
    let scene = mesh("furnace_cube");
    let tracer = Tracer::new(&scene);
    let mut study = Study::new(&tracer, options(0.005, &[100, 300, 900], &[16, 64])).unwrap();
    finish(&mut study);
    let reference = study.reference().unwrap();
    // It is the same everywhere, whatever the rays: paths alone are noisy.
    for row in study.rows().iter().filter(|row| row.is_converged()) {
        assert!(matches!(row.reading(), Reading::Below(_)), "{row:?}");
        assert!(
            row.error < 2.0 * reference.resolution() && row.bias.abs() < 4.0 * reference.noise(),
            "{row:?}"
        );
    }
    let found = Conclusions::new(study.rows(), reference);
    assert!(found.patches.and_then(|trend| trend.slope).is_none(), "no slope through noise");
    assert!(found.targets.iter().all(|target| target.accuracy >= found.resolution));
}

/// Stops at the n-th look of a stage.
struct Stop {
    stage: &'static str,
    looks: AtomicUsize,
}

impl Observer for Stop {
    fn at(&self, stage: &'static str, _: f64) -> ControlFlow<()> {
        if stage == self.stage && self.looks.fetch_sub(1, Ordering::Relaxed) == 1 {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

#[test]
fn a_study_that_was_stopped_resumes_to_the_same_table() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let stop = Stop { stage: "study", looks: AtomicUsize::new(400) };
    let whole = || options(0.01, &[60, 120], &[16, 32]);
    let mut stopped = Study::new(&tracer, StudyOptions { progress: Progress::to(&stop), ..whole() }).unwrap();
    let end = loop {
        match stopped.advance() {
            Ok(more) => assert!(more, "stopped before the end"),
            Err(error) => break error,
        }
    };
    assert!(
        matches!(
            end,
            MeasureError::Transport(_)
                | MeasureError::Cancelled(_)
                | MeasureError::Patches(_)
                | MeasureError::Solve(_)
        ),
        "{end:?}"
    );
    let [table, reference] = tables(&stopped);
    let before = stopped.rows().len();

    let mut resumed = Study::new(&tracer, whole()).unwrap();
    let (known, rows) = read_study(&resumed, table.as_slice(), reference.as_slice()).unwrap();
    assert_eq!((&known, rows.as_slice()), (stopped.reference().unwrap(), stopped.rows()), "to the last bit");
    resumed.resume(known.clone(), rows);
    finish(&mut resumed);
    assert_eq!(resumed.taken_over(), before);

    let mut at_once = Study::new(&tracer, whole()).unwrap();
    finish(&mut at_once);
    assert_eq!(at_once.reference().unwrap().sides, known.sides, "the same seed, the same reference");
    assert_eq!(timeless(resumed.rows()), timeless(at_once.rows()));
    assert!(resumed.rows().len() > before && before > 0);
    assert!(!resumed.advance().unwrap(), "nothing is left to do");

    // Another seed, another scene or a damaged table are other studies.
    let [table, reference] = tables(&resumed);
    let seeded = Study::new(&tracer, StudyOptions { seed: 1, ..whole() }).unwrap();
    assert!(read_study(&seeded, table.as_slice(), reference.as_slice()).is_none());
    assert!(read_study(&resumed, table.as_slice(), &reference[..reference.len() - 4]).is_none());
    assert!(read_study(&resumed, table.as_slice(), &b""[..]).is_none());
    // So are tables of which a number cannot be.
    let forged = |bytes: &[u8], column: usize, value: &str| -> Vec<u8> {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut fields: Vec<&str> = lines[1].split(',').collect();
        fields[column] = value;
        lines[1] = fields.join(",");
        (lines.join("\n") + "\n").into_bytes()
    };
    for (column, value) in
        [(0, "99999"), (0, "1"), (1, "inside"), (2, "1e9"), (2, "nan"), (4, "-1"), (4, "inf"), (5, "-1")]
    {
        let wrong = forged(&reference, column, value);
        assert!(read_study(&resumed, table.as_slice(), wrong.as_slice()).is_none(), "{column} {value}");
    }
    for (column, value) in [(0, "0"), (0, "-3"), (4, "nan"), (6, "-1"), (6, "inf"), (2, "magic")] {
        let wrong = forged(&table, column, value);
        assert!(read_study(&resumed, wrong.as_slice(), reference.as_slice()).is_none(), "{column} {value}");
    }
    let other = mesh("two_rooms");
    let tracer = Tracer::new(&other);
    let other = Study::new(&tracer, whole()).unwrap();
    assert!(read_study(&other, table.as_slice(), reference.as_slice()).is_none());
}

#[test]
fn what_does_not_fit_is_left_out_with_what_it_wants() {
    let scene = Scene::cornell_box();
    let tracer = Tracer::new(&scene);
    let short = StudyOptions { time: Duration::from_millis(50), ..options(0.01, &[60, 4000], &[16, 4096]) };
    let mut study = Study::new(&tracer, short).unwrap();
    finish(&mut study);
    let left: Vec<_> = study.left_out().iter().map(|left| (left.cell.patches, left.cell.rays)).collect();
    assert!(left.contains(&(4000, 4096)) && !left.contains(&(60, 16)), "{left:?}");
    assert!(study.left_out().iter().all(|left| matches!(left.wants, Want::Seconds(s) if s > 0.0)));
    assert!(study.seconds_for_all() > study.spent());
    let small = StudyOptions { memory: 2 << 20, ..options(0.01, &[60, 4000], &[64]) };
    let mut study = Study::new(&tracer, small).unwrap();
    finish(&mut study);
    assert_eq!(study.left_out().len(), 1);
    assert!(matches!(&study.left_out()[0].wants, Want::Memory(why) if why.contains("--memory")));
}
