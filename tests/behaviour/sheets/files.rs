//! Sheets in files: settings, pictures on them, and how bad ones are refused.

use radiosity::patches::{Basis, PatchSize, Sheets};
use radiosity::scene::{Material, Pixels, Scene, SceneError, SceneParts, Side, Texture, Textures};

use super::{around, factors};
use crate::scenes::parts_of;
use crate::scratch::Scratch;

#[test]
fn a_picture_on_a_sheet_varies_what_it_reflects_and_not_what_comes_through() {
    let texels = (0..64).map(|k| [if k % 2 == 0 { 0.2 } else { 0.8 }; 3]).collect();
    let textures =
        Textures { reflectance: Some(Texture::new(Pixels::new(8, 8, texels))), ..Default::default() };
    let sheet = Material::diffuse("sheet", &[0.6; 3]).with_sheet(&[1.0; 3], &[0.19; 3]);
    let textured = |material: Material| Material { textures: textures.clone(), ..material };
    let scene = around(textured(sheet.clone()));
    let (patches, _) = factors(&scene, PatchSize::Count(100), (Basis::Constant, 64));
    let rho = patches.reflectances();
    let Sheets { pairs, transmittance } = patches.sheets().unwrap();
    for (p, &[front, back]) in pairs.iter().enumerate() {
        // Faces without texture coordinates have the mean of the picture.
        for (found, exact) in [(rho[(front, 0)], 0.3), (rho[(back, 0)], 0.5), (transmittance[(p, 0)], 0.19)] {
            assert!((found - exact).abs() < 1e-7, "{found} {exact}");
        }
    }
    let too_bright = sheet.with_sheet(&[1.0; 3], &[0.21; 3]);
    let materials = scene.materials()[..3].iter().cloned().chain([textured(too_bright)]).collect();
    let refused = Scene::new(SceneParts { materials, ..parts_of(&scene) });
    let message = refused.unwrap_err().to_string();
    assert!(
        ["material sheet", "reflectance_back 0.8", "0.21", "lower"].iter().all(|word| message.contains(word)),
        "{message}"
    );
}

/// A square of a material named paper with these lines in the MTL file and the settings.
fn square_with(mtl: &str, settings: &str) -> Result<Scene, SceneError> {
    let obj = "mtllib a.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nusemtl paper\nf 1 2 3 4\n";
    let mtl = format!("newmtl paper\n{mtl}\n");
    let folder = Scratch::with(&[("a.obj", obj), ("a.mtl", &mtl), ("a.toml", settings)]);
    Scene::load(folder.path("a.obj"))
}

#[test]
fn settings_make_sheets_of_materials() {
    let sheet = |settings: &str| {
        let scene = square_with("Kd 0.5 0.4 0.3\nd 0.2", &format!("[material.paper]\n{settings}")).unwrap();
        let material = scene.materials()[0].clone();
        let side = |side: Side| material.reflectance_of(side).to_vec();
        (side(Side::Front), side(Side::Back), material.transmittance().map(<[f64]>::to_vec))
    };
    let kd = vec![0.5, 0.4, 0.3];
    assert_eq!(sheet("transmittance = 0.25"), (kd.clone(), kd.clone(), Some(vec![0.25; 3])));
    assert_eq!(sheet("reflectance_back = [0.1, 0.2, 0.3]"), (kd.clone(), vec![0.1, 0.2, 0.3], None));
    assert_eq!(
        sheet("reflectance = 0.5\nreflectance_back = 0.3\ntransmittance = 0.25"),
        (vec![0.5], vec![0.3], Some(vec![0.25])),
        "one channel where all agree"
    );
    assert_eq!(
        sheet("reflectance = 0.5\ntransmittance = [0.25, 0.5, 0.1]"),
        (vec![0.5; 3], vec![0.5; 3], Some(vec![0.25, 0.5, 0.1]))
    );
    assert_eq!(sheet("emission = 0"), (kd.clone(), kd, None), "d is no transmittance");
    let glossy = square_with("Kd 0.5 0.5 0.5\nPr 0.5", "[material.paper]\ntransmittance = 0.25").unwrap();
    assert!(glossy.materials()[0].transmittance().is_some());
    assert!(glossy.warnings().iter().any(|line| line.contains("paper") && line.contains("matt")));
}

#[test]
fn bad_sheets_are_refused_with_their_line_and_a_remedy() {
    // A key that is named alone is told by its line, else the head.
    for (mtl, settings, at, words) in [
        ("Kd 0.5 0.5 0.5", "transmittance = 0.6", 3, ["reflectance 0.5", "transmittance 0.6", "lower"]),
        (
            "Kd 0.3 0.3 0.3",
            "reflectance_back = 0.8\ntransmittance = 0.3",
            2,
            ["reflectance_back 0.8", "0.3", "lower"],
        ),
        ("Kd 0.3 0.3 0.3", "transmittance = [0.1, 0.2, 0.8]", 3, ["transmittance 0.8", "0.3", "lower"]),
        ("Kd 0.3 0.3 0.3", "transmittance = -0.1", 3, ["transmittance -0.1", "between", "0 and 1"]),
        ("Kd 0.3 0.3 0.3", "reflectance_back = nan", 3, ["reflectance_back NaN", "between", "0 and 1"]),
        ("Ks 1 1 1\nillum 3", "transmittance = 0.1", 3, ["transmittance", "diffuse", "material of its own"]),
    ] {
        let error = square_with(mtl, &format!("\n[material.paper]\n{settings}")).unwrap_err();
        let SceneError::Parse { line, message, .. } = &error else { panic!("{error}") };
        assert!(*line == at && message.contains("material paper"), "{error}");
        assert!(words.iter().all(|word| message.contains(word)), "{settings}: {error}");
    }
}
