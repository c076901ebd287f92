//! Closed forms of point lights, spots, suns and skies.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use radiosity::patches::{Basis, PatchSize, Patches};
use radiosity::scene::{Light, Side, SkyKind};
use radiosity::trace::Tracer;
use radiosity::transport::{LightOptions, Sources};

use super::room_with_window;
use crate::scenes::{BASES, cut, grey, lit_quads, point, sky, square, sun};

/// H₀ of every patch of a scene, by means over patches.
fn direct_light(tracer: &Tracer, patches: &Patches, basis: Basis, rays: u32) -> DMatrix<f64> {
    let sources =
        Sources::trace(tracer, patches, basis, &LightOptions { rays, ..Default::default() }).unwrap();
    basis.means(&sources.direct.unwrap())
}

#[test]
fn a_point_light_over_a_plane_obeys_the_inverse_square_and_cosine_laws() {
    let light = DVec3::new(0.3, 1.2, -0.4);
    let scene = lit_quads(&[(square(0.0, 1.0), 0)], grey(0.5), vec![point(light, &[20.0])], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.02));
    assert!(patches.len() > 9000);
    for basis in BASES {
        let found = direct_light(&tracer, &patches, basis, 64);
        for i in 0..patches.len() {
            let between = light - patches.centre(i);
            let exact = 20.0 * between.y / between.length().powi(3);
            assert!((found[i] / exact - 1.0).abs() < 1e-4, "{basis:?} {i}: {} {exact}", found[i]);
        }
    }
}

#[test]
fn unhidden_point_lights_are_exact_over_patches_of_any_size() {
    let light = DVec3::new(0.3, 0.2, -0.4);
    let scene = lit_quads(&[(square(0.0, 1.0), 0)], grey(0.5), vec![point(light, &[1.0])], None);
    let tracer = Tracer::new(&scene);
    let whole = |edge: f64, rays: u32| {
        let patches = cut(&tracer, PatchSize::Edge(edge));
        let h = direct_light(&tracer, &patches, Basis::Constant, rays);
        (0..patches.len()).map(|i| patches.area(i) * h[i]).sum::<f64>()
    };
    // The flux that a square of half-width a catches at the side of its axis: four corners' solid angles.
    let corner = |x: f64, z: f64| (x * z / (light.y * (x * x + z * z + light.y * light.y).sqrt())).atan();
    let [x, z] = [light.x, light.z];
    let exact: f64 = [(1.0 - x, 1.0 - z), (1.0 - x, 1.0 + z), (1.0 + x, 1.0 - z), (1.0 + x, 1.0 + z)]
        .map(|(x, z)| corner(x, z))
        .iter()
        .sum();
    for (edge, rays) in [(2.0, 8), (0.5, 32), (0.1, 8)] {
        let off = whole(edge, rays) / exact - 1.0;
        assert!(off.abs() < 1e-12, "{edge}: {off}");
    }
}

#[test]
fn a_spot_lights_what_is_in_its_cone_as_a_point_does_and_nothing_else() {
    let position = DVec3::new(0.0, 1.0, 0.0);
    let spot =
        Light::Spot { position, direction: DVec3::NEG_Y, intensity: vec![3.0], cone: 30.0, penumbra: 10.0 };
    let scene = lit_quads(&[(square(0.0, 1.0), 0)], grey(0.0), vec![spot], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.02));
    let found = direct_light(&tracer, &patches, Basis::Constant, 64);
    let [mut inside, mut edge] = [0; 2];
    for i in 0..patches.len() {
        let between = position - patches.centre(i);
        let angle = between.angle_between(DVec3::Y).to_degrees();
        let by_a_point = 3.0 * between.y / between.length().powi(3);
        if angle < 19.0 {
            inside += 1;
            assert!((found[i] / by_a_point - 1.0).abs() < 1e-4, "{i}: {}", found[i]);
        } else if (21.0..29.0).contains(&angle) {
            edge += 1;
            assert!(found[i] > 0.0 && found[i] < by_a_point);
        } else if angle > 31.0 {
            assert_eq!(found[i], 0.0);
        }
    }
    assert!(inside > 500 && edge > 500);
    // What the cone's end never reaches is no patch at all.
    let corner = patches.len() as f64 * 0.02 * 0.02 / 2.0;
    assert!(corner < 0.5 * 4.0, "{corner} m² of 4 m² are reached");
}

