//! What the report of a lot shows.

use zerorate_cal::log_fit::LogFit;

/// A lot of units, in counts.
#[derive(Debug, Clone, PartialEq)]
pub struct LotReport {
    /// The rows it was made from, as they were given.
    pub source: String,
    /// The model asked for.
    pub model: String,
    /// The units, in the order of their time.
    pub units: Vec<LotUnit>,
    /// The limits a unit must keep, each over both axes.
    pub limits: Vec<LotLimit>,
    /// The worst units with their fits, the worst first.
    pub worst: Vec<WorstUnit>,
    /// What the lot has beside its units; `None` where the rows do not tell.
    pub beside: Option<LotBeside>,
    /// How many worst units could not be drawn, and why; empty where all could.
    pub undrawn: Vec<String>,
}

/// What a lot has beside the recordings that were fitted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LotBeside {
    /// Files that were skipped: the name of each, and why.
    pub skipped: Vec<(String, String)>,
    /// Recordings of other procedures.
    pub other_procedures: u64,
}

/// One unit.
#[derive(Debug, Clone, PartialEq)]
pub struct LotUnit {
    /// Its serial.
    pub serial: String,
    /// Its recording.
    pub file: String,
    /// The station that recorded it.
    pub station: String,
    /// When it was recorded, days since the first unit; NaN if not known.
    pub day: f64,
    /// Why it was rejected, a sentence each; empty for a unit that was not.
    pub rejected: Vec<String>,
    /// What else there is to look at, a sentence each.
    pub warned: Vec<String>,
    /// Its fits, X first; none where it could not be fitted.
    pub axes: Vec<LotAxis>,
}

/// The fit of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct LotAxis {
    /// The axis's name.
    pub name: String,
    /// The values of [`Quantity::ALL`], counts.
    pub values: [f64; 5],
}

/// A number that every fit has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The drift over the valid range, peak to peak.
    Drift,
    /// The reading in the middle of the valid range.
    Reading,
    /// What the fit leaves, rms.
    InSample,
    /// What it leaves of folds predicted by the fit of the others, rms.
    HeldOut,
    /// The same, peak to peak.
    HeldOutPp,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Drift, Self::Reading, Self::InSample, Self::HeldOut, Self::HeldOutPp];

    /// The name in a limits file.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Drift => "drift_pp_counts",
            Self::Reading => "reading_mid_counts",
            Self::InSample => "in_sample_rms_counts",
            Self::HeldOut => "held_out_rms_counts",
            Self::HeldOutPp => "held_out_pp_counts",
        }
    }

    /// The name in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Drift => "drift, peak to peak",
            Self::Reading => "reading in mid range",
            Self::InSample => "in-sample residual, rms",
            Self::HeldOut => "held-out residual, rms",
            Self::HeldOutPp => "held-out residual, peak to peak",
        }
    }
}

/// A limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LotLimit {
    /// Of what.
    pub quantity: Quantity,
    /// The least that passes, counts.
    pub min: f64,
    /// The greatest that passes, counts.
    pub max: f64,
}

impl LotLimit {
    /// Whether both axes of a unit keep it; a number that is missing does not.
    #[must_use]
    pub fn kept_by(&self, unit: &LotUnit) -> bool {
        let inside = |axis: &LotAxis| {
            let value = axis.values[self.quantity as usize];
            self.min <= value && value <= self.max
        };
        !unit.axes.is_empty() && unit.axes.iter().all(inside)
    }
}

/// A unit among the worst.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstUnit {
    /// Its serial.
    pub serial: String,
    /// The worse of its axes, by its name.
    pub axis: String,
    /// That axis's held-out residual, counts rms.
    pub held_out_rms: f64,
    /// Its fit.
    pub fit: LogFit,
}

impl LotReport {
    /// Units that were not rejected and keep every limit.
    #[must_use]
    pub fn passed(&self) -> usize {
        let passes = |unit: &&LotUnit| unit.rejected.is_empty() && self.limits.iter().all(|limit| limit.kept_by(unit));
        self.units.iter().filter(passes).count()
    }

    /// Units that were rejected.
    #[must_use]
    pub fn rejected(&self) -> usize {
        self.units.iter().filter(|unit| !unit.rejected.is_empty()).count()
    }

    /// Units that were not rejected and miss a limit.
    #[must_use]
    pub fn outside(&self) -> usize {
        self.units.len() - self.passed() - self.rejected()
    }

    /// Units that were not rejected and have something to look at.
    #[must_use]
    pub fn warned(&self) -> usize {
        self.units.iter().filter(|unit| unit.rejected.is_empty() && !unit.warned.is_empty()).count()
    }

    /// The files that were skipped, with the reasons; none where the rows do not tell.
    #[must_use]
    pub fn skipped(&self) -> &[(String, String)] {
        self.beside.as_ref().map_or(&[], |beside| &beside.skipped)
    }

    /// [`LotReport::undrawn`] with what many units share said once: sentences that differ in nothing but the unit and its
    /// recording are one, with the number of units.
    #[must_use]
    pub fn undrawn_notes(&self) -> Vec<String> {
        let mut groups: Vec<(String, Vec<&str>, &str)> = Vec::new();
        for sentence in &self.undrawn {
            let (serial, why) = sentence.split_once(": ").unwrap_or(("", sentence));
            let common = self.without_recording(serial, why);
            match groups.iter_mut().find(|group| group.0 == common) {
                Some(group) => group.1.push(serial),
                None => groups.push((common, vec![serial], sentence)),
            }
        }
        let note = |(common, serials, sentence): (String, Vec<&str>, &str)| match serials.len() {
            1 => sentence.to_owned(),
            units => format!("{units} of the worst units ({}) are {common}", serials.join(", ")),
        };
        groups.into_iter().map(note).collect()
    }

    /// A sentence about a unit without what names its recording: its file, wherever that lies, and its serial.
    fn without_recording(&self, serial: &str, sentence: &str) -> String {
        let Some(unit) = self.units.iter().find(|unit| unit.serial == serial) else { return sentence.to_owned() };
        let name = unit.file.rsplit(['/', '\\']).next().unwrap_or(&unit.file);
        let without = |text: String, what: &str| if what.is_empty() { text } else { text.replace(what, "…") };
        let sentence = sentence.replace(&format!("{}: ", unit.file), "");
        without(without(sentence, name), serial)
    }
}
