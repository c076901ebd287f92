//! Saved form factors: what may change around them, and what makes them useless.

use std::io::Cursor;

use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize, Patches, Tessellation};
use radiosity::scene::{Material, Scene};
use radiosity::trace::Tracer;
use radiosity::trace::sampling::Stream;
use radiosity::transport::{
    FactorsFileError, FormFactors, Keep, Reuse, StorageKind, TraceOptions, TransportError,
};

use crate::scenes::{irradiance, moved, quads, room};

/// A room with two lamps that may be on or off, and a divider that is lit on both sides.
fn scene(lamps: [f64; 2], rho: f64) -> Scene {
    let panel = |x: f64| [[x, 0.9, 0.4], [x + 0.2, 0.9, 0.4], [x + 0.2, 0.9, 0.6], [x, 0.9, 0.6]];
    let divider = [[0.5, 0.0, 0.0], [0.5, 0.6, 0.0], [0.5, 0.6, 1.0], [0.5, 0.0, 1.0]];
    let walls = room([0.0; 3], [1.0; 3]).map(|quad| (quad, 0));
    let more = [(panel(0.1), 1), (panel(0.7), 2), (divider, 0)];
    let all: Vec<_> = walls.into_iter().chain(more).collect();
    let lamp = |name: &str, power: f64| Material::lamp(name, &[0.1], &[power]);
    quads(&all, vec![Material::diffuse("grey", &[rho]), lamp("left", lamps[0]), lamp("right", lamps[1])])
}

fn cut() -> Tessellation<'static> {
    Tessellation { size: PatchSize::Edge(0.12), ..Default::default() }
}

fn traced<'s>(tracer: &Tracer<'s>, storage: StorageKind) -> (Patches<'s>, FormFactors) {
    traced_for(tracer, (Basis::Constant, storage))
}

