//! What stands about a real board: a person, or instruments by remote control.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::{Result, bail};
use zerorate_bench::client::DeviceClient;
use zerorate_bench::instruments::{Bench, Chamber, Power, Supply};
use zerorate_bench::manual::{self, Person};
use zerorate_bench::remote::{Found, LeftOn, RemoteChamber, RemoteSupply};
use zerorate_bench::setup::SetUp;

use super::instrument::Instrument;
use super::operator::AtTerminal;

/// A chamber and a supply that were asked who they are, and what was found.
pub struct Instruments {
    chamber: Option<RemoteChamber>,
    supply: Option<RemoteSupply>,
    /// A sentence each.
    pub found: Vec<String>,
    /// Which they are, by `chamber` and `supply`, as a record says it.
    labels: Vec<(&'static str, String)>,
}

impl Instruments {
    /// Asks those that are remote. Nothing is moved or fed.
    pub fn open(chamber: &Instrument, supply: &Instrument, setup: &SetUp) -> Result<Self> {
        let (mut found, mut labels) = (Vec::new(), Vec::new());
        let mut note = |what, Found { told, label }| {
            found.push(told);
            labels.push((what, label));
        };
        let chamber = match chamber {
            Instrument::Simulated => bail!("a real board is in no simulated chamber: --chamber manual, or its address"),
            Instrument::Manual => None,
            Instrument::Remote(address) => {
                let (chamber, found) = RemoteChamber::open(address, setup)?;
                note("chamber", found);
                Some(chamber)
            }
        };
        let supply = match supply {
            Instrument::Simulated => bail!("a real board has no simulated supply: --supply manual, or its address"),
            Instrument::Manual => None,
            Instrument::Remote(address) => {
                let (supply, found) = RemoteSupply::open(address, setup)?;
                note("supply", found);
                Some(supply)
            }
        };
        Ok(Self { chamber, supply, found, labels })
    }

    /// The set-up with the instruments among its labels, so that every record says by which it was made; what the set-up says of
    /// them itself stays.
    pub fn named_in(&self, setup: &SetUp) -> SetUp {
        let mut setup = setup.clone();
        for (what, label) in &self.labels {
            setup.labels.entry((*what).to_owned()).or_insert_with(|| label.clone());
        }
        setup
    }

    /// The bench. Who is there for one of them turns the board's switch too; where nobody is, it stays on.
    pub fn bench(self, device: DeviceClient, operator: impl FnOnce() -> AtTerminal) -> Result<Bench> {
        let (chamber, supply, power): (Box<dyn Chamber>, Box<dyn Supply>, Box<dyn Power>) =
            match (self.chamber, self.supply) {
                (Some(chamber), Some(supply)) => (Box::new(chamber), Box::new(supply), Box::new(LeftOn)),
                (chamber, supply) => {
                    let person: Person = Rc::new(RefCell::new(operator()));
                    let chamber = match chamber {
                        Some(chamber) => Box::new(chamber),
                        None => manual::chamber(&person)?,
                    };
                    let supply =
                        supply.map_or_else(|| manual::supply(&person), |supply| Box::new(supply) as Box<dyn Supply>);
                    (chamber, supply, manual::power(&person))
                }
            };
        Ok(Bench { device, chamber, supply, power, clock: None, witness: None })
    }
}
