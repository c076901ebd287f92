//! The pictures of render and solve.

use super::{CUBE, done};
use crate::program::text;
use crate::scratch::{Scratch, content, names};

#[test]
fn render_writes_a_picture_and_nothing_else() {
    let scratch = Scratch::new();
    done(scratch.folder(), "render -o .");
    assert_eq!(names(scratch.folder()), ["image.png"]);
    assert_eq!(image::image_dimensions(scratch.path("image.png")).unwrap(), (80, 60));
    done(scratch.folder(), "render -o . --exr --shading flat --outlines");
    assert_eq!(names(scratch.folder()), ["image.exr", "image.png"]);
}

#[test]
fn every_shading_is_saved_as_png_and_exr_with_the_same_bytes_on_any_number_of_threads() {
    let scratch = Scratch::new();
    let mut pictures = Vec::new();
    for shading in ["flat", "smooth", "gather", "path"] {
        for threads in [1, 3] {
            let arguments = format!(
                "render -o {shading}{threads} --exr --shading {shading} --samples 4 --threads {threads}"
            );
            done(scratch.folder(), &arguments);
        }
        let [one, three] = [1, 3].map(|threads| content(&scratch.path(&format!("{shading}{threads}"))));
        assert_eq!(one.keys().collect::<Vec<_>>(), ["image.exr", "image.png"]);
        assert!(one == three, "{shading}");
        pictures.push(one);
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 4, "each shading looks different");
    done(scratch.folder(), "render -o seed --exr --shading gather --samples 4 --seed 5");
    assert!(content(&scratch.path("seed"))["image.exr"] != pictures[2]["image.exr"]);
}

#[test]
fn a_camera_that_sees_nothing_lit_is_warned_about() {
    let scratch = Scratch::with(&[
        ("cube.obj", CUBE),
        ("cube.mtl", "newmtl wall\nKd 0.5\nnewmtl last\nKd 0.5\nKe 1\n"),
        ("cube.toml", "[camera]\nposition = [5, 0.5, 0.5]\ntarget = [9, 0.5, 0.5]\n"),
    ]);
    let output = done(scratch.folder(), "render cube.obj -o .");
    assert!(text(&output.stderr).contains("warning: the picture is black"), "{}", text(&output.stderr));
    let seen = image::open(scratch.path("image.png")).unwrap().into_rgb8();
    assert!(seen.pixels().all(|pixel| pixel.0 == [0; 3]));
    scratch.write("cube.toml", "");
    let output = done(scratch.folder(), "render cube.obj -o .");
    assert!(!text(&output.stderr).contains("black"));
}

#[test]
fn render_and_solve_make_the_same_picture() {
    let scratch = Scratch::new();
    done(scratch.folder(), "render -o rendered");
    done(scratch.folder(), "solve -o solved");
    let [rendered, solved] =
        ["rendered", "solved"].map(|folder| content(&scratch.path(folder)).remove("image.png"));
    assert!(rendered.is_some() && rendered == solved);
}

#[test]
fn vertex_normals_smooth_the_picture_and_change_no_table() {
    let camera = "[camera]\nposition = [0.9, 0.5, 0.5]\ntarget = [0.0, 0.0, 0.0]\n";
    let normals =
        "vn 1 1 1\nvn 1 -1 1\nvn 1 -1 -1\nvn 1 1 -1\nvn -1 1 -1\nvn -1 -1 -1\nvn -1 -1 1\nvn -1 1 1\n";
    let smooth: String = CUBE
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => {
                let corners: String = corners.split(' ').map(|k| format!(" {k}//{k}")).collect();
                format!("f{corners}\n")
            }
            None => format!("{line}\n"),
        })
        .collect();
    let [flat, round] = [CUBE.to_owned(), smooth].map(|text| {
        let scratch = Scratch::with(&[
            ("cube.obj", format!("{normals}{text}")),
            ("cube.mtl", "newmtl wall\nKd 0.5\nKe 1\nnewmtl last\nKd 0\n".to_owned()),
            ("cube.toml", camera.to_owned()),
        ]);
        done(scratch.folder(), "solve cube.obj -o .");
        content(scratch.folder())
    });
    assert!(flat["image.png"] != round["image.png"] && flat["mesh.ply"] != round["mesh.ply"]);
    assert!(flat["patches.csv"] == round["patches.csv"] && flat["faces.csv"] == round["faces.csv"]);
}