fn traced_for<'s>(tracer: &Tracer<'s>, (basis, storage): (Basis, StorageKind)) -> (Patches<'s>, FormFactors) {
    let mut patches = Patches::new(tracer, &cut()).unwrap();
    let options = TraceOptions { rays: Some(64), basis, storage, keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(tracer, &mut patches, &options).unwrap();
    (patches, factors)
}

fn saved(scene: &Scene, storage: StorageKind) -> Vec<u8> {
    let tracer = Tracer::new(scene);
    let (patches, factors) = traced(&tracer, storage);
    let mut file = Vec::new();
    factors.save(&patches, &mut file).unwrap();
    file
}

/// Irradiance of every patch, and how much of `file` could be used.
fn solved_with(file: &[u8], scene: &Scene) -> (DMatrix<f64>, Reuse) {
    let tracer = Tracer::new(scene);
    let (patches, factors, reuse) =
        FormFactors::load(&mut Cursor::new(file), &tracer, &cut(), StorageKind::Auto, Keep::Nothing).unwrap();
    (irradiance(&patches, &factors), reuse)
}

#[test]
fn nothing_is_traced_again_for_other_powers_and_reflectances() {
    for storage in [StorageKind::Dense, StorageKind::Sparse] {
        let before = scene([5.0, 3.0], 0.5);
        let file = saved(&before, storage);
        for (after, same_powers) in [(scene([5.0, 3.0], 0.8), true), (scene([1.0, 1.0], 0.8), false)] {
            let (reused, reuse) = solved_with(&file, &after);
            assert!(reuse.traced == 0 && reuse.balanced, "{reuse:?}");
            let tracer = Tracer::new(&after);
            let (patches, fresh) = traced(&tracer, storage);
            let fresh = irradiance(&patches, &fresh);
            if same_powers {
                assert_eq!(reused, fresh, "the same bits");
            }
            // Powers guide where light sampling looks, so that other ones come with other noise.
            let mean = |h: &DMatrix<f64>| h.iter().sum::<f64>() / h.len() as f64;
            assert!(reused.len() == fresh.len() && (mean(&reused) / mean(&fresh) - 1.0).abs() < 0.01);
        }
        assert!(solved_with(&file, &before).1.balanced);
    }
}

#[test]
fn linear_elements_are_saved_with_all_that_other_lamps_need() {
    let left = scene([5.0, 0.0], 0.5);
    let both = scene([5.0, 5.0], 0.5);
    for storage in [StorageKind::Dense, StorageKind::Sparse] {
        let kind = (Basis::Linear, storage);
        let tracer = Tracer::new(&left);
        let (patches, factors) = traced_for(&tracer, kind);
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        let (reused, reuse) = solved_with(&file, &left);
        assert!(reuse.balanced && reused.len() == 3 * patches.len());
        assert_eq!(reused, irradiance(&patches, &factors), "the same bits");
        // Lamps that are newly lit, from the same rays as if all had been traced anew; storage is chosen anew
        // too.
        let (adapted, reuse) = solved_with(&file, &both);
        assert!(!reuse.balanced && reuse.traced < reuse.held / 10, "{reuse:?}");
        let tracer = Tracer::new(&both);
        let (patches, fresh) = traced_for(&tracer, (Basis::Linear, StorageKind::Auto));
        assert_eq!(adapted, irradiance(&patches, &fresh));
        // The same lamps over black walls: fewer sides are reached, and what is known of lamps is taken from
        // the file.
        let black = scene([5.0, 0.0], 0.0);
        let (adapted, reuse) = solved_with(&file, &black);
        assert!(!reuse.balanced && reuse.traced == 0, "{reuse:?}");
        let tracer_of_black = Tracer::new(&black);
        let (patches, fresh) = traced_for(&tracer_of_black, (Basis::Linear, StorageKind::Auto));
        assert_eq!(adapted, irradiance(&patches, &fresh));
        // Damage is found before anything is made of it.
        for place in [100, file.len() / 3] {
            let mut altered = file.clone();
            altered[place] ^= 0x10;
            let loaded =
                FormFactors::load(&mut Cursor::new(altered), &tracer, &cut(), storage, Keep::Nothing);
            assert!(matches!(loaded, Err(TransportError::File(FactorsFileError::Damaged))));
        }
    }
}

#[test]
fn only_what_other_lamps_newly_reach_is_traced() {
    let left = scene([5.0, 0.0], 0.5);
    let both = scene([5.0, 5.0], 0.5);
    let file = saved(&left, StorageKind::Auto);
    let (adapted, reuse) = solved_with(&file, &both);
    assert!(!reuse.balanced && reuse.traced < reuse.held / 10, "{reuse:?}");
    let tracer = Tracer::new(&both);
    let (patches, fresh) = traced(&tracer, StorageKind::Auto);
    assert_eq!(adapted, irradiance(&patches, &fresh), "as if all had been traced anew");
    // And back again: nothing is missing then.
    let file = saved(&both, StorageKind::Auto);
    let (adapted, reuse) = solved_with(&file, &left);
    assert_eq!(reuse.traced, 0);
    let tracer = Tracer::new(&left);
    let (patches, fresh) = traced(&tracer, StorageKind::Auto);
    let fresh = irradiance(&patches, &fresh);
    assert_eq!(adapted.len(), fresh.len());
    assert_eq!(adapted, fresh);
}

#[test]
fn a_file_that_does_not_fit_is_refused_with_the_reason() {
    let scene = scene([5.0, 3.0], 0.5);
    let file = saved(&scene, StorageKind::Auto);
    let tracer = Tracer::new(&scene);
    let refused_when = |keep: Keep, file: &[u8], tracer: &Tracer| {
        let loaded = FormFactors::load(&mut Cursor::new(file), tracer, &cut(), StorageKind::Auto, keep);
        match loaded {
            Err(TransportError::File(error)) => error,
            other => panic!("{:?}", other.map(|(_, _, reuse)| reuse)),
        }
    };
    let refused = |file: &[u8], tracer: &Tracer| refused_when(Keep::Nothing, file, tracer);
    assert_eq!(refused(b"mtllib a.mtl", &tracer), FactorsFileError::Foreign);
    assert_eq!(refused(b"", &tracer), FactorsFileError::Foreign);
    for length in [9, 12, 40, file.len() / 2, file.len() - 1] {
        assert_eq!(refused(&file[..length], &tracer), FactorsFileError::Damaged, "cut to {length}");
    }
    for place in [20, 100, file.len() / 2, file.len() - 3] {
        let mut altered = file.clone();
        altered[place] ^= 0x10;
        // What lies behind the exchange areas is looked at only when it is needed.
        assert_eq!(
            refused_when(Keep::Rays, &altered, &tracer),
            FactorsFileError::Damaged,
            "altered at {place}"
        );
    }
    let mut newer = file.clone();
    newer[8] += 1;
    assert_eq!(refused(&newer, &tracer), FactorsFileError::Version { found: 9 });
    let larger = moved(&scene, |p| p * 1.25);
    assert_eq!(refused(&file, &Tracer::new(&larger)), FactorsFileError::OtherScene);
}

#[test]
fn form_factors_without_their_rays_can_not_be_saved() {
    let scene = scene([5.0, 3.0], 0.5);
    let tracer = Tracer::new(&scene);
    let mut patches = Patches::new(&tracer, &cut()).unwrap();
    let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default()).unwrap();
    let error = factors.save(&patches, &mut Vec::new()).unwrap_err();
    assert!(error.to_string().contains("not kept"), "{error}");
}

