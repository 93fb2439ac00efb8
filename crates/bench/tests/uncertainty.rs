//! The uncertainty of a certificate against what the plant knows of itself: U must hold what it says, and must not be so
//! large that it holds anything.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use zerorate_bench::calibrate::calibrate;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::checkpoint::Keep;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::procedure::compensation_test::{self, Extent};
use zerorate_bench::run::{Recorder, Session, Silent, Taken};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::uncertainty::budgets;
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

/// Equal parts of the temperatures, so that each counts as much as another.
const PARTS: usize = 100;

/// The paper's profile with a tenth of its samples, which is as good here and takes a fraction of the time.
fn set_up(kind: PlantKind) -> SetUp {
    let mut setup = kind.setup();
    (setup.acquisition.group_length, setup.acquisition.sample_period_us) = (50, 30_000);
    setup.chamber.soaks_c.clear();
    setup
}

/// One budget beside the truth of another switch-on.
struct Held {
    what: String,
    mode: Mode,
    expanded: f64,
    /// How often it holds by the certificate, 0 to 1.
    said: f64,
    /// The rms of the truth about the centre, counts, and the shares of temperatures within U: of the truth, and of what was read.
    rms: f64,
    truth: f64,
    read: f64,
}

/// The compensated output less the centre in parts of the temperatures, of both ramps: by the plant without noise, and as read.
fn errors(ramp: &[Taken], axis: Axis, centre: f64) -> Vec<[f64; 2]> {
    let temperature = |taken: &Taken| taken.truth.as_ref().unwrap().axes[axis.index()].temperature_counts;
    let coldest = ramp.iter().map(temperature).fold(f64::INFINITY, f64::min);
    let hottest = ramp.iter().map(temperature).fold(f64::NEG_INFINITY, f64::max);
    let part = |place: usize| coldest + (hottest - coldest) * place as f64 / PARTS as f64;
    let first_in = |place| ramp.iter().find(|taken| (part(place)..part(place + 1)).contains(&temperature(taken)));
    let error = |taken: &Taken| {
        let truth = &taken.truth.as_ref().unwrap().axes[axis.index()];
        let read = taken.corrected(axis).0;
        [read - taken.zro(axis).0 + truth.drift_counts + truth.wiper_counts - centre, read - centre]
    };
    (0..PARTS).filter_map(first_in).map(error).collect()
}

/// A unit is calibrated, and then switched on anew for each of its budgets.
fn held(kind: PlantKind, seed: u64) -> Vec<Held> {
    let setup = set_up(kind);
    let unit = Unit::new("ZR-U", Some((kind, seed))).unwrap();
    let mut bench = simulated::bench(kind.build(seed), &setup, &unit.serial);
    let folder = tempfile::tempdir().unwrap();
    calibrate(&mut bench, &setup, unit, folder.path(), &mut Silent, Keep::Nothing).unwrap();
    let run = BoardRun::read(folder.path()).unwrap();
    let mut silent = Silent;
    let mut session = Session::new(&mut bench, &setup, &mut silent);
    let extent = Extent { cooling: true, samples: false };
    let of_budget = |budget: &zerorate_board_run::uncertainty::Budget| {
        let (axis, mode) = (budget.axis, budget.mode);
        let recorder = &mut Recorder::discarding();
        let test = compensation_test::run(&mut session, &[], mode, axis, extent, recorder).unwrap();
        let centre = setup.board.centre_counts;
        let errors = [errors(&test.heating, axis, centre), errors(&test.cooling, axis, centre)].concat();
        let share = |which: usize| {
            let within = errors.iter().filter(|error| error[which].abs() <= budget.expanded_counts()).count();
            within as f64 / errors.len() as f64
        };
        let squares: f64 = errors.iter().map(|[truth, _]| truth * truth).sum();
        let rows: Vec<String> =
            budget.contributions.iter().map(|row| format!("{:?} {:.2}", row.source, row.counts())).collect();
        Held {
            what: format!("{} seed {seed} {} {}: {}", kind.name(), axis.name(), mode.name(), rows.join(", ")),
            mode,
            expanded: budget.expanded_counts(),
            said: budget.held(),
            rms: (squares / errors.len() as f64).sqrt(),
            truth: share(0),
            read: share(1),
        }
    };
    budgets(&run).iter().map(of_budget).collect()
}

#[test]
fn the_plants_own_output_at_another_switch_on_lies_within_u_as_often_as_is_said() {
    const EACH: u64 = 10;
    let (next, all) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, std::num::NonZero::get) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= 2 * EACH {
                        break;
                    }
                    let kind = if number < EACH { PlantKind::Paper } else { PlantKind::Typical };
                    let of_unit = held(kind, 7001 + number);
                    all.lock().unwrap().extend(of_unit);
                }
            });
        }
    });
    let all = all.into_inner().unwrap();
    assert!(all.len() as u64 >= 2 * EACH * 3, "{}", all.len());
    for held in &all {
        println!(
            "{}; U {:.2}, true rms {:.2}, within U {:.2}, as read {:.2}",
            held.what, held.expanded, held.rms, held.truth, held.read
        );
    }
    let of = |trim: bool, value: &dyn Fn(&Held) -> f64| {
        let own: Vec<f64> = all.iter().filter(|held| (held.mode == Mode::Trim) == trim).map(value).collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    for trim in [true, false] {
        let (truth, read) = (of(trim, &|held| held.truth), of(trim, &|held| held.read));
        let too_large = of(trim, &|held| held.expanded / held.rms);
        let said = of(trim, &|held| held.said);
        println!(
            "trim {trim}: {said:.3} said, within U {truth:.3}, as read {read:.3}; U is {too_large:.2} times the true rms"
        );
        // Forty budgets with few switch-ons each tell the share to some hundredths.
        assert!(truth > said - 0.06 && read > said - 0.06, "trim {trim}: {said} said, {truth} {read}");
        assert!((0.85..=1.0).contains(&truth) && (0.85..=1.0).contains(&read), "trim {trim}: {truth} {read}");
        assert!(too_large < 4.0, "trim {trim}: {too_large}");
    }
}
