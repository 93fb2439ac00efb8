mod steps;

use super::*;
use crate::log::Rows;
use crate::units::TemperatureUnit;

const ROWS: usize = 8400;
/// Standard deviation of the noise below: uniform over 1e-3.
const NOISE: f64 = 1e-3 / 3.464;

/// A chamber cycle like the shared recording: cool, heat, cool, two rows a second.
pub(crate) fn cycle() -> (Vec<f64>, [Vec<f64>; 2]) {
    let temperatures: Vec<f64> = (0..ROWS)
        .map(|row| {
            let t = row as f64 / ROWS as f64;
            28.0 + 45.0 * (std::f64::consts::TAU * 1.2 * t + 1.0).cos()
        })
        .collect();
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        1e-3 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    let rates = [1.0, -2.0]
        .map(|factor| temperatures.iter().map(|t| factor * (0.01 + 3e-4 * t - 2e-6 * t * t) + noise()).collect());
    (temperatures, rates)
}

fn rows<'a>(time_s: &'a [f64], temperature: &'a [f64], values: &'a [Vec<f64>]) -> Rows<'a> {
    Rows { sensor: 0, part: 0, first_row: 0, time_s, temperature, values }
}

fn condition(temperatures: &[f64], rates: &[Vec<f64>]) -> (Vec<Group>, Vec<Tally>, Levels) {
    let length = Length::of_extent(ROWS as u64, 0.5, None);
    let mut grouping = Grouping::new(rates.len(), length, TemperatureUnit::C, 0);
    let time_s: Vec<f64> = (0..temperatures.len()).map(|row| row as f64 * 0.5).collect();
    grouping.push_rows(&rows(&time_s, temperatures, rates));
    let (mut groups, mut tallies) = grouping.finish();
    let levels = level(&mut groups, &mut tallies, TemperatureUnit::C, f64::INFINITY, &[]);
    (groups, tallies, levels)
}

#[test]
fn groups_last_ten_seconds_and_are_neither_too_few_nor_too_many() {
    let of = |rows, step_s, asked_s| match Length::of_extent(rows, step_s, asked_s) {
        Length::Rows { rows, .. } => rows,
        Length::Seconds(_) => 0,
    };
    assert_eq!(of(8400, 0.5054, None), 21);
    assert_eq!(of(4_000_000, 1e-3, None), 10_000);
    assert_eq!(of(2400, 1.5, None), 21);
    assert_eq!(of(300, 0.5, None), 4);
    assert_eq!(of(10, f64::NAN, None), 1);
    assert_eq!(of(100_000_000, 0.5, None), 5000);
    assert_eq!(of(8400, 0.5, Some(2.0)), 4);
}

#[test]
fn a_few_rows_at_the_end_or_before_a_gap_belong_to_the_group_before() {
    let ends = |count: usize, gap_after: usize, length: Length| -> Vec<(u64, u64)> {
        let mut grouping = Grouping::new(1, length, TemperatureUnit::C, 0);
        let time_s: Vec<f64> =
            (0..count).map(|row| 0.1 * row as f64 + if row < gap_after { 0.0 } else { 1000.0 }).collect();
        grouping.push_rows(&rows(&time_s, &vec![20.0; count], &[vec![0.5; count]]));
        grouping.finish().0.iter().map(|group| (group.first_row, group.end_row)).collect()
    };
    let by_rows = Length::Rows { rows: 100, step_s: 0.1 };
    for length in [by_rows, Length::Seconds(10.0)] {
        assert_eq!(ends(203, 203, length), [(0, 100), (100, 203)]);
        assert_eq!(ends(249, 203, length), [(0, 100), (100, 203), (203, 249)]);
    }
    assert_eq!(ends(260, 260, by_rows), [(0, 100), (100, 200), (200, 260)]);
    // Alone it is what there is.
    assert_eq!(ends(3, 3, by_rows), [(0, 3)]);
}

#[test]
fn a_clean_cycle_is_left_as_it_is() {
    let (temperatures, rates) = cycle();
    let (groups, tallies, levels) = condition(&temperatures, &rates);
    assert_eq!(groups.len(), 400);
    assert_eq!(levels, Levels::default());
    assert!(tallies.iter().all(|tally| tally.rejected().is_empty()), "{tallies:?}");
    assert!((groups[7].axes[0].scatter / NOISE - 1.0).abs() < 0.5);
}

