//! A lot to try: recordings of random typical units, some of them bad, and the truth about which.
//!
//! The units are the simulated bench's, each with its own plant. Group sums only: a group has 20 samples of 75 ms where
//! the paper's has 500 of 3 ms, so that a unit takes a fiftieth of a second and not half of one; the set-up in the
//! recording says so.

mod spoil;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use zerorate_bench::error::BenchError;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::procedure::full_temperature;
use zerorate_bench::run::{Phase, Recorder, Session, Silent, Taken, row};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_cal::recording::{GroupRow, RecordingInfo, RecordingWriter, WriteError};
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Celsius};

pub use spoil::Defect;

/// The name of the truth's file.
pub const TRUTH: &str = "truth.json";

/// Seconds from one recording's start to the next one's: 2026-01-05, 06:00 UTC is the first.
const EVERY_S: i64 = 300;
const FIRST_UNIX_S: i64 = 1_767_592_800;

/// What to simulate.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// Units.
    pub units: u32,
    /// Everything is drawn from it.
    pub seed: u64,
    /// The folder for the recordings; it is made.
    pub out: PathBuf,
    /// The part of the units that are bad, 0 to 1.
    pub bad: f64,
    /// Whether the way back down is recorded too.
    pub cooling: bool,
}

/// The truth about a lot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// The seed.
    pub seed: u64,
    /// The units, in the order of their files.
    pub units: Vec<UnitTruth>,
}

/// The truth about one unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitTruth {
    /// The file of its recording.
    pub file: String,
    /// Its true serial.
    pub serial: String,
    /// The seed of its plant.
    pub seed: u64,
    /// What is bad about it; nothing for a good unit.
    pub defect: Option<Defect>,
}

/// Why a lot cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The folder or the truth cannot be written.
    #[error("{path}: cannot be written: {source}: choose a folder that can be")]
    Write {
        /// What was to be written.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// There is a lot already.
    #[error("{path}: there are recordings already: choose another folder, or remove them")]
    Taken {
        /// The folder.
        path: String,
    },
    /// A recording cannot be written.
    #[error(transparent)]
    Recording(#[from] WriteError),
    /// A unit's run failed.
    #[error("unit {serial}: {source}")]
    Bench {
        /// Its serial.
        serial: String,
        /// Why; boxed, for it is far larger than the others.
        source: Box<BenchError>,
    },
}

impl Simulation {
    /// Writes the lot, on as many threads as there are cores; `done` is told of each unit.
    ///
    /// # Errors
    /// [`SimulateError`], of the first unit that fails.
    pub fn run(&self, done: &(dyn Fn() + Sync)) -> Result<Truth, SimulateError> {
        let cannot = |path: &Path| {
            let path = path.display().to_string();
            move |source| SimulateError::Write { path, source }
        };
        fs::create_dir_all(&self.out).map_err(cannot(&self.out))?;
        let mut there = fs::read_dir(&self.out).map_err(cannot(&self.out))?.flatten().map(|entry| entry.path());
        if there.any(|path| path.extension().is_some_and(|kind| kind == "parquet")) {
            return Err(SimulateError::Taken { path: self.out.display().to_string() });
        }
        let truth = self.truth();
        let next = AtomicU32::new(0);
        let failed: Mutex<Option<SimulateError>> = Mutex::new(None);
        std::thread::scope(|scope| {
            for _ in 0..std::thread::available_parallelism().map_or(1, std::num::NonZero::get) {
                scope.spawn(|| {
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= self.units || failed.lock().is_ok_and(|failed| failed.is_some()) {
                            return;
                        }
                        match self.unit(number, &truth) {
                            Ok(()) => done(),
                            Err(error) => _ = failed.lock().map(|mut failed| failed.get_or_insert(error).to_string()),
                        }
                    }
                });
            }
        });
        if let Some(error) = failed.into_inner().ok().flatten() {
            return Err(error);
        }
        let path = self.out.join(TRUTH);
        let text = serde_json::to_string_pretty(&truth).unwrap_or_default() + "\n";
        fs::write(&path, text).map_err(cannot(&path))?;
        Ok(truth)
    }

    /// Which units are bad, and how: every kind of defect in turn, spread over the lot by the seed.
    fn truth(&self) -> Truth {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut kinds = Defect::ALL.iter().cycle();
        let units = (0..self.units)
            .map(|number| {
                let serial = serial(number);
                let bad = random.random_bool(self.bad.clamp(0.0, 1.0));
                let defect = bad.then(|| kinds.next().copied()).flatten();
                let seed = self.seed.wrapping_mul(1_000_003).wrapping_add(u64::from(number));
                UnitTruth { file: format!("{serial}.parquet"), serial, seed, defect }
            })
            .collect();
        Truth { seed: self.seed, units }
    }

    fn unit(&self, number: u32, truth: &Truth) -> Result<(), SimulateError> {
        let unit = &truth.units[number as usize];
        let setup = set_up(number, self.cooling);
        let mut rows = record(unit.seed, &setup, &unit.serial)
            .map_err(|source| SimulateError::Bench { serial: unit.serial.clone(), source: Box::new(source) })?;
        let mut info = RecordingInfo {
            unit_serial: unit.serial.clone(),
            procedure: "full-temperature".into(),
            set_up: setup.to_toml(),
            firmware: env!("CARGO_PKG_VERSION").into(),
            seed: Some(unit.seed),
            started: None,
            labels: setup.labels.clone(),
        };
        if let Some(defect) = unit.defect {
            // The unit before it, or the second for the first.
            let other = serial(if number == 0 { 1 } else { number - 1 });
            spoil::spoil(defect, unit.seed, &mut rows, &mut info, &other);
        }
        let mut writer = RecordingWriter::create(&self.out.join(&unit.file), &info)?;
        writer.write_group(&rows)?;
        writer.finish()?;
        Ok(())
    }
}

