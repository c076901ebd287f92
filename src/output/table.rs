//! Tables: radiance and irradiance by face and by patch, as CSV.

use std::io::{self, Write};
use std::path::Path;

use nalgebra::DMatrix;

use super::{OutputError, replace, to_rgb};
use crate::patches::Patches;

/// Columns of radiometric tables after their keys.
const QUANTITIES: [&str; 6] =
    ["irradiance_r", "irradiance_g", "irradiance_b", "radiance_r", "radiance_g", "radiance_b"];

/// Writes `faces.csv`: a row per face and side that light reaches, with averages over the face.
///
/// `irradiance` (W·m⁻²) and `radiance` (W·sr⁻¹·m⁻²) are n × c.
///
/// # Errors
/// If the file can't be written.
pub fn write_faces(
    path: &Path,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
) -> Result<(), OutputError> {
    let scene = patches.scene();
    let rows = patches.average_by_face(irradiance).into_iter().zip(patches.average_by_face(radiance));
    write(path, &["face", "side", "object", "material", "area"], |table| {
        for (h, l) in rows {
            let face = &scene.faces()[h.face];
            let keys = [
                h.face.to_string(),
                h.side.name().to_owned(),
                scene.objects()[face.object as usize].clone(),
                scene.material_of(h.face).name.clone(),
                digits(h.area),
            ];
            table.write_record(keys.into_iter().chain(quantities(&h.mean, &l.mean)))?;
        }
        Ok(())
    })
}

/// Writes `patches.csv`: a row per patch, with its centre in metres.
///
/// # Errors
/// If the file can't be written.
pub fn write_patches(
    path: &Path,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
) -> Result<(), OutputError> {
    let row = |field: &DMatrix<f64>, i: usize| field.row(i).iter().copied().collect::<Vec<f64>>();
    write(path, &["patch", "face", "side", "cx", "cy", "cz", "area"], |table| {
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

fn write(
    path: &Path,
    keys: &[&str],
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> csv::Result<()>,
) -> Result<(), OutputError> {
    replace(path, |file| {
        let mut table = csv::Writer::from_writer(file);
        table
            .write_record(keys.iter().chain(&QUANTITIES))
            .and_then(|()| rows(&mut table))
            .map_err(io::Error::from)?;
        table.flush()
    })
}

/// A number with nine significant digits, without trailing zeros.
pub(super) fn digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.8e}").parse().unwrap_or(x);
    if rounded != 0.0 && !(1e-4..1e9).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
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