#[test]
fn rows_without_a_number_are_dropped_and_counted() {
    let (mut temperatures, mut rates) = cycle();
    (0..ROWS).step_by(50).for_each(|row| temperatures[row] = f64::NAN);
    rates[1][77] = f64::NAN;
    let (groups, tallies, _) = condition(&temperatures, &rates);
    assert_eq!(tallies[0].count(DropReason::MissingTemperature), 168);
    assert_eq!((tallies[0].count(DropReason::MissingRate), tallies[1].count(DropReason::MissingRate)), (0, 1));
    let used: u64 = groups.iter().map(|group| u64::from(group.axes[1].rows)).sum();
    assert_eq!(used, 8400 - 168 - 1);
}

#[test]
fn spikes_are_dropped_and_a_first_row_outlier_is_start_up() {
    let (mut temperatures, mut rates) = cycle();
    (60..ROWS).step_by(105).for_each(|row| rates[0][row] += 0.8);
    rates[0][0] -= 0.024;
    temperatures[4000] = 85.0;
    let (groups, tallies, levels) = condition(&temperatures, &rates);
    assert_eq!(tallies[0].count(DropReason::Spike), 80);
    assert_eq!(tallies[0].count(DropReason::StartUp), 1);
    assert_eq!(tallies[1].count(DropReason::Spike), 0);
    assert_eq!(tallies[1].count(DropReason::TemperatureSpike), 1);
    assert_eq!(levels, Levels::default());
    assert!(groups.iter().all(|group| group.axes[0].scatter < 2.0 * NOISE));
}

#[test]
fn a_rotation_is_left_out_of_every_axis_with_its_range() {
    let (temperatures, mut rates) = cycle();
    (5000..5060).for_each(|row| rates[0][row] += 2.0);
    let (groups, tallies, levels) = condition(&temperatures, &rates);
    let [interval] = &levels.excluded[..] else { panic!("{levels:?}") };
    assert!(interval.rows.0 <= 5000 && interval.rows.1 >= 5060 && interval.rows.1 - interval.rows.0 <= 84);
    assert!((2490.0..2510.0).contains(&interval.time_s.0));
    let of_rows = (0_u64..).zip(&temperatures).filter(|(row, _)| (interval.rows.0..interval.rows.1).contains(row));
    let (least, most) = of_rows.fold((f64::NAN, f64::NAN), |(a, b), (_, t)| (t.min(a), t.max(b)));
    assert_eq!(interval.temperature, (least, most), "of its rows, not of their averages");
    assert!(tallies[1].count(DropReason::Rotation) >= 60);
    assert!(levels.steps.is_empty());
    assert!(groups.iter().all(|group| group.axes[0].rows == 0 || group.axes[0].rate < 0.1));
}

#[test]
fn a_rotation_that_lasts_is_one_interval_and_no_steps() {
    let (temperatures, clean) = cycle();
    let mut rates = clean.clone();
    // 400 s at a rate below what only turning shows: two steps of one size.
    (4000..4800).for_each(|row| rates[0][row] += 0.2);
    let (groups, _, levels) = condition(&temperatures, &rates);
    assert_eq!(levels.steps, []);
    let [interval] = &levels.excluded[..] else { panic!("{levels:?}") };
    assert_eq!(interval.reason, DropReason::Rotation);
    assert!(
        interval.rows.0 <= 4000 && interval.rows.1 >= 4800 && interval.rows.1 - interval.rows.0 <= 860,
        "{interval:?}"
    );
    let (clean, ..) = condition(&temperatures, &clean);
    for (group, clean) in groups.iter().zip(&clean).filter(|(group, _)| group.axes[0].rows > 0) {
        assert!((group.axes[0].rate - clean.axes[0].rate).abs() < 1e-3);
        assert!((group.time_s - clean.time_s).abs() < 1e-9 && group.temperature.is_finite());
    }
}

#[test]
fn a_temperature_that_stands_still_and_jumps_is_left_out_and_one_that_holds_is_not() {
    let (mut temperatures, rates) = cycle();
    let held = temperatures[3000];
    temperatures[3000..3400].fill(held);
    let (_, tallies, levels) = condition(&temperatures, &rates);
    let [interval] = &levels.excluded[..] else { panic!("{levels:?}") };
    assert_eq!(interval.reason, DropReason::FrozenTemperature);
    assert!(interval.rows.0.abs_diff(3000) <= 21 && interval.rows.1.abs_diff(3400) <= 42, "{interval:?}");
    assert!(tallies[1].count(DropReason::FrozenTemperature) > 300);
}

