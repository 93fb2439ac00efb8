//! A supply by SCPI: a voltage that is fed, held against what the supply measures, and taken off at every end.

mod table;

use std::thread;
use std::time::Duration;

use zerorate_core::units::{Axis, Volts};

pub use self::table::SupplyTable;

use crate::address::{Address, Protocol};
use crate::fault::Fault;
use crate::scpi::Scpi;

/// How often the output is measured before it is not what was set, and how long between two: it settles.
const LOOKS: u32 = 5;
const LOOK_AGAIN: Duration = Duration::from_millis(100);
/// How often a command is given before it is not obeyed: one may be lost with its connection, and nothing answers it.
const COMMANDED: u32 = 2;
/// Two measurements of one voltage differ by less.
const NOISE_V: f64 = 1e-3;
/// A current of this share of its limit is the limit's.
const AT_LIMIT: f64 = 0.95;

/// A supply, and the voltmeter behind the same address where there is one.
pub struct PowerSupply {
    scpi: Scpi,
    table: SupplyTable,
    /// What it feeds: as it was sent, and as it was measured.
    fed: Option<[f64; 2]>,
}

impl PowerSupply {
    /// A supply at an address, by its table.
    ///
    /// # Errors
    /// A sentence, where the address is no SCPI one.
    pub fn new(address: &Address, table: &SupplyTable) -> Result<Self, String> {
        if address.protocol != Protocol::Scpi {
            return Err(format!("{address}: a supply is spoken to by SCPI: give scpi:HOST:PORT or scpi:PATH"));
        }
        let scpi = Scpi::new(address.line(), Duration::from_millis(table.time_out_ms));
        Ok(Self { scpi, table: table.clone(), fed: None })
    }

    /// Who it says that it is.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn identity(&mut self) -> Result<String, Fault> {
        self.scpi.ask("*IDN?")
    }

    /// Whether its output is on.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn is_on(&mut self) -> Result<bool, Fault> {
        self.scpi.ask_switch(&format!("OUTP?{}", self.table.output.alone()))
    }

    /// Whether the voltmeters answer as the table asks them: an hour later would be late.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn try_voltmeters(&mut self) -> Result<(), Fault> {
        Axis::BOTH.into_iter().try_for_each(|axis| self.gyro_output(axis).map(drop))
    }

    /// Empties its queue of errors: those in it are of what somebody said before.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn forget_errors(&mut self) -> Result<(), Fault> {
        self.scpi.forget_errors()
    }

    /// Feeds a voltage: set, switched on, measured.
    ///
    /// # Errors
    /// [`Fault::OutsideLimits`] before anything is sent; [`Fault::CurrentLimit`] or [`Fault::NotTaken`] after it.
    pub fn feed(&mut self, volts: Volts) -> Result<(), Fault> {
        let most = self.table.most_v;
        if !(0.0..=most).contains(&volts.0) {
            return Err(Fault::OutsideLimits {
                what: "a supply's voltage (V) of",
                value: volts.0,
                least: 0.0,
                most,
                limit: "supply.most_v",
            });
        }
        let on = self.table.output;
        let mut commanded = 1;
        loop {
            self.scpi.order(&format!("VOLT {:.6}{}", volts.0, on.as_argument()))?;
            self.scpi.order(&format!("OUTP ON{}", on.as_argument()))?;
            let given = self.settled(volts.0)?;
            let (is_within, is_last) = (self.is_within(volts.0, given), commanded == COMMANDED);
            if is_within && (is_last || self.has_moved(volts.0, given)) {
                self.fed = Some([volts.0, given]);
                return Ok(());
            }
            if !is_within {
                let amperes = self.scpi.ask_number(&format!("MEAS:CURR?{}", on.alone()))?;
                let limit = self.scpi.ask_number(&format!("CURR?{}", on.alone()))?;
                if amperes >= AT_LIMIT * limit {
                    return Err(Fault::CurrentLimit { volts: volts.0, given, amperes });
                }
                if is_last {
                    return Err(Fault::NotTaken { what: "a supply's voltage (V) of", sent: volts.0, read_back: given });
                }
            }
            commanded += 1;
        }
    }

    /// What it gives once it is what was sent, or does not become it.
    fn settled(&mut self, volts: f64) -> Result<f64, Fault> {
        let mut looks = 1;
        loop {
            let given = self.measured()?;
            if looks == LOOKS || self.is_within(volts, given) {
                return Ok(given);
            }
            looks += 1;
            thread::sleep(LOOK_AGAIN);
        }
    }

    fn measured(&mut self) -> Result<f64, Fault> {
        self.scpi.ask_number(&format!("MEAS:VOLT?{}", self.table.output.alone()))
    }

    fn is_within(&self, volts: f64, given: f64) -> bool {
        (given - volts).abs() <= self.table.tolerance_v
    }

    /// Whether it has moved from the voltage before as it was told: that may be within the tolerance of the new one.
    fn has_moved(&self, volts: f64, given: f64) -> bool {
        self.fed.is_none_or(|[sent, gave]| {
            let (asked, moved) = (volts - sent, given - gave);
            (moved - asked).abs() <= 0.5 * asked.abs() + NOISE_V
        })
    }

    /// Measures once more what it feeds: what was measured on it rests on that.
    ///
    /// # Errors
    /// [`Fault::NotHeld`].
    pub fn hold(&mut self) -> Result<(), Fault> {
        let Some([volts, _]) = self.fed else { return Ok(()) };
        let given = self.settled(volts)?;
        if self.is_within(volts, given) { Ok(()) } else { Err(Fault::NotHeld { volts, given }) }
    }

    /// Switches the output off, and asks whether it is.
    ///
    /// # Errors
    /// [`Fault`]; then somebody has to go there.
    pub fn off(&mut self) -> Result<(), Fault> {
        let output = self.table.output;
        self.fed = None;
        for _ in 0..COMMANDED {
            self.scpi.order(&format!("OUTP OFF{}", output.as_argument()))?;
            if !self.is_on()? {
                return Ok(());
            }
        }
        Err(Fault::Scpi { command: "OUTP OFF".into(), error: "its output is still on".into() })
    }

    /// What a voltmeter shows at a gyro's rate output; without one what the set-up says.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn gyro_output(&mut self, axis: Axis) -> Result<Volts, Fault> {
        let question = [&self.table.voltmeter_x, &self.table.voltmeter_y][axis.index()].clone();
        if question.is_empty() { Ok(Volts(self.table.gyro_v)) } else { self.scpi.ask_number(&question).map(Volts) }
    }
}
