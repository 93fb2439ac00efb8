//! What `zerorate fit` does: recognises what was given, and fits it.

use crate::log::LogFault;
use crate::log_fit::{FitOptions, LogFit, LogFitError, fit_logs};
use crate::ramp_fit::fit_recording;
use crate::recording::Recording;
use crate::source::Source;

/// Fits logs of one unit as one. A recording of the bench alone is fitted by its ramps ([`crate::ramp_fit`]), unless
/// something is asked for that only the fit of a log knows.
///
/// # Errors
/// [`LogFitError`].
pub fn fit(sources: &[Source], options: &FitOptions) -> Result<LogFit, LogFitError> {
    match sources {
        [source] if options.is_of_ramps() && Recording::is_one(source) => {
            Ok(fit_recording(&Recording::read(source).map_err(LogFault::named)?, source, options))
        }
        _ => fit_logs(sources, options),
    }
}
