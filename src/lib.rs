pub mod measure;
pub mod output;
pub mod patches;
pub mod progress;
pub mod scene;
pub mod solve;
pub mod trace;
pub mod transport;
