use super::*;

fn point(supply: f64, at_middle: f64, trimmed: f64, tap: u16) -> SupplyPoint {
    SupplyPoint {
        supply: Volts(supply),
        at_middle: Counts(at_middle),
        trimmed: Counts(trimmed),
        tap: Taps::new(tap).unwrap(),
    }
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
}

/// Uniform numbers, 0 to 1 (splitmix64; Steele, Lea and Flood, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A part: how much each tap raises the reading, and what it reads at the room reading's supply.
struct Part {
    counts_per_tap: f64,
    room: f64,
    /// What each tap adds beyond the line, counts.
    uneven: Vec<f64>,
}

impl Part {
    /// A part whose taps are uneven by `inl_taps`, uniform either way.
    fn draw(random: &mut Random, inl_taps: f64) -> Self {
        let counts_per_tap = 31.26 * (0.95 + 0.1 * random.next());
        let uneven = (0..1024).map(|_| (2.0 * random.next() - 1.0) * inl_taps * counts_per_tap).collect();
        Self { counts_per_tap, room: 8100.0 + 800.0 * random.next(), uneven }
    }

    fn reading(&self, shift: f64, tap: u16) -> f64 {
        self.room + shift + self.counts_per_tap * (f64::from(tap) - 511.0) + self.uneven[usize::from(tap)]
    }

    /// The paper's 21 points, 10 each side of the room reading, to `half_span` counts.
    fn experiment(&self, half_span: f64) -> Vec<SupplyPoint> {
        (-10..=10)
            .map(|k| {
                let shift = f64::from(k) * half_span / 10.0;
                let off = |tap: &u16| (self.reading(shift, *tap) - 8200.0).abs();
                let tap = (300..724).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
                point(2.5 + f64::from(k) * 0.01, self.reading(shift, 511), self.reading(shift, tap), tap)
            })
            .collect()
    }
}

#[test]
fn points_on_the_papers_line_give_the_papers_numbers() {
    for (a, b, v0) in [(-0.031_990_6, -0.274_587, 8203.3), (-0.031_609_3, -0.332_050, 8202.4)] {
        let points: Vec<SupplyPoint> = (-10..=10)
            .map(|k| {
                let dn = 3.0 * f64::from(k);
                // Off the centre by turns, with no effect on the mean.
                let trimmed = v0 + f64::from(k % 3) * 4.0;
                point(f64::from(k), v0 + (dn - b) / a, trimmed, (511 + 3 * k).try_into().unwrap())
            })
            .collect();
        let fit = fit_trim(&points, Counts(8200.0), Taps::MIDDLE).unwrap();
        close(fit.paper.slope_taps_per_count, a, 1e-12);
        close(fit.paper.intercept_taps, b, 1e-10);
        close(fit.paper.centre_counts, v0, 1e-9);
        close(fit.paper.residual_rms_taps, 0.0, 1e-10);
        close(fit.paper.counts_per_tap().0, -1.0 / a, 1e-8);
    }
}

/// Golden values by numpy 2.4, with V, T, N the columns below:
/// `p, c = np.polyfit(dv, N - 511, 1, cov=True)` for `dv = V - T.mean()` and `dv = V - T`; standard errors
/// `np.sqrt(np.diag(c))`.
#[test]
fn both_lines_and_their_errors_agree_with_numpy() {
    let points = [
        point(2.9, 9230.4, 8207.1, 478),
        point(2.7, 8710.2, 8195.2, 495),
        point(2.5, 8195.7, 8195.7, 511),
        point(2.3, 7721.9, 8190.8, 526),
        point(2.1, 7180.3, 8212.5, 544),
    ];
    let fit = fit_trim(&points, Counts(8200.0), Taps::MIDDLE).unwrap();
    close(fit.paper.slope_taps_per_count, -3.203726700e-02, 3e-10);
    close(fit.paper.intercept_taps, 3.835726646e-02, 4e-10);
    close(fit.paper.slope_standard_error_taps_per_count, 2.085551013e-04, 2e-12);
    close(fit.paper.intercept_standard_error_taps, 1.501131669e-01, 2e-09);
    close(fit.paper.residual_rms_taps, 2.599897416e-01, 3e-09);
    close(fit.paired.slope_taps_per_count, -3.199265206e-02, 3e-10);
    close(fit.paired.intercept_taps, 3.802533133e-02, 4e-10);
    close(fit.paired.slope_standard_error_taps_per_count, 1.924755698e-04, 2e-12);
    close(fit.paired.intercept_standard_error_taps, 1.387339538e-01, 1e-09);
    close(fit.paired.residual_rms_taps, 2.402814553e-01, 2e-09);
    close(fit.paper.centre_counts, 8200.26, 1e-9);
    close(fit.paper.centre_standard_error_counts, 4.07732756, 1e-7);
}