/// Where the two sections of a file begin, behind their lengths, and how long they are.
fn sections(file: &[u8]) -> [(usize, usize); 2] {
    let length = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    let first = (20, length(12));
    let second = first.0 + first.1 + 8;
    [first, (second + 8, length(second))]
}

/// Changes a number or a few in a section, and makes the checksum right.
fn forge(file: &[u8], seed: u64) -> Vec<u8> {
    let mut random = Stream::Callers
        .sequence(seed, 1, 0)
        .point(0)
        .into_iter()
        .chain(Stream::Callers.sequence(seed, 2, 0).point(1));
    let mut below = |n: usize| (random.next().unwrap() * n as f64) as usize;
    let mut forged = file.to_vec();
    let (start, length) = sections(file)[below(8) / 7];
    // Half of all hits fall on what stands before the lists.
    let words = if below(2) == 0 { 64.min(length / 4) } else { length / 4 };
    let place = start + 4 * below(words);
    let word: [u8; 4] = forged[place..place + 4].try_into().unwrap();
    let new = match below(8) {
        0 => [0xff; 4],
        1 => [0; 4],
        2 => (u32::from_le_bytes(word).wrapping_add(1)).to_le_bytes(),
        3 => (f32::from_le_bytes(word) * 1.01).to_le_bytes(),
        4 => f32::NAN.to_le_bytes(),
        5 => (-f32::from_le_bytes(word)).to_le_bytes(),
        6 => [word[3], word[1], word[2], word[0]],
        _ => 0x7fff_fff0u32.to_le_bytes(),
    };
    forged[place..place + 4].copy_from_slice(&new);
    let sum = xxhash_rust::xxh3::xxh3_64(&forged[start..start + length]);
    forged[start + length..start + length + 8].copy_from_slice(&sum.to_le_bytes());
    forged
}

#[test]
fn forged_files_with_right_checksums_change_no_answer() {
    let (left, both) = (scene([5.0, 0.0], 0.5), scene([5.0, 5.0], 0.5));
    let (tracer, tracer_of_both) = (Tracer::new(&left), Tracer::new(&both));
    let [mut changed, mut refused] = [0; 2];
    for (basis, storage) in [
        (Basis::Constant, StorageKind::Dense),
        (Basis::Constant, StorageKind::Sparse),
        (Basis::Linear, StorageKind::Sparse),
    ] {
        let (patches, factors) = traced_for(&tracer, (basis, storage));
        let mut file = Vec::new();
        factors.save(&patches, &mut file).unwrap();
        let right = irradiance(&patches, &factors);
        let most = right.iter().fold(0.0f64, |most, h| most.max(h.abs()));
        for seed in 0..80 {
            let forged = forge(&file, seed);
            if forged == file {
                continue;
            }
            changed += 1;
            let load =
                |tracer, keep| FormFactors::load(&mut Cursor::new(&forged), tracer, &cut(), storage, keep);
            // Other lamps make more of the file count: nothing panics.
            let _ = load(&tracer_of_both, Keep::Nothing);
            let Ok((patches, factors, _)) = load(&tracer, Keep::Rays) else {
                refused += 1;
                continue;
            };
            let found = irradiance(&patches, &factors);
            assert_eq!(found.len(), right.len(), "{basis:?} {storage:?} {seed}");
            let off = found.iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Where light may start differs, all is balanced anew, from the same rays.
            assert!(off <= 1e-6 * most, "{basis:?} {storage:?} {seed}: off by {off} of {most}");
        }
    }
    assert!(changed > 150 && 2 * refused > changed, "{refused} of {changed} refused");
}
