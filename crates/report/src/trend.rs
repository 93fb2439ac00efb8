//! A trend that is left, in a sentence: the same on a screen and in a page.

use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::units::{RateScale, WrittenRate};
use zerorate_fit::trend::{Against, Trend};

use crate::number::aligned;

/// A sentence for each trend in what the model leaves of a log, in the unit that was asked for. None in most.
#[must_use]
pub fn trend_sentences(fit: &LogFit, asked: Option<WrittenRate>) -> Vec<String> {
    let of_axis = |axis: &AxisFit| {
        let scale = fit.scale(axis.calibration.rate_unit, asked);
        let sentence = |trend: &Trend| sentence(&axis.name, trend, scale);
        axis.calibration.fit.statistics.trends.iter().map(sentence).collect::<Vec<_>>()
    };
    fit.axes.iter().flat_map(of_axis).collect()
}

fn sentence(axis: &str, trend: &Trend, scale: RateScale) -> String {
    let numbers = aligned(&[trend.change.abs(), trend.standard_error].map(|rate| scale.of_rate(rate)));
    let [change, error] = [&numbers[0], &numbers[1]];
    let size = format!("{change} \u{b1} {error} {}", scale.unit());
    let (ends, meaning) = match trend.against {
        Against::Time => (
            "the log's start to its end",
            "a drift in time, which no calibration knows, or a hysteresis that the model does not hold; of either the curve may \
             hold a part besides",
        ),
        Against::Temperature => {
            ("the coldest to the hottest", "the model does not follow the whole drift over temperature")
        }
        Against::Direction => {
            let side = if trend.change < 0.0 { "lower" } else { "higher" };
            return format!(
                "{axis}: what the model leaves is {side} by {size} while it heats than while it cools: a hysteresis that the model \
                 does not hold, or a drift in time."
            );
        }
        Against::TimeOrTemperature => (
            "the log's start to its end",
            "in time or over temperature, which a log that comes back to its first temperature would tell apart",
        ),
    };
    let verb = if trend.change < 0.0 { "falls" } else { "rises" };
    format!("{axis}: what the model leaves still {verb} by {size} from {ends}: {meaning}.")
}

#[cfg(test)]
mod tests {
    use zerorate_cal::units::RateUnit;

    use super::*;

    #[test]
    fn a_trend_is_told_with_its_number_its_error_and_what_it_means() {
        let trend = Trend { against: Against::Time, change: -4e-4, standard_error: 2.5e-5 };
        let told = sentence("gyro_x", &trend, RateScale::of(RateUnit::RadPerS, &[0.01], None));
        assert_eq!(
            told,
            "gyro_x: what the model leaves still falls by 0.400 \u{b1} 0.025 mrad/s from the log's start to its end: a drift \
             in time, which no calibration knows, or a hysteresis that the model does not hold; of either the curve may hold a part \
             besides."
        );
        for (change, side) in [(3e-4, "higher"), (-3e-4, "lower")] {
            let trend = Trend { against: Against::Direction, change, standard_error: 2.5e-5 };
            let told = sentence("gyro_x", &trend, RateScale::of(RateUnit::RadPerS, &[0.01], None));
            assert!(
                told.contains(&format!("is {side} by 0.300 \u{b1} 0.025 mrad/s while it heats than while it cools")),
                "{told}"
            );
        }
    }
}
