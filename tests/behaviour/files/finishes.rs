//! Which materials are plastic, mirrors, glass and metals.

use radiosity::scene::Surface;
use radiosity::transport::Plan;

use super::{loaded, mtl, refusal, says};

#[test]
fn plastic_is_told_from_what_exporters_write_everywhere() {
    let on = |lines: &str| -> Vec<&str> {
        let plan = Plan::new(&loaded(&mtl(&format!("Kd 0.5\n{lines}"))));
        plan.effects.iter().filter(|e| e.on && e.reason == "m").map(|e| e.effect).collect()
    };
    for lines in ["Pr 0.3", "Pm 0.2", "illum 5\nNs 100"] {
        assert_eq!(on(lines), ["plastic"], "{lines:?}");
    }
    for lines in ["illum 0", "illum 1\nKs 0.9", "illum 2\nKs 1 1 1\nNs 90"] {
        assert_eq!(on(lines), [""; 0], "{lines:?}: exporters write a meaningless Ks everywhere");
    }
}

#[test]
fn mirrors_and_glass_are_recognised_by_their_illumination_model() {
    let surface = |lines: &str| {
        let scene = loaded(&mtl(lines));
        (scene.materials()[0].surface.clone(), scene.warnings().len())
    };
    let mirror = |r: f64| Surface::Mirror { reflectance: vec![r] };
    let glass = |index: f64, t: f64| Surface::Dielectric { index, filter: vec![t] };
    assert_eq!(surface("illum 3\nKs 0.9"), (mirror(0.9), 0));
    assert_eq!(surface("illum 3"), (mirror(1.0), 1));
    assert_eq!(surface("illum 3\nKs 0.9\nKd 0.5"), (mirror(0.9), 1));
    for model in [4, 6, 7, 9] {
        // A lone triangle of glass has no inside either.
        assert_eq!(surface(&format!("illum {model}\nNi 1.33\nTf 0.8")), (glass(1.33, 0.8), 1));
        assert_eq!(surface(&format!("illum {model}")), (glass(1.5, 1.0), 2));
    }
    assert_eq!(surface("illum 3\nKs 0.9\nKd 0.5\nKe 1"), (Surface::Diffuse, 1));
}

#[test]
fn metals_are_recognised_by_their_metalness_or_their_highlight_without_a_base() {
    let metal = |lines: &str| {
        let scene = loaded(&mtl(lines));
        match scene.materials()[0].surface.clone() {
            Surface::Conductor { reflectance, roughness } => {
                (reflectance[0], (1000.0 * roughness).round() / 1000.0, scene.warnings().len())
            }
            other => panic!("{lines}: {other:?}"),
        }
    };
    assert_eq!(metal("Kd 0.8\nPm 1\nPr 0.4"), (0.8, 0.4, 0));
    assert_eq!(metal("Kd 0.8\nPm 0.6\nPr 0.4"), (0.8, 0.4, 1));
    assert_eq!(metal("Pm 1"), (1.0, 0.3, 2));
    // α² = 2/(Ns + 2) is 0.02.
    assert_eq!(metal("Ks 0.9\nNs 98\nillum 5"), (0.9, 0.376, 0));
    assert_eq!(metal("Kd 0\nKs 0.9\nNs 98\nPr 0.2\nillum 5"), (0.9, 0.2, 0));
    let lamp = loaded(&mtl("Kd 0.5\nKe 1\nPm 1\nPr 0.3"));
    assert_eq!((lamp.materials()[0].surface.clone(), lamp.warnings().len()), (Surface::Diffuse, 1));
}

#[test]
fn refuses_mirrors_and_glass_that_cannot_be() {
    for (lines, words) in [
        ("illum 4\nNi 0", ["material m", "index of refraction 0", "1.5"]),
        ("illum 4\nNi 1.5\nTf 1.2", ["material m", "filter 1.2", "between 0 and 1"]),
        ("illum 3\nKs 1.5", ["material m", "mirror reflectance 1.5", "between 0 and 1"]),
        ("illum 5\nKs 1.5", ["material m", "reflectance 1.5 of a metal", "between 0 and 1"]),
    ] {
        says(&refusal(&mtl(lines)), &words);
    }
}

#[test]
fn glass_without_an_inside_is_named_with_what_to_do() {
    let tetrahedron = |faces: &str| {
        let text = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl pane\n{faces}");
        let scene = loaded(&[("a.obj", text.as_str()), ("a.mtl", "newmtl pane\nillum 4\nNi 1.5\n")]);
        scene.warnings().join("\n")
    };
    assert_eq!(tetrahedron("f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"), "");
    says(&tetrahedron("f 1 3 2\nf 1 2 4\nf 1 4 3\n"), &["material pane", "no inside", "close the mesh"]);
    says(&tetrahedron("f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n"), &["material pane", "no inside"]);
    says(&tetrahedron("f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"), &["material pane", "inside out", "flip"]);
}
