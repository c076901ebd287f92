//! Environment: a picture of everything around the scene, by longitude and latitude.
//!
//! The upper edge is straight up and the lower one straight down. With y up the middle of the picture lies
//! towards −z and what is to the right of it towards +x; other ups tilt all of it by the shortest way. `turn`
//! then turns it about up, counter-clockwise seen from above.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::scene::material::{Beyond, Pixels};
use crate::scene::photometry::luminance;

/// Around it goes on, above and below it ends.
const BEYOND: [Beyond; 2] = [Beyond::Repeat, Beyond::Clamp];

/// At least so many columns are looked at to integrate over it.
const COLUMNS: usize = 1024;

/// Radiance by direction, as a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    pixels: Pixels,
    /// From the picture's own directions, y up, to those of the scene.
    frame: DMat3,
}

impl Environment {
    /// Lays a picture around the scene; `up` is a unit vector, `turn` in degrees.
    pub fn new(pixels: Pixels, up: DVec3, turn: f64) -> Self {
        let tilt = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, up));
        Self { pixels, frame: tilt * DMat3::from_rotation_y(turn.to_radians()) }
    }

    /// The same in tones of grey.
    pub fn grey(&self) -> Self {
        Self { pixels: self.pixels.grey(), frame: self.frame }
    }

    /// The picture.
    pub fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// Red, green and blue that come from a direction, a unit vector that points away from the scene.
    #[inline]
    pub fn from(&self, towards: DVec3) -> [f64; 3] {
        self.pixels.at(self.place(towards), BEYOND)
    }

    /// Where in the picture a direction lies, in texels from the left and from the top.
    #[inline]
    pub fn place(&self, towards: DVec3) -> DVec2 {
        let local = self.frame.transpose() * towards;
        let [width, height] = self.pixels.size().map(|count| count as f64);
        let longitude = local.x.atan2(-local.z) / TAU + 0.5;
        DVec2::new(longitude * width, local.y.clamp(-1.0, 1.0).acos() / PI * height)
    }

    /// The direction that lies at a longitude, 0 to 1 from the left, and has this cosine with up.
    #[inline]
    pub fn direction(&self, longitude: f64, cosine: f64) -> DVec3 {
        let (sine, angle) = ((1.0 - cosine * cosine).max(0.0).sqrt(), (longitude - 0.5) * TAU);
        self.frame * DVec3::new(sine * angle.sin(), cosine, -sine * angle.cos())
    }

    /// The cosines with up between which a row of texels lies, the higher one first.
    pub fn row(&self, row: usize) -> [f64; 2] {
        let height = self.pixels.size()[1] as f64;
        [row, row + 1].map(|edge| (PI * edge as f64 / height).cos())
    }

    /// ∫ L cos θ dω over what is above the horizon, by luminance: the irradiance of open level ground.
    pub(crate) fn horizontal(&self) -> f64 {
        let [width, height] = self.pixels.size();
        let finer = COLUMNS.div_ceil(width);
        let (columns, rows) = (finer * width, finer * height);
        let at = |i: usize, j: usize| {
            let place = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / finer as f64;
            luminance(&self.pixels.at(place, BEYOND))
        };
        let ring = |j: usize| {
            // ∫ cos θ sin θ dθ over the row, as far as it is above the horizon.
            let edges = [j, j + 1].map(|edge| (PI * edge as f64 / rows as f64).cos().max(0.0).powi(2));
            let weight = 0.5 * (edges[0] - edges[1]) * TAU / columns as f64;
            if weight > 0.0 { weight * (0..columns).map(|i| at(i, j)).sum::<f64>() } else { 0.0 }
        };
        (0..rows).map(ring).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight columns and four rows, each texel its own value.
    fn numbered() -> Pixels {
        Pixels::new(8, 4, (0..32).map(|k| [k as f32; 3]).collect())
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn the_middle_of_the_picture_lies_ahead_and_what_is_right_of_it_to_the_right() {
        let around = Environment::new(numbered(), DVec3::Y, 0.0);
        for (towards, place) in [
            (-DVec3::Z, DVec2::new(4.0, 2.0)),
            (DVec3::X, DVec2::new(6.0, 2.0)),
            (-DVec3::X, DVec2::new(2.0, 2.0)),
            (DVec3::new(0.0, 1.0, -1.0).normalize(), DVec2::new(4.0, 1.0)),
        ] {
            assert!((around.place(towards) - place).length() < 1e-9, "{towards}");
        }
        // Straight up and down are the edges.
        assert!(near(around.place(DVec3::Y).y, 0.0) && near(around.place(-DVec3::Y).y, 4.0));
        assert_eq!(around.from(DVec3::new(1.0, 0.0, -1.0).normalize()), [0.5 * (12.5 + 20.5); 3]);
    }

    #[test]
    fn an_environment_turns_about_up_counter_clockwise_and_tilts_with_it() {
        let turned = Environment::new(numbered(), DVec3::Y, 90.0);
        assert!((turned.place(-DVec3::X) - DVec2::new(4.0, 2.0)).length() < 1e-9);
        let tilted = Environment::new(numbered(), DVec3::Z, 0.0);
        assert!((tilted.place(DVec3::Y) - DVec2::new(4.0, 2.0)).length() < 1e-9);
        assert!((tilted.place(DVec3::X) - DVec2::new(6.0, 2.0)).length() < 1e-9);
    }

    #[test]
    fn a_direction_lies_at_the_place_it_was_made_from() {
        let around = Environment::new(numbered(), DVec3::new(0.3, 0.5, -0.4).normalize(), 33.0);
        for k in 0..100 {
            let (longitude, cosine) = ((f64::from(k) + 0.5) / 100.0, (f64::from(k) * 0.7).sin());
            let place = around.place(around.direction(longitude, cosine));
            assert!(near(place.x, 8.0 * longitude) && near(place.y, 4.0 * cosine.acos() / PI));
        }
    }

    #[test]
    fn level_ground_gets_what_the_closed_form_says() {
        let even = Environment::new(Pixels::new(2, 1, vec![[3.0; 3]; 2]), DVec3::Y, 0.0);
        assert!((even.horizontal() / (3.0 * PI) - 1.0).abs() < 1e-9);
        // L = 1 + cos² θ: ∫ = 2π (1/2 + 1/4).
        let texel =
            |k: usize| [1.0 + ((k / 64) as f64 + 0.5).mul_add(PI / 128.0, 0.0).cos().powi(2) as f32; 3];
        let graded =
            Environment::new(Pixels::new(64, 128, (0..64 * 128).map(texel).collect()), DVec3::Y, 0.0);
        assert!((graded.horizontal() / (1.5 * PI) - 1.0).abs() < 3e-4, "{}", graded.horizontal() / PI);
    }
}