/// The relative error of the slope over many parts, rms, by the paper's formula and by the paired one.
fn scatter(half_span: f64, draw: impl Fn(&mut Random) -> Part) -> (f64, f64) {
    let mut random = Random(7);
    let (mut paper, mut paired, draws) = (0.0, 0.0, 400);
    for _ in 0..draws {
        let part = draw(&mut random);
        let fit = fit_trim(&part.experiment(half_span), Counts(8200.0), Taps::MIDDLE).unwrap();
        let error = |line: &TrimEstimate| line.slope_taps_per_count * part.counts_per_tap + 1.0;
        paper += error(&fit.paper).powi(2);
        paired += error(&fit.paired).powi(2);
    }
    ((paper / f64::from(draws)).sqrt(), (paired / f64::from(draws)).sqrt())
}

/// docs/paper.md: 0.17 % over +-1000 counts, 0.74 % over +-220, for parts of the paper's gain.
#[test]
fn the_papers_formula_scatters_by_its_half_taps_and_the_paired_one_does_not() {
    let papers = |random: &mut Random| Part { counts_per_tap: 31.26, ..Part::draw(random, 0.0) };
    let (paper, paired) = scatter(1000.0, papers);
    assert!((0.0016..0.0019).contains(&paper), "{paper}");
    assert!(paired < 1e-12, "{paired}");
    let (paper, paired) = scatter(220.0, papers);
    assert!((0.0066..0.0078).contains(&paper), "{paper}");
    assert!(paired < 1e-12, "{paired}");
}

#[test]
fn uneven_taps_leave_the_paired_line_twice_as_good() {
    let (paper, paired) = scatter(1000.0, |random| Part::draw(random, 0.1));
    assert!(paired < 0.5 * paper, "{paired} against {paper}");
}

#[test]
fn the_standard_error_tells_the_scatter() {
    let mut random = Random(3);
    let (mut squares, draws) = (0.0, 400);
    for _ in 0..draws {
        let part = Part::draw(&mut random, 0.1);
        let paired = fit_trim(&part.experiment(1000.0), Counts(8200.0), Taps::MIDDLE).unwrap().paired;
        let error = paired.slope_taps_per_count + 1.0 / part.counts_per_tap;
        squares += (error / paired.slope_standard_error_taps_per_count).powi(2);
    }
    // Student's t with 19 degrees of freedom: 19/17.
    assert!((0.9..1.4).contains(&(squares / f64::from(draws))), "{}", squares / f64::from(draws));
}

#[test]
fn the_model_takes_the_paired_line_about_any_centre() {
    let part = Part::draw(&mut Random(1), 0.0);
    let fit = fit_trim(&part.experiment(1000.0), Counts(8200.0), Taps::MIDDLE).unwrap();
    let trim = fit.trim(fit.aim, None).unwrap();
    let position = trim.line.position(Counts(part.reading(400.0, 511)));
    close(part.room + 400.0 + part.counts_per_tap * (position - 511.0), 8200.0, 1e-8);
    assert!((fit.paired.centre_counts - 8200.0).abs() < 3.0 * fit.paired.centre_standard_error_counts);
    assert_eq!(fit.trim(Counts(f64::NAN), None), Err(TrimFitError::Centre));
}

