//! Photometry: what lighting designers report, in lumens, lux and candelas per square metre; and
//! `receivers.csv`.

use std::io::{self, Write};

use nalgebra::DMatrix;
use serde::Serialize;

use super::table::{digits, write_columns};
use crate::measure::{Darkness, ErrorBars, ReceiverBars, lit_points};
use crate::patches::Patches;
use crate::render::to_rgb;
use crate::scene::{Light, Scene, luminance};
use crate::transport::Received;

/// How a quantity is spread over some area or over some points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Levels {
    /// Mean, weighted by area; of surfaces over the whole area of the sides that are not
    /// [dark](Darkness).
    pub mean: f64,
    /// The lowest mean of a patch that is not dark, or value at a point.
    pub minimum: f64,
    /// The highest.
    pub maximum: f64,
    /// U₀: minimum / mean; 0 where there is nothing.
    pub uniformity: f64,
    /// U_d: minimum / maximum; 0 where there is nothing.
    pub diversity: f64,
}

impl Levels {
    /// Sums up values with their areas; none where there are no values.
    pub fn of(values: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let (mut area, mut whole, mut minimum, mut maximum) = (0.0, 0.0, f64::INFINITY, 0.0f64);
        for (value, part) in values {
            area += part;
            whole += value * part;
            minimum = minimum.min(value);
            maximum = maximum.max(value);
        }
        let mean = whole / area;
        let ratio = |of: f64| if of > 0.0 { minimum / of } else { 0.0 };
        let (uniformity, diversity) = (ratio(mean), ratio(maximum));
        (area > 0.0).then_some(Self { mean, minimum, maximum, uniformity, diversity })
    }
}

/// One standard error of each of some levels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelErrors {
    /// Of the mean.
    pub mean: f64,
    /// Of the lowest value; not of surfaces, where it is lower the smaller patches are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum: Option<f64>,
    /// Of the uniformity U₀; the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uniformity: Option<f64>,
}

/// The light of a lamp, or on a material, an object or a receiver.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Photometry {
    /// `material`, `object`, `light` or `receiver`.
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// Area, m²: of the sides of faces that are not dark, lit all over or not, or of the receiver; none of a
    /// light without area.
    pub area: Option<f64>,
    /// Luminous flux that it emits, lm; none of receivers and of suns, whose flux has no end.
    pub emitted: Option<f64>,
    /// Illuminance, lx.
    pub illuminance: Option<Levels>,
    /// Luminance, cd/m²; of surfaces.
    pub luminance: Option<Levels>,
    /// How wrong the illuminance may be, lx.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub illuminance_error: Option<LevelErrors>,
}

impl Photometry {
    /// Every material and object that has patches, from their irradiance (W·m⁻²) and radiance (W·sr⁻¹·m⁻²),
    /// each n × c, and the error bars of that irradiance.
    ///
    /// # Panics
    /// If any has not n rows.
    pub fn of_surfaces(
        patches: &Patches,
        irradiance: &DMatrix<f64>,
        radiance: &DMatrix<f64>,
        bars: &ErrorBars,
    ) -> Vec<Self> {
        let scene = patches.scene();
        let [lux, candelas] = [irradiance, radiance].map(|field| luminous(field, scene.efficacy()));
        let emitted = luminous(&patches.emitted_radiance(), scene.efficacy());
        assert!(lux.len() == patches.len() && candelas.len() == patches.len(), "one row per patch");
        let darkness = Darkness::of(patches, &lux);
        let hidden: Vec<(usize, usize, f64)> = patches
            .dark_areas()
            .into_iter()
            .map(|(face, side, area)| (face, patches.patches_of(face, side).start, area))
            .collect();
        let groups = |kind, names: Vec<&str>, of: &dyn Fn(usize) -> u32| -> Vec<Self> {
            let mut members = vec![Vec::new(); names.len()];
            (0..patches.len()).for_each(|i| members[of(patches.place(i).face) as usize].push(i));
            // Dark sides count only where there is nothing else.
            for members in &mut members {
                if members.iter().any(|&i| !darkness.sides[i]) {
                    members.retain(|&i| !darkness.sides[i]);
                }
            }
            let mut dark = vec![0.0; names.len()];
            for &(face, first, area) in &hidden {
                let group = of(face) as usize;
                let counts = members[group].binary_search(&first).is_ok();
                dark[group] += if counts { area } else { 0.0 };
            }
            let row = |((name, members), dark): ((&str, Vec<usize>), f64)| {
                let lit: f64 = members.iter().map(|&i| patches.area(i)).sum();
                let levels = |field: &DMatrix<f64>| {
                    let of = |members: &mut dyn Iterator<Item = usize>| {
                        Levels::of(members.map(|i| (field[i], patches.area(i))))
                    };
                    let all = of(&mut members.iter().copied())?;
                    // What is hidden counts in the mean alone: under the foot of a chair nobody looks for the
                    // lowest value.
                    let seen =
                        of(&mut members.iter().copied().filter(|&i| !darkness.patches[i])).unwrap_or(all);
                    let mean = all.mean * lit / (lit + dark);
                    let uniformity = if mean > 0.0 { seen.minimum / mean } else { 0.0 };
                    Some(Levels { mean, uniformity, ..seen })
                };
                let flux = |&i: &usize| std::f64::consts::PI * patches.area(i) * emitted[i];
                let illuminance = levels(&lux);
                let over: Vec<(usize, f64)> =
                    members.iter().map(|&i| (i, patches.area(i) / (lit + dark))).collect();
                let lux = |irradiance: &[f64]| scene.efficacy() * luminance(irradiance);
                let error = |levels: Levels| LevelErrors {
                    mean: bars.standard_error_of_mean(levels.mean, &over, lux),
                    minimum: None,
                    uniformity: None,
                };
                Self {
                    kind,
                    name: name.to_owned(),
                    area: Some(lit + dark),
                    emitted: Some(members.iter().map(flux).sum()),
                    illuminance,
                    luminance: levels(&candelas),
                    illuminance_error: illuminance.map(error),
                }
            };
            let all = names.into_iter().zip(members).zip(dark);
            all.filter(|((_, members), _)| !members.is_empty()).map(row).collect()
        };
        let materials = scene.materials().iter().map(|material| material.name.as_str()).collect();
        let objects = scene.objects().iter().map(String::as_str).collect();
        let mut rows = groups("material", materials, &|face| scene.faces()[face].material);
        rows.extend(groups("object", objects, &|face| scene.faces()[face].object));
        rows
    }

