//! Textures: averages over patches, light paths that read the picture itself, pictures, and what files say
//! and lack.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use image::{ImageFormat, Rgb, Rgb32FImage, RgbImage};
use nalgebra::DMatrix;
use radiosity::measure::{Difference, Energy, RelativeRms};
use radiosity::patches::{Basis, PatchSize, Patches, Reach, Tessellation};
use radiosity::reference::{Budget, PathOptions, PathTracer};
use radiosity::render::{self, Picture, RenderOptions, Shading, Surfaces};
use radiosity::scene::{Camera, Face, FaceState, Material, Pixels, Scene, SceneParts, Side, Texture};
use radiosity::solve;
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, TraceOptions, Transport};

use crate::scenes::room;
use crate::scratch::Scratch;

/// A picture whose channels vary each in its own way, between `low` and 1.
fn pattern(low: f32) -> Texture {
    let (width, height) = (24, 16);
    let texel = |k: usize| {
        let (i, j) = ((k % width) as f32, (k / width) as f32);
        let mix = |x: f32| low + (1.0 - low) * x;
        [
            mix(i / 23.0),
            mix(if (i as u32 / 6 + j as u32 / 4).is_multiple_of(2) { 1.0 } else { 0.0 }),
            mix(j / 15.0),
        ]
    };
    Texture::new(Pixels::new(width, height, (0..width * height).map(texel).collect()))
}

/// Quadrilaterals with a material each, over each of which a picture lies once.
fn textured(quads: &[([[f64; 3]; 4], u32)], materials: Vec<Material>) -> Scene {
    let mut parts = SceneParts { materials, objects: vec!["all".into()], ..Default::default() };
    let unit = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from);
    for (corners, material) in quads {
        let first = parts.vertices.len() as u32;
        parts.vertices.extend(corners.map(DVec3::from));
        for k in [1, 2] {
            let vertices = [first, first + k, first + k + 1];
            let state = FaceState::Kept;
            parts.faces.push(Face { vertices, normals: None, material: *material, object: 0, state });
            parts.texture_coordinates.push(Some([unit[0], unit[k as usize], unit[k as usize + 1]]));
        }
    }
    Scene::new(parts).unwrap()
}

fn painted(reflectance: [f64; 3], texture: Texture) -> Material {
    let mut material = Material::diffuse("painted", &reflectance);
    material.textures.reflectance = Some(texture);
    material
}

/// A closed room with a painted floor, and a painted lamp under its ceiling.
fn gallery() -> Scene {
    let mut lamp = Material::lamp("lamp", &[0.0; 3], &[4.0, 6.0, 9.0]);
    lamp.textures.emission = Some(pattern(0.0));
    let mut quads: Vec<_> = room([0.0; 3], [2.0, 1.5, 2.0]).map(|quad| (quad, 0)).to_vec();
    quads[1].1 = 1;
    let panel = [[0.6, 1.4, 0.5], [1.5, 1.4, 0.5], [1.5, 1.4, 1.3], [0.6, 1.4, 1.3]];
    quads.push((panel, 2));
    textured(&quads, vec![Material::diffuse("wall", &[0.6, 0.5, 0.4]), painted([0.9; 3], pattern(0.1)), lamp])
}

struct Case<'s> {
    patches: Patches<'s>,
    factors: FormFactors,
}

fn case<'s>(tracer: &Tracer<'s>, count: usize, basis: Basis) -> Case<'s> {
    let size = PatchSize::Count(count);
    let mut patches = Patches::new(tracer, &Tessellation { size, ..Default::default() }).unwrap();
    let options = TraceOptions { basis, ..Default::default() };
    let factors = FormFactors::trace(tracer, &mut patches, &options).unwrap();
    Case { patches, factors }
}

impl Case<'_> {
    fn solve(&self) -> solve::Solution {
        let k = Transport::of(&self.factors, &self.patches).unwrap();
        let e = self.factors.basis().coefficients_of(&self.patches.emitted_radiance());
        solve::solve(&k, &e, &Default::default()).unwrap()
    }
}

#[test]
fn patches_average_the_picture_so_that_faces_have_its_mean() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    for edge in [3.0, 0.4, 0.13] {
        let (size, reach) = (PatchSize::Edge(edge), Reach::Everything);
        let patches = Patches::new(&tracer, &Tessellation { size, reach, ..Default::default() }).unwrap();
        for (field, lamp) in [(patches.reflectances(), false), (patches.emitted_radiance(), true)] {
            for row in patches.average_by_face(&field).iter().filter(|row| row.side == Side::Front) {
                let material = scene.material_of(row.face);
                let (plain, texture) = match lamp {
                    false => (&material.reflectance, scene.reflectance_texture(row.face)),
                    true => (&material.emission, scene.emission_texture(row.face)),
                };
                let factors = texture.map_or([1.0; 3], |texture| texture.mean());
                for c in 0..3 {
                    let exact = plain[c] * factors[c];
                    assert!((row.mean[c] - exact).abs() < 1e-9, "{edge} {row:?}: {exact}");
                }
            }
        }
        assert!(edge > 1.0 || patches.reflectances().column(1).max() > 0.85, "patches differ");
    }
}

