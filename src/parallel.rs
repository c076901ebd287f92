//! Parallel: how many threads share the work.

/// Threads that share the work of the calling thread: those of the pool it belongs to, or else of the global
/// one. The one place that asks for it.
pub fn threads() -> usize {
    rayon::current_num_threads()
}
