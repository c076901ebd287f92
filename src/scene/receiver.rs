//! Receiver: a grid of points at which light is measured; it neither reflects nor blocks.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::is_near;
use super::spelled::spelled;

/// A work plane or sensor grid: the middles of the cells of a parallelogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// Name, as tables spell it.
    pub name: String,
    /// A corner, metres.
    pub corner: DVec3,
    /// Two edges from that corner, metres.
    pub edges: [DVec3; 2],
    /// Number of points along each edge.
    pub counts: [usize; 2],
    /// What is measured at each point.
    pub measure: Measure,
    /// Points nearer than this to an edge count in no level, metres.
    pub margin: f64,
    /// Maintenance factor, 0 to 1: the part of the light that is left when lamps and surfaces have aged. All
    /// that is measured is multiplied by it.
    pub maintenance: f64,
}

/// What a receiver measures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Measure {
    /// Irradiance on the receiver's own plane, on the side from which the first edge turns counter-clockwise
    /// into the second.
    #[default]
    Plane,
    /// Irradiance on a plane with this unit normal.
    Normal(DVec3),
    /// Cylindrical irradiance (EN 12464-1): the mean over all directions across this unit axis of that on a
    /// plane which looks there, ∫ L sin θ dω / π.
    Cylinder(DVec3),
}

/// More points than this in one receiver are refused.
const MOST: usize = 1 << 24;

impl Receiver {
    /// A grid that measures irradiance on its own plane.
    pub fn grid(name: &str, corner: DVec3, edges: [DVec3; 2], counts: [usize; 2]) -> Self {
        let measure = Measure::Plane;
        Self { name: name.to_owned(), corner, edges, counts, measure, margin: 0.0, maintenance: 1.0 }
    }

    /// Number of points along each of two edges (metres) by the rule of EN 12464-1: about p = 0.2 · 5^(log₁₀
    /// d) apart and at most 10 m, with d the longer edge in metres, or the shorter one where they differ by a
    /// factor of two or more.
    pub fn usual_counts(edges: [DVec3; 2]) -> [usize; 2] {
        let lengths = edges.map(DVec3::length);
        let (short, long) = (lengths[0].min(lengths[1]), lengths[0].max(lengths[1]));
        let d = if long >= 2.0 * short { short } else { long };
        let p = (0.2 * 5f64.powf(d.log10())).min(10.0);
        lengths.map(|length| (length / p).round().clamp(1.0, 4096.0) as usize)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Whether it has no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The points, metres, along the first edge first.
    pub fn points(&self) -> impl Iterator<Item = DVec3> {
        let [across, along] = self.edges;
        self.places().map(move |[x, y]| self.corner + across * x + along * y)
    }

    /// Where the points are along either edge, 0 to 1.
    fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        let [columns, rows] = self.counts;
        let place = move |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
        (0..rows * columns).map(move |k| [place(k % columns, columns), place(k / columns, rows)])
    }

    /// Whether each point counts in levels: it lies no nearer to an edge than the margin.
    pub fn inner(&self) -> impl Iterator<Item = bool> {
        let area = self.edges[0].cross(self.edges[1]).length();
        // How far opposite edges are apart.
        let [wide, high] = [1, 0].map(|other| area / self.edges[other].length());
        let depth = move |at: f64, width: f64| at.min(1.0 - at) * width;
        self.places().map(move |[x, y]| depth(x, wide).min(depth(y, high)) >= self.margin * (1.0 - 1e-9))
    }

    /// The normal of its plane, a unit vector.
    pub fn normal(&self) -> DVec3 {
        self.edges[0].cross(self.edges[1]).normalize_or_zero()
    }

    /// The direction it looks in, a unit vector: where it measures all around, its plane's normal.
    pub fn front(&self) -> DVec3 {
        if let Measure::Normal(normal) = self.measure { normal } else { self.normal() }
    }

    /// How much light from a direction, a unit vector towards it, counts of what faces it.
    pub fn response(&self, towards: DVec3) -> f64 {
        match self.measure {
            Measure::Plane => self.normal().dot(towards).max(0.0),
            Measure::Normal(normal) => normal.dot(towards).max(0.0),
            Measure::Cylinder(axis) => FRAC_1_PI * (1.0 - axis.dot(towards).powi(2)).max(0.0).sqrt(),
        }
    }

    /// What is wrong with it, if anything.
    pub(super) fn check(&self) -> Result<(), String> {
        let sound = is_near(self.corner) && self.edges.into_iter().all(is_near);
        if !sound || self.normal() == DVec3::ZERO {
            return Err(
                "corner and edges must be finite, up to 1e30 m, and the edges must span an area".into()
            );
        }
        if let Measure::Normal(axis) | Measure::Cylinder(axis) = self.measure
            && (axis.length() - 1.0).abs() > 1e-9
        {
            return Err("normal and axis must be three finite numbers that are not all 0".into());
        }
        if !(self.maintenance > 0.0 && self.maintenance <= 1.0) {
            let maintenance = spelled(self.maintenance);
            return Err(format!("maintenance {maintenance} must be more than 0 and at most 1"));
        }
        let count = self.counts[0].checked_mul(self.counts[1]).filter(|count| (1..=MOST).contains(count));
        count.ok_or_else(|| format!("points must be 1 to {MOST} in all"))?;
        if !(self.margin >= 0.0 && self.inner().any(|is_inner| is_inner)) {
            return Err(format!("margin {} m must be 0 or more, and leave a point", spelled(self.margin)));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_by_the_standards_rule_are_as_fine_as_it_says() {
        let counts = |a: f64, b: f64| Receiver::usual_counts([a * DVec3::X, b * DVec3::Z]);
        // EN 12464-1, table A.1.
        for (length, points) in [(1.0, 5), (2.0, 6), (5.0, 8), (10.0, 10)] {
            assert_eq!(counts(length, length), [points; 2], "{length}");
        }
        assert_eq!(counts(1.0, 4.0), [5, 20], "the shorter edge tells where they differ much");
    }

    #[test]
    fn a_margin_leaves_out_what_is_near_the_edges() {
        let grid = Receiver::grid("desk", DVec3::ZERO, [4.0 * DVec3::X, 2.0 * DVec3::Z], [4, 2]);
        let inner = |margin: f64| Receiver { margin, ..grid.clone() }.inner().filter(|&is| is).count();
        assert_eq!([inner(0.0), inner(0.5), inner(0.6)], [8, 8, 0]);
        assert!(Receiver { margin: 0.6, ..grid.clone() }.check().is_err());
        assert!(Receiver { maintenance: 0.0, ..grid }.check().is_err());
    }
}
