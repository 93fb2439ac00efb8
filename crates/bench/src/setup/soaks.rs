//! The profile of a set-up: how fast its ramp is, and which soaks are made, those within the ramp that they are compared with.

use zerorate_core::units::Celsius;

use super::SetUp;

/// No ramp slower than this is too fast, kelvins a minute: three times the paper's, 100 K in an hour (docs/paper.md, S6).
pub(crate) const FASTEST_K_PER_MIN: f64 = 5.0;

impl SetUp {
    /// The temperatures of the soaks that are made.
    #[must_use]
    pub fn soaks(&self) -> Vec<Celsius> {
        self.chamber.soaks_c.iter().copied().filter(|&soak| self.is_on_the_ramp(soak)).map(Celsius).collect()
    }

    /// How fast a ramp goes if it takes the time in which its groups are taken, kelvins a minute.
    #[must_use]
    pub fn ramp_rate(&self) -> f64 {
        let [cold, hot] = self.ends();
        (hot - cold).0 / (f64::from(self.chamber.ramp_groups) * self.group_period().0 / 60.0)
    }

    /// What is told of a ramp that no chamber goes, a sentence.
    pub(super) fn ramp_too_fast(&self) -> Option<String> {
        let (rate, [cold, hot]) = (self.ramp_rate(), self.ends());
        let way = (hot - cold).0;
        let groups = way / FASTEST_K_PER_MIN * 60.0 / self.group_period().0;
        (rate > FASTEST_K_PER_MIN).then(|| {
            format!(
                "chamber.ramp_groups {} last {:.1} min, and {way:.0} K in them are {rate:.1} K/min: few chambers go faster than {FASTEST_K_PER_MIN:.0}, and only as much of the way is measured as the chamber goes in that time; a gyro that follows its air in 2.5 min would be {:.0} K behind it. The paper takes an hour for 100 K, 1.7 K/min; {groups:.0} groups make {FASTEST_K_PER_MIN:.0} K/min here",
                self.chamber.ramp_groups,
                f64::from(self.chamber.ramp_groups) * self.group_period().0 / 60.0,
                2.5 * rate
            )
        })
    }

    /// Which soaks are not made and why, a sentence; `None` where all are.
    #[must_use]
    pub fn soaks_left_out(&self) -> Option<String> {
        let (asked, [cold, hot]) = (&self.chamber.soaks_c, self.ends());
        let outside: Vec<String> =
            asked.iter().filter(|&&soak| !self.is_on_the_ramp(soak)).map(f64::to_string).collect();
        (!outside.is_empty()).then(|| {
            format!(
                "{} of the {} soaks of chamber.soaks_c are left out: {} C lie outside the ramp of {} to {} C, which measures nothing there to compare them with",
                outside.len(),
                asked.len(),
                outside.join(", "),
                cold.0,
                hot.0
            )
        })
    }

    fn is_on_the_ramp(&self, soak_c: f64) -> bool {
        let [cold, hot] = self.ends();
        (cold.0..=hot.0).contains(&soak_c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_that_no_chamber_goes_is_told_with_its_rate_and_the_papers_and_slower_ones_are_not() {
        let told = |ramp_groups: u32| {
            SetUp::parse(&format!("[chamber]\nramp_groups = {ramp_groups}"), "x").unwrap().unreachable()
        };
        // 100 K in 100 groups of 1.5 s are 40 K/min, in 801 a little less than 5.
        let fast = told(100);
        for part in ["last 2.5 min", "100 K in them are 40.0 K/min", "100 K behind", "800 groups make 5 K/min"] {
            assert!(fast.len() == 1 && fast[0].contains(part), "{part} is missing from: {fast:?}");
        }
        assert_eq!((told(801), told(2400)), (Vec::new(), Vec::new()));
    }

    #[test]
    fn soaks_outside_the_ramp_are_not_made_and_are_named() {
        // The paper's soaks are 10 K apart from -40 to 60 C: two of them lie from 20 to 32 C.
        let narrow = SetUp::parse("[chamber]\ncold_c = 20.0\nhot_c = 32.0\n", "x").unwrap();
        assert_eq!(narrow.soaks(), [Celsius(20.0), Celsius(30.0)]);
        let told = narrow.soaks_left_out().unwrap();
        assert!(
            told.starts_with("9 of the 11 soaks") && told.contains("-40, -30, -20, -10, 0, 10, 40, 50, 60 C"),
            "{told}"
        );
        let fine = SetUp::parse("[chamber]\nsoaks_c = [-40.4, 20.0]\n", "x").unwrap().soaks_left_out().unwrap();
        assert!(fine.contains(": -40.4 C lie outside the ramp of -40 to 60 C"), "{fine}");
        assert_eq!((SetUp::paper().soaks().len(), SetUp::paper().soaks_left_out()), (11, None));
    }
}