fn serial(number: u32) -> String {
    format!("ZR-{:06}", number + 1)
}

/// The set-up of a station of the line.
fn set_up(number: u32, cooling: bool) -> SetUp {
    let mut setup = SetUp::typical();
    setup.chamber.cooling_ramp = cooling;
    setup.acquisition.group_length = 20;
    setup.acquisition.sample_period_us = 75_000;
    setup.labels = [
        ("station".to_owned(), format!("ST-{}", number % 4 + 1)),
        ("operator".to_owned(), ["Aoki", "Brandt", "Costa"][(number / 96 % 3) as usize].to_owned()),
        ("recorded_at".to_owned(), rfc3339(FIRST_UNIX_S + i64::from(number) * EVERY_S)),
    ]
    .into();
    setup
}

/// The ramps of one unit.
fn record(seed: u64, setup: &SetUp, serial: &str) -> Result<Vec<GroupRow>, BenchError> {
    let unit: UnitSerial = serial.chars().take(32).collect();
    let mut bench = simulated::bench(PlantKind::Typical.build(seed), setup, &unit);
    let mut silent = Silent;
    let mut session = Session::new(&mut bench, setup, &mut silent);
    let ramp = full_temperature::run(&mut session, &mut Recorder::discarding())?;
    let [cold, hot] = setup.ends();
    let set = |taken: &Taken| if taken.phase == Phase::Cooling { cold } else { hot };
    let air = |taken: &Taken| Celsius(taken.truth.as_ref().map_or(f64::NAN, |truth| truth.chamber_c));
    let group = |taken: &Taken| (taken.report.group.0, taken.time.0);
    Ok(ramp
        .iter()
        .flat_map(|taken| Axis::BOTH.map(|axis| row(taken, axis, group(taken), set(taken), air(taken))))
        .collect())
}

/// A time as `2026-01-05T06:00:00Z` (RFC 3339); the days by Howard Hinnant's algorithm.
fn rfc3339(unix_s: i64) -> String {
    let (days, second) = (unix_s.div_euclid(86_400), unix_s.rem_euclid(86_400));
    let shifted = days + 719_468;
    let era = shifted.div_euclid(146_097);
    let of_era = shifted.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", second / 3600, second / 60 % 60, second % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_as_calendars_have_them() {
        assert_eq!(rfc3339(FIRST_UNIX_S), "2026-01-05T06:00:00Z");
        assert_eq!(rfc3339(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(rfc3339(-1), "1969-12-31T23:59:59Z");
    }

    #[test]
    fn the_truth_repeats_by_its_seed_and_plants_every_kind_of_defect() {
        let lot = |seed| Simulation { units: 500, seed, out: PathBuf::new(), bad: 0.05, cooling: false }.truth();
        assert_eq!(lot(7), lot(7));
        assert_ne!(lot(7), lot(8));
        let bad = |defect| lot(7).units.iter().filter(|unit| unit.defect == Some(defect)).count();
        assert!(Defect::ALL.iter().all(|defect| bad(*defect) > 0));
    }
}
