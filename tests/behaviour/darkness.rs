//! Darkness: what light reaches only by leaks counts in no mean, and answers that are too uncertain say so.

use std::f64::consts::PI;

use glam::DVec3;
use radiosity::measure::{Cause, DARK, Darkness, ErrorBars, Level, Verdict, lit_points, unlit_points};
use radiosity::output::Photometry;
use radiosity::patches::{Basis, Patches};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Receiver, Scene};
use radiosity::solve::{Problem, Solution};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, LightOptions, Received, TraceOptions};

use crate::scenes::{cut_into, flipped, quads, room};

/// A room of 3 m with a lamp on its ceiling, and a closed box on its floor; object k is quad k.
fn room_with_box() -> Scene {
    let walls = room([0.0; 3], [3.0; 3]).map(|wall| (wall, 0));
    let lamp = [[1.0, 2.9, 1.0], [2.0, 2.9, 1.0], [2.0, 2.9, 2.0], [1.0, 2.9, 2.0]];
    let solid = room([0.5, 0.5, 0.5], [1.0; 3]).map(|side| (flipped(side), 0));
    let materials = vec![Material::diffuse("wall", &[0.5]), Material::lamp("lamp", &[0.0], &[5.0])];
    quads(&[&walls[..], &[(lamp, 1)], &solid[..]].concat(), materials)
}

/// A solved scene.
struct Solved<'s> {
    tracer: Tracer<'s>,
    patches: Patches<'s>,
    means: Solution,
    bars: ErrorBars,
}

fn solved(scene: &Scene, count: usize, rays: u32) -> Solved<'_> {
    let tracer = Tracer::new(scene);
    let mut patches = cut_into(&tracer, count);
    let options = TraceOptions { rays: Some(rays), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default()).unwrap();
    let solution = problem.direct(&Default::default()).unwrap();
    let bars = ErrorBars::of(&patches, &problem, &solution, Progress::default()).unwrap();
    let means = solution.means();
    Solved { tracer, patches, means, bars }
}

#[test]
fn dark_sides_count_in_no_mean_and_dark_patches_in_no_minimum() {
    let scene = room_with_box();
    let Solved { patches, means, bars, .. } = solved(&scene, 600, 64);
    let of = |irradiance: &nalgebra::DMatrix<f64>, kind: &str, name: &str| {
        let rows = Photometry::of_surfaces(&patches, irradiance, &means.radiance, &bars);
        rows.into_iter().find(|row| row.kind == kind && row.name == name).unwrap()
    };
    let floor = |i: usize| patches.place(i).face / 2 == 1;
    let lit = &means.irradiance;
    let (all, wall) = (of(lit, "material", "wall"), of(lit, "object", "quad 1"));
    let whole = all.area.unwrap();

    // All of the floor is dark, as if it lay in a solid.
    let mut dark = lit.clone();
    (0..patches.len()).filter(|&i| floor(i)).for_each(|i| dark[i] *= 0.1 * DARK);
    let without = of(&dark, "material", "wall");
    assert!((without.area.unwrap() - (whole - 9.0)).abs() < 1e-9, "{without:?}");
    let [mean, minimum] =
        [without, all.clone()].map(|row| row.illuminance.unwrap()).map(|l| [l.mean, l.minimum])[0];
    let flux = |row: &Photometry| row.area.unwrap() * row.illuminance.unwrap().mean;
    assert!((mean * (whole - 9.0) / (flux(&all) - flux(&wall)) - 1.0).abs() < 1e-9);
    assert!(minimum > 1e-2 * mean);
    // By itself it has what there is.
    let alone = of(&dark, "object", "quad 1");
    assert!((alone.area.unwrap() - 9.0).abs() < 1e-9 && alone.illuminance.unwrap().mean > 0.0, "{alone:?}");

    // One patch of it is dark, as under the foot of a chair: it counts in mean and area alone.
    let mut spot = lit.clone();
    let foot = (0..patches.len()).find(|&i| floor(i)).unwrap();
    spot[foot] = 1e-12;
    let row = of(&spot, "object", "quad 1");
    assert_eq!(row.area, wall.area);
    let (before, after) = (wall.illuminance.unwrap(), row.illuminance.unwrap());
    assert!(after.mean < before.mean && after.minimum >= before.minimum, "{before:?} {after:?}");
    let darkness = Darkness::of(&patches, &spot);
    assert!(darkness.patches[foot] && darkness.patches.iter().filter(|&&dark| dark).count() == 1);
    assert!(!darkness.sides.contains(&true));
}