    /// Every light without area that shines.
    pub fn of_lights(scene: &Scene) -> Vec<Self> {
        let row = |(number, light): (usize, &Light)| {
            let emitted = light.flux().map(|flux| scene.efficacy() * luminance(&flux));
            let name = format!("{} {}", light.kind(), number + 1);
            Self {
                kind: "light",
                name,
                area: None,
                emitted,
                illuminance: None,
                luminance: None,
                illuminance_error: None,
            }
        };
        scene.lights().enumerate().map(row).collect()
    }

    /// What a receiver measures and how wrong that may be, at an efficacy in lm·W⁻¹; of its points within the
    /// margin that [get light](lit_points).
    pub fn of_receiver(received: &Received, bars: &ReceiverBars, efficacy: f64) -> Self {
        let Received { receiver, irradiance, .. } = received;
        let area = receiver.edges[0].cross(receiver.edges[1]).length();
        let lux = luminous(irradiance, efficacy);
        let part = area / receiver.len() as f64;
        let counted = receiver.inner().zip(lit_points(received)).map(|(is_inner, is_lit)| is_inner && is_lit);
        let inner: Vec<usize> = counted.enumerate().filter(|(_, counts)| *counts).map(|(i, _)| i).collect();
        let illuminance = Levels::of(inner.iter().map(|&i| (lux[i], part)));
        let illuminance_error = illuminance.map(|levels| {
            let lowest = inner.iter().copied().find(|&i| lux[i] == levels.minimum).unwrap_or(0);
            let mean = |field: &DMatrix<f64>| luminous(&field.select_rows(&inner), efficacy).mean();
            let minimum = |field: &DMatrix<f64>| luminous(&field.rows(lowest, 1).into_owned(), efficacy)[0];
            let uniformity = |field: &DMatrix<f64>| {
                if levels.mean > 0.0 {
                    (minimum(field) - levels.uniformity * mean(field)) / levels.mean
                } else {
                    0.0
                }
            };
            LevelErrors {
                mean: bars.standard_error(mean),
                minimum: Some(bars.standard_error(minimum)),
                uniformity: Some(bars.standard_error(uniformity)),
            }
        });
        Self {
            kind: "receiver",
            name: receiver.name.clone(),
            area: Some(area),
            emitted: None,
            illuminance,
            luminance: None,
            illuminance_error,
        }
    }
}

/// Illuminance (lx) of an irradiance (W·m⁻²), or luminance (cd·m⁻²) of a radiance (W·sr⁻¹·m⁻²), N × c, at an
/// efficacy in lm·W⁻¹; N × 1.
pub fn luminous(field: &DMatrix<f64>, efficacy: f64) -> DMatrix<f64> {
    let value = |i: usize, _| efficacy * luminance(field.row(i).transpose().as_slice());
    DMatrix::from_fn(field.nrows(), 1, value)
}