fn without_untrue(temperatures: &[f64], rates: &[Vec<f64>]) -> (Vec<Group>, Vec<Excluded>) {
    let mut grouping = Grouping::new(rates.len(), Length::of_extent(ROWS as u64, 0.5, None), TemperatureUnit::C, 0);
    let time_s: Vec<f64> = (0..temperatures.len()).map(|row| row as f64 * 0.5).collect();
    grouping.push_rows(&rows(&time_s, temperatures, rates));
    let step = grouping.temperature_step();
    let (mut groups, mut tallies) = grouping.finish();
    let excluded = leave_out_untrue_temperatures(&mut groups, &mut tallies, TemperatureUnit::C, step);
    (groups, excluded)
}

#[test]
fn a_temperature_that_jumps_away_and_back_is_left_out_and_no_history_goes_there() {
    let (clean, rates) = cycle();
    assert_eq!(without_untrue(&clean, &rates).1, []);
    for (long, shows) in [(10, 85.0), (100, 85.0), (100, 0.0), (600, -127.0)] {
        let mut temperatures = clean.clone();
        temperatures[2005..2005 + long].fill(shows);
        let (groups, excluded) = without_untrue(&temperatures, &rates);
        let [interval] = &excluded[..] else { panic!("{long} rows at {shows}: {excluded:?}") };
        assert_eq!(interval.reason, DropReason::TemperatureSpike);
        let (first, end) = interval.rows;
        assert!(first <= 2005 && end >= 2005 + long as u64 && end - first < long as u64 + 42, "{interval:?}");
        for group in &groups {
            let at = clean[usize::try_from(u64::midpoint(group.first_row, group.end_row)).unwrap()];
            assert!((group.temperature - at).abs() < 2.0, "{} for {at}", group.temperature);
        }
    }
}

#[test]
fn a_noisy_temperature_that_stands_still_has_stopped_and_one_of_a_coarse_sensor_rests() {
    let (temperatures, rates) = cycle();
    // A twentieth of a degree to and fro, and from row 6000 on one number, to the last and shorter average.
    let rows_but = ROWS - 9;
    let shorter = rates.map(|rate| rate[..rows_but].to_vec());
    let noisy: Vec<f64> =
        temperatures.iter().zip(0_u32..).map(|(t, row)| t + 1e-3 * f64::from(row * 7919 % 101)).collect();
    let stopped: Vec<f64> = (0..rows_but).map(|row| noisy[row.min(6000)]).collect();
    let (_, excluded) = without_untrue(&stopped, &shorter);
    let [interval] = &excluded[..] else { panic!("{excluded:?}") };
    assert_eq!((interval.reason, interval.rows.1), (DropReason::FrozenTemperature, rows_but as u64));
    // With the average in which it stopped.
    assert!((5979..=6000).contains(&interval.rows.0), "{interval:?}");
    let coarse: Vec<f64> = stopped.iter().map(|t| (10.0 * t).round() / 10.0).collect();
    assert_eq!(without_untrue(&coarse, &shorter).1, []);
}

#[test]
fn what_settles_after_the_start_is_left_out() {
    let (temperatures, mut rates) = cycle();
    (0..120).for_each(|row| rates[1][row] += 0.02 * (-(row as f64) / 25.0).exp());
    let (groups, tallies, levels) = condition(&temperatures, &rates);
    let [interval] = &levels.excluded[..] else { panic!("{levels:?}") };
    assert_eq!((interval.reason, interval.rows.0), (DropReason::StartUp, 0));
    assert!((42..=168).contains(&interval.rows.1), "{interval:?}");
    assert!(tallies[0].count(DropReason::StartUp) >= 42);
    assert!(groups[0].temperature.is_finite());
}

