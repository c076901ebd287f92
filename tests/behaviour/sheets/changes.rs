//! Sheets that come and go: saved form factors, the plan, and switches.

use std::io::Cursor;

use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::scene::{Material, Scene};
use radiosity::solve::{self, DirectOptions};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, Plan, StorageKind, Switches, TraceOptions, Transport};

use super::{around, factors, gauze, paper};
use crate::scenes::difference;

#[test]
fn saved_form_factors_serve_when_a_wall_becomes_translucent() {
    let cut = Tessellation { size: PatchSize::Edge(0.2), ..Default::default() };
    let options = TraceOptions { rays: Some(64), keep: Keep::Rays, ..Default::default() };
    let traced = |scene: &Scene| {
        let tracer = Tracer::new(scene);
        let mut patches = Patches::new(&tracer, &cut).unwrap();
        let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
        let radiance = radiance(&patches, &factors);
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        (file, radiance)
    };
    let card = Material::diffuse("card", &[0.5; 3]);
    for (before, after, all_there) in
        [(card.clone(), paper(), false), (paper(), gauze(), true), (gauze(), card, true)]
    {
        let (file, _) = traced(&around(before));
        let scene = around(after);
        let (_, fresh) = traced(&scene);
        let tracer = Tracer::new(&scene);
        let file = &mut Cursor::new(file);
        let (patches, factors, reuse) =
            FormFactors::load(file, &tracer, &cut, StorageKind::Auto, Keep::Nothing).unwrap();
        assert_eq!(reuse.traced == 0, all_there, "{reuse:?}");
        let reused = radiance(&patches, &factors);
        assert!(reused.len() == fresh.len() && difference(&reused, &fresh) < 1e-9);
    }
}

fn radiance(patches: &Patches, factors: &FormFactors) -> DMatrix<f64> {
    let k = Transport::of(factors, patches).unwrap();
    solve::direct(&k, &DirectOptions::default()).unwrap().solve(&patches.emitted_radiance()).radiance
}

#[test]
fn the_plan_names_sheets_and_can_leave_out_what_comes_through() {
    let effect = |plan: &Plan| plan.effects.iter().find(|e| e.effect == "transmission").unwrap().clone();
    assert!(!effect(&Plan::new(&Scene::cornell_box())).on);
    let planned = effect(&Plan::new(&around(paper())));
    assert!(planned.on && planned.reason.contains("paper"), "{}", planned.reason);
    let opaque = {
        let scene =
            around(Material::diffuse("paper", &[0.5, 0.4, 0.3]).with_sheet(&[0.2, 0.4, 0.6], &[0.0; 3]));
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        radiance(&patches, &factors)
    };
    for (switches, told_of) in [
        ("-transmission", vec!["transmission"]),
        ("-back-sides", vec!["back sides", "nothing comes through"]),
    ] {
        let (scene, plan, told) = switches.parse::<Switches>().unwrap().apply(around(paper()));
        assert!(
            !effect(&plan).on && told.iter().any(|line| told_of.iter().all(|word| line.contains(word))),
            "{told:?}"
        );
        let (patches, factors) = factors(&scene, PatchSize::Count(300), (Basis::Constant, 64));
        assert!(patches.sheets().is_none());
        if switches == "-transmission" {
            assert_eq!(radiance(&patches, &factors), opaque);
        }
    }
}
