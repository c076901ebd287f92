//! Faces: how far an answer is from one that another program found for the same faces.

use super::constants::TOO_NOISY;
use crate::patches::FaceRow;
use crate::reference::ReferenceRow;

/// How far an answer is from a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeRms {
    /// Area-weighted relative root mean square difference, the reference's noise taken off.
    pub value: f64,
    /// That noise, in the same norm.
    pub noise: f64,
    /// Number of values that were compared.
    pub compared: usize,
}

impl RelativeRms {
    /// Compares irradiance by face: √((ΣA(H − H_ref)² − ΣA se²) / ΣA H_ref²), over all channels.
    ///
    /// Rows of the reference that `faces` lacks, and values whose standard error exceeds a fifth of them, are
    /// left out. An answer of one channel is compared with every channel of the reference.
    pub fn of(faces: &[FaceRow], reference: &[ReferenceRow]) -> Self {
        let (mut difference, mut noise, mut whole, mut compared) = (0.0, 0.0, 0.0, 0);
        for row in reference {
            let Some(face) = faces.iter().find(|f| (f.face, f.side) == (row.face, row.side)) else {
                continue;
            };
            for (c, (mean, error)) in row.mean.iter().zip(&row.standard_error).enumerate() {
                if *error < TOO_NOISY * mean {
                    let value = face.mean[c.min(face.mean.len() - 1)];
                    difference += face.area * (value - mean).powi(2);
                    noise += face.area * error * error;
                    whole += face.area * mean * mean;
                    compared += 1;
                }
            }
        }
        let relative = |squared: f64| (squared.max(0.0) / whole).sqrt();
        Self { value: relative(difference - noise), noise: relative(noise), compared }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Side;

    #[test]
    fn noise_is_taken_off_and_noisy_values_are_left_out() {
        let face = |face: usize, h: f64| FaceRow { face, side: Side::Front, area: 2.0, mean: vec![h] };
        let row = |face: usize, mean: f64, error: f64| ReferenceRow {
            face,
            side: Side::Front,
            mean: vec![mean],
            standard_error: vec![error],
        };
        let reference = [row(0, 1.0, 0.1), row(1, 2.0, 0.1), row(2, 1.0, 0.5)];
        let rms = RelativeRms::of(&[face(0, 1.1), face(1, 1.8), face(2, 9.0)], &reference);
        assert_eq!(rms.compared, 2);
        assert!((rms.value - ((0.01 + 0.04 - 0.02) / 5.0f64).sqrt()).abs() < 1e-12);
        assert!((rms.noise - (0.02 / 5.0f64).sqrt()).abs() < 1e-12);
    }
}