#[test]
fn a_time_without_rows_is_told() {
    let (temperatures, rates) = cycle();
    let kept: Vec<usize> = (0..ROWS).filter(|row| !(2000..2600).contains(row)).collect();
    let time_s: Vec<f64> = kept.iter().map(|row| *row as f64 * 0.5).collect();
    let temperatures: Vec<f64> = kept.iter().map(|row| temperatures[*row]).collect();
    let rates = rates.map(|rate| kept.iter().map(|row| rate[*row]).collect::<Vec<f64>>());
    for length in [Length::Seconds(10.0), Length::of_extent(kept.len() as u64, 0.54, None)] {
        let mut grouping = Grouping::new(2, length, TemperatureUnit::C, 0);
        grouping.push_rows(&rows(&time_s, &temperatures, &rates));
        let (mut groups, mut tallies) = grouping.finish();
        assert!(groups.iter().all(|group| group.times_s.1 - group.times_s.0 < 20.0));
        let levels = level(&mut groups, &mut tallies, TemperatureUnit::C, f64::INFINITY, &[]);
        let [gap] = &levels.excluded[..] else { panic!("{levels:?}") };
        assert_eq!((gap.reason, gap.rows, gap.time_s), (DropReason::Gap, (2000, 2000), (999.5, 1300.0)));
        assert!(tallies.iter().all(|tally| tally.rejected().is_empty()), "{tallies:?}");
    }
}

#[test]
fn a_ramp_that_turned_while_nothing_was_read_was_not_moved() {
    let time_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * 0.5).collect();
    // Up and straight down, and a rate that follows.
    let temperatures: Vec<f64> = (0..ROWS).map(|row| 60.0 - 0.02 * (row as f64 - 4200.0).abs()).collect();
    let (_, noise) = cycle();
    let curve = |t: f64| 0.01 + 3e-4 * t - 2e-6 * t * t;
    let (calm, _) = cycle();
    let rate = |row: usize| noise[0][row] - curve(calm[row]) + curve(temperatures[row]);
    let whole: Vec<f64> = (0..ROWS).map(rate).collect();
    for lost in [3800..4300, 3900..4400, 4100..4900] {
        let mut rates = whole.clone();
        rates[lost.clone()].fill(f64::NAN);
        let (groups, tallies, levels) = condition(&temperatures, &[rates]);
        assert!(levels.excluded.is_empty() && levels.steps.is_empty(), "{lost:?}: {levels:?}");
        assert_eq!(tallies[0].count(DropReason::Rotation), 0, "{lost:?}");
        // And as rows that are not there.
        let kept: Vec<usize> = (0..ROWS).filter(|row| !lost.contains(row)).collect();
        let of = |values: &[f64]| kept.iter().map(|row| values[*row]).collect::<Vec<f64>>();
        let mut grouping = Grouping::new(1, Length::of_extent(ROWS as u64, 0.5, None), TemperatureUnit::C, 0);
        grouping.push_rows(&rows(&of(&time_s), &of(&temperatures), &[of(&whole)]));
        let (mut groups_of_kept, mut tallies) = grouping.finish();
        assert!(groups_of_kept.len() < groups.len());
        let levels = level(&mut groups_of_kept, &mut tallies, TemperatureUnit::C, f64::INFINITY, &[]);
        assert!(levels.excluded.iter().all(|interval| interval.reason == DropReason::Gap), "{lost:?}: {levels:?}");
    }
}

#[test]
fn a_unit_that_was_moved_beside_a_gap_was_moved() {
    let (temperatures, [calm, _]) = cycle();
    for (moved, lost) in [(3725..3775, 3775..4475), (4475..4525, 3775..4475)] {
        let mut rates = calm.clone();
        rates[moved.clone()].iter_mut().for_each(|rate| *rate += 0.035);
        rates[lost].fill(f64::NAN);
        let (_, tallies, levels) = condition(&temperatures, &[rates]);
        let is_left_out = |row: &u64| {
            levels.excluded.iter().any(|interval| {
                interval.reason == DropReason::Rotation && (interval.rows.0..interval.rows.1).contains(row)
            })
        };
        assert!((moved.start as u64..moved.end as u64).all(|row| is_left_out(&row)), "{moved:?}: {levels:?}");
        assert!(levels.steps.is_empty() && tallies[0].count(DropReason::Rotation) <= 150, "{levels:?}, {tallies:?}");
    }
}

