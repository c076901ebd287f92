//! Form factors as files: what is written can be read back, and means what it says.

mod command; // the command: what it writes, prints and refuses
mod estimates; // reciprocity, closure, no bias
mod formats; // what CSV, Matrix Market and NumPy files hold

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use radiosity::output::{FactorTable, write_form_factors};
use radiosity::patches::{GroupBy, Groups, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Material, Scene};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, TraceOptions};

use crate::scenes::{quads, room};
use crate::scratch::{Scratch, names};

/// A cube from whose six objects its last one is missing, and a sheet in its middle.
fn open_cube_with_a_sheet() -> Scene {
    let sheet = [[0.2, 0.3, 0.5], [0.8, 0.3, 0.5], [0.8, 0.7, 0.5], [0.2, 0.7, 0.5]];
    let mut all: Vec<_> = room([0.0; 3], [1.0; 3])[..5].iter().map(|&quad| (quad, 0)).collect();
    all.push((sheet, 1));
    quads(&all, vec![Material::diffuse("wall", &[0.5]), Material::diffuse("sheet", &[0.0])])
}

fn traced(scene: &Scene, then: impl FnOnce(&Patches, &FormFactors)) {
    let tracer = Tracer::new(scene);
    let options =
        Tessellation { size: PatchSize::Count(200), reach: Reach::Everything, ..Default::default() };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options = TraceOptions { rays: Some(64), lamp_rays: Some(0), keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    then(&patches, &factors);
}

/// Hands on what is known between the groups of a scene.
fn grouped(scene: &Scene, by: GroupBy, then: impl FnOnce(&FactorTable)) {
    traced(scene, |patches, factors| {
        let groups = Groups::new(patches, by, |_, _| true);
        let between = factors.between_groups(patches, groups.of_patch(), Progress::default()).unwrap();
        then(&FactorTable::between_groups(patches, &groups, &between, factors.rays()));
    });
}

/// A written file.
fn written(table: &FactorTable, name: &str) -> Scratch {
    let scratch = Scratch::new();
    write_form_factors(&scratch.path(name), table).unwrap();
    assert_eq!(names(scratch.folder()), [name]);
    scratch
}

/// The header of a CSV file, and its records.
fn csv_of(path: &Path) -> (String, Vec<Vec<String>>) {
    let text = fs::read_to_string(path).unwrap();
    let records = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
    (text.lines().next().unwrap().to_owned(), records.map(|record| record.unwrap()).collect())
}

/// Form factor and standard error by the names of a pair.
fn pairs(path: &Path) -> BTreeMap<(String, String), (f64, f64)> {
    let (header, records) = csv_of(path);
    assert_eq!(header, "from,to,form_factor,standard_error,from_area,escape,escape_error,upper95");
    let number = |text: &String| text.parse().unwrap();
    let pair = |r: &Vec<String>| ((r[0].clone(), r[1].clone()), (number(&r[2]), number(&r[3])));
    records.iter().map(pair).collect()
}