#[test]
fn an_experiment_that_went_wrong_is_refused_with_the_voltage() {
    let part = Part::draw(&mut Random(1), 0.0);
    let good = part.experiment(1000.0);
    let refused = |points: &[SupplyPoint]| fit_trim(points, Counts(8200.0), Taps::MIDDLE).unwrap_err();

    assert_eq!(refused(&good[..2]), TrimFitError::TooFewPoints { found: 2 });

    let same: Vec<SupplyPoint> = good.iter().map(|p| SupplyPoint { tap: Taps::MIDDLE, ..*p }).collect();
    assert_eq!(refused(&same), TrimFitError::OneTap { tap: 511 });

    let turned: Vec<SupplyPoint> =
        good.iter().map(|p| SupplyPoint { at_middle: Counts(16_400.0) - p.at_middle, ..*p }).collect();
    let text = refused(&turned).to_string();
    assert!(text.contains("swap the supply's leads"), "{text}");

    // The wiper's last tap was not enough at the last voltage: two taps short.
    let mut short = good.clone();
    let end = &mut short[20];
    end.tap = Taps::new(end.tap.get() + 2).unwrap();
    end.trimmed = end.trimmed + Counts(2.0 * part.counts_per_tap);
    let text = refused(&short).to_string();
    assert!(text.starts_with("at 2.6000 V") && text.contains("beyond the trim's range"), "{text}");

    let mut stuck = good.clone();
    stuck[20].at_middle = stuck[20].at_middle - Counts(200.0);
    assert!(matches!(refused(&stuck), TrimFitError::Stray { .. }));

    let mut lost = good;
    lost[4].trimmed = Counts(f64::NAN);
    assert!(refused(&lost).to_string().starts_with("at 2.4400 V"));
}

fn sweep(taps: impl IntoIterator<Item = u16>) -> Vec<TapReading> {
    taps.into_iter()
        .map(|tap| TapReading {
            tap: Taps::new(tap).unwrap(),
            reading: Counts(8200.0 + 31.0 * (f64::from(tap) - 511.0) + f64::from(tap % 2)),
        })
        .collect()
}

#[test]
fn each_tap_is_read_against_the_middle_one() {
    let effects = tap_effects(&sweep((495..=520).rev()), Taps::MIDDLE).unwrap();
    assert_eq!(effects.first().get(), 495);
    assert_eq!(effects.effects().len(), 26);
    assert_eq!(effects.get(Taps::MIDDLE), Some(Counts(0.0)));
    assert_eq!(effects.get(Taps::new(512).unwrap()), Some(Counts(30.0)));
    assert_eq!(effects.get(Taps::new(521).unwrap()), None);
}

#[test]
fn a_tap_read_twice_counts_by_its_mean() {
    let mut readings = sweep(505..=515);
    readings.push(TapReading { tap: Taps::MIDDLE, reading: readings[6].reading + Counts(1.0) });
    let effects = tap_effects(&readings, Taps::MIDDLE).unwrap();
    let second = effects.get(Taps::new(512).unwrap()).unwrap();
    let mean = 0.5 * (8201.0 + readings[11].reading.0);
    close(second.0, readings[7].reading.0 - mean, 1e-9);
}

#[test]
fn a_working_range_far_from_the_middle_tap_needs_only_its_reading() {
    let effects = tap_effects(&sweep((400..=430).chain([511])), Taps::MIDDLE).unwrap();
    assert_eq!((effects.first().get(), effects.effects().len()), (400, 31));
    close(effects.get(Taps::new(401).unwrap()).unwrap().0, -110.0 * 31.0, 1e-9);
}

#[test]
fn a_sweep_with_a_hole_or_without_its_middle_is_refused() {
    let refused = |taps: Vec<u16>| tap_effects(&sweep(taps), Taps::MIDDLE).unwrap_err();
    assert_eq!(refused(vec![]), TrimFitError::EmptySweep);
    assert_eq!(refused((500..=510).collect()), TrimFitError::NoMiddle { middle: 511, first: 500, last: 510 });
    assert_eq!(refused((500..=520).filter(|t| *t != 515).collect()), TrimFitError::Gap { tap: 515 });
    assert_eq!(refused((450..=550).collect()), TrimFitError::TooManyTaps { found: 101 });
    let mut lost = sweep(505..=515);
    lost[2].reading = Counts(f64::NAN);
    assert_eq!(tap_effects(&lost, Taps::MIDDLE), Err(TrimFitError::SweepNotFinite { tap: 507 }));
}