#[test]
fn rows_a_minute_apart_have_no_gaps_between_them() {
    let time_s: Vec<f64> = (0..100).map(|row| 60.0 * f64::from(row)).collect();
    let temperatures: Vec<f64> = (0..100).map(|row| 0.5 * f64::from(row)).collect();
    let mut grouping = Grouping::new(1, Length::of_extent(100, 60.0, None), TemperatureUnit::C, 0);
    grouping.push_rows(&rows(&time_s, &temperatures, &[vec![0.0; 100]]));
    let (mut groups, mut tallies) = grouping.finish();
    let levels = level(&mut groups, &mut tallies, TemperatureUnit::C, f64::INFINITY, &[]);
    assert_eq!((groups.len(), levels.excluded), (100, Vec::new()));
}

#[test]
fn each_degree_counts_alike_however_long_the_log_dwelt_on_it() {
    let mut temperatures = vec![20.0; 4000];
    temperatures.extend((0..4000).map(|row| 20.0 + 0.01 * f64::from(row)));
    let rates = [vec![0.0; 8000]];
    let (mut groups, ..) = condition(&temperatures, &rates);
    weigh(&mut groups, 0);
    let weights = |range: std::ops::Range<f64>| -> f64 {
        groups.iter().filter(|group| range.contains(&group.temperature)).map(|group| group.axes[0].weight).sum()
    };
    let mean = weights(-1e9..1e9) / groups.len() as f64;
    assert!((mean - 1.0).abs() < 1e-9, "{mean}");
    let (dwelt, passed) = (weights(19.5..22.0), weights(40.0..42.5));
    assert!(dwelt / passed < 0.35 * 200.0 / 12.0, "{dwelt} {passed}");
}

/// A sensor of 2 or 4 C whose noise of a tenth of a step makes it go to and fro beside a stair's edge.
#[test]
fn the_stairs_of_a_coarse_sensor_are_no_spikes_and_a_spike_on_them_is_one() {
    let (smooth, rates) = cycle();
    for step in [2.0, 4.0] {
        let mut state = 3_u64;
        let mut stairs: Vec<f64> = smooth
            .iter()
            .map(|t| {
                state = 16_807 * state % 2_147_483_647;
                let noise = 0.35 * step * (state as f64 / 2_147_483_647.0 - 0.5);
                step * ((t + noise) / step).round()
            })
            .collect();
        let spikes = |temperatures: &[f64]| -> Vec<u64> {
            let tallies = condition(temperatures, &rates).1;
            tallies.iter().map(|tally| tally.count(DropReason::TemperatureSpike)).collect()
        };
        assert_eq!(spikes(&stairs), [0, 0], "steps of {step}");
        stairs[4203] += 20.0 * step;
        assert_eq!(spikes(&stairs), [1, 1], "steps of {step}");
    }
}

#[test]
fn a_coarse_temperature_is_dequantised() {
    let (temperatures, rates) = cycle();
    let steps: Vec<f64> = temperatures.iter().map(|t| 10.0 * (t / 10.0).round()).collect();
    let (mut groups, ..) = condition(&steps, &rates);
    dequantise(&mut groups, 10.0);
    let (truth, ..) = condition(&temperatures, &rates);
    let rms = |groups: &[Group]| {
        let squares = groups.iter().zip(&truth).map(|(group, truth)| (group.temperature - truth.temperature).powi(2));
        (squares.sum::<f64>() / truth.len() as f64).sqrt()
    };
    let (raw, ..) = condition(&steps, &rates);
    assert!(rms(&groups) < 0.8 * rms(&raw), "{} {}", rms(&groups), rms(&raw));
}

#[test]
fn groups_before_the_first_temperature_lie_on_the_line_through_the_first_ones() {
    let (mut temperatures, rates) = cycle();
    let whole = condition(&temperatures, &rates).0;
    temperatures[..100].fill(f64::NAN);
    let (mut groups, ..) = condition(&temperatures, &rates);
    assert!(groups[..4].iter().all(|group| group.temperature.is_nan()));
    extend_to_the_start(&mut groups);
    for (group, whole) in groups.iter().zip(&whole).take(4) {
        assert!((group.temperature - whole.temperature).abs() < 0.3, "{} {}", group.temperature, whole.temperature);
        assert_eq!(group.axes[0].rows, 0, "its rates are left out all the same");
    }
    // Ten minutes are not drawn from one.
    temperatures[..1200].fill(f64::NAN);
    let (mut groups, ..) = condition(&temperatures, &rates);
    extend_to_the_start(&mut groups);
    assert!(groups[..50].iter().all(|group| group.temperature.is_nan()) && groups[52].temperature.is_finite());
}
