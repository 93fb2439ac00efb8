//! What is told of a log and a chamber's recording that were joined: by which clocks, and what speaks against that or against a
//! thermometer.

use zerorate_fit::intervals::ends;

use super::Soak;

/// What is less than a log's average, ten seconds, is not told.
const TOLD_S: f64 = 10.0;
/// A sensor is colder than its air by less than this where a chamber is held to as much.
const HELD_K: f64 = 0.5;
/// A chamber that comes to a soak from a temperature so much higher, and from none that is lower.
const FROM_ABOVE_K: f64 = 5.0;
/// In the time before the soak, seconds.
const BEFORE_S: f64 = 3600.0;

/// By which clocks two were joined, and whether the data speak against it: a sentence or two.
pub(super) fn joined(by_time_of_day: bool, begins_s: f64, answers_after_s: Option<[f64; 2]>) -> String {
    let by = if by_time_of_day {
        "Joined by the time of day, as the log and the chamber's machine each tell it"
    } else {
        "Joined as it was said (`chamber_at`)"
    };
    let found = match answers_after_s {
        None => "whether the two clocks agree cannot be told from the data: the temperature moved too little, its ways have no corners, or the sensor does not follow this air".to_owned(),
        Some([from, to]) if to < -TOLD_S => format!(
            "but the sensor begins to answer {:.0} to {:.0} s before the air moves, which no sensor does: the clocks are apart by as much at least, or the chamber's thermometer is as slow. Joined by `chamber_at` {:.0} both would begin at once",
            -to,
            -from,
            begins_s + f64::midpoint(from, to)
        ),
        Some([from, to]) if from > TOLD_S => format!(
            "the sensor begins to answer {from:.0} to {to:.0} s after the air, beside its lag: so deep it lies in the board, or as much the log's clock is late; which of both, a night of the same board with clocks that were set would tell"
        ),
        Some([from, to]) => {
            // Less than an average is not claimed.
            let farthest = f64::max(-from, to).max(TOLD_S);
            if farthest > 2.0 * TOLD_S {
                format!("clocks that are apart by less than {farthest:.0} s would not be seen in these data")
            } else {
                format!("the sensor begins to answer with the air, within {farthest:.0} s: the clocks agree as far")
            }
        }
    };
    format!("{by}; {found}.")
}

/// A board under power is no colder than its air: where its sensor is at the end of every soak that was come to from above, one of the two
/// thermometers is wrong.
pub(super) fn colder_than_its_air(air: &[(f64, f64)], soaks: &[Soak]) -> Option<String> {
    let from_above = soaks.iter().filter(|soak| {
        let before =
            air.iter().filter(|(time_s, c)| (soak.from_s - BEFORE_S..soak.from_s).contains(time_s) && c.is_finite());
        let (low, high) = ends(before.map(|(_, c)| *c));
        high > soak.air_c + FROM_ABOVE_K && low > soak.air_c - FROM_ABOVE_K
    });
    let below = from_above.flat_map(|soak| soak.axes.iter().map(|axis| soak.air_c - axis.sensor_c));
    let (least, most) = ends(below);
    (least > HELD_K && most.is_finite()).then(|| {
        format!(
            "At the end of each soak that was come to from above the sensor reads {least:.1} to {most:.1} K less than the chamber's air, and a board under power is no colder than that: the chamber's thermometer reads too high by as much at least, or the sensor too low. A second thermometer beside the board tells which."
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::SoakedAxis;
    use super::*;

    #[test]
    fn by_which_clocks_and_what_speaks_against_it_is_told() {
        for (answers, parts) in [
            (None, ["time of day", "cannot be told"]),
            (Some([-31.0, -25.0]), ["begins to answer 25 to 31 s before the air", "`chamber_at` 92 both"]),
            (Some([21.0, 29.0]), ["21 to 29 s after the air", "the log's clock is late"]),
            (Some([-4.0, 6.0]), ["with the air, within 10 s", "the clocks agree"]),
            (Some([-15.0, -9.0]), ["with the air, within 15 s", "the clocks agree"]),
            (Some([-4.0, 90.0]), ["apart by less than 90 s", "would not be seen"]),
        ] {
            let told = joined(true, 120.0, answers);
            assert!(parts.iter().all(|part| told.contains(part)), "{told}");
        }
        assert!(joined(false, 120.0, None).starts_with("Joined as it was said (`chamber_at`)"));
    }

    /// A soak at the end of an hour's way, its air and what the sensor reads less.
    fn night(ways: &[(f64, f64, f64)]) -> (Vec<(f64, f64)>, Vec<Soak>) {
        let mut air = Vec::new();
        let soaks = ways.iter().enumerate().map(|(place, (from_c, to_c, below_k))| {
            let begins = 7200.0 * place as f64;
            air.extend((0..=60).map(|minute| {
                let minute = f64::from(minute);
                (begins + 60.0 * minute, from_c + (to_c - from_c) * minute / 60.0)
            }));
            let axes = vec![SoakedAxis { name: "x".into(), sensor_c: to_c - below_k, residual: 0.0, groups: 9 }];
            Soak { from_s: begins + 3601.0, to_s: begins + 7200.0, set_c: *to_c, air_c: *to_c, axes }
        });
        let soaks = soaks.collect();
        (air, soaks)
    }

    #[test]
    fn a_thermometer_that_reads_three_kelvins_too_high_is_told_where_lag_cannot_make_it() {
        let told = |ways: &[(f64, f64, f64)]| {
            let (air, soaks) = night(ways);
            colder_than_its_air(&air, &soaks)
        };
        // A board that warms itself by 0.6 K, and air that is told 3 K too high: 2.4 K less.
        let text = told(&[(25.0, -20.0, 2.4), (-20.0, 60.0, 2.9), (60.0, 25.0, 2.4)]).unwrap();
        assert!(text.contains("reads 2.4 to 2.4 K less than the chamber's air"), "{text}");
        // One that is not through at the hot end, and one whose own warmth hides it.
        assert_eq!(told(&[(25.0, -20.0, -0.6), (-20.0, 60.0, 4.0)]), None);
        assert_eq!(told(&[(-20.0, 60.0, 4.0)]), None);
        assert_eq!(told(&[(25.0, -20.0, 2.4), (60.0, 25.0, -1.0)]), None);
        assert_eq!(told(&[]), None);
    }
}
