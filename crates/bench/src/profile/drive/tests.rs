use std::cell::Cell;
use std::rc::Rc;

use super::*;

/// A chamber whose air goes to its set point at 3 K/min at most; away between two times.
struct Lagging {
    now_s: Rc<Cell<f64>>,
    seen_s: f64,
    set_c: f64,
    air_c: f64,
    away_s: [f64; 2],
    sent: Rc<Cell<u32>>,
}

impl Lagging {
    fn is_away(&self) -> bool {
        (self.away_s[0]..self.away_s[1]).contains(&self.now_s.get())
    }
}

impl Chamber for Lagging {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        if self.is_away() {
            return Err(InstrumentError::Away("chamber"));
        }
        self.sent.set(self.sent.get() + 1);
        self.set_c = set_point.0;
        Ok(())
    }

    fn set_point(&self) -> Celsius {
        Celsius(self.set_c)
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        let most = 3.0 / 60.0 * (self.now_s.get() - self.seen_s);
        self.seen_s = self.now_s.get();
        self.air_c += (self.set_c - self.air_c).clamp(-most, most);
        Ok(Celsius(if self.is_away() { f64::NAN } else { self.air_c }))
    }
}

/// Time that passes as it is asked to.
struct Asked(Rc<Cell<f64>>);

impl Pace for Asked {
    fn wait(&mut self, time: Seconds) -> Result<Seconds, InstrumentError> {
        self.0.set(self.0.get() + time.0);
        Ok(time)
    }
}

#[derive(Default)]
struct Kept {
    moments: Vec<ChamberMoment>,
    notes: Vec<String>,
    steps: Vec<usize>,
}

impl Watcher for Kept {
    fn step(&mut self, place: usize) {
        self.steps.push(place);
    }

    fn moment(&mut self, moment: &ChamberMoment) -> Result<(), BenchError> {
        self.moments.push(moment.clone());
        Ok(())
    }

    fn note(&mut self, text: &str) {
        self.notes.push(text.to_owned());
    }
}

/// What was kept of a profile in a chamber that begins at 20 C, and how often its set point was written.
fn driven(steps: &str, away_s: [f64; 2]) -> (Kept, u32) {
    let profile = Profile::parse("p", format!("steps = [{steps}]"), [-40.0, 85.0]).unwrap();
    let (now, sent) = (Rc::new(Cell::new(0.0)), Rc::new(Cell::new(0)));
    let mut chamber =
        Lagging { now_s: Rc::clone(&now), seen_s: 0.0, set_c: 20.0, air_c: 20.0, away_s, sent: Rc::clone(&sent) };
    let mut kept = Kept::default();
    drive(&profile, &mut chamber, &mut Asked(now), &mut kept).unwrap();
    (kept, sent.get())
}

const NEVER: [f64; 2] = [0.0, 0.0];

/// Seconds of a step and phase.
fn seconds(kept: &Kept, step: u32, phase: Phase) -> usize {
    kept.moments.iter().filter(|moment| (moment.step, moment.phase) == (step, phase)).count()
}

/// By hand: 30 K at 3 K/min, less the last half kelvin, are 590 s; 40 K at 1 K/min are 2400 s.
#[test]
fn soaks_and_ramps_take_their_times_and_each_moment_says_what_it_is_of() {
    let (kept, sent) = driven("{ soak_c = -10, minutes = 5 }, { ramp_c = 30, k_per_min = 1 }", NEVER);
    assert_eq!(kept.steps, [0, 1]);
    assert!((589..=592).contains(&seconds(&kept, 1, Phase::Cooling)), "{}", seconds(&kept, 1, Phase::Cooling));
    assert_eq!(seconds(&kept, 1, Phase::Soak), 300);
    let heated = seconds(&kept, 2, Phase::Heating);
    assert!((2398..=2405).contains(&heated), "{heated}");
    assert_eq!(sent, 1 + 80, "half a kelvin at once");
    assert!(
        kept.moments.windows(2).all(|pair| (pair[1].t_s - pair[0].t_s - 1.0).abs() < 1e-9) && kept.notes.is_empty()
    );
}

#[test]
fn a_ramp_waits_for_a_chamber_that_is_too_slow_and_says_so_once() {
    let (kept, _) = driven("{ ramp_c = 80, k_per_min = 10 }", NEVER);
    let behind = kept.moments.iter().map(|moment| moment.set_c - moment.air_c).fold(0.0, f64::max);
    assert!(behind <= 11.0, "{behind}");
    assert!(matches!(&kept.notes[..], [note] if note.contains("does not go at 10 K/min")), "{:?}", kept.notes);
}

/// The set point stays where it is, and does not jump when the chamber is back.
#[test]
fn while_the_chamber_is_away_its_soak_and_ramp_stand_still() {
    let profile = "{ ramp_c = 30, k_per_min = 1 }, { soak_c = 30, minutes = 10 }";
    let (kept, _) = driven(profile, [100.0, 400.0]);
    let whole = kept.moments.len();
    assert!((600 + 300 + 600..=600 + 300 + 610).contains(&whole), "{whole}");
    let step = kept.moments.windows(2).map(|pair| pair[1].set_c - pair[0].set_c).fold(0.0, f64::max);
    assert!(step <= 0.6, "{step}");
    assert_eq!(kept.moments.iter().filter(|moment| moment.air_c.is_nan()).count(), 300);
}
