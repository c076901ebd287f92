//! Luminaires: luminous intensity by direction, as photometric files give it.
//!
//! In the frame of a luminaire a vertical angle θ of 0 is its axis, usually straight down, and 180 the way
//! back; a horizontal angle φ of 0 is the half-plane C0, and φ grows counter-clockwise seen from behind the
//! luminaire, which is from above. Between the angles of the table intensity is bilinear, outside it is none.
//!
//! Tables are by such angles (type C), or by those about another axis: of type B about the horizontal axis
//! across C0, of type A about C0 itself (IESNA LM-63; CIE 121). The latter are the same tables, turned.

mod eulumdat;
mod lm63;
mod numbers;

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

/// More angles of a kind than this are refused.
const MOST_ANGLES: usize = 10_000;

/// Luminous intensity by direction, cd.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityTable {
    /// θ about the table's pole, ascending, degrees.
    vertical: Vec<f64>,
    /// φ about it, ascending, degrees.
    horizontal: Vec<f64>,
    /// By φ, then θ.
    candela: Vec<f64>,
    highest: f64,
    symmetry: Symmetry,
    /// From the luminaire's frame, C0, C90 and the axis, to that of the table's pole.
    turn: Option<DMat3>,
    /// What is sent of it when the luminaire is tilted by an angle from straight down, degrees and share.
    tilt: Vec<[f64; 2]>,
    /// Luminous width, length and height, metres; negative where they are diameters.
    size: [f64; 3],
}

/// What lies at horizontal angles that a table does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Symmetry {
    /// The same all around.
    Round,
    /// The table has 0 to 90, and the rest is its image in both planes.
    Quarter,
    /// It has 0 to 180.
    Half,
    /// It has 90 to 270.
    OtherHalf,
    /// It has all of them.
    Whole,
    /// Nothing.
    Sector,
}

impl IntensityTable {
    /// Reads the text of a photometric file: LM-63 (`.ies`), or EULUMDAT (`.ldt`), which has no line `TILT=`.
    /// Lamp multiplier and ballast factor are in the intensities then; what the user should know of is added
    /// to `warnings`.
    ///
    /// # Errors
    /// What is wrong and what to do, with the line from 1.
    pub fn parse(text: &str, warnings: &mut Vec<String>) -> Result<Self, (usize, String)> {
        match lm63::tilt(text) {
            None if eulumdat::looks_like(text) => eulumdat::parse(text, warnings),
            tilt => lm63::parse(text, tilt, warnings),
        }
    }

    /// The highest intensity, cd.
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// What part of its light a luminaire sends that is tilted by this angle from straight down, degrees:
    /// lamps may burn less brightly then.
    pub fn tilt_factor(&self, angle: f64) -> f64 {
        let angles: Vec<f64> = self.tilt.iter().map(|pair| pair[0]).collect();
        let (Some(first), Some(last)) = (angles.first(), angles.last()) else { return 1.0 };
        let (k, share) = between(&angles, angle.clamp(*first, *last)).unwrap_or((0, 0.0));
        let factor = |k: usize| self.tilt[k.min(self.tilt.len() - 1)][1];
        factor(k) + (factor(k + 1) - factor(k)) * share
    }

    /// Width, length and height of what shines, metres; negative where one is a diameter, 0 where nothing is
    /// said.
    pub fn luminous_size(&self) -> [f64; 3] {
        self.size
    }

    /// Intensity at a vertical and a horizontal angle of the luminaire, degrees; cd.
    #[inline]
    pub fn at(&self, vertical: f64, horizontal: f64) -> f64 {
        match &self.turn {
            None => self.about_pole(vertical, horizontal),
            Some(turn) => {
                let (up, around) = (vertical.to_radians(), horizontal.to_radians());
                let towards = *turn * DVec3::new(up.sin() * around.cos(), up.sin() * around.sin(), up.cos());
                let vertical = towards.z.clamp(-1.0, 1.0).acos().to_degrees();
                self.about_pole(vertical, towards.y.atan2(towards.x).to_degrees())
            }
        }
    }

    /// Intensity at angles about the table's pole, degrees; cd.
    #[inline]
    fn about_pole(&self, vertical: f64, horizontal: f64) -> f64 {
        let Some((j, t)) = between(&self.vertical, vertical) else { return 0.0 };
        let Some((i, s)) = between(&self.horizontal, self.folded(horizontal)) else { return 0.0 };
        let row = |i: usize| {
            let row = &self.candela[i * self.vertical.len()..][..self.vertical.len()];
            row[j] + (row[(j + 1).min(row.len() - 1)] - row[j]) * t
        };
        let here = row(i);
        if s > 0.0 { here + (row(i + 1) - here) * s } else { here }
    }

