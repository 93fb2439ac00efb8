//! Many differences, each known badly: the largest of them is mostly noise, and drawn towards their mean it is not.

/// Each value drawn towards the mean of all by the share of noise in how they scatter, with its standard error: what it is likely to
/// be, if the true values scatter about their mean as much as noise does not explain. Of k values with errors V and a true
/// scatter A the share is `B = (k - 3) / (k - 1) V / (V + A)`, and the error's square `V (1 - (k - 1) / k B) + 2 / (k - 3) B^2 d^2`,
/// d the distance from the mean (Morris, Parametric Empirical Bayes Inference, JASA 78, 1983): the second part is that A is
/// itself known by k values. Fewer than four stay as they are. `errors` are the values' standard errors.
#[must_use]
pub fn shrunk(values: &[f64], errors: &[f64]) -> Vec<(f64, f64)> {
    let k = values.len() as f64;
    if values.len() < 4 {
        return values.iter().copied().zip(errors.iter().copied()).collect();
    }
    let mean = values.iter().sum::<f64>() / k;
    let scatter = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (k - 1.0);
    let noise = errors.iter().map(|error| error.powi(2)).sum::<f64>() / k;
    let true_scatter = (scatter - noise).max(0.0);
    let drawn = |(value, error): (&f64, &f64)| {
        let (own, distance) = (error.powi(2), value - mean);
        let share = if own > 0.0 { (k - 3.0) / (k - 1.0) * own / (own + true_scatter) } else { 0.0 };
        let squared = own * (1.0 - (k - 1.0) / k * share) + 2.0 / (k - 3.0) * (share * distance).powi(2);
        (value - share * distance, squared.sqrt())
    };
    values.iter().zip(errors).map(drawn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal noise of one, by the sum of twelve.
    fn normal(state: &mut u64) -> f64 {
        let mut uniform = || {
            *state = 16_807 * *state % 2_147_483_647;
            *state as f64 / 2_147_483_647.0
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    #[test]
    fn the_largest_of_many_that_are_noise_about_one_value_is_that_value() {
        let mut state = 7;
        let (mut raw, mut drawn) = (0.0, 0.0);
        for _ in 0..200 {
            let values: Vec<f64> = (0..40).map(|_| -2.0 + 3.0 * normal(&mut state)).collect();
            let largest = |values: &mut dyn Iterator<Item = f64>| {
                values.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
            };
            raw += largest(&mut values.iter().copied()).abs() / 200.0;
            drawn += largest(&mut shrunk(&values, &[3.0; 40]).into_iter().map(|(value, _)| value)).abs() / 200.0;
        }
        assert!(raw > 8.0 && drawn < 3.5, "{raw} {drawn} for 2");
    }

    #[test]
    fn values_that_are_known_well_stay_and_errors_hold_the_truth() {
        let exact = shrunk(&[1.0, 2.0, 4.0, 7.0], &[0.0; 4]);
        assert_eq!(exact, [(1.0, 0.0), (2.0, 0.0), (4.0, 0.0), (7.0, 0.0)]);
        let (mut state, mut squares, mut count) = (11, 0.0, 0.0);
        for _ in 0..200 {
            let truth: Vec<f64> = (0..40).map(|_| 5.0 + normal(&mut state)).collect();
            let values: Vec<f64> = truth.iter().map(|truth| truth + normal(&mut state)).collect();
            for ((value, error), truth) in shrunk(&values, &[1.0; 40]).into_iter().zip(&truth) {
                squares += ((value - truth) / error).powi(2);
                count += 1.0;
            }
        }
        assert!(((squares / count).sqrt() - 1.0_f64).abs() < 0.05, "{}", squares / count);
    }
}