#[test]
fn the_sun_through_a_window_casts_its_patch_where_geometry_says() {
    let direction = DVec3::new(0.2, -1.0, 0.9);
    let scene = lit_quads(&room_with_window(), grey(0.5), vec![sun(direction.to_array(), 100.0, 0.0)], None);
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Edge(0.05));
    let found = direct_light(&tracer, &patches, Basis::Constant, 64);
    let cosine = -direction.normalize().y;
    let [mut lit, mut dark] = [0; 2];
    for i in 0..patches.len() {
        let place = patches.place(i);
        let [p, q, r] = patches.corners(i).map(|corner| patches.point(place.face, corner));
        if patches.centre(i).y > 1e-9 || place.side == Side::Back {
            continue;
        }
        // Back along the ray to the plane of the window.
        let seen = [p, q, r].map(|p| p - direction * (p.z / direction.z));
        let within = |p: &DVec3| {
            let low = (p.x - 1.0).min(p.y - 1.0);
            low.min(2.0 - p.x).min(2.0 - p.y)
        };
        let margins = seen.iter().map(within);
        if margins.clone().fold(f64::INFINITY, f64::min) > 1e-9 {
            lit += 1;
            assert!((found[i] / (100.0 * cosine) - 1.0).abs() < 1e-12, "{i}: {}", found[i]);
        } else if seen.iter().all(|p| p.x < 1.0 - 1e-9)
            || seen.iter().all(|p| p.x > 2.0 + 1e-9)
            || seen.iter().all(|p| p.y < 1.0 - 1e-9)
            || seen.iter().all(|p| p.y > 2.0 + 1e-9)
        {
            dark += 1;
            assert_eq!(found[i], 0.0, "{i}");
        }
    }
    assert!(lit > 200 && dark > 500, "{lit} {dark}");
    // All the flux that comes through the window is found.
    let inside = (0..patches.len()).filter(|&i| patches.place(i).side == Side::Front);
    let flux: f64 = inside.map(|i| patches.area(i) * found[i]).sum();
    let through = 100.0 * direction.normalize().z;
    assert!((flux / through - 1.0).abs() < 2e-3, "{flux} {through}");
}

#[test]
fn open_ground_under_a_sky_has_its_closed_form() {
    for (kind, exact) in [
        // ∫ (1 + 2 cos θ)/3 cos θ dω over the hemisphere.
        (SkyKind::Overcast, 7.0 * PI / 9.0),
        (SkyKind::Constant, PI),
    ] {
        let scene = lit_quads(&[(square(0.0, 1.0), 0)], grey(0.5), vec![], Some(sky(kind.clone(), 100.0)));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, PatchSize::Count(200));
        for basis in BASES {
            let found = direct_light(&tracer, &patches, basis, 4096);
            let mean = (0..patches.len()).map(|i| patches.area(i) * found[i]).sum::<f64>()
                / (0..patches.len()).map(|i| patches.area(i)).sum::<f64>();
            // The back of the ground sees nothing of an overcast sky, and all of a constant one.
            assert!((mean / (100.0 * exact) - 1.0).abs() < 1e-3, "{kind:?} {basis:?}: {mean}");
            let worst = found.iter().map(|h| (h / (100.0 * exact) - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{kind:?} {basis:?}: {worst}");
        }
    }
}

#[test]
fn a_clear_sky_sends_what_its_own_integral_says() {
    let towards = DVec3::new(0.6, 0.5, -0.3).normalize();
    let clear = sky(SkyKind::Clear { sun: towards }, 10.0);
    let exact = 10.0 * clear.horizontal();
    let scene = lit_quads(&[(square(0.0, 1.0), 0)], grey(0.5), vec![], Some(clear));
    let tracer = Tracer::new(&scene);
    let patches = cut(&tracer, PatchSize::Count(200));
    let found = direct_light(&tracer, &patches, Basis::Constant, 4096);
    let worst = found.iter().map(|h| (h / exact - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst < 3e-3, "{worst}");
}
