//! What settings of lights mean, and how bad ones are refused.

use std::f64::consts::PI;

use glam::DVec3;
use radiosity::scene::{Light, Scene, SceneError};

use crate::scratch::Scratch;

/// A floor with these settings beside it.
fn floor_with(settings: &str) -> Result<Scene, SceneError> {
    let obj = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";
    let folder = Scratch::with(&[("floor.obj", obj), ("floor.toml", settings)]);
    Scene::load(folder.path("floor.obj"))
}

#[test]
fn watts_and_lumens_mean_the_same_light() {
    let power = |settings: &str| floor_with(settings).unwrap().lights().next().unwrap().power().to_vec();
    let point = |amount: &str| power(&format!("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n{amount}"));
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 1e-9);
    assert_eq!(point("intensity = 2"), [2.0]);
    assert!(close(&point("luminous_intensity = 1366"), &[2.0]));
    assert!(close(&point("flux = 25.132741228718345"), &[2.0]));
    assert!(close(&point("luminous_flux = 17165.662259214629"), &[2.0]));
    let tinted = point("luminous_intensity = 683\ncolour = [1.0, 0.5, 0.0]");
    assert!((radiosity::scene::luminance(&tinted) - 1.0).abs() < 1e-12 && tinted[0] == 2.0 * tinted[1]);
    let radiance =
        power("efficacy = 179\n[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nilluminance = 358\n");
    assert!(close(&radiance, &[2.0]));
    let overcast = floor_with("[sky]\nkind = \"overcast\"\nilluminance = 10000").unwrap();
    let zenith = overcast.sky().unwrap().zenith[0];
    assert!((683.0 * zenith * 7.0 * PI / 9.0 / 10000.0 - 1.0).abs() < 1e-12);
}

#[test]
fn lengths_of_lights_are_in_the_unit_of_the_scene() {
    let scene = floor_with(
        "unit = 0.01\n[[light]]\nkind = \"spot\"\nposition = [0, 100, 0]\ntarget = [0, 0, 0]\ncone = 30\nflux = 5\n",
    );
    let scene = scene.unwrap();
    let Some(Light::Spot { position, direction, .. }) = scene.lights().next() else { panic!("a spot") };
    assert_eq!((*position, *direction), (DVec3::Y, DVec3::NEG_Y));
}

#[test]
fn numbers_are_refused_as_they_are_written_and_with_what_they_may_be() {
    let spot = "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\ncone = 30\nflux = 1\n";
    for (settings, line, words) in [
        ("efficacy = 1e-300\n".to_owned(), 1, ["efficacy = 1e-300", "from 1e-30 to 1e30"]),
        (
            "efficacy = 1e-29\n[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nluminous_flux = 1000\n"
                .into(),
            5,
            ["luminous_flux comes to 7.9", "at most 1e30"],
        ),
        (
            spot.replace("flux = 1", "flux = 1e300") + "direction = [0, -1, 0]\n",
            5,
            ["flux 1e300", "at most 1e30"],
        ),
        (
            spot.replace("[0, 1, 0]", "[0, 1e300, 0]") + "direction = [0, -1, 0]\n",
            3,
            ["[0, 1e300, 0]", "1e30 m"],
        ),
        (format!("{spot}target = [0, 1, 0]\n"), 1, ["target [0, 1, 0]", "move one of them"]),
    ] {
        let error = floor_with(&settings).unwrap_err();
        let SceneError::Parse { line: found, message, .. } = &error else { panic!("{error}") };
        assert!(*found == line && words.iter().all(|word| message.contains(word)), "{settings}: {error}");
    }
    let long = floor_with("[[light]]\nkind = \"sun\"\ndirection = [0, -1e300, 0]\nirradiance = 1\n").unwrap();
    let Some(Light::Sun { direction, .. }) = long.lights().next() else { panic!("a sun") };
    assert_eq!(*direction, DVec3::NEG_Y);
}

#[test]
fn bad_lights_are_refused_with_their_line_and_a_remedy() {
    for (settings, line, words) in [
        ("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\n", 1, "luminous_flux"),
        ("\n[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nflux = 1\nintensity = 1\n", 2, "one of"),
        ("[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nflux = -1\n", 4, "not negative"),
        ("[[light]]\nkind = \"point\"\nposition = [0, nan, 0]\nflux = 1\n", 3, "finite"),
        ("[[light]]\nkind = \"lava\"\nposition = [0, 1, 0]\nflux = 1\n", 2, "lava"),
        ("[[light]]\nkind = \"sun\"\ndirection = [0, 0, 0]\nirradiance = 1\n", 3, "no direction"),
        (
            "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\ndiameter = 200\n",
            5,
            "diameter",
        ),
        (
            "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\ncone = 20\npenumbra = 30\nflux = 1\n",
            1,
            "penumbra",
        ),
        ("[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\ncone = 20\nflux = 1\n", 1, "target"),
        (
            "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nflux = 1\ncolour = [1, 0, 0]\n",
            1,
            "leave out colour",
        ),
        ("[sky]\nkind = \"overcast\"\n", 1, "illuminance"),
        ("[sky]\nkind = \"overcast\"\nradiance = 1\nground = 2\n", 4, "ground"),
        ("[sky]\nkind = \"clear\"\nradiance = 1\nsun = [0, -1, 0]\n", 4, "horizon"),
        ("efficacy = 0\n", 1, "efficacy"),
    ] {
        let error = floor_with(settings).unwrap_err();
        let SceneError::Parse { line: found, message, .. } = &error else { panic!("{error}") };
        assert!(*found == line && message.contains(words), "{settings}: {error}");
    }
}
