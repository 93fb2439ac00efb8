#![doc = include_str!("../README.md")]

pub mod allan;
pub mod auto;
pub mod boot;
pub mod choose;
pub mod crowding;
pub mod direction;
pub mod drift_fit;
pub mod dropouts;
mod evidence;
pub mod folds;
pub mod intervals;
pub mod jumps;
pub mod least_squares;
pub mod model;
mod model_fit;
pub mod nearest;
pub mod noise_signs;
pub mod predict;
pub mod ramp;
pub mod residual;
pub mod robust;
pub mod series;
pub mod shrinkage;
pub mod spikes;
pub mod still;
pub mod trend;
pub mod trim;
