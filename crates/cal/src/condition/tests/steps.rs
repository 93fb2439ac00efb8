use super::*;

#[test]
fn a_step_is_found_sized_and_taken_out() {
    let (temperatures, clean) = cycle();
    let mut rates = clean.clone();
    (4000..ROWS).for_each(|row| rates[0][row] += 0.02);
    let (groups, _, levels) = condition(&temperatures, &rates);
    let [step] = &levels.steps[..] else { panic!("{levels:?}") };
    assert_eq!(step.axis, 0);
    assert!((3979..=4021).contains(&step.row), "{step:?}");
    // It is where it was made, and that is told to within three averages.
    assert!(step.rows.0 <= 4000 && 4000 <= step.rows.1 && step.rows.1 - step.rows.0 <= 63, "{step:?}");
    assert!(step.time_s.0 <= 2000.0 && 2000.0 <= step.time_s.1, "{step:?}");
    let (least, most) = step.temperature;
    assert!(least <= temperatures[4000] && temperatures[4000] <= most && most - least < 1.0, "{step:?}");
    assert!((step.size - 0.02).abs() < 5e-4, "{step:?}");
    let (clean, _, _) = condition(&temperatures, &clean);
    for (group, clean) in groups.iter().zip(&clean).filter(|(group, _)| group.axes[0].rows > 0) {
        assert!((group.axes[0].rate - clean.axes[0].rate).abs() < 1e-3);
    }
}

#[test]
fn a_step_is_sized_to_its_error_wherever_it_cuts_an_average() {
    let (temperatures, clean) = cycle();
    // Sixteen times the noise of a row: no more than an average that is cut scatters as a moved one does.
    let size = -16.0 * NOISE;
    let mut squares = 0.0;
    for cut in 0..21 {
        let mut rates = clean.clone();
        let noise =
            |row: usize| clean[1][row] - (-2.0 * (0.01 + 3e-4 * temperatures[row] - 2e-6 * temperatures[row].powi(2)));
        (0..ROWS).for_each(|row| rates[0][row] = 1e-5 * temperatures[row] + noise(row));
        (3990 + cut..ROWS).for_each(|row| rates[0][row] += size);
        let (groups, _, levels) = condition(&temperatures, &rates);
        let [step] = &levels.steps[..] else { panic!("{cut}: {levels:?}") };
        assert!(step.rows.0 <= 3990 + cut as u64 && 3990 + cut as u64 <= step.rows.1, "{cut}: {step:?}");
        assert!((step.size - size).abs() < 4.0 * step.error && step.error < -0.1 * size, "{cut}: {step:?}");
        squares += ((step.size - size) / step.error).powi(2);
        let kept = groups.iter().filter(|group| group.axes[0].rows > 0);
        assert!(kept.clone().all(|group| (group.axes[0].rate - 1e-5 * group.temperature).abs() < 2.0 * NOISE));
    }
    assert!((squares / 21.0).sqrt() < 2.0, "{squares}");
}

#[test]
fn what_went_and_came_back_is_taken_out_on_both_sides_or_on_none() {
    let (temperatures, clean) = cycle();
    // About the share of the drift from which a step is taken out, and for five minutes.
    for size in [1.8e-3, 2.1e-3, 2.4e-3, 2.7e-3, 3.0e-3] {
        let mut rates = clean.clone();
        rates[0][3995..4600].iter_mut().for_each(|rate| *rate += size);
        let (groups, _, levels) = condition(&temperatures, &rates);
        let last = |groups: &[Group]| groups[300..].iter().map(|group| group.axes[0].rate).sum::<f64>();
        let (clean, ..) = condition(&temperatures, &clean);
        assert!((last(&groups) - last(&clean)).abs() / 100.0 < 0.1 * size, "{size}: {levels:?}");
    }
}

