//! Slow noise of a gyro: flicker and rate random walk. The white noise is drawn scan by scan with the low-pass, in
//! `channel.rs`.

use core::f64::consts::PI;

use crate::random::Stream;

/// The shortest correlation time of the flicker's processes in seconds. Faster flicker is there, but at the default
/// densities it lies a hundred times below the white noise.
const SHORTEST_S: f64 = 1.0;

/// From one process's correlation time to the next one's. With a factor of 4 the sum's density ripples by less than
/// 2 % about a true 1/f.
const RATIO: f64 = 4.0;

/// Processes of 1, 4, ... 4096 s: flicker from 0.2 Hz down to one period in seven hours.
const PROCESSES: usize = 7;

/// Flicker noise as a sum of Ornstein-Uhlenbeck processes of equal variance and logarithmically spaced times.
///
/// One such process of variance `s^2` and time `t` has the one-sided density `4 s^2 t / (1 + (2 pi f t)^2)`; summed over
/// times a factor `r` apart this is `s^2 / (ln r f)`. A bias instability of `B` is a density of `B^2 / (pi f)` (IEEE
/// 952, annex C; the floor of the Allan deviation is then 0.664 B), so `s^2 = B^2 ln r / pi`.
#[derive(Debug, Clone)]
pub(crate) struct Flicker {
    deviation: f64,
    states: [f64; PROCESSES],
    step_s: f64,
    /// For each process: what is kept over `step_s`, and what is drawn anew.
    step: [(f64, f64); PROCESSES],
    stream: Stream,
}

impl Flicker {
    /// Flicker of the given bias instability, in its unit; the processes start in their stationary state.
    pub(crate) fn new(bias_instability: f64, mut stream: Stream) -> Self {
        let deviation = bias_instability * (libm::log(RATIO) / PI).sqrt();
        let states = core::array::from_fn(|_| deviation * stream.normal());
        Self { deviation, states, step_s: 0.0, step: [(1.0, 0.0); PROCESSES], stream }
    }

    pub(crate) fn value(&self) -> f64 {
        self.states.iter().sum()
    }

    /// Moves on by `dt_s`, exactly for any step.
    pub(crate) fn advance(&mut self, dt_s: f64) {
        if (dt_s - self.step_s).abs() > f64::EPSILON {
            self.step_s = dt_s;
            let mut time_s = SHORTEST_S;
            for step in &mut self.step {
                let kept = libm::exp(-dt_s / time_s);
                *step = (kept, self.deviation * (1.0 - kept * kept).sqrt());
                time_s *= RATIO;
            }
        }
        for (state, (kept, drawn)) in self.states.iter_mut().zip(self.step) {
            *state = *state * kept + drawn * self.stream.normal();
        }
    }
}

/// A random walk from 0.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    per_root_second: f64,
    value: f64,
    stream: Stream,
}

impl Walk {
    pub(crate) fn new(per_root_second: f64, stream: Stream) -> Self {
        Self { per_root_second, value: 0.0, stream }
    }

    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    pub(crate) fn advance(&mut self, dt_s: f64) {
        self.value += self.per_root_second * dt_s.sqrt() * self.stream.normal();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Source;
    use zerorate_core::units::Axis;

    /// The Allan deviation of a series of means over 1 s, at `m` seconds.
    fn allan_deviation(series: &[f64], m: usize) -> f64 {
        let means: Vec<f64> = series.chunks_exact(m).map(|part| part.iter().sum::<f64>() / m as f64).collect();
        let squares: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        (squares / (2.0 * (means.len() - 1) as f64)).sqrt()
    }

    #[test]
    fn flicker_has_a_flat_allan_deviation_of_0_664_times_the_bias_instability() {
        let mut flicker = Flicker::new(1.0, Stream::of_axis(3, Source::Flicker, Axis::X));
        let series: Vec<f64> = (0..400_000)
            .map(|_| {
                (0..4).fold(0.0, |sum, _| {
                    flicker.advance(0.25);
                    sum + flicker.value() / 4.0
                })
            })
            .collect();
        for m in [8, 32, 128, 512] {
            let deviation = allan_deviation(&series, m);
            assert!((deviation / 0.664 - 1.0).abs() < 0.1, "{m} s: {deviation}");
        }
    }

    #[test]
    fn a_walk_spreads_with_the_root_of_time() {
        let ends: Vec<f64> = (0..2000)
            .map(|seed| {
                let mut walk = Walk::new(0.1, Stream::of_axis(seed, Source::RateWalk, Axis::X));
                (0..100).for_each(|_| walk.advance(1.0));
                walk.value()
            })
            .collect();
        let variance = ends.iter().map(|end| end * end).sum::<f64>() / ends.len() as f64;
        assert!((variance - 1.0).abs() < 0.1, "{variance}");
    }
}
