//! Progress: how long library calls tell what they are at, and how they are asked to stop.
//!
//! Every long call takes a [`Progress`] in its options. The default is silent and never cancels; a
//! program passes an [`Observer`] of its own (a terminal bar, a test, a stop button).

use std::ops::ControlFlow;

/// Watches a long computation. Called often and from any thread, so it must be quick.
pub trait Observer: Sync {
    /// Stage `stage` (such as `trace`) has begun, or has come as far as `done`, from 0 to 1.
    ///
    /// Answering [`ControlFlow::Break`] asks the computation to end with its `Cancelled` error.
    fn at(&self, stage: &'static str, done: f64) -> ControlFlow<()>;
}

/// Where to report progress; copied freely, silent by default.
#[derive(Clone, Copy, Default)]
pub struct Progress<'a>(Option<&'a dyn Observer>);

/// The computation was asked to stop by its [`Observer`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl<'a> Progress<'a> {
    /// Reports to `observer`.
    pub fn to(observer: &'a dyn Observer) -> Self {
        Self(Some(observer))
    }

    /// Says that `stage` has come as far as `done` (0 to 1); an error when asked to stop.
    pub fn at(&self, stage: &'static str, done: f64) -> Result<(), Cancelled> {
        match self.0.map(|observer| observer.at(stage, done)) {
            Some(ControlFlow::Break(())) => Err(Cancelled),
            _ => Ok(()),
        }
    }
}

impl std::fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.0.is_some() { "Progress(observed)" } else { "Progress(silent)" })
    }
}
