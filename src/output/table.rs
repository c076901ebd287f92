//! Tables: radiance and irradiance by face and by patch, as CSV.

use std::io::{self, Write};

use nalgebra::DMatrix;

use super::to_rgb;
use crate::patches::Patches;
use crate::solve::Solution;

/// Columns of radiometric tables after their keys.
const QUANTITIES: [&str; 6] =
    ["irradiance_r", "irradiance_g", "irradiance_b", "radiance_r", "radiance_g", "radiance_b"];

/// Writes `faces.csv`: a row per face and side that light reaches, with averages over the face.
///
/// `irradiance` (W·m⁻²) and `radiance` (W·sr⁻¹·m⁻²) are n × c.
///
/// # Errors
/// Those of `writer`.
pub fn write_faces(
    writer: &mut dyn Write,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
) -> io::Result<()> {
    write(writer, &FACE_KEYS, |table| write_face_rows(table, patches, None, (irradiance, radiance)))
}

/// Writes `lamp_groups.csv`: the rows of `faces.csv` for each group of lamps by itself, with the group's name in front.
///
/// # Errors
/// Those of `writer`.
pub fn write_lamp_groups(
    writer: &mut dyn Write,
    patches: &Patches,
    groups: &[(&str, &Solution)],
) -> io::Result<()> {
    let keys: Vec<&str> = std::iter::once("lamps").chain(FACE_KEYS).collect();
    write(writer, &keys, |table| {
        groups.iter().try_for_each(|&(name, solution)| {
            write_face_rows(table, patches, Some(name), (&solution.irradiance, &solution.radiance))
        })
    })
}

const FACE_KEYS: [&str; 5] = ["face", "side", "object", "material", "area"];

fn write_face_rows(
    table: &mut csv::Writer<&mut dyn Write>,
    patches: &Patches,
    group: Option<&str>,
    (irradiance, radiance): (&DMatrix<f64>, &DMatrix<f64>),
) -> csv::Result<()> {
    let scene = patches.scene();
    for (h, l) in patches.average_by_face(irradiance).into_iter().zip(patches.average_by_face(radiance)) {
        let face = &scene.faces()[h.face];
        let keys = [
            h.face.to_string(),
            h.side.name().to_owned(),
            scene.objects()[face.object as usize].clone(),
            scene.material_of(h.face).name.clone(),
            digits(h.area),
        ];
        let row = group.map(str::to_owned).into_iter().chain(keys).chain(quantities(&h.mean, &l.mean));
        table.write_record(row)?;
    }
    Ok(())
}

/// Writes `patches.csv`: a row per patch, with its centre in metres.
///
/// # Errors
/// Those of `writer`.
pub fn write_patches(
    writer: &mut dyn Write,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
) -> io::Result<()> {
    let row = |field: &DMatrix<f64>, i: usize| field.row(i).iter().copied().collect::<Vec<f64>>();
    write(writer, &["patch", "face", "side", "cx", "cy", "cz", "area"], |table| {
        for i in 0..patches.len() {
            let (place, centre) = (patches.place(i), patches.centre(i));
            let keys = [
                i.to_string(),
                place.face.to_string(),
                place.side.name().to_owned(),
                digits(centre.x),
                digits(centre.y),
                digits(centre.z),
                digits(patches.area(i)),
            ];
            table.write_record(keys.into_iter().chain(quantities(&row(irradiance, i), &row(radiance, i))))?;
        }
        Ok(())
    })
}

fn quantities(irradiance: &[f64], radiance: &[f64]) -> impl Iterator<Item = String> {
    to_rgb(irradiance).into_iter().chain(to_rgb(radiance)).map(digits)
}

/// Writes a table with the columns of `keys` and [`QUANTITIES`].
fn write(
    writer: &mut dyn Write,
    keys: &[&str],
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> csv::Result<()>,
) -> io::Result<()> {
    let columns: Vec<&str> = keys.iter().chain(&QUANTITIES).copied().collect();
    write_columns(writer, &columns, rows)
}

/// Writes a table with these columns.
pub(super) fn write_columns(
    writer: &mut dyn Write,
    columns: &[&str],
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> csv::Result<()>,
) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(writer);
    table.write_record(columns)?;
    rows(&mut table)?;
    table.flush()
}

/// A number with nine significant digits, without trailing zeros.
pub(super) fn digits(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let magnitude = x.abs().log10().floor();
    if !(-4.0..9.0).contains(&magnitude) {
        let text = format!("{x:.8e}");
        let (number, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", number.trim_end_matches('0').trim_end_matches('.'));
    }
    let text = format!("{x:.*}", (8 - magnitude as i32).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_have_nine_digits_and_no_trailing_zeros() {
        assert_eq!(digits(0.1 + 0.2), "0.3");
        assert_eq!(digits(2.0 / 3.0), "0.666666667");
        assert_eq!(digits(-1.5e-7), "-1.5e-7");
        assert_eq!(digits(0.0), "0");
        assert_eq!(digits(123456.7890123), "123456.789");
    }
}
