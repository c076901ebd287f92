//! Form factors of one side over its whole area: known values, closure, reciprocity, bounds on what no ray
//! found, which sides are meant.

mod bounds; // upper bounds on what few rays find
mod closure; // rows sum to one, reciprocity
mod command; // --sides, inconsistent winding, scenes without lamps
mod known_values; // closed forms and integrals
mod sides; // one side over its whole area, backs by themselves

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use radiosity::output::{FactorEntry, FactorTable};
use radiosity::patches::{GroupBy, Groups, PatchSize, Patches, Reach, Tessellation};
use radiosity::progress::Progress;
use radiosity::scene::{Scene, Side};
use radiosity::trace::Tracer;
use radiosity::transport::{FormFactors, Keep, TraceOptions};

use crate::program::radiosity;
use crate::scratch::Scratch;

/// How finely a table is found.
#[derive(Clone, Copy)]
struct Effort {
    patches: usize,
    rays: u32,
    seed: u64,
}

/// Form factors from the fronts of objects, and from their backs too where everything is reached.
fn by_object(scene: &Scene, reach: Reach, effort: Effort, then: impl FnOnce(&FactorTable)) {
    let Effort { patches, rays, seed } = effort;
    let tracer = Tracer::new(scene);
    let options = Tessellation { size: PatchSize::Count(patches), reach, seed, ..Default::default() };
    let mut patches = Patches::new(&tracer, &options).unwrap();
    let options =
        TraceOptions { rays: Some(rays), lamp_rays: Some(0), seed, keep: Keep::Rays, ..Default::default() };
    let factors = FormFactors::trace(&tracer, &mut patches, &options).unwrap();
    let sends = |_: usize, side: Side| reach == Reach::Everything || side == Side::Front;
    let groups = Groups::new(&patches, GroupBy::Object, sends);
    let between = factors.between_groups(&patches, groups.of_patch(), Progress::default()).unwrap();
    then(&FactorTable::between_groups(&patches, &groups, &between, rays));
}

const FRONTS: Reach = Reach::OneSide(Side::Front);

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/view_factors").join(format!("{name}.obj"))
}

/// The place of a group in a table.
fn place(table: &FactorTable, name: &str) -> usize {
    table.groups().all().iter().position(|group| group.name == name).unwrap()
}

fn factor(table: &FactorTable, from: &str, to: &str) -> FactorEntry {
    table.full_row(place(table, from))[place(table, to)]
}

/// The records of `form-factors`, by name of column, and what it warns of.
#[track_caller]
fn records(scratch: &Scratch, arguments: &str) -> (Vec<BTreeMap<String, String>>, String) {
    let output = radiosity(
        scratch.folder(),
        &format!("form-factors {arguments} -o f.csv --quiet --patches 400 --rays 64"),
    );
    let quiet = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {quiet}");
    let told =
        radiosity(scratch.folder(), &format!("form-factors {arguments} -o g.csv --patches 20 --rays 8"));
    let text = fs::read_to_string(scratch.path("f.csv")).unwrap();
    let mut csv = csv::Reader::from_reader(text.as_bytes());
    let records = csv.deserialize().map(|record| record.unwrap()).collect();
    (records, String::from_utf8(told.stderr).unwrap())
}
