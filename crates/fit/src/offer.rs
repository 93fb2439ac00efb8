//! What rows have to offer, before anything is fitted to them.

/// What one axis has to offer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisSurvey {
    /// Rows with a temperature and a rate.
    pub rows: u64,
    /// Rows without a temperature.
    pub missing_temperature: u64,
    /// Rows with a temperature and no rate.
    pub missing_rate: u64,
    /// The least temperature with a rate.
    pub min: f64,
    /// The greatest.
    pub max: f64,
}

impl AxisSurvey {
    /// Of no row yet.
    pub const EMPTY: Self =
        Self { rows: 0, missing_temperature: 0, missing_rate: 0, min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// Takes in some rows.
    pub fn take(&mut self, temperatures: &[f64], rates: &[f64]) {
        for (temperature, rate) in temperatures.iter().zip(rates) {
            if !temperature.is_finite() {
                self.missing_temperature += 1;
            } else if !rate.is_finite() {
                self.missing_rate += 1;
            } else {
                self.rows += 1;
                self.min = self.min.min(*temperature);
                self.max = self.max.max(*temperature);
            }
        }
    }
}