#[test]
fn an_even_picture_is_as_good_as_its_colour() {
    let even = |x: [f32; 3]| Texture::new(Pixels::new(3, 2, vec![x; 6]));
    let lamp = Material::lamp("lamp", &[0.3; 3], &[5.0; 3]);
    let quads: Vec<_> = room([0.0; 3], [1.0; 3]).into_iter().zip([0, 0, 0, 0, 1, 0]).collect();
    let with = textured(&quads, vec![painted([0.8, 0.8, 0.4], even([0.5, 0.25, 1.0])), lamp.clone()]);
    let plain = textured(&quads, vec![Material::diffuse("plain", &[0.4, 0.2, 0.4]), lamp]);
    for basis in [Basis::Constant, Basis::Linear] {
        let [ours, theirs] =
            [&with, &plain].map(|scene| case(&Tracer::new(scene), 300, basis).solve().radiance);
        assert!((&ours - &theirs).amax() < 1e-9 * theirs.amax(), "{basis:?}");
    }
}

#[test]
fn light_paths_that_read_the_picture_itself_agree() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let case = case(&tracer, 6000, Basis::Constant);
    let solution = case.solve();
    let budget = Budget { paths: Some(1_500_000), ..Default::default() };
    let options = PathOptions { budget, seed: 3, ..Default::default() };
    let truth = PathTracer::new(&tracer).irradiance(&case.patches, &options).unwrap();
    let floor = case.patches.average_by_face(&solution.irradiance);
    let rms = RelativeRms::of(&floor, &truth.by_face(&case.patches));
    assert!(rms.compared > 30 && rms.value < 0.005, "{rms:?}");
    let difference = Difference::new(&solution.irradiance, &truth);
    assert!(difference.bias.abs() < 0.002 + 3.0 * difference.bias_error, "{difference:?}");
    // The lamp is no even one: neither is the light below it.
    let [left, right] = [2, 3].map(|face| floor.iter().find(|row| row.face == face).unwrap().mean[0]);
    assert!((left / right - 1.0).abs() > 0.02, "{left} {right}");
}

#[test]
fn energy_balances_where_reflectance_varies() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let case = case(&tracer, 1500, Basis::Constant);
    let k = Transport::of(&case.factors, &case.patches).unwrap();
    let e = case.patches.emitted_radiance();
    let solution = solve::direct(&k, &Default::default()).unwrap().solve(&e);
    assert!(Energy::new(&k, &e, &solution.radiance).imbalance < 1e-9);
}

/// The floor from above.
fn from_above() -> Camera {
    Camera { position: DVec3::new(1.9, 1.3, 1.9), target: DVec3::new(0.9, 0.0, 0.9), up: DVec3::Y, fov: 50.0 }
}

/// Relative root mean square difference of two pictures beside lamps.
fn apart(a: &Picture, b: &Picture) -> f64 {
    let (mut squares, mut whole) = (0.0, 0.0);
    for (k, (p, q)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        if a.lamps[k].share == 0.0 {
            for c in 0..3 {
                squares += f64::from(p[c] - q[c]).powi(2);
                whole += f64::from(q[c]).powi(2);
            }
        }
    }
    (squares / whole).sqrt()
}

#[test]
fn every_way_of_shading_shows_the_picture_under_the_light() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let mut truth = None;
    for basis in [Basis::Constant, Basis::Linear] {
        // Patches are larger than what the picture shows.
        let case = case(&tracer, 250, basis);
        let radiance = case.solve().radiance;
        let seen = |shading: Shading, surfaces: Surfaces, samples: u32| {
            let options =
                RenderOptions { width: 64, height: 48, shading, surfaces, samples, ..Default::default() };
            render::picture(&tracer, &case.patches, &radiance, &from_above(), &options).unwrap()
        };
        let paths = truth.get_or_insert_with(|| seen(Shading::Path, Surfaces::Textured, 512));
        let averaged = apart(&seen(Shading::Flat, Surfaces::Averaged, 1), paths);
        assert!(averaged > 0.15, "{averaged}: the picture shows");
        for (shading, most) in [(Shading::Flat, 0.1), (Shading::Smooth, 0.1), (Shading::Gather, 0.05)] {
            let textured = apart(&seen(shading, Surfaces::Textured, 256), paths);
            assert!(textured < most, "{basis:?} {shading:?}: {textured}, averaged {averaged}");
        }
    }
}

