//! The command `zerorate`: all of it, for whoever starts it. Its own program does, and so does the Python package.

mod clock;
mod command;
mod interrupt;
mod labels;
mod log_arguments;
mod looking_on;
mod notify;
mod output;
mod plant;
mod progress;
mod screen;

pub use command::run;
