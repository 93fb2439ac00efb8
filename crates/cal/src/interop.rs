//! Formats of autopilots and of other programs. What these call things stays in here.

pub mod export;
