//! A reading in coarse steps, made smooth.

/// Values on each side over which steps are averaged, at most: ten minutes of groups of 10 s.
const MOST_REACH: usize = 30;

/// Each value as the mean of those around it, over about the time that the reading takes from one step to the next. `step` is
/// the size of a step.
#[must_use]
pub fn smoothed(values: &[f64], step: f64) -> Vec<f64> {
    let rise: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|rise| rise.is_finite()).sum();
    if rise <= 0.0 {
        return values.to_vec();
    }
    // Values from one step to the next, on average.
    let spacing = step * values.len() as f64 / rise;
    let most = (0..=MOST_REACH).take_while(|reach| 2.0 * (*reach as f64) < spacing).last().unwrap_or(0);
    let smooth = |(place, value): (usize, &f64)| {
        // Symmetric, so that a slope stays one at the ends.
        let reach = most.min(place).min(values.len() - 1 - place);
        let around = values[place - reach..=place + reach].iter().filter(|t| t.is_finite());
        let (sum, count) = around.fold((0.0, 0_u32), |(sum, count), t| (sum + t, count + 1));
        if value.is_finite() { sum / f64::from(count) } else { *value }
    };
    values.iter().enumerate().map(smooth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stairs_become_a_slope_and_what_is_no_number_stays_none() {
        let mut stairs: Vec<f64> = (0..400).map(|place: u32| f64::from(place / 10)).collect();
        stairs[200] = f64::NAN;
        let smooth = smoothed(&stairs, 1.0);
        assert!(smooth[200].is_nan());
        let off =
            (20..380).filter(|place| *place != 200).map(|place| (smooth[place] - (place as f64 - 4.5) / 10.0).abs());
        assert!(off.fold(0.0, f64::max) < 0.2);
        assert_eq!(smoothed(&[1.0; 9], 1.0), [1.0; 9]);
    }
}
