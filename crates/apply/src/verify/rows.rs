//! What a calibration takes off each row, on average over the rows of each group: a device has its temperatures row by row, and what
//! it remembers of them does not go by their averages.

use zerorate_cal::log::{LogError, LogFile, Rows, Sink, Stream};
use zerorate_cal::log_fit::AxisFit;
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_fit::predict::{DriftModel, Predictor, Start};

/// For each axis of a log, with the model that is taken off it, the mean bias of the rows of each point of its trace that have a rate;
/// NaN of none.
///
/// # Errors
/// When the log cannot be read.
pub(super) fn mean_biases(
    log: &Source,
    columns: &Columns,
    axes: &[(&AxisFit, &DriftModel)],
) -> Result<Vec<Vec<f64>>, LogError> {
    let means = axes.iter().map(|(axis, _)| vec![(0.0, 0.0); axis.trace.len()]).collect();
    let mut taking = Taking { axes, streams: Vec::new(), means };
    LogFile::open(log, columns)?.read(&mut taking)?;
    let mean = |(sum, rows): (f64, f64)| sum / rows;
    Ok(taking.means.into_iter().map(|means| means.into_iter().map(mean).collect()).collect())
}

struct Taking<'a> {
    axes: &'a [(&'a AxisFit, &'a DriftModel)],
    /// Of each sensor met those of the axes that are its.
    streams: Vec<Vec<Taken<'a>>>,
    /// Of each axis and point the sum of its biases, and how many.
    means: Vec<Vec<(f64, f64)>>,
}

struct Taken<'a> {
    axis: usize,
    /// Its place among the sensor's.
    column: usize,
    /// The history begins with the log, as it does on a device that is switched on.
    predictor: Predictor<'a>,
    /// The point that rows have come to.
    point: usize,
}

impl Sink for Taking<'_> {
    fn stream(&mut self, stream: &Stream) -> bool {
        let column = |axis: &AxisFit| match axis.calibration.sensor == stream.sensor {
            true => stream.names.iter().position(|name| *name == axis.name),
            false => None,
        };
        let mut taken = Vec::new();
        for (axis, &(fit, model)) in self.axes.iter().enumerate() {
            let Some(column) = column(fit) else { continue };
            taken.push(Taken { axis, column, predictor: Predictor::new(model, Start::Unknown), point: 0 });
        }
        let is_wanted = !taken.is_empty();
        self.streams.push(taken);
        is_wanted
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        for taken in &mut self.streams[rows.sensor] {
            let points = &self.axes[taken.axis].0.trace;
            let times = rows.time_s.iter().zip(rows.temperature).zip(&rows.values[taken.column]);
            for (row, ((time_s, temperature), rate)) in (rows.first_row..).zip(times) {
                let bias = taken.predictor.predict(*time_s, *temperature).bias;
                let rows_of = |point: usize| points.get(point).and_then(|point| point.rows);
                while rows_of(taken.point).is_some_and(|(_, end)| row >= end) {
                    taken.point += 1;
                }
                let is_in = rows_of(taken.point).is_some_and(|(first, _)| row >= first);
                if is_in && rate.is_finite() && bias.is_finite() {
                    let (sum, count) = &mut self.means[taken.axis][taken.point];
                    *sum += bias;
                    *count += 1.0;
                }
            }
        }
    }
}
