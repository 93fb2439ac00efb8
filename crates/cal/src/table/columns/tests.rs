use super::*;
use crate::source::Source;

fn table(content: &str) -> Result<Table, TableError> {
    Table::open(&Source::bytes("log", content.as_bytes()))
}

fn resolve(header: &str, columns: &Columns) -> Result<Resolved, TableError> {
    columns.resolve(&table(&format!("{header}\n"))?)
}

/// The places of the first sensor's rates.
fn places(found: &Resolved) -> Vec<usize> {
    found.sensors[0].rates.iter().map(|rate| rate.column).collect()
}

#[test]
fn columns_are_guessed_where_the_names_make_it_plain() {
    for (header, time, temperature, rates) in [
        ("t_s,temperature_c,x_rad_s,y_rad_s,z_rad_s", Some(0), 1, vec![2, 3, 4]),
        ("timestamp,imu.gyro.x,imu.gyro.y,imu.gyro.z,imu.acc.x,imu.status,imu.temperature", Some(0), 6, vec![1, 2, 3]),
        ("TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T", Some(0), 10, vec![2, 3, 4]),
        ("TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,heat", Some(0), usize::MAX, vec![]),
        ("timestamp,timestamp_sample,device_id,x,y,z,temperature", Some(0), 6, vec![3, 4, 5]),
        ("timestamp,time_s,temp_c,rate_dps", Some(1), 2, vec![3]),
        ("temp,rate_dps", None, 0, vec![1]),
    ] {
        match resolve(header, &Columns::default()) {
            Ok(found) => {
                assert_eq!((found.time, found.sensors[0].temperature, places(&found)), (time, temperature, rates))
            }
            Err(error) => {
                assert_eq!(temperature, usize::MAX, "{error}");
                assert!(error.to_string().contains("say which (`temperature`); the columns are TimeUS, I,"));
            }
        }
    }
}

#[test]
fn a_t_of_degrees_is_a_temperature_and_a_bare_one_where_nothing_else_is() {
    use WrittenTemperature::{Celsius, Fahrenheit, Kelvin};
    for (header, time, temperature, unit) in [
        ("t_s,T [°C],x_dps", Some(0), 1, Celsius),
        ("t_s,T_C,x_dps", Some(0), 1, Celsius),
        ("t_s,T [K],x_dps", Some(0), 1, Kelvin),
        ("t_s,T_gyro (°F),x_dps", Some(0), 1, Fahrenheit),
        ("T [°C],x_dps", None, 0, Celsius),
        ("t,T,x_dps", Some(0), 1, Celsius),
        ("T,t,x_dps", Some(1), 0, Celsius),
        ("time,t,x_dps", Some(0), 1, Celsius),
        ("T,x_dps", None, 0, Celsius),
        // Beside a temperature it is the time.
        ("T,temp_c,x_dps", Some(0), 1, Celsius),
    ] {
        let found = resolve(header, &Columns::default()).unwrap();
        let sensor = &found.sensors[0];
        assert_eq!((found.time, sensor.temperature, sensor.written_temperature), (time, temperature, unit), "{header}");
    }
    let time_alone = resolve("t,x_dps", &Columns::default()).unwrap_err().to_string();
    assert!(time_alone.contains("no column could be the temperature"), "{time_alone}");
}

#[test]
fn a_first_column_in_a_unit_of_times_that_never_falls_is_the_time_where_none_is_called_so() {
    let rows = |head: &str, first: [f64; 3]| {
        let rows: String = first.iter().map(|number| format!("{number},20,1\n")).collect();
        Columns::default().resolve(&table(&format!("{head}\n{rows}")).unwrap()).unwrap()
    };
    for (head, unit) in [
        ("Zeit_s,temp_c,x_dps", TimeUnit::S),
        ("Laufzeit [s],temp_c,x_dps", TimeUnit::S),
        ("Elapsed (ms),temp_c,x_dps", TimeUnit::Ms),
        ("us,temp_c,x_dps", TimeUnit::Us),
    ] {
        let found = rows(head, [0.0, 0.5, 1.0]);
        assert_eq!((found.time, found.time_unit), (Some(0), Some(unit)), "{head}");
        let name = head.split(',').next().unwrap();
        assert_eq!(found.notes, [format!("'{name}' is taken for the time, by its unit (`time` says another column)")]);
        assert_eq!(rows(head, [0.0, 0.5, 0.2]).time, None, "{head} falls");
    }
    assert_eq!(rows("Zeit,temp_c,x_dps", [0.0, 0.5, 1.0]).time, None);
    assert_eq!(rows("v_m_s,temp_c,x_dps", [0.0, 0.5, 1.0]).time, None);
    assert!(rows("time_s,temp_c,x_dps", [0.0, 0.5, 1.0]).notes.is_empty());
    let called = resolve("Zeit_s,time_ms,temp_c,x_dps", &Columns::default()).unwrap();
    assert_eq!(called.time, Some(1));
}

