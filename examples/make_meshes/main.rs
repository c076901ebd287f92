//! Builds the example scenes and writes each as OBJ (shape), MTL (paint) and TOML (camera, lights):
//!
//! ```text
//! cargo run --release --example make_meshes              # into meshes/
//! cargo run --release --example make_meshes -- FOLDER    # somewhere else
//! ```
//!
//! Lengths are metres and y points up. A face's front is the side from which its corners run
//! counter-clockwise; rooms front inward, furniture outward, and only the front of a lamp shines.
//! Walls that meet share their corners, so a closed room is closed to the last bit. Where two
//! solids touch, the smaller one leaves out the side that is hidden, so no two faces overlap.
//!
//! At the end every mesh's area is held against a formula that knows nothing of the mesh.

mod carriers; // mirrors, metals, glass, plastic
mod cornell_box; // what every renderer is first asked for
mod furnaces; // where every answer is known: a cube, a sphere
mod furnished_room; // a living room
mod lit; // sun and sky, and spots
mod measured; // a luminaire's file, and a picture of the sky
mod plates; // two plates that face each other
mod sheets; // a blind and a lampshade
mod textured; // pictures on surfaces
mod two_rooms; // two rooms and a doorway

mod areas; // by formula
mod furniture; // tables, chairs, a bookcase, a sofa, a picture
mod mesh; // polygons, boxes, spheres
mod scene; // a scene and its three files

use std::path::PathBuf;
use std::process::ExitCode;
use std::{env, fs, io};

fn main() -> io::Result<ExitCode> {
    let folder = env::args_os().nth(1).map_or("meshes".into(), PathBuf::from);
    fs::create_dir_all(&folder)?;

    let scenes = [
        cornell_box::cornell_box(),
        furnaces::furnace_cube(),
        furnaces::furnace_sphere(),
        plates::facing_plates(),
        two_rooms::two_rooms(),
        furnished_room::furnished_room(),
        carriers::mirror_room(),
        carriers::glass_balls(),
        carriers::glossy_floor(),
        carriers::sun_catcher(),
        carriers::plastic_toys(),
        lit::daylit_room(),
        lit::spot_gallery(),
        sheets::blinds(),
        textured::textured_room(),
        measured::office(),
        measured::pavilion(),
    ];
    textured::write_pictures(&folder)?;
    measured::write_files(&folder)?;
    let mut all_right = true;
    for scene in &scenes {
        scene.write(&folder)?;

        // Hold the area of what was written against the formula.
        let (faces, area) = (scene.mesh.face_count(), scene.mesh.area());
        let shortfall = 1.0 - area / scene.area;
        let right = shortfall.abs() <= scene.tolerance;
        all_right &= right;
        println!(
            "{:<15}{faces:>5} faces {area:>11.6} m², by formula {:>10.6} m², short by {shortfall:>8.1e}{}",
            scene.name,
            scene.area,
            if right { "" } else { "  MISMATCH" },
        );
    }
    Ok(if all_right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
