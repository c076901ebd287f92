//! What each side of a sheet reflects, and what comes through to the other.

use std::f64::consts::PI;

use radiosity::patches::{Basis, PatchSize, Sheets};
use radiosity::scene::{Material, Side};
use radiosity::solve::{self, DirectOptions};
use radiosity::transport::Transport;

use super::{around, every_solver, factors, paper};
use crate::scenes::{flipped, quads, unit_square};

#[test]
fn light_comes_through_a_translucent_wall_and_through_no_other() {
    let lit_behind = |wall: Material| {
        let scene = around(wall);
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        let k = Transport::of(&factors, &patches).unwrap();
        let solution =
            solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.emitted_radiance());
        let behind = |i: usize| {
            let place = patches.place(i);
            let material = &scene.material_of(place.face).name;
            material == "second" || (place.side == Side::Back && material != "lamp")
        };
        let behind: Vec<usize> = (0..patches.len()).filter(|&i| behind(i)).collect();
        let least = behind.iter().map(|&i| solution.irradiance[(i, 0)]).fold(f64::INFINITY, f64::min);
        (behind.len(), least)
    };
    let (patches, least) = lit_behind(paper());
    assert!(patches > 50 && least > 0.0, "{patches} {least}");
    for opaque in [
        Material::diffuse("card", &[0.5; 3]),
        Material::diffuse("card", &[0.5; 3]).with_sheet(&[0.9; 3], &[0.0; 3]),
    ] {
        assert_eq!(lit_behind(opaque).0, 0);
    }
}

#[test]
fn each_side_reflects_by_itself() {
    // Two lamps of their own on both sides of an opaque card.
    let card = Material::diffuse("card", &[0.8]).with_sheet(&[0.1], &[0.0]);
    let lamp = Material::lamp("lamp", &[0.0], &[1.0]);
    let faces = [(unit_square(0.0), 1), (unit_square(0.5), 0), (flipped(unit_square(1.0)), 1)];
    let scene = quads(&faces, vec![card, lamp]);
    let (patches, factors) = factors(&scene, PatchSize::Edge(0.3), (Basis::Constant, 256));
    let k = Transport::of(&factors, &patches).unwrap();
    assert!(k.sheets().is_none());
    let solution = solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.emitted_radiance());
    for i in (0..patches.len()).filter(|&i| scene.material_of(patches.place(i).face).name == "card") {
        let rho = if patches.place(i).side == Side::Front { 0.8 } else { 0.1 };
        let found = solution.radiance[i] * PI / solution.irradiance[i];
        assert!((found - rho).abs() < 1e-12, "{found} {rho}");
    }
}

#[test]
fn radiance_is_what_is_reflected_and_what_comes_through() {
    let scene = around(paper());
    let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
    let k = Transport::of(&factors, &patches).unwrap();
    let e = patches.emitted_radiance();
    for solution in every_solver(&k, &e) {
        let Sheets { pairs, .. } = patches.sheets().unwrap();
        for [front, back] in pairs {
            for c in 0..3 {
                let [h, behind] = [front, back].map(|i| solution.irradiance[(i, c)]);
                let leaves = [
                    paper().reflectance[c] * h + paper().transmittance().unwrap()[c] * behind,
                    paper().reflectance_of(Side::Back)[c] * behind + paper().transmittance().unwrap()[c] * h,
                ];
                for (i, exact) in [front, back].into_iter().zip(leaves) {
                    let found = solution.radiance[(i, c)];
                    assert!((found * PI - exact).abs() < 1e-12, "{found} {exact}");
                }
            }
        }
    }
}
