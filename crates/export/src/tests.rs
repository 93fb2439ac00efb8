//! Two readers of parameter files that know nothing of the writers, and compilers for the source code.

mod calibrations;
mod compiled;
mod parameters;
mod told;
