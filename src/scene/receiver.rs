//! Receiver: a grid of points at which light is measured; it neither reflects nor blocks.

use glam::DVec3;

use super::is_near;

/// A work plane or sensor grid: the middles of the cells of a parallelogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// Name, as tables spell it.
    pub name: String,
    /// A corner, metres.
    pub corner: DVec3,
    /// Two edges from that corner, metres; light is measured on the side from which the first turns
    /// counter-clockwise into the second.
    pub edges: [DVec3; 2],
    /// Number of points along each edge.
    pub counts: [usize; 2],
}

/// More points than this in one receiver are refused.
const MOST: usize = 1 << 24;

impl Receiver {
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
        let [columns, rows] = self.counts;
        let place = move |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
        (0..rows * columns).map(move |k| {
            self.corner + across * place(k % columns, columns) + along * place(k / columns, rows)
        })
    }

    /// The direction it looks, a unit vector.
    pub fn normal(&self) -> DVec3 {
        self.edges[0].cross(self.edges[1]).normalize_or_zero()
    }

    /// What is wrong with it, if anything.
    pub(super) fn check(&self) -> Result<(), String> {
        let sound = is_near(self.corner) && self.edges.into_iter().all(is_near);
        if !sound || self.normal() == DVec3::ZERO {
            return Err(
                "corner and edges must be finite, up to 1e30 m, and the edges must span an area".into()
            );
        }
        let count = self.counts[0].checked_mul(self.counts[1]).filter(|count| (1..=MOST).contains(count));
        count.map(|_| ()).ok_or_else(|| format!("points must be 1 to {MOST} in all"))
    }
}
