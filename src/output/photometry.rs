//! Photometry: what lighting designers report, in lux; and `receivers.csv`.

use std::io::{self, Write};

use nalgebra::DMatrix;
use serde::Serialize;

use super::table::{digits, write_columns};
use super::to_rgb;
use crate::patches::Patches;
use crate::scene::{Receiver, luminance};

/// The light on some area or on some points, lx.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Illuminance {
    /// `material`, `object` or `receiver`.
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// Area, m²: of the sides that light reaches, or of the receiver.
    pub area: f64,
    /// Mean, weighted by area.
    pub mean: f64,
    /// The lowest mean of a patch, or value at a point.
    pub minimum: f64,
    /// The highest.
    pub maximum: f64,
    /// U₀: minimum / mean; 0 where no light arrives.
    pub uniformity: f64,
    /// U_d: minimum / maximum; 0 where no light arrives.
    pub diversity: f64,
}

impl Illuminance {
    /// Sums up values (lx) with their areas (m²).
    pub fn of(kind: &'static str, name: &str, values: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let area: f64 = values.clone().map(|(_, area)| area).sum();
        let mean = values.clone().map(|(value, area)| value * area).sum::<f64>() / area;
        let minimum = values.clone().map(|(value, _)| value).fold(f64::INFINITY, f64::min);
        let maximum = values.map(|(value, _)| value).fold(0.0, f64::max);
        let ratio = |of: f64| if of > 0.0 { minimum / of } else { 0.0 };
        let (uniformity, diversity) = (ratio(mean), ratio(maximum));
        Self { kind, name: name.to_owned(), area, mean, minimum, maximum, uniformity, diversity }
    }

    /// Every material and object that has patches, from their irradiance (n × c, W·m⁻²) at an efficacy in lm·W⁻¹.
    ///
    /// # Panics
    /// If `irradiance` has not n rows.
    pub fn of_surfaces(patches: &Patches, irradiance: &DMatrix<f64>, efficacy: f64) -> Vec<Self> {
        assert_eq!(irradiance.nrows(), patches.len(), "one row per patch");
        let scene = patches.scene();
        let lux = illuminance(irradiance, efficacy);
        let values = (0..patches.len()).map(|i| (lux[i], patches.area(i)));
        let (mut materials, mut objects) =
            (vec![Vec::new(); scene.materials().len()], vec![Vec::new(); scene.objects().len()]);
        for (i, value) in values.enumerate() {
            let face = &scene.faces()[patches.place(i).face];
            materials[face.material as usize].push(value);
            objects[face.object as usize].push(value);
        }
        let row = |kind, name: &str, members: &Vec<(f64, f64)>| {
            (!members.is_empty()).then(|| Self::of(kind, name, members.iter().copied()))
        };
        let materials = scene.materials().iter().zip(&materials).map(|(m, of)| row("material", &m.name, of));
        let objects = scene.objects().iter().zip(&objects).map(|(name, of)| row("object", name, of));
        materials.chain(objects).flatten().collect()
    }

    /// A receiver, from the irradiance of its points (m × c, W·m⁻²).
    pub fn of_receiver(receiver: &Receiver, irradiance: &DMatrix<f64>, efficacy: f64) -> Self {
        let area = receiver.edges[0].cross(receiver.edges[1]).length() / receiver.len() as f64;
        let lux = illuminance(irradiance, efficacy);
        Self::of("receiver", &receiver.name, lux.iter().map(|&value| (value, area)))
    }
}

/// Illuminance (lx, N × 1) of an irradiance (N × c, W·m⁻²) at an efficacy in lm·W⁻¹.
pub fn illuminance(irradiance: &DMatrix<f64>, efficacy: f64) -> DMatrix<f64> {
    let of = |i: usize, _| efficacy * luminance(irradiance.row(i).transpose().as_slice());
    DMatrix::from_fn(irradiance.nrows(), 1, of)
}

/// Writes `photometry.csv`: a row per material, object and receiver, lx.
///
/// # Errors
/// Those of `writer`.
pub fn write_photometry(writer: &mut dyn Write, rows: &[Illuminance]) -> io::Result<()> {
    let columns = ["kind", "name", "area", "mean", "minimum", "maximum", "uniformity", "diversity"];
    write_columns(writer, &columns, |table| {
        rows.iter().try_for_each(|row| {
            let numbers =
                [row.area, row.mean, row.minimum, row.maximum, row.uniformity, row.diversity].map(digits);
            table.write_record([row.kind.to_owned(), row.name.clone()].into_iter().chain(numbers))
        })
    })
}

/// Writes `receivers.csv`: a row per point, with its irradiance (W·m⁻²) and illuminance (lx).
///
/// # Errors
/// Those of `writer`.
pub fn write_receivers(
    writer: &mut dyn Write,
    receivers: &[(&Receiver, &DMatrix<f64>)],
    efficacy: f64,
) -> io::Result<()> {
    let columns =
        ["receiver", "point", "x", "y", "z", "irradiance_r", "irradiance_g", "irradiance_b", "illuminance"];
    write_columns(writer, &columns, |table| {
        for (receiver, irradiance) in receivers {
            for (i, point) in receiver.points().enumerate() {
                let values = irradiance.row(i).transpose();
                let lux = efficacy * luminance(values.as_slice());
                let numbers = point.to_array().into_iter().chain(to_rgb(values.as_slice())).chain([lux]);
                let keys = [receiver.name.clone(), i.to_string()];
                table.write_record(keys.into_iter().chain(numbers.map(digits)))?;
            }
        }
        Ok(())
    })
}
