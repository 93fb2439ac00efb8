//! What stands about a real board: a person, or instruments by remote control.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::{Result, bail, ensure};
use zerorate_bench::client::DeviceClient;
use zerorate_bench::instruments::{Bench, Chamber, Power, Supply};
use zerorate_bench::manual::{self, Person};
use zerorate_bench::remote::{Found, LeftOn, RemoteChamber, RemoteSupply};
use zerorate_bench::setup::SetUp;
use zerorate_bench::shared::{self, SharedChamber};
use zerorate_board_run::folder::{POWER, POWER_LEFT_ON, POWER_SWITCHED};

use super::instrument::Instrument;
use super::operator::AtTerminal;

/// A chamber and a supply that were asked who they are, and what was found.
pub struct Instruments {
    chamber: Option<RemoteChamber>,
    supply: Option<RemoteSupply>,
    /// A sentence each.
    pub found: Vec<String>,
    /// Which they are, by `chamber` and `supply`, and what became of the power, as a record says it.
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
        let nobody_there = chamber.is_some() && supply.is_some();
        labels.push((POWER, if nobody_there { POWER_LEFT_ON } else { POWER_SWITCHED }.to_owned()));
        Ok(Self { chamber, supply, found, labels })
    }

    /// The set-up with the instruments among its labels, so that every record says by which it was made; what the set-up says of
    /// them itself stays, but for the power.
    pub fn named_in(&self, setup: &SetUp) -> SetUp {
        named_in(setup, &self.labels)
    }

    /// The bench. Who is there for one of them turns the board's switch too; where nobody is, it stays on.
    pub fn bench(mut self, device: DeviceClient, operator: impl FnOnce() -> AtTerminal) -> Result<Bench> {
        self.supply.iter_mut().try_for_each(RemoteSupply::make_ready)?;
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

fn named_in(setup: &SetUp, labels: &[(&'static str, String)]) -> SetUp {
    let mut setup = setup.clone();
    for (what, label) in labels {
        let said = setup.labels.entry((*what).to_owned()).or_insert_with(|| label.clone());
        // What became of the power nobody knows better: of that a budget is made.
        if *what == POWER {
            said.clone_from(label);
        }
    }
    setup
}

/// What stands about several boards: a chamber for all, and a supply for each or one for one after the other. All obey by
/// themselves: a person who is asked by sixteen runs at once does not know what for.
pub struct SharedInstruments {
    chamber: (RemoteChamber, String),
    supplies: Vec<(RemoteSupply, String)>,
    boards: usize,
    /// A sentence each.
    pub found: Vec<String>,
}

impl SharedInstruments {
    /// Asks them who they are. Nothing is moved or fed.
    pub fn open(chamber: Option<&Instrument>, supplies: &[Instrument], boards: usize, setup: &SetUp) -> Result<Self> {
        let Some(Instrument::Remote(chamber)) = chamber else {
            bail!("several boards at once need a chamber that obeys by itself: give its address (--chamber)");
        };
        ensure!(
            supplies.len() == 1 || supplies.len() == boards,
            "{} supplies for {boards} boards: give one for each, or one for all (--supply)",
            supplies.len()
        );
        let twice = supplies.iter().enumerate().find(|(place, one)| supplies[..*place].contains(one));
        if let Some((_, Instrument::Remote(address))) = twice {
            bail!(
                "--supply {address} was given twice, and each of its boards would switch the other's gyros: give one for each, or one for all"
            );
        }
        let (chamber, Found { told, label }) = RemoteChamber::open(chamber, setup)?;
        let (chamber, mut found) = ((chamber, label), vec![told]);
        let supplies = supplies.iter().map(|supply| match supply {
            Instrument::Remote(address) => {
                let (supply, Found { told, label }) = RemoteSupply::open(address, setup)?;
                found.push(told);
                Ok((supply, label))
            }
            _ => bail!("several boards at once need supplies that obey by themselves: give their addresses (--supply)"),
        });
        let supplies = supplies.collect::<Result<_>>()?;
        Ok(Self { chamber, supplies, boards, found })
    }

    /// Each board's part of them, and the set-up with their names among its labels.
    ///
    /// # Errors
    /// A supply that cannot be made ready.
    pub fn each(
        mut self,
        setup: &SetUp,
    ) -> Result<impl Iterator<Item = (SharedChamber, Box<dyn Supply + Send>, SetUp)>> {
        self.supplies.iter_mut().try_for_each(|(supply, _)| supply.make_ready())?;
        let ((chamber, chamber_label), boards) = (self.chamber, self.boards);
        let supplies: Vec<(Box<dyn Supply + Send>, String)> = match <[_; 1]>::try_from(self.supplies) {
            Ok([(supply, label)]) => {
                let turns = shared::supply(Box::new(supply), boards).into_iter();
                turns.map(|turn| (Box::new(turn) as Box<dyn Supply + Send>, label.clone())).collect()
            }
            Err(own) => own.into_iter().map(|(supply, label)| (Box::new(supply) as _, label)).collect(),
        };
        let seats = shared::chamber(Box::new(chamber), boards);
        Ok(seats.into_iter().zip(supplies).map(move |(seat, (supply, label))| {
            let power = POWER_LEFT_ON.to_owned();
            let labels = [("chamber", chamber_label.clone()), ("supply", label), (POWER, power)];
            (seat, supply, named_in(setup, &labels))
        }))
    }
}