#[test]
fn even_light_on_a_picture_shows_the_picture() {
    let scene = gallery();
    let tracer = Tracer::new(&scene);
    let patches =
        Patches::new(&tracer, &Tessellation { size: PatchSize::Edge(0.5), ..Default::default() }).unwrap();
    // Under H = π everywhere, L = Lₑ + ρ.
    let radiance: DMatrix<f64> = patches.emitted_radiance() + patches.reflectances();
    let camera = Camera {
        position: DVec3::new(1.0, 1.0, 1.0),
        target: DVec3::new(1.0, 0.0, 1.0001),
        up: DVec3::Z,
        fov: 20.0,
    };
    for shading in [Shading::Flat, Shading::Smooth] {
        let options = RenderOptions { width: 40, height: 40, shading, ..Default::default() };
        let picture = render::picture(&tracer, &patches, &radiance, &camera, &options).unwrap();
        // The middle of the floor: compare with the picture there, by hand.
        let hit_colour = picture.pixels[20 * 40 + 20];
        let texture = scene.material_of(2).textures.reflectance.clone().unwrap();
        let place = |face: usize| {
            let [a, b, c] = scene.corners(face).map(|p| DVec2::new(p.x, p.z));
            let w = glam::DMat2::from_cols(b - a, c - a).inverse() * (DVec2::new(1.0, 1.0) - a);
            [w.x, w.y]
        };
        let exact = scene.reflectance_texture(2).unwrap().at(place(2));
        assert_eq!(exact, texture.at(DVec2::splat(0.5)));
        for c in 0..3 {
            assert!(
                (f64::from(hit_colour[c]) - 0.9 * exact[c]).abs() < 0.06,
                "{shading:?} {hit_colour:?} {exact:?}"
            );
        }
    }
}

const OBJ: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";