/// A name that says minutes or hours is not taken for one that says nothing.
#[test]
fn minutes_and_hours_are_read_from_the_names() {
    for (head, unit) in [
        ("time_min", TimeUnit::Min),
        ("time (min)", TimeUnit::Min),
        ("t_minutes", TimeUnit::Min),
        ("time_h", TimeUnit::H),
        ("time [hr]", TimeUnit::H),
        ("t_hours", TimeUnit::H),
        ("time_s", TimeUnit::S),
    ] {
        let found = resolve(&format!("{head},temp_c,x_dps"), &Columns::default()).unwrap();
        assert_eq!((found.time, found.time_unit), (Some(0), Some(unit)), "{head}");
    }
    assert!((TimeUnit::H.seconds() - 3600.0).abs() < 1e-9 && (TimeUnit::Min.seconds() - 60.0).abs() < 1e-9);
    // What says nothing is still in what a clock counts.
    assert_eq!(TimeUnit::by_duration(60.0), None);
}

/// A unit that is named and not read is told by its name, and never taken for another.
#[test]
fn rates_in_units_that_are_not_read_are_refused() {
    for (head, unit) in [
        ("gx (rad/ms)", "rad for a part of a second"),
        ("gx (deg/ms)", "deg for a part of a second"),
        ("gx [mrad/us]", "rad for a part of a second"),
        ("gx (rev/s)", "turns"),
        ("gx (rps)", "turns"),
        ("gx (turns/s)", "turns"),
        ("gx (kdps)", "thousands of deg/s"),
        ("gx (krad/s)", "thousands of rad/s"),
        ("gx (rad/min)", "rad/min"),
        ("gx (rad/h)", "rad/h"),
        ("gx (deg/min)", "deg/min"),
    ] {
        let told = resolve(&format!("time_s,temp_c,{head}"), &Columns::default()).unwrap_err().to_string();
        assert!(told.contains(&format!("'{head}' is in {unit}, by its name")), "{told}");
    }
}

#[test]
fn what_is_no_unit_of_its_column_is_refused() {
    for (heads, column, unit, instead) in [
        ("time_s,temp_c,gx (Hz)", "gx (Hz)", "hertz", "dps or rad/s, or say its unit (`rate_unit`)"),
        ("time_s,temp_c,gyro_x_mV", "gyro_x_mV", "volts", "dps or rad/s"),
        ("time_s,temp_mV,gx_dps", "temp_mV", "volts", "degrees C, or say its unit (`temperature_unit`)"),
        ("time_s,temp [kOhm],gx_dps", "temp [kOhm]", "ohms", "degrees C"),
        ("time_days,temp_c,gx_dps", "time_days", "days", "seconds, or say its unit (`time_unit`)"),
        ("time [100ns],temp_c,gx_dps", "time [100ns]", "several of a unit", "seconds"),
    ] {
        let told = resolve(heads, &Columns::default()).unwrap_err().to_string();
        let expected =
            format!("column '{column}' is in {unit}, by its name, and that unit is not read: convert it to {instead}");
        assert!(told.contains(&expected), "{told}");
    }
    // Said, they are read.
    let rate_unit = Some(WrittenRate::Counts);
    assert!(resolve("time_s,temp_c,gx (V)", &Columns { rate_unit, ..Columns::default() }).is_ok());
    assert!(resolve("time_s,temp_c_mean_10s,gx_dps", &Columns::default()).is_ok());
}

#[test]
fn units_come_from_the_names() {
    let named = resolve("TimeUS,temp_counts,GyrX_dps", &Columns::default()).unwrap();
    assert_eq!(named.time_unit, Some(TimeUnit::Us));
    assert_eq!(named.sensors[0].rate_unit, RateUnit::Dps);
    assert_eq!(named.sensors[0].written_temperature, WrittenTemperature::Counts);
    assert!(named.notes.is_empty() && named.guesses.is_empty());
    let bare = resolve("timestamp,temperature,gyro.x", &Columns::default()).unwrap();
    assert_eq!((bare.time_unit, bare.sensors[0].rate_unit), (None, RateUnit::RadPerS));
    let kinds: Vec<ReasonKind> = bare.guesses.iter().map(|guess| guess.kind).collect();
    assert_eq!(kinds, [ReasonKind::AssumedUnit, ReasonKind::GuessedUnit]);
    assert!(bare.guesses[1].text.contains("'gyro.x' names no unit: taken as rad/s"));
}

