//! The columns of a table, and what to apply to which.

use anyhow::{Context, Result, ensure};
use zerorate_apply::apply::AppliedModel;
use zerorate_apply::verify::known_columns;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::log::{Clock, SensorChoice, Surveyed, surveyed};
use zerorate_cal::matching::{Known, calibrated, places, renamed};
use zerorate_cal::quality::ReasonKind;
use zerorate_cal::source::Source;
use zerorate_cal::table::{Columns, ResolvedRate, ResolvedSensor, Table};
use zerorate_cal::units::WrittenRate;

/// What was found of the log's columns.
pub(super) struct Found {
    pub table: Table,
    /// The column of times, and these.
    pub time: Option<(String, Clock)>,
    /// In the log's order.
    pub models: Vec<AppliedModel>,
    /// The units that were guessed, which axis was taken for which, and those that the log does not have.
    pub notes: Vec<String>,
}

/// Finds the columns, and matches their axes as `verify` does.
pub(super) fn found(
    log: &Source,
    calibration: &Calibration,
    asked: Columns,
    sensor: Option<SensorChoice>,
) -> Result<Found> {
    let table = Table::open(log)?;
    let found = known_columns(log, calibration, asked).resolve(&table)?;
    let is_wanted = |of: &&ResolvedSensor| sensor.zip(of.sensor).is_none_or(|(choice, sensor)| choice.takes(&sensor));
    let sensors = found.sensors.iter().filter(is_wanted);
    let rates: Vec<(&ResolvedSensor, &ResolvedRate)> =
        sensors.flat_map(|sensor| sensor.rates.iter().map(move |rate| (sensor, rate))).collect();
    let known =
        rates.iter().map(|(sensor, rate)| Known { name: &rate.name, sensor: sensor.sensor, unit: sensor.rate_unit });
    let logged: Vec<Known<'_>> = known.collect();
    let own = calibrated(calibration, sensor);
    let places = places(&own, &logged).with_context(|| log.name().to_owned())?;
    let mut models: Vec<(usize, AppliedModel)> = Vec::new();
    let mut notes = Vec::new();
    for (own, place) in own.iter().zip(places) {
        let Some(place) = place else {
            notes.push(format!(
                "{} of the calibration: the log has no such axis, and none was corrected by it",
                own.name
            ));
            continue;
        };
        let (sensor, rate) = rates[place];
        notes.extend(renamed(&rate.name, own.name));
        models.push((rate.column, model(&table, calibration, own.name, sensor, rate)?));
    }
    models.sort_by_key(|(place, _)| *place);
    let is_guess = |kind: ReasonKind| matches!(kind, ReasonKind::AssumedUnit | ReasonKind::GuessedUnit);
    let Surveyed { reasons, clock } = surveyed(&table, &found)?;
    notes.extend(reasons.into_iter().filter(|reason| is_guess(reason.kind)).map(|reason| reason.text));
    Ok(Found {
        time: found.time.map(|place| (table.names()[place].clone(), clock)),
        models: models.into_iter().map(|(_, model)| model).collect(),
        notes,
        table,
    })
}

/// The model of a calibration's axis for a column.
fn model(
    table: &Table,
    calibration: &Calibration,
    own: &str,
    sensor: &ResolvedSensor,
    rate: &ResolvedRate,
) -> Result<AppliedModel> {
    let (log, axis) = (table.source().name(), &calibration.axes[own]);
    let temperature = &table.names()[sensor.temperature];
    let (unit, of_log) = (calibration.temperature_unit, sensor.written_temperature.unit());
    ensure!(
        unit == of_log,
        "{log}: column '{temperature}' is in {}, and the calibration's temperatures are in {}: give the column in {1} with --temperature",
        of_log.name(),
        unit.name()
    );
    let to_own = WrittenRate::of(sensor.rate_unit).and_then(|unit| unit.in_unit(axis.rate_unit));
    let to_own = to_own.with_context(|| {
        format!(
            "{log}: column '{}' is in {}, and the calibration's in {}: say which it is (--rate-unit)",
            rate.name, sensor.rate_unit, axis.rate_unit
        )
    })?;
    Ok(AppliedModel {
        column: rate.name.clone(),
        temperature: temperature.clone(),
        written_temperature: sensor.written_temperature,
        model: axis.fit.model.clone(),
        measured: axis.fit.measured,
        factor: rate.factor * to_own,
    })
}