#[test]
fn points_within_a_solid_are_named_and_count_in_no_uniformity() {
    let scene = room_with_box();
    let Solved { tracer, patches, means, bars, .. } = solved(&scene, 600, 64);
    // Eight of the 36 points, at most, lie within the box.
    let desk = Receiver::grid("desk", DVec3::new(0.0, 0.75, 0.0), [DVec3::Z * 3.0, DVec3::X * 3.0], [6, 6]);
    let radiance = Basis::Constant.coefficients_of(&means.radiance);
    let received = Received::trace(&tracer, &patches, &radiance, &desk, &LightOptions::default()).unwrap();
    let within = |p: DVec3| p.cmpgt(DVec3::splat(0.5)).all() && p.cmplt(DVec3::ONE).all();
    let wanted: Vec<bool> = desk.points().map(|point| !within(point)).collect();
    assert_eq!(lit_points(&received), wanted);
    let unlit = wanted.iter().filter(|lit| !**lit).count();
    let said = unlit_points(&received).unwrap();
    assert!(unlit > 0 && said.starts_with(&format!("receiver desk: {unlit} of its 36 points")), "{said}");
    // In the open nothing is said.
    let high = Receiver { corner: DVec3::new(0.0, 2.0, 0.0), ..desk };
    let received = Received::trace(&tracer, &patches, &radiance, &high, &LightOptions::default()).unwrap();
    assert_eq!(unlit_points(&received), None);
    assert!(bars.budget.upper95 < 0.25, "{:?}", bars.budget);
}

#[test]
fn an_answer_that_is_too_uncertain_is_doubtful() {
    let scene = room_with_box();
    let verdict = |rays: u32| {
        let Solved { bars, .. } = solved(&scene, 120, rays);
        let error = bars.headline(|budget| budget.upper95);
        (error.budget.upper95, Verdict::default().with_error(&error))
    };
    let (bound, good) = verdict(512);
    assert!(bound < 0.25 && good == Verdict::default(), "{bound} {good:?}");
    let (bound, doubtful) = verdict(8);
    assert!(bound > 0.25 && doubtful.level == Level::Doubtful, "{bound} {doubtful:?}");
    assert_eq!(doubtful.reasons.iter().map(|reason| reason.cause).collect::<Vec<_>>(), [Cause::Uncertain]);
}

#[test]
fn large_faces_are_cut_beside_thousands_of_small_ones() {
    // A rough sheet of 3200 triangles of 2 cm in a room whose walls have two each.
    let height = |i: usize, j: usize| 1.0 + 0.004 * ((i * 7 + j * 3) % 5) as f64;
    let at = |i: usize, j: usize| [1.0 + 0.02 * i as f64, height(i, j), 1.0 + 0.02 * j as f64];
    let cell = |k: usize| {
        let (i, j) = (k / 40, k % 40);
        ([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)], 0)
    };
    let sheet: Vec<_> = (0..1600).map(cell).collect();
    let walls = room([0.0; 3], [4.0, 3.0, 4.0]).map(|wall| (wall, 0));
    let lamp = [[1.0, 2.9, 1.0], [2.0, 2.9, 1.0], [2.0, 2.9, 2.0], [1.0, 2.9, 2.0]];
    let materials = vec![Material::diffuse("wall", &[0.5]), Material::lamp("lamp", &[0.0], &[5.0 / PI])];
    let scene = quads(&[&walls[..], &[(lamp, 1)], &sheet[..]].concat(), materials);
    let tracer = Tracer::new(&scene);
    for count in [800, 2000] {
        let patches = cut_into(&tracer, count);
        let on_walls: Vec<f64> =
            (0..patches.len()).filter(|&i| patches.place(i).face < 12).map(|i| patches.area(i)).collect();
        // As finely as so many patches would cut the room's 80 m² and the sheet's two sides.
        let largest = on_walls.iter().copied().fold(0.0, f64::max);
        assert!(largest < 1.5 * 82.0 / count as f64, "{count}: {largest} m²");
        assert!(on_walls.len() < 2 * count, "{count}: {} on walls", on_walls.len());
    }
}
