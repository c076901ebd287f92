//! Tables: radiance and irradiance by face and by patch, as CSV.

use std::io::{self, Write};

use nalgebra::DMatrix;

use crate::measure::ErrorBars;
use crate::patches::{FaceRow, Patches};
use crate::render::to_rgb;
use crate::solve::Solution;

/// Columns of radiometric tables after their keys; the last three, one standard error of irradiance, where
/// that is known.
const QUANTITIES: [&str; 9] = [
    "irradiance_r",
    "irradiance_g",
    "irradiance_b",
    "radiance_r",
    "radiance_g",
    "radiance_b",
    "error_r",
    "error_g",
    "error_b",
];

/// How many of [`QUANTITIES`] there are without errors.
const WITHOUT_ERRORS: usize = 6;

/// Writes `faces.csv`: a row per face and side that light reaches, with averages over the face, one standard
/// error of irradiance, and the number of the face's polygon.
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
    errors: &ErrorBars,
) -> io::Result<()> {
    let columns: Vec<&str> = FACE_KEYS.iter().chain(&QUANTITIES).chain(&["polygon"]).copied().collect();
    let errors = Some(errors.faces.as_slice());
    write_columns(writer, &columns, |table| {
        write_face_rows(table, patches, None, [irradiance, radiance], errors)
    })
}

/// Writes `lamp_groups.csv`: the rows of `faces.csv` for each group of lamps by itself, with the group's name
/// in front.
///
/// # Errors
/// Those of `writer`.
pub fn write_lamp_groups(
    writer: &mut dyn Write,
    patches: &Patches,
    groups: &[(&str, &Solution)],
) -> io::Result<()> {
    let quantities = QUANTITIES.into_iter().take(WITHOUT_ERRORS);
    let columns: Vec<&str> = std::iter::once("lamps").chain(FACE_KEYS).chain(quantities).collect();
    write_columns(writer, &columns, |table| {
        groups.iter().try_for_each(|&(name, solution)| {
            write_face_rows(table, patches, Some(name), [&solution.irradiance, &solution.radiance], None)
        })
    })
}

const FACE_KEYS: [&str; 5] = ["face", "side", "object", "material", "area"];

fn write_face_rows(
    table: &mut csv::Writer<&mut dyn Write>,
    patches: &Patches,
    group: Option<&str>,
    [irradiance, radiance]: [&DMatrix<f64>; 2],
    errors: Option<&[FaceRow]>,
) -> csv::Result<()> {
    let scene = patches.scene();
    let rows = patches.average_by_face(irradiance).into_iter().zip(patches.average_by_face(radiance));
    for (f, (h, l)) in rows.enumerate() {
        let face = &scene.faces()[h.face];
        let keys = [
            h.face.to_string(),
            h.side.name().to_owned(),
            scene.objects()[face.object as usize].clone(),
            scene.material_of(h.face).name.clone(),
            digits(h.area),
        ];
        let row = group.map(str::to_owned).into_iter().chain(keys).chain(quantities(&h.mean, &l.mean));
        let polygon = errors.map(|_| scene.polygon_of(h.face).to_string());
        let errors = errors.into_iter().flat_map(|rows| to_rgb(&rows[f].mean)).map(digits);
        table.write_record(row.chain(errors).chain(polygon))?;
    }
    Ok(())
}

/// Writes `patches.csv`: a row per patch, with its centre in metres, and one standard error of irradiance.
///
/// # Errors
/// Those of `writer`.
pub fn write_patches(
    writer: &mut dyn Write,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
    errors: &ErrorBars,
) -> io::Result<()> {
    let columns: Vec<&str> =
        ["patch", "face", "side", "cx", "cy", "cz", "area"].into_iter().chain(QUANTITIES).collect();
    let row = |field: &DMatrix<f64>, i: usize| field.row(i).iter().copied().collect::<Vec<f64>>();
    write_columns(writer, &columns, |table| {
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
            let fields = [irradiance, radiance, &errors.patches].map(|field| row(field, i));
            let values = fields.iter().flat_map(|values| to_rgb(values)).map(digits);
            table.write_record(keys.into_iter().chain(values))?;
        }
        Ok(())
    })
}

fn quantities(irradiance: &[f64], radiance: &[f64]) -> impl Iterator<Item = String> {
    to_rgb(irradiance).into_iter().chain(to_rgb(radiance)).map(digits)
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
    significant(x, 9)
}

/// A number with so many significant digits, without trailing zeros.
pub(super) fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let magnitude = x.abs().log10().floor();
    if !(-4.0..digits as f64).contains(&magnitude) {
        let text = format!("{x:.*e}", digits - 1);
        let (number, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", number.trim_end_matches('0').trim_end_matches('.'));
    }
    let text = format!("{x:.*}", (digits as i32 - 1 - magnitude as i32).max(0) as usize);
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