    /// The angle of the table at which the same is sent as at a horizontal angle.
    fn folded(&self, horizontal: f64) -> f64 {
        let turned = horizontal.rem_euclid(360.0);
        match self.symmetry {
            Symmetry::Round => self.horizontal[0],
            Symmetry::Quarter => {
                let half = turned % 180.0;
                half.min(180.0 - half)
            }
            Symmetry::Half => turned.min(360.0 - turned),
            Symmetry::OtherHalf if !(90.0..=270.0).contains(&turned) => (180.0 - turned).rem_euclid(360.0),
            Symmetry::OtherHalf | Symmetry::Whole => turned,
            Symmetry::Sector if turned > 180.0 => turned - 360.0,
            Symmetry::Sector => turned,
        }
    }

    /// Luminous flux, lm: the exact integral of intensity over all directions.
    pub fn flux(&self) -> f64 {
        let rows: Vec<f64> =
            self.candela.chunks_exact(self.vertical.len()).map(|row| self.over_vertical(row)).collect();
        if self.symmetry == Symmetry::Round {
            return TAU * rows[0];
        }
        let span = self.horizontal[self.horizontal.len() - 1] - self.horizontal[0];
        let part = |k: usize| 0.5 * (rows[k] + rows[k + 1]) * (self.horizontal[k + 1] - self.horizontal[k]);
        let whole = if self.symmetry == Symmetry::Sector { span.to_radians() } else { TAU };
        (0..rows.len() - 1).map(part).sum::<f64>() / span * whole
    }

    /// ∫ I sin θ dθ over a row, I linear between its angles: [−I cos θ + I′ sin θ].
    fn over_vertical(&self, row: &[f64]) -> f64 {
        let piece = |k: usize| {
            let [a, b] = [self.vertical[k], self.vertical[k + 1]].map(f64::to_radians);
            let slope = (row[k + 1] - row[k]) / (b - a);
            row[k] * a.cos() - row[k + 1] * b.cos() + slope * (b.sin() - a.sin())
        };
        (0..row.len() - 1).map(piece).sum()
    }
}