#[test]
fn a_column_asked_for_wins_and_a_wrong_one_lists_those_there_are() {
    let asked = Columns { rates: vec!["b".into()], temperature: Some("a".into()), ..Columns::default() };
    let found = resolve("a,b,gyro_x", &asked).unwrap();
    assert_eq!((found.sensors[0].temperature, places(&found)), (0, vec![1]));
    let wrong = Columns { temperature: Some("heat".into()), ..Columns::default() };
    let error = resolve("a,b", &wrong).unwrap_err().to_string();
    assert!(error.ends_with("there is no column 'heat'; the columns are a, b"), "{error}");
    let two = resolve("temp_1,temp_2,gyro_x", &Columns::default()).unwrap_err().to_string();
    assert!(two.contains("more than one column could be the temperature"), "{two}");
}

#[test]
fn two_columns_of_one_name_are_no_two_axes() {
    let head = "t_s,temp_c,x_rad_s,x_rad_s,z_rad_s";
    let asked = Columns { rates: vec!["z_rad_s".into(), "x_rad_s".into()], ..Columns::default() };
    for columns in [&Columns::default(), &asked] {
        let refused = resolve(head, columns).unwrap_err().to_string();
        assert!(refused.contains("columns 3 and 4 are both called 'x_rad_s'"), "{refused}");
    }
    let asked = Columns { rates: vec!["z_rad_s".into(), "z_rad_s".into()], ..Columns::default() };
    let refused = resolve(head, &asked).unwrap_err().to_string();
    assert!(refused.contains("column 'z_rad_s' was asked for twice (`rate`)"), "{refused}");
    // Two that nobody asks for are in nobody's way.
    assert_eq!(places(&resolve("t_s,temp_c,x_rad_s,note,note", &Columns::default()).unwrap()), [2]);
}

#[test]
fn a_unit_that_a_name_says_is_read_or_refused_and_never_mistaken() {
    use WrittenTemperature::{Celsius, Fahrenheit, Kelvin};
    let guessed = Columns::default();
    for (head, temperature, unit, factor) in [
        ("time_s,temp_F,gyro_x_dps", Fahrenheit, RateUnit::Dps, 1.0),
        ("time_s,Temp [°F],gyro_x_dps", Fahrenheit, RateUnit::Dps, 1.0),
        ("time_s,temperature_k,gyro_x_mDPS", Kelvin, RateUnit::Dps, 1e-3),
        ("time_s,temp [K],x [°/s]", Kelvin, RateUnit::Dps, 1.0),
        ("time_s,Temperature [°C],x_deg_s", Celsius, RateUnit::Dps, 1.0),
        ("time_s,temp_c,gyro_x_mdps", Celsius, RateUnit::Dps, 1e-3),
        ("time_s,temp_c,x [m°/s]", Celsius, RateUnit::Dps, 1e-3),
        ("time_s,temp_c,x_deg_h", Celsius, RateUnit::Dps, 1.0 / 3600.0),
        ("time_s,temp_c,x [°/h]", Celsius, RateUnit::Dps, 1.0 / 3600.0),
        ("time_s,temp_c,gyro_x_mrad_s", Celsius, RateUnit::RadPerS, 1e-3),
        ("time_s,temp_c,gyro_x_rad/s", Celsius, RateUnit::RadPerS, 1.0),
    ] {
        let found = resolve(head, &guessed).unwrap();
        let sensor = &found.sensors[0];
        assert_eq!((sensor.written_temperature, sensor.rate_unit), (temperature, unit), "{head}");
        assert!((sensor.rates[0].factor / factor - 1.0).abs() < 1e-12 && found.guesses.is_empty(), "{head}");
    }
    for (head, unit) in [("time_s,temp_c,x_deg_min", "deg/min"), ("time_s,temp_c,gyro_x_rpm", "turns a minute")] {
        let refused = resolve(head, &guessed).unwrap_err().to_string();
        assert!(refused.contains(unit) && refused.contains("unit is not read"), "{head}: {refused}");
    }
    let given = Columns { rate_unit: Some(WrittenRate::Dps), ..Columns::default() };
    let found = resolve("time_s,temp_c,gyro_x_mdps", &given).unwrap();
    assert!((found.sensors[0].rates[0].factor - 1.0).abs() < 1e-12);
    assert_eq!(found.notes, ["'gyro_x_mdps' says mdps, and is taken as dps, as asked (`rate_unit`)"]);
}

