//! The paper's procedures, one a file. Each takes a [`Session`](crate::run::Session) and a recording, and is ordered by
//! group number alone.

pub mod compensation_test;
pub mod full_temperature;
pub mod soaks;
pub mod trim_experiment;