/// Writes `photometry.csv`: a row per material, object, light and receiver, each column with its unit.
///
/// # Errors
/// Those of `writer`.
pub fn write_photometry(writer: &mut dyn Write, rows: &[Photometry]) -> io::Result<()> {
    let mut columns: Vec<String> = ["kind", "name", "area_m2", "emitted_lm"].map(str::to_owned).to_vec();
    for (quantity, unit) in [("illuminance", "lx"), ("luminance", "cd_m2")] {
        columns.extend(["mean", "minimum", "maximum"].map(|level| format!("{quantity}_{level}_{unit}")));
        columns.extend(["u0", "ud"].map(|ratio| format!("{quantity}_{ratio}")));
    }
    columns
        .extend(["mean_error_lx", "minimum_error_lx", "u0_error"].map(|name| format!("illuminance_{name}")));
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    write_columns(writer, &columns, |table| {
        rows.iter().try_for_each(|row| {
            let levels = [row.illuminance, row.luminance].into_iter().flat_map(|levels| match levels {
                None => [None; 5],
                Some(l) => [l.mean, l.minimum, l.maximum, l.uniformity, l.diversity].map(Some),
            });
            let errors = row.illuminance_error.map_or([None; 3], |e| [Some(e.mean), e.minimum, e.uniformity]);
            let numbers = [row.area, row.emitted].into_iter().chain(levels).chain(errors);
            let numbers = numbers.map(|number| number.map_or_else(String::new, digits));
            table.write_record([row.kind.to_owned(), row.name.clone()].into_iter().chain(numbers))
        })
    })
}

/// Writes `faces_photometric.csv`: a row per face and side that light reaches, with means over the face; from
/// irradiance (W·m⁻²) and radiance (W·sr⁻¹·m⁻²), each n × c.
///
/// # Errors
/// Those of `writer`.
pub fn write_luminous_faces(
    writer: &mut dyn Write,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
) -> io::Result<()> {
    let scene = patches.scene();
    let [lux, candelas] =
        [irradiance, radiance].map(|field| patches.average_by_face(&luminous(field, scene.efficacy())));
    let columns = ["face", "side", "object", "material", "area_m2", "illuminance_lx", "luminance_cd_m2"];
    write_columns(writer, &columns, |table| {
        lux.iter().zip(&candelas).try_for_each(|(lux, candelas)| {
            let object = scene.faces()[lux.face].object as usize;
            let keys = [lux.face.to_string(), lux.side.name().to_owned(), scene.objects()[object].clone()];
            let material = [scene.material_of(lux.face).name.clone()];
            let numbers = [lux.area, lux.mean[0], candelas.mean[0]].map(digits);
            table.write_record(keys.into_iter().chain(material).chain(numbers))
        })
    })
}

/// Writes `patches_photometric.csv`: a row per patch, with its centre in metres; from irradiance (W·m⁻²) and
/// radiance (W·sr⁻¹·m⁻²), each n × c.
///
/// # Errors
/// Those of `writer`.
pub fn write_luminous_patches(
    writer: &mut dyn Write,
    patches: &Patches,
    irradiance: &DMatrix<f64>,
    radiance: &DMatrix<f64>,
) -> io::Result<()> {
    let efficacy = patches.scene().efficacy();
    let [lux, candelas] = [irradiance, radiance].map(|field| luminous(field, efficacy));
    let columns =
        ["patch", "face", "side", "cx_m", "cy_m", "cz_m", "area_m2", "illuminance_lx", "luminance_cd_m2"];
    write_columns(writer, &columns, |table| {
        (0..patches.len()).try_for_each(|i| {
            let place = patches.place(i);
            let keys = [i.to_string(), place.face.to_string(), place.side.name().to_owned()];
            let numbers =
                patches.centre(i).to_array().into_iter().chain([patches.area(i), lux[i], candelas[i]]);
            table.write_record(keys.into_iter().chain(numbers.map(digits)))
        })
    })
}

/// Writes `receivers.csv`: a row per point, with its irradiance (W·m⁻²), illuminance (lx) and one standard
/// error of its irradiance.
///
/// # Errors
/// Those of `writer`.
pub fn write_receivers(
    writer: &mut dyn Write,
    receivers: &[(&Received, &ReceiverBars)],
    efficacy: f64,
) -> io::Result<()> {
    let mut columns = vec!["receiver", "point", "x", "y", "z"];
    columns.extend(["irradiance_r", "irradiance_g", "irradiance_b", "illuminance"]);
    columns.extend(["error_r", "error_g", "error_b"]);
    write_columns(writer, &columns, |table| {
        for (Received { receiver, irradiance, .. }, bars) in receivers {
            for (i, point) in receiver.points().enumerate() {
                let values = irradiance.row(i).transpose();
                let lux = efficacy * luminance(values.as_slice());
                let errors = bars.points.row(i).transpose();
                let numbers = point.to_array().into_iter().chain(to_rgb(values.as_slice())).chain([lux]);
                let numbers = numbers.chain(to_rgb(errors.as_slice()));
                let keys = [receiver.name.clone(), i.to_string()];
                table.write_record(keys.into_iter().chain(numbers.map(digits)))?;
            }
        }
        Ok(())
    })
}
