pub mod output;
pub mod patches;
pub mod progress;
pub mod scene;
pub mod trace;