fn png(colour: [u8; 3]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    RgbImage::from_pixel(4, 4, Rgb(colour)).write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn exr(colour: [f32; 3]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    Rgb32FImage::from_pixel(4, 4, Rgb(colour)).write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

/// A scene of one triangle whose material has these lines.
fn load(lines: &str, files: &[(&str, Vec<u8>)]) -> Result<Scene, String> {
    let scratch = Scratch::with(files);
    scratch.write("a.obj", OBJ);
    scratch.write("a.mtl", format!("newmtl m\n{lines}\n"));
    Scene::load(scratch.path("a.obj")).map_err(|e| e.to_string())
}

#[test]
fn pictures_of_bytes_are_srgb_and_those_of_floats_are_linear() {
    let files = [("grey.png", png([188, 188, 0])), ("glow.exr", exr([2.0, 4.0, 8.0]))];
    let scene = load("Kd 0.5\nmap_Kd grey.png\nKe 3 2 1\nmap_Ke glow.exr", &files).unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    let rho = scene.reflectance_texture(0).unwrap().at([0.3, 0.3]);
    assert!((rho[0] - 0.502886).abs() < 1e-5 && rho[2] == 0.0, "{rho:?}");
    assert_eq!(scene.mean_emission(0), [6.0, 8.0, 8.0]);
    // Without a factor the picture is taken as it is.
    let scene = load("map_Kd grey.png\nmap_Ke glow.exr", &files).unwrap();
    assert_eq!(
        (&scene.material_of(0).reflectance[..], &scene.mean_emission(0)[..]),
        (&[1.0; 3][..], &[2.0, 4.0, 8.0][..])
    );
    assert_eq!(scene.warnings(), [""; 0]);
}

#[test]
fn grey_pictures_leave_one_channel() {
    let scene = load("Kd 0.5\nmap_Kd grey.png\nKe 1", &[("grey.png", png([90; 3]))]).unwrap();
    assert_eq!(scene.channels(), 1);
    let scene = load("Kd 0.5\nmap_Kd red.png\nKe 1", &[("red.png", png([90, 10, 10]))]).unwrap();
    assert_eq!(scene.channels(), 3);
}

#[test]
fn materials_do_without_pictures_that_cannot_be_had() {
    let without = |lines: &str, files: &[(&str, Vec<u8>)], wanted: &[&str], reflectance: f64| {
        let scene = load(lines, files).unwrap();
        let said = scene.warnings().join("\n");
        wanted.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
        let material = scene.material_of(0);
        assert!(material.textures.all().next().is_none() && !material.emits(), "{lines}");
        assert_eq!(material.reflectance[0], reflectance, "{lines}");
    };
    without("Kd 0.2\nmap_Kd wood.png", &[], &["wood.png", "not there", "remove the line"], 0.2);
    without("map_Kd -s 2 2 2 my wood.png", &[], &["picture my wood.png", "grey 0.5"], 0.5);
    without("map_Kd a.png", &[("a.png", b"no picture".to_vec())], &["cannot be read", "PNG"], 0.5);
    without("map_Kd a.png", &[("a.png", png([9; 3])[..40].to_vec())], &["cannot be read"], 0.5);
    let broken = exr([1.0, f32::NAN, 1.0]);
    without("Kd 0.1\nmap_Ke a.exr", &[("a.exr", broken)], &["column 0, row 0", "NaN", "repair"], 0.1);
    without("map_Ke a.exr", &[("a.exr", exr([-1.0; 3]))], &["not negative"], 0.5);
    let message = load("Kd 0.8\nmap_Kd a.exr", &[("a.exr", exr([1.5; 3]))]).unwrap_err();
    assert!(message.contains("material m") && message.contains("as high as 1.2"), "{message}");
}

#[test]
fn pictures_are_found_by_their_bare_names_in_any_letter_case() {
    for statement in ["Wood.PNG", "D:\\maps\\wood.png", "/maps/wood.png", "maps\\wood.png", "../WOOD.png"] {
        for place in ["wood.png", "Textures/wood.PNG"] {
            let scratch = Scratch::with(&[
                ("a.obj", OBJ.to_owned()),
                ("a.mtl", format!("newmtl m\nKd 1\nmap_Kd {statement}\n")),
            ]);
            std::fs::create_dir_all(scratch.path("Textures")).unwrap();
            scratch.write(place, png([188; 3]));
            let scene = Scene::load(scratch.path("a.obj")).unwrap();
            assert!(scene.has_textures(), "{statement} {place}: {:?}", scene.warnings());
            let said = scene.warnings().join("\n");
            assert!(said.contains("found by name") && said.contains(statement), "{said}");
        }
    }
}

#[test]
fn what_a_picture_cannot_do_is_warned_of() {
    let files = [("a.png", png([200; 3]))];
    let warned = |obj: &str, lines: &str, wanted: &str| {
        let scratch = Scratch::with(&files);
        scratch.write("a.obj", obj);
        scratch.write("a.mtl", format!("newmtl m\n{lines}\n"));
        let scene = Scene::load(scratch.path("a.obj")).unwrap();
        assert!(
            scene.warnings().len() == 1 && scene.warnings()[0].contains(wanted),
            "{:?}",
            scene.warnings()
        );
        scene
    };
    let bare = OBJ.replace("f 1/1 2/2 3/3", "f 1 2 3");
    let scene = warned(&bare, "Kd 0.5\nmap_Kd a.png", "1 face without texture coordinates");
    let mean = scene.reflectance_texture(0).unwrap().at([0.9, 0.1]);
    assert!((mean[0] - 0.577580).abs() < 1e-5, "{mean:?}");
    let some = OBJ.replace("f 1/1 2/2 3/3", "f 1/1 2 3/3");
    warned(&some, "Kd 0.5\nmap_Kd a.png", "unwrap the mesh");
    warned(OBJ, "Kd 0\nmap_Kd a.png", "multiplied by Kd, which is 0");
    warned(OBJ, "Kd 1\nmap_Kd -blendu off -boost 2 a.png", "no notice is taken of -blendu, -boost");
}

#[test]
fn coordinates_are_the_face_corners_own_and_options_move_them() {
    let mut picture = RgbImage::new(2, 1);
    picture.put_pixel(1, 0, Rgb([255; 3]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let files = [("a.png", bytes.into_inner())];
    // Point [s, t] of the face has coordinates (s, t).
    for (options, point, wanted) in [
        ("", [0.25, 0.1], 0.0),
        ("", [0.75, 0.1], 1.0),
        ("-s 2 1 1", [0.375, 0.1], 1.0),
        ("-o 0.5 0 0", [0.25, 0.1], 1.0),
        ("-clamp on -o 7", [0.0, 0.1], 1.0),
    ] {
        let scene = load(&format!("Kd 1\nmap_Kd {options} a.png"), &files).unwrap();
        assert_eq!(scene.reflectance_texture(0).unwrap().at(point)[0], wanted, "{options}");
    }
}

#[test]
fn one_file_for_two_materials_is_read_once() {
    let scratch = Scratch::with(&[("a.png", png([90; 3]))]);
    scratch.write("a.obj", OBJ.replace("f 1/1", "f 1/1 2/2 3/3\nusemtl n\nf 2/1"));
    scratch.write("a.mtl", "newmtl m\nmap_Kd a.png\nnewmtl n\nKd 0.5\nmap_Kd -s 2 2 2 a.png\n");
    let scene = Scene::load(scratch.path("a.obj")).unwrap();
    let [m, n] = [0, 1].map(|k| scene.materials()[k].textures.reflectance.as_ref().unwrap().pixels.clone());
    assert!(Arc::ptr_eq(&m, &n));
}
