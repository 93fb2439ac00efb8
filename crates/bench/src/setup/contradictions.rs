//! What a set-up must hold so that a run of hours does not end in a contradiction.

use zerorate_cal::compose::WIDEST_DEAD_BAND_TAPS;
use zerorate_core::drift::MAX_KNOTS;
use zerorate_core::units::{Celsius, Taps};
use zerorate_fit::model::Model;
use zerorate_instruments::supply::SupplyTable;

use super::SetUp;

impl SetUp {
    /// Taps to each side of the middle one that the trim experiment goes to, as the circuit's drawing has it; none where a
    /// number that makes them is a contradiction itself.
    fn reach_taps(&self) -> f64 {
        let taps = self.trim.span_counts / self.nominal_counts_per_tap() + f64::from(self.trim.margin_taps);
        if taps.is_finite() { taps.max(0.0) } else { 0.0 }
    }

    /// What cannot be, in sentences; empty for a sound set-up.
    #[must_use]
    pub fn contradictions(&self) -> Vec<String> {
        let Self { board, acquisition, chamber, trim, drift, limits, supply, labels: _ } = self;
        let mut found = Vec::new();
        let mut must = |holds: bool, sentence: String| {
            if !holds {
                found.push(sentence);
            }
        };
        must(
            (8..=16).contains(&board.converter_bits),
            format!("board.converter_bits is {}: it must be 8 to 16", board.converter_bits),
        );
        must(
            board.trim_part == "max5494",
            format!("board.trim_part is \"{}\": only \"max5494\" is supported so far", board.trim_part),
        );
        must(
            board.centre_counts > 0.0 && board.centre_counts < self.full_scale().0,
            format!(
                "board.centre_counts {} is outside the converter's 0 to {}",
                board.centre_counts,
                self.full_scale().0
            ),
        );
        must(
            Taps::new(board.middle_tap).is_some(),
            format!("board.middle_tap {} is not a tap: the part has 0 to {}", board.middle_tap, Taps::LAST.get()),
        );
        let (last, reach) = (f64::from(Taps::LAST.get()), self.reach_taps());
        must(
            (reach..=last - reach).contains(&f64::from(board.middle_tap)) || board.middle_tap > Taps::LAST.get(),
            format!(
                "board.middle_tap {} leaves no room for the {reach:.0} taps to each side that trim.span_counts {} and trim.margin_taps {} need of 0 to {last}",
                board.middle_tap, trim.span_counts, trim.margin_taps
            ),
        );
        must(
            board.counts_per_dps != 0.0 && board.counts_per_dps.is_finite(),
            "board.counts_per_dps must be a number other than 0".into(),
        );
        for (name, value) in [
            ("board.counts_per_celsius", board.counts_per_celsius),
            ("board.counts_at_zero_celsius", board.counts_at_zero_celsius),
            ("board.temperature_noise_counts", board.temperature_noise_counts),
            ("board.input_volts_per_count", board.input_volts_per_count),
            ("board.low_pass_hz", board.low_pass_hz),
            ("trim.span_counts", trim.span_counts),
            ("chamber.soak_s", chamber.soak_s),
            ("limits.trim_residual_pp_counts", limits.trim_residual_pp_counts),
            ("limits.hybrid_residual_floors", limits.hybrid_residual_floors),
            ("limits.mean_offset_counts", limits.mean_offset_counts),
            ("limits.soak_difference_counts", limits.soak_difference_counts),
        ] {
            must(value > 0.0 && value.is_finite(), format!("{name} is {value}: it must be above 0"));
        }
        must(
            limits.hybrid_residual_floors.is_nan() || limits.hybrid_residual_floors >= 1.0,
            format!(
                "limits.hybrid_residual_floors is {}: below 1 it asks for less than noise alone makes",
                limits.hybrid_residual_floors
            ),
        );
        must(
            (0.0..f64::from(acquisition.sample_period_us)).contains(&board.wiper_delay_us),
            "board.wiper_delay_us must be shorter than acquisition.sample_period_us".into(),
        );
        must(
            (1..=512).contains(&acquisition.group_length),
            format!("acquisition.group_length {} does not fit the port's banks of 1 to 512", acquisition.group_length),
        );
        must(
            (100..=1_000_000).contains(&acquisition.sample_period_us),
            format!(
                "acquisition.sample_period_us {} is outside the port's 100 to 1000000",
                acquisition.sample_period_us
            ),
        );
        let oversampling = acquisition.oversampling;
        must(
            oversampling.is_power_of_two() && oversampling <= 16,
            format!("acquisition.oversampling is {oversampling}: it must be 1, 2, 4, 8 or 16"),
        );
        must(
            acquisition.sample_period_us >= 100 * u32::from(oversampling) || oversampling == 1,
            format!(
                "acquisition.sample_period_us {} has no room for {oversampling} conversions of 100 each",
                acquisition.sample_period_us
            ),
        );
        let [low, high] = chamber.limits_c;
        must(
            chamber.cold_c < chamber.hot_c,
            format!("chamber.cold_c {} is not below chamber.hot_c {}", chamber.cold_c, chamber.hot_c),
        );
        for (name, value) in [("cold_c", chamber.cold_c), ("hot_c", chamber.hot_c), ("room_c", chamber.room_c)]
            .into_iter()
            .chain(chamber.soaks_c.iter().map(|&soak| ("soaks_c", soak)))
        {
            must(
                (low..=high).contains(&value),
                format!("chamber.{name} {value} is outside the chamber's limits {low} to {high}"),
            );
        }
        must(
            chamber.ramp_groups >= 40,
            format!("chamber.ramp_groups {} is too few to fit: at least 40", chamber.ramp_groups),
        );
        must(chamber.soak_groups >= 2, "chamber.soak_groups must be at least 2: the first sets the tap".into());
        must(trim.points >= 3, format!("trim.points {} is too few for a line: at least 3", trim.points));
        must(trim.groups_per_point >= 1, "trim.groups_per_point must be at least 1".into());
        must(
            (0.0..=WIDEST_DEAD_BAND_TAPS).contains(&trim.dead_band_taps),
            format!("trim.dead_band_taps {} is outside 0 to {WIDEST_DEAD_BAND_TAPS}", trim.dead_band_taps),
        );
        must(
            board.centre_counts - trim.span_counts > 0.0
                && board.centre_counts + trim.span_counts < self.full_scale().0,
            format!("trim.span_counts {} about the centre leaves the converter", trim.span_counts),
        );
        match drift.model.parse::<Model>() {
            Err(error) => must(false, format!("drift.model: {error}")),
            Ok(Model::Table(pieces)) => must(
                pieces < MAX_KNOTS,
                format!("drift.model table:{pieces} has more pieces than the device's {}", MAX_KNOTS - 1),
            ),
            Ok(_) => {}
        }
        let ends = chamber.limits_c.map(Celsius);
        found.extend(chamber.controller.iter().flat_map(|table| table.contradictions(ends)));
        found.extend(supply.iter().flat_map(SupplyTable::contradictions));
        found
    }
}