#[test]
fn a_gap_across_which_the_curve_goes_on_is_no_step() {
    let (temperatures, clean) = cycle();
    // A bend that lines on either side would draw past one another by more than a tenth of the whole.
    let bend = |t: f64| 2e-3 * ((t - 28.0) / 15.0).tanh();
    let mut rates = clean.clone();
    rates[0].iter_mut().zip(&temperatures).for_each(|(rate, t)| *rate += 10.0 * bend(*t));
    for start in [2200, 3000, 5400, 6300] {
        let mut gap = rates.clone();
        gap.iter_mut().for_each(|rate| rate[start..start + 1000].fill(f64::NAN));
        let (_, _, levels) = condition(&temperatures, &gap);
        assert_eq!((levels.steps, levels.left_in), (vec![], vec![]), "from {start}");
        // A step across a short gap is found.
        let mut short = rates.clone();
        short.iter_mut().for_each(|rate| rate[start..start + 100].fill(f64::NAN));
        short[0][start..].iter_mut().for_each(|rate| *rate += 0.04);
        let (_, _, levels) = condition(&temperatures, &short);
        assert_eq!(levels.steps.len(), 1, "from {start}");
    }
}

#[test]
fn a_step_that_is_small_beside_the_drift_is_told_and_left_in() {
    let (temperatures, mut rates) = cycle();
    let (clean, _, levels) = condition(&temperatures, &rates);
    assert_eq!((levels.steps, levels.left_in), (vec![], vec![]));
    // An eighth of the peak to peak, thirty standard deviations of a group's mean.
    rates[0][4000..].iter_mut().for_each(|rate| *rate += 2e-3);
    let (groups, _, levels) = condition(&temperatures, &rates);
    assert_eq!(levels.steps, []);
    let [step] = &levels.left_in[..] else { panic!("{levels:?}") };
    assert!(step.axis == 0 && (step.size - 2e-3).abs() < 3e-4, "{step:?}");
    assert!((step.rows.0..=step.rows.1).contains(&4000), "{step:?}");
    let last = |groups: &[Group]| groups.last().unwrap().axes[0].rate;
    assert!((last(&groups) - last(&clean) - 2e-3).abs() < 1e-12, "it is left in");
}

#[test]
fn a_step_of_eight_standard_deviations_of_an_average_is_told_and_left_in() {
    // Of 21 rows an average.
    let size = 8.0 * NOISE / 21_f64.sqrt();
    let mut told = 0;
    for row in (1500..7000).step_by(500) {
        let (temperatures, mut rates) = cycle();
        rates[1][row..].iter_mut().for_each(|rate| *rate -= size);
        let (_, _, levels) = condition(&temperatures, &rates);
        assert_eq!(levels.steps, []);
        for step in &levels.left_in {
            // Noise hides half an average more.
            let near = (step.rows.0 - 10..=step.rows.1 + 10).contains(&(row as u64));
            assert!(step.axis == 1 && near, "{row}: {step:?}");
            assert!((step.size + size).abs() < 4.0 * step.error && step.temperature.0 < step.temperature.1, "{step:?}");
            told += 1;
        }
    }
    assert!(told >= 9, "{told} of 11");
}

#[test]
fn a_coarse_converter_is_no_motion_and_no_step() {
    let (temperatures, clean) = cycle();
    // Twenty steps over the drift, with noise of a tenth of one and of none.
    for (noise, step) in [(1.0, 3e-3), (0.0, 3e-3), (1.0, 6e-3)] {
        let curve = |t: f64| 0.01 + 3e-4 * t - 2e-6 * t * t;
        let coarse = |(rate, t): (&f64, &f64)| ((curve(*t) + noise * (rate - curve(*t))) / step).round() * step;
        let rates = [clean[0].iter().zip(&temperatures).map(coarse).collect::<Vec<f64>>()];
        let length = Length::of_extent(ROWS as u64, 0.5, None);
        let mut grouping = Grouping::new(1, length, TemperatureUnit::C, 0);
        let time_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * 0.5).collect();
        grouping.push_rows(&rows(&time_s, &temperatures, &rates));
        let steps = grouping.rate_steps();
        assert!((steps[0] / step - 1.0).abs() < 1e-6, "{steps:?}");
        let (mut groups, mut tallies) = grouping.finish();
        let levels = level(&mut groups, &mut tallies, TemperatureUnit::C, f64::INFINITY, &steps);
        assert_eq!(levels, Levels::default(), "{noise} {step}");
        assert!(tallies[0].rejected().is_empty(), "{tallies:?}");
    }
}

