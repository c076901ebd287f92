//! Spots of any width: what they send arrives, however small the part of a patch on which it falls.

use std::f64::consts::TAU;

use glam::DVec3;
use radiosity::patches::Basis;
use radiosity::scene::{Light, Material};
use radiosity::trace::Tracer;
use radiosity::trace::sampling::Stream;
use radiosity::transport::{LightOptions, Sources};

use crate::scenes::{cut_into, flipped, lit_quads, room, square};

#[test]
fn all_that_a_spot_sends_arrives_whatever_its_cone() {
    let table = square(1.0, 0.5).map(|[x, y, z]| [x + 1.5, y, z + 1.5]);
    let under = flipped(table.map(|[x, y, z]| [x, y - 0.02, z]));
    let walls = room([0.0; 3], [4.0, 3.0, 5.0]).into_iter().map(|quad| (quad, 0));
    let quads: Vec<_> = walls.chain([(table, 0), (under, 0)]).collect();
    for (k, cone) in [0.02, 0.1, 0.5, 2.0, 6.0, 15.0, 40.0].into_iter().enumerate() {
        for place in 0..6 {
            let [x, z, u, v] = Stream::Callers.sequence(7, place, k as u64).point(3);
            let (tilt, turn) = (0.8 * u, TAU * v);
            let direction = DVec3::new(tilt * turn.cos(), -1.0, tilt * turn.sin()).normalize();
            let position = DVec3::new(0.5 + 3.0 * x, 2.9, 0.5 + 4.0 * z);
            let spot = Light::Spot { position, direction, intensity: vec![3.0], cone, penumbra: 0.3 * cone };
            let sent = spot.flux().unwrap()[0];
            let scene = lit_quads(&quads, vec![Material::diffuse("grey", &[0.5])], vec![spot], None);
            let tracer = Tracer::new(&scene);
            let patches = cut_into(&tracer, 300);
            let options = LightOptions::default();
            for basis in [Basis::Constant, Basis::Linear] {
                let sources = Sources::trace(&tracer, &patches, basis, &options).unwrap();
                let arrives = |field| {
                    let irradiance = basis.means(field);
                    (0..patches.len()).map(|i| patches.area(i) * irradiance[i]).sum::<f64>()
                };
                let arrived = arrives(sources.direct.as_ref().unwrap());
                let noise: f64 = sources.spread.iter().map(|part| arrives(part).powi(2)).sum();
                let error = (noise / 56.0).sqrt() / sent;
                let off = arrived / sent - 1.0;
                // A narrow spot's light is shared out between patches without loss; of wide ones edges are
                // noise.
                let most = if cone <= 2.0 { 3e-3 } else { (4.0 * error).max(3e-3) };
                assert!(off.abs() < most, "{cone} {place} {basis:?}: {off} {error}");
                assert!(error < 0.02, "{cone} {place} {basis:?}: {error}");
            }
        }
    }
}
