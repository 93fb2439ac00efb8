//! A Watlow F4T by SCPI, on port 5025: control loop 1 (Watlow F4T user's guide, SCPI commands; as Espec North America's
//! WatlowF4TscpiLibrary and others use them). Not tried on the real thing.

use super::Speech;
use crate::fault::Fault;
use crate::scpi::Scpi;

/// The loop's set point and process value, and the chamber's output.
const SET_POINT: &str = ":SOURCE:CLOOP1:SPOINT";
const PROCESS_VALUE: &str = ":SOURCE:CLOOP1:PVALUE";
const OUTPUT: &str = ":OUTPUT1:STATE";

/// A controller by SCPI.
pub(super) struct ByScpi(Scpi);

impl ByScpi {
    pub(super) const fn new(scpi: Scpi) -> Self {
        Self(scpi)
    }
}

impl Speech for ByScpi {
    fn actual(&mut self) -> Result<f64, Fault> {
        self.0.ask_number(&format!("{PROCESS_VALUE}?"))
    }

    fn set_point(&mut self) -> Result<f64, Fault> {
        self.0.ask_number(&format!("{SET_POINT}?"))
    }

    // It has no error queue: what was sent is read back.
    fn send(&mut self, value: f64) -> Result<(), Fault> {
        self.0.tell(&format!("{SET_POINT} {value:.2}"))
    }

    fn run(&mut self) -> Result<(), Fault> {
        self.0.tell(&format!("{OUTPUT} ON"))
    }

    fn stop(&mut self) -> Result<(), Fault> {
        self.0.tell(&format!("{OUTPUT} OFF"))
    }

    // What it answers to a question for its output is in no source at hand.
    fn stopped(&mut self) -> Result<Option<bool>, Fault> {
        Ok(None)
    }

    fn resolution(&self) -> f64 {
        0.1
    }

    fn identity(&mut self) -> Result<Option<String>, Fault> {
        self.0.ask("*IDN?").map(Some)
    }
}