#[test]
fn a_gap_beside_a_turn_is_no_step_though_heating_and_cooling_differ() {
    let time_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * 0.5).collect();
    // Up and straight down, with hysteresis of an eighth of the drift.
    let temperatures: Vec<f64> = (0..ROWS).map(|row| 60.0 - 0.02 * (row as f64 - 4200.0).abs()).collect();
    let (calm, [clean, _]) = cycle();
    let curve = |t: f64| 0.01 + 3e-4 * t - 2e-6 * t * t;
    // As a play does: over some degrees of the way back.
    let way = |row: usize| 2e-3 - 4e-3 * ((row as f64 - 4200.0) / 300.0).clamp(0.0, 1.0);
    let whole: Vec<f64> =
        (0..ROWS).map(|row| clean[row] - curve(calm[row]) + curve(temperatures[row]) + way(row)).collect();
    for lost in [4000..4300, 4050..4210, 4190..4500, 4260..4500] {
        let mut rates = whole.clone();
        rates[lost.clone()].fill(f64::NAN);
        let (_, _, levels) = condition(&temperatures, &[rates]);
        assert!(levels.steps.is_empty() && levels.left_in.is_empty(), "{lost:?}: {levels:?}");
        let kept: Vec<usize> = (0..ROWS).filter(|row| !lost.contains(row)).collect();
        let of = |values: &[f64]| kept.iter().map(|row| values[*row]).collect::<Vec<f64>>();
        let mut grouping = Grouping::new(1, Length::of_extent(ROWS as u64, 0.5, None), TemperatureUnit::C, 0);
        grouping.push_rows(&rows(&of(&time_s), &of(&temperatures), &[of(&whole)]));
        let (mut groups, mut tallies) = grouping.finish();
        let levels = level(&mut groups, &mut tallies, TemperatureUnit::C, f64::INFINITY, &[]);
        assert!(levels.steps.is_empty() && levels.left_in.is_empty(), "{lost:?}: {levels:?}");
    }
}

#[test]
fn a_rate_that_goes_by_how_fast_the_temperature_changes_does_not_step_where_a_ramp_begins_or_ends() {
    let (of_cycle, clean) = cycle();
    let noise = |row: usize| clean[0][row] - (0.01 + 3e-4 * of_cycle[row] - 2e-6 * of_cycle[row].powi(2));
    // Soak, heat at 2 K/min, soak, cool, soak; and the same without a soak at the top. A sensor in steps of 0.1 C as well.
    for (ends, resolution) in
        [([1200, 3600, 4800, 7200], 0.0), ([1200, 4200, 4200, 7200], 0.0), ([1200, 3600, 4800, 7200], 0.1)]
    {
        let mut temperature = -10.0;
        let (mut temperatures, mut rates) = (Vec::new(), Vec::new());
        for row in 0..ROWS {
            let speed = match row {
                row if (ends[0]..ends[1]).contains(&row) => 1.0,
                row if (ends[2]..ends[3]).contains(&row) => -1.0,
                _ => 0.0,
            };
            temperature += speed / 60.0;
            rates.push(1e-4 * temperature + 8e-3 * speed + noise(row));
            let read = temperature + 10.0 * noise(row);
            temperatures.push(if resolution > 0.0 { resolution * (read / resolution).round() } else { read });
        }
        let (_, _, levels) = condition(&temperatures, std::slice::from_ref(&rates));
        assert_eq!((&levels.steps[..], &levels.left_in[..]), (&[][..], &[][..]), "{ends:?} {resolution}");
        // One that is elsewhere on the ramp is one.
        rates[2400..].iter_mut().for_each(|rate| *rate += 0.05);
        let (_, _, levels) = condition(&temperatures, &[rates]);
        let [step] = &levels.steps[..] else { panic!("{ends:?} {resolution}: {levels:?}") };
        assert!((step.size - 0.05).abs() < 5e-4, "{step:?}");
    }
}
