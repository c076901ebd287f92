//! Table: `study.csv` and `study_reference.csv`, from which a study can be resumed.
//!
//! Every row ends with the key of its study ([`Study::key`]); rows of another are not read. Numbers are
//! written such that reading gives the same bits.

use std::io::{self, Read, Write};

use crate::scene::triangle;
use serde::{Deserialize, Serialize};

use crate::measure::{ReferenceSide, Study, StudyReference, StudyRow};
use crate::scene::{Scene, Side};

/// Column of the key.
const KEY: &str = "study";

/// Writes `study.csv`: a row per way of solving.
///
/// # Errors
/// Those of `writer`.
pub fn write_study_table(writer: &mut dyn Write, study: &Study) -> io::Result<()> {
    #[derive(Serialize)]
    struct Keyed<'a> {
        study: &'a str,
    }
    let mut table = csv::Writer::from_writer(writer);
    let key = spelt(study.key());
    for row in study.rows() {
        table.serialize((row, Keyed { study: &key }))?;
    }
    table.flush()
}

/// One side of a face and channel of `study_reference.csv`.
#[derive(Serialize, Deserialize)]
struct Known {
    face: usize,
    side: String,
    area: f64,
    channel: usize,
    irradiance: f64,
    standard_error: f64,
    degrees_of_freedom: f64,
    /// Of the whole reference.
    paths: u64,
    seconds: f64,
    study: String,
}

/// Writes `study_reference.csv`: a row per side of a face and channel.
///
/// # Errors
/// Those of `writer`.
pub fn write_study_reference(
    writer: &mut dyn Write,
    study: &Study,
    reference: &StudyReference,
) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(writer);
    for side in &reference.sides {
        for (channel, (&irradiance, &standard_error)) in
            side.mean.iter().zip(&side.standard_error).enumerate()
        {
            table.serialize(Known {
                face: side.face,
                side: side.side.name().to_owned(),
                area: side.area,
                channel,
                irradiance,
                standard_error,
                degrees_of_freedom: side.degrees_of_freedom,
                paths: reference.paths,
                seconds: reference.seconds,
                study: spelt(study.key()),
            })?;
        }
    }
    table.flush()
}

/// Reads what earlier runs of the same study have found; none where the reference is of another, or either
/// table is not what [`write_study_reference`] and [`write_study_table`] write of this scene.
pub fn read_study(
    study: &Study,
    table: impl Read,
    reference: impl Read,
) -> Option<(StudyReference, Vec<StudyRow>)> {
    let key = spelt(study.key());
    let reference = read_reference(reference, &key).filter(|found| is_of(found, study.scene()))?;
    let mut table = csv::Reader::from_reader(table);
    let headers = table.headers().ok()?.clone();
    let at = headers.iter().position(|name| name == KEY)?;
    let own = table.records().filter_map(Result::ok).filter(|record| record.get(at) == Some(&key));
    let rows: Vec<StudyRow> =
        own.map(|record| record.deserialize(Some(&headers)).ok()).collect::<Option<_>>()?;
    rows.iter().all(is_sound).then_some((reference, rows))
}

/// Whether a reference is one of a scene's faces, each side once and by every channel.
fn is_of(reference: &StudyReference, scene: &Scene) -> bool {
    let is_amount = |x: &f64| x.is_finite() && *x >= 0.0;
    let is_sound = |side: &ReferenceSide| {
        side.face < scene.faces().len()
            && side.area > 0.0
            && side.area <= triangle::area(&scene.corners(side.face)) * (1.0 + 1e-9)
            && side.mean.len() == scene.channels()
            && side.mean.iter().all(is_amount)
            && side.standard_error.iter().chain([&side.degrees_of_freedom]).all(|x| *x >= 0.0)
    };
    let mut places: Vec<(usize, Side)> = reference.sides.iter().map(|side| (side.face, side.side)).collect();
    places.sort_unstable();
    let once = places.windows(2).all(|pair| pair[0] != pair[1]);
    once && is_amount(&reference.seconds) && reference.sides.iter().all(is_sound)
}

/// Whether a row has numbers that measuring could give.
fn is_sound(row: &StudyRow) -> bool {
    let amounts = [row.seconds, row.error, row.error_se, row.leak, row.solve_seconds];
    row.patches > 0
        && row.repeats > 0
        && row.bias.is_finite()
        && amounts.iter().all(|x| x.is_finite() && *x >= 0.0)
        && row.solve_seconds <= row.seconds
}

fn read_reference(reference: impl Read, key: &str) -> Option<StudyReference> {
    let mut found = StudyReference { sides: Vec::new(), paths: 0, seconds: 0.0 };
    for known in csv::Reader::from_reader(reference).into_deserialize() {
        let known: Known = known.ok()?;
        if known.study != key {
            return None;
        }
        (found.paths, found.seconds) = (known.paths, known.seconds);
        let side = Side::BOTH.into_iter().find(|side| side.name() == known.side)?;
        if known.channel == 0 {
            found.sides.push(ReferenceSide {
                face: known.face,
                side,
                area: known.area,
                mean: Vec::new(),
                standard_error: Vec::new(),
                degrees_of_freedom: known.degrees_of_freedom,
            });
        }
        let row = found.sides.last_mut()?;
        row.mean.push(known.irradiance);
        row.standard_error.push(known.standard_error);
    }
    (!found.sides.is_empty()).then_some(found)
}

/// A key as tables spell it.
fn spelt(key: u64) -> String {
    format!("{key:016x}")
}
