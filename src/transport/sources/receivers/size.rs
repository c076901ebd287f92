//! Size: the memory that the rows of receivers take, known before they are traced.

use super::{BATCHES, rays_of};
use crate::scene::Scene;
use crate::transport::TransportError;
use crate::transport::rows::Tones;

/// A coefficient or form factor and its patch, bytes.
const ENTRY: f64 = 16.0;

/// A row's list of entries, bytes.
const LIST: f64 = 24.0;

/// A number, bytes.
const NUMBER: f64 = 8.0;

/// Bytes that all receivers of a scene take with so many patches, and so many rays for each of these.
pub(crate) fn receiver_bytes(scene: &Scene, patches: usize, rays: u32) -> f64 {
    let (tones, channels) = (Tones::of(scene).len() as f64, scene.channels() as f64);
    let of_points = |points: usize| {
        // Rays that land anywhere meet some patches more than once.
        let (n, rays) = (patches.max(1) as f64, f64::from(rays_of(points, patches, rays)));
        let met = n * (1.0 - (-rays / n).exp());
        // What each batch finds is held as it is found, and as a sample of the noise.
        let samples = 2.0 * f64::from(BATCHES) * channels * NUMBER;
        points as f64 * (tones * (LIST + met * ENTRY) + samples)
    };
    scene.receivers().iter().map(|receiver| of_points(receiver.len())).sum()
}

/// Refuses receivers of so many points that their rows would not fit into `memory` bytes.
///
/// # Errors
/// `Receivers`.
pub fn check_receivers(scene: &Scene, patches: usize, rays: u32, memory: u64) -> Result<(), TransportError> {
    let needed = receiver_bytes(scene, patches, rays) as u64;
    match scene.receivers().iter().max_by_key(|receiver| receiver.len()) {
        Some(largest) if needed > memory => Err(TransportError::Receivers {
            points: scene.receivers().iter().map(|receiver| receiver.len()).sum(),
            largest: largest.name.clone(),
            needed,
            limit: memory,
        }),
        _ => Ok(()),
    }
}