#[test]
fn columns_of_one_gyro_in_two_units_are_read_in_one() {
    let found = resolve("t_s,temp_c,x_dps,y_rad_s,gyro_z", &Columns::default()).unwrap();
    let factors: Vec<f64> = found.sensors[0].rates.iter().map(|rate| rate.factor).collect();
    assert_eq!(found.sensors[0].rate_unit, RateUnit::Dps);
    assert!((factors[0] - 1.0).abs() < 1e-12 && (factors[1] - 57.295_779_513).abs() < 1e-6);
    assert!(found.guesses[0].text.contains("'gyro_z' names no unit: taken as dps, as the columns beside it"));
    let counts = resolve("t_s,temp_c,x_counts,y_raw,status_raw", &Columns::default()).unwrap();
    assert_eq!((counts.sensors[0].rate_unit, counts.sensors[0].rates.len()), (RateUnit::Counts, 2));
    let mixed = resolve("t_s,temp_c,x_dps,gyro_y_counts", &Columns::default()).unwrap_err().to_string();
    assert!(mixed.contains("'gyro_y_counts' is in counts"), "{mixed}");
}

#[test]
fn several_gyros_are_told_apart_by_their_numbers() {
    let gyro = |instance, temperature, rates: [usize; 3]| (Some(instance), temperature, rates.to_vec());
    for (head, expected) in [
        ("t_s,temp_c,gyro0_x,gyro0_y,gyro0_z,gyro1_x,gyro1_y,gyro1_z", [gyro(0, 1, [2, 3, 4]), gyro(1, 1, [5, 6, 7])]),
        (
            "t_s,gyro1_x,gyro1_y,gyro1_z,temp1,gyro2_x,gyro2_y,gyro2_z,temp2",
            [gyro(1, 4, [1, 2, 3]), gyro(2, 8, [5, 6, 7])],
        ),
        (
            "t_s,imu0.gyro.x,imu0.gyro.y,imu0.gyro.z,imu0.temperature,imu1.gyro.x,imu1.gyro.y,imu1.gyro.z,imu1.temperature",
            [gyro(0, 4, [1, 2, 3]), gyro(1, 8, [5, 6, 7])],
        ),
    ] {
        let found = resolve(head, &Columns::default()).unwrap();
        let sensors: Vec<(Option<u8>, usize, Vec<usize>)> = found
            .sensors
            .iter()
            .map(|own| {
                let rates = own.rates.iter().map(|rate| rate.column).collect();
                (own.sensor.map(|sensor| sensor.instance), own.temperature, rates)
            })
            .collect();
        assert_eq!(sensors, expected, "{head}");
    }
    let filtered = "t_s,temp_c,gyro_x,gyro_y,gyro_z,gyro_filtered_x,gyro_filtered_y,gyro_filtered_z";
    let unclear = resolve(filtered, &Columns::default()).unwrap_err().to_string();
    assert!(unclear.contains("more than one column could be the rate: say which (`rate`)"), "{unclear}");
}

#[test]
fn a_unit_that_is_given_against_a_temperatures_name_is_told() {
    let given = Columns { temperature_unit: Some(WrittenTemperature::Celsius), ..Columns::default() };
    let found = resolve("time_s,temp_K,x_dps", &given).unwrap();
    assert_eq!(found.sensors[0].written_temperature, WrittenTemperature::Celsius);
    let [note] = &found.notes[..] else { panic!("{:?}", found.notes) };
    assert!(note.starts_with("'temp_K' says ") && note.ends_with("as asked (`temperature_unit`)"), "{note}");
    assert!(resolve("time_s,temp_c,x_dps", &given).unwrap().notes.is_empty());
}

#[test]
fn beside_a_date_the_time_of_day_is_the_time() {
    assert_eq!(resolve("date,time,temp_c,x_dps", &Columns::default()).unwrap().time, Some(1));
    assert_eq!(resolve("date,temp_c,x_dps", &Columns::default()).unwrap().time, Some(0));
}