/// The interval of ascending numbers in which one lies, and how far in; none outside.
#[inline]
fn between(numbers: &[f64], x: f64) -> Option<(usize, f64)> {
    let last = numbers.len() - 1;
    if !(numbers[0]..=numbers[last]).contains(&x) {
        return None;
    }
    let k = (numbers.partition_point(|&number| number <= x) - 1).min(last.saturating_sub(1));
    let share = if last == 0 { 0.0 } else { (x - numbers[k]) / (numbers[k + 1] - numbers[k]) };
    Some((k, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with these angles, and candelas by both.
    fn file(head: &str, vertical: &[f64], horizontal: &[f64], candela: impl Fn(f64, f64) -> f64) -> String {
        let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let mut text = format!(
            "{head}\nTILT=NONE\n1 1000 2 {} {} 1 2 0.1 0.1 0\n0.5 1 30\n",
            vertical.len(),
            horizontal.len()
        );
        text += &format!("{}\n{}\n", words(vertical), words(horizontal));
        for &h in horizontal {
            let row: Vec<f64> = vertical.iter().map(|&v| candela(v, h)).collect();
            text += &format!("{}\n", words(&row));
        }
        text
    }

    fn parse(text: &str) -> IntensityTable {
        IntensityTable::parse(text, &mut Vec::new()).unwrap()
    }

    fn steps(from: f64, to: f64, count: usize) -> Vec<f64> {
        (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).collect()
    }

    #[test]
    fn symmetric_tables_stand_for_whole_ones() {
        let vertical = steps(0.0, 180.0, 18);
        // Each is symmetric in the way that its table says.
        type Case = (Vec<f64>, fn(f64) -> f64);
        let cases: [Case; 5] = [
            (vec![0.0], |_| 1.0),
            (steps(0.0, 90.0, 6), |h| 2.0 + (2.0 * h.to_radians()).cos()),
            (steps(0.0, 180.0, 12), |h| 2.0 + h.to_radians().cos()),
            (steps(90.0, 270.0, 12), |h| 2.0 + h.to_radians().sin()),
            (steps(0.0, 360.0, 24), |h| 2.0 + (h - 15.0).to_radians().cos()),
        ];
        for (horizontal, around) in cases {
            let part =
                parse(&file("IESNA:LM-63-2002", &vertical, &horizontal, |v, h| around(h) * (200.0 - v)));
            let whole = parse(&file("IESNA:LM-63-2002", &vertical, &steps(0.0, 360.0, 24), |v, h| {
                around(h) * (200.0 - v)
            }));
            for k in 0..500 {
                let (v, h) = (f64::from(k) * 0.37 % 180.0, f64::from(k) * 7.3 - 900.0);
                let (a, b) = (part.at(v, h), whole.at(v, h));
                assert!((a - b).abs() < 1e-9 * b, "{horizontal:?} {v} {h}: {a} {b}");
            }
            assert!((part.flux() / whole.flux() - 1.0).abs() < 1e-12, "{horizontal:?}");
        }
    }

    #[test]
    fn flux_is_the_integral_of_intensity() {
        // Even: 4π; the cosine law: π, but for interpolation between its angles.
        let even = parse(&file("IESNA:LM-63-1995", &[0.0, 180.0], &[0.0], |_, _| 7.0));
        assert!((even.flux() / (2.0 * TAU * 7.0) - 1.0).abs() < 1e-12);
        let lambert =
            parse(&file("IESNA91", &steps(0.0, 90.0, 90), &[0.0], |v, _| 10.0 * v.to_radians().cos()));
        assert!((lambert.flux() / (0.5 * TAU * 10.0) - 1.0).abs() < 1e-4, "{}", lambert.flux());
        let uneven =
            parse(&file("IESNA91", &steps(0.0, 90.0, 9), &steps(0.0, 360.0, 8), |v, h| v * (400.0 - h)));
        let n = 720;
        let cell = |k: usize| {
            let (v, h) =
                (((k / n) as f64 + 0.5) * 90.0 / n as f64, ((k % n) as f64 + 0.5) * 360.0 / n as f64);
            uneven.at(v, h) * v.to_radians().sin() * (0.25 * TAU / n as f64) * (TAU / n as f64)
        };
        let sum: f64 = (0..n * n).map(cell).sum();
        assert!((uneven.flux() / sum - 1.0).abs() < 1e-5, "{} {sum}", uneven.flux());
    }

    #[test]
    fn intensity_is_interpolated_and_none_outside_the_table() {
        let table = parse(&file("IESNA:LM-63-2002", &[0.0, 40.0, 90.0], &[0.0, 90.0], |v, h| v + h));
        assert_eq!([table.at(20.0, 45.0), table.at(40.0, 90.0), table.at(90.0, 0.0)], [65.0, 130.0, 90.0]);
        assert_eq!([table.at(90.1, 0.0), table.at(180.0, 0.0)], [0.0; 2]);
        let up = parse(&file("IESNA:LM-63-2002", &[90.0, 180.0], &[0.0], |_, _| 3.0));
        assert_eq!([up.at(89.0, 10.0), up.at(91.0, 10.0)], [0.0, 3.0]);
    }

    #[test]
    fn multiplier_and_ballast_act_and_the_third_factor_only_in_early_files() {
        let with = |head: &str| {
            let text = file(head, &[0.0, 90.0], &[0.0], |_, _| 100.0).replace("0.5 1 30", "0.5 0.8 30");
            parse(&text).at(10.0, 0.0)
        };
        assert_eq!(
            ["an old luminaire", "IESNA91", "IESNA:LM-63-1995", "IES:LM-63-2019"].map(with),
            [80.0, 80.0, 100.0, 100.0]
        );
    }

    #[test]
    fn tilt_factors_are_read_and_interpolated() {
        let text = file("IESNA:LM-63-2002\n[MANUFAC] none", &[0.0, 90.0], &[0.0], |_, _| 5.0);
        let tilted = text.replace("TILT=NONE", "tilt = include\n1\n3\n0 45 90\n1, 0.9, 0.8");
        let mut warnings = Vec::new();
        let table = IntensityTable::parse(&tilted, &mut warnings).unwrap();
        assert_eq!(
            [0.0, 22.5, 45.0, 90.0, 135.0].map(|angle| table.tilt_factor(angle)),
            [1.0, 0.95, 0.9, 0.8, 0.8]
        );
        assert!(warnings.len() == 1 && warnings[0].contains("TILT=INCLUDE"));
        let plain = parse(&text.replace("TILT=NONE", " Tilt = None"));
        assert_eq!((plain.tilt_factor(33.0), plain.at(10.0, 0.0)), (1.0, table.at(10.0, 0.0)));
    }

    /// A file of type A or B of a lamp with this intensity by direction: to the right, ahead (C0) and down.
    fn turned(kind: u8, count: usize, intensity: impl Fn([f64; 3]) -> f64) -> IntensityTable {
        let angles = steps(-90.0, 90.0, count);
        let candela = |v: f64, h: f64| {
            let ((sv, cv), (sh, ch)) = (v.to_radians().sin_cos(), h.to_radians().sin_cos());
            intensity(if kind == 3 { [cv * sh, sv, cv * ch] } else { [sh, ch * sv, ch * cv] })
        };
        let text = file("IESNA:LM-63-2002", &angles, &angles, candela);
        parse(&text.replace(" 1 2 0.1", &format!(" {kind} 2 0.1")))
    }

    #[test]
    fn tables_about_other_axes_are_the_same_lamp() {
        let lamp = |[right, ahead, down]: [f64; 3]| (down * (2.0 + right + 0.3 * ahead * ahead)).max(0.0);
        let c = parse(&file("IESNA:LM-63-2002", &steps(0.0, 90.0, 180), &steps(0.0, 360.0, 720), |v, h| {
            let ((sv, cv), (sh, ch)) = (v.to_radians().sin_cos(), h.to_radians().sin_cos());
            lamp([-sv * sh, sv * ch, cv])
        }));
        let [b, a] = [2, 3].map(|kind| turned(kind, 360, lamp));
        for k in 0..500 {
            let (v, h) = (f64::from(k) * 0.37 % 89.0, f64::from(k) * 7.3 - 900.0);
            let [wanted, of_a, of_b] = [&c, &a, &b].map(|table| table.at(v, h));
            assert!(
                (of_a - wanted).abs() < 1e-3 && (of_b - wanted).abs() < 1e-3,
                "{v} {h}: {wanted} {of_a} {of_b}"
            );
            assert!(a.at(180.0 - v, h) < 1e-6 && b.at(180.0 - v, h) < 1e-6);
        }
        // The same flux: that of the sum of what each term sends.
        let wanted = 0.5 * TAU * (2.0 + 0.3 * 0.25);
        for table in [&a, &b, &c] {
            assert!((table.flux() / wanted - 1.0).abs() < 1e-4, "{} {wanted}", table.flux());
        }
    }

    #[test]
    fn half_a_table_about_another_axis_is_its_own_image() {
        let even = |h: f64, v: f64| 3.0 + (h * h + v).to_radians().cos();
        for kind in [2, 3] {
            let [whole, half] = [steps(-90.0, 90.0, 12), steps(0.0, 90.0, 6)].map(|horizontal| {
                let text = file("IESNA:LM-63-2002", &steps(-90.0, 90.0, 9), &horizontal, |v, h| even(h, v));
                parse(&text.replace(" 1 2 0.1", &format!(" {kind} 2 0.1")))
            });
            assert_eq!(whole, half);
        }
    }

    #[test]
    fn sizes_are_in_metres_and_lumens_may_be_less_than_none() {
        let text = file("IESNA:LM-63-2002", &[0.0, 90.0], &[0.0], |_, _| 5.0).replace("1 1000 2", "1 -1 2");
        assert_eq!(parse(&text).luminous_size(), [0.1, 0.1, 0.0]);
        let feet = parse(&text.replace(" 1 2 0.1", " 1 1 0.1"));
        assert!((feet.luminous_size()[0] - 0.03048).abs() < 1e-12);
        assert_eq!(parse(&text).at(10.0, 0.0), 5.0);
    }

    /// A EULUMDAT file of one lamp of 2000 lm.
    fn eulumdat(symmetry: u8, planes: usize, rows: &[[f64; 3]]) -> String {
        let mut lines: Vec<String> = vec![String::from("nobody"), "1".into(), symmetry.to_string()];
        let step = 360.0 / planes as f64;
        lines.extend([planes.to_string(), step.to_string(), "3".into(), "45".into()]);
        lines.extend((0..5).map(|k| format!("name {k}")));
        lines.extend(
            ["600", "300", "100", "500", "200", "0", "0", "0", "0", "100", "80", "0,5", "0", "1"]
                .map(str::to_owned),
        );
        lines.extend(["1", "a lamp", "2000", "3000", "1A", "30"].map(str::to_owned));
        lines.extend((0..10).map(|_| "0.5".to_owned()));
        lines.extend((0..planes).map(|k| (k as f64 * step).to_string()));
        lines.extend(["0", "45", "90"].map(str::to_owned));
        lines.extend(rows.iter().flatten().map(|x| x.to_string().replace('.', ",")));
        lines.join("\r\n")
    }

    #[test]
    fn eulumdat_tables_of_every_symmetry_are_read() {
        let row = |angle: f64| [7.0, 4.5 + angle.to_radians().cos(), angle.to_radians().sin().abs()];
        let rows = |angles: &[f64]| angles.iter().map(|&angle| row(angle)).collect::<Vec<_>>();
        for (symmetry, stored) in [
            (0, &[0.0, 90.0, 180.0, 270.0][..]),
            (1, &[0.0]),
            (2, &[0.0, 90.0, 180.0]),
            (3, &[270.0, 0.0, 90.0]),
            (4, &[0.0, 90.0]),
        ] {
            let table = parse(&eulumdat(symmetry, 4, &rows(stored)));
            assert_eq!(table.luminous_size(), [0.2, 0.5, 0.0]);
            for &angle in stored {
                // A conversion factor of a half, and 2 klm.
                assert_eq!(table.at(0.0, angle), 7.0, "{symmetry}");
                let [_, at_45, at_90] = row(angle);
                assert!((table.at(45.0, angle) - at_45).abs() < 1e-12, "{symmetry} {angle}");
                assert!((table.at(90.0, angle) - at_90).abs() < 1e-12, "{symmetry} {angle}");
            }
            let [one, other] = match symmetry {
                2 => [90.0, 270.0],
                3 => [0.0, 180.0],
                4 => [90.0, 270.0],
                _ => [0.0, 360.0],
            };
            assert_eq!(table.at(45.0, one), table.at(45.0, other), "{symmetry}");
        }
    }

    #[test]
    fn broken_eulumdat_files_are_named_by_line() {
        let good = eulumdat(1, 4, &[[7.0, 5.0, 1.0]]);
        for (from, to, line, wanted) in [
            ("\r\n45\r\n90\r\n7", "\r\n45\r\n40\r\n7", 49, "angle 3 of 3 is 40"),
            ("\r\n7\r\n5\r\n1", "\r\n7\r\n5", 51, "the file ends where intensity 3 of plane 1"),
            ("\r\n7\r\n5", "\r\n7\r\n-5", 51, "negative"),
            ("\r\n7\r\n5", "\r\n7\r\nx", 51, "`x` stands where intensity 2"),
        ] {
            assert!(good.contains(from), "{from:?}");
            let (at, message) =
                IntensityTable::parse(&good.replacen(from, to, 1), &mut Vec::new()).unwrap_err();
            assert!(at == line && message.contains(wanted), "{to:?}: {at}: {message}");
        }
    }

    #[test]
    fn broken_files_are_named_by_line() {
        let good = file("IESNA:LM-63-2002", &[0.0, 45.0, 90.0], &[0.0, 90.0], |_, _| 5.0);
        for (from, to, line, wanted) in [
            ("TILT=NONE", "TILT=a.tlt", 2, "TILT=NONE"),
            ("TILT=NONE", "", 8, "no line TILT="),
            ("3 2 1 2", "3 2 1 3", 3, "no unit of length"),
            ("3 2 1 2", "3 2 7 2", 3, "no type"),
            ("3 2 1 2", "0 2 1 2", 3, "the number of vertical angles is 0"),
            ("3 2 1 2", "3 1e9 1 2", 3, "the number of horizontal angles"),
            ("1000 2 3", "1000 0 3", 3, "the multiplier of candelas is 0"),
            ("0.5 1 30", "0.5 one 30", 4, "`one` stands where"),
            ("0 45 90", "0 95 90", 5, "vertical angle 3 of 3 is 90"),
            ("0 45 90", "0 45 80", 5, "vertical angles run from 0 to 80"),
            ("\n0 90\n", "\n0 70\n", 6, "horizontal angles run from 0 to 70"),
            ("5 5 5\n5 5 5", "5 5 5\n5 -5 5", 8, "candela value 5 of 6 is -5"),
            ("5 5 5\n5 5 5", "5 5 5\n5 5", 8, "the file ends where candela value 6 of 6"),
            ("5 5 5\n5 5 5", "5 5 5\n5 nan 5", 8, "`nan`"),
            (
                "5 5 5\n5 5 5",
                "5,5 5,5 5,5\n5,5 5,5 5,5",
                8,
                "`5` is left over after the 6 candelas of 3 by 2 angles, and 5 more",
            ),
        ] {
            assert!(good.contains(from), "{from}");
            let (at, message) =
                IntensityTable::parse(&good.replacen(from, to, 1), &mut Vec::new()).unwrap_err();
            assert!(at == line && message.contains(wanted), "{to}: {at}: {message}");
        }
        assert!(IntensityTable::parse("", &mut Vec::new()).is_err());
    }
}
