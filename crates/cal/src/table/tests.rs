use std::sync::Arc;

use ::parquet::arrow::ArrowWriter;
use arrow_array::{ArrayRef, Float32Array, Float64Array, Int64Array, RecordBatch, StringArray};

use super::*;
use crate::units::{RateUnit, TemperatureUnit, TimeUnit};

fn table(content: &[u8]) -> Result<Table, TableError> {
    Table::open(&Source::bytes("log", content))
}

fn read(content: &str) -> Result<(Vec<String>, Vec<Vec<f64>>), TableError> {
    let table = table(content.as_bytes())?;
    let all: Vec<usize> = (0..table.names().len()).collect();
    let mut columns = vec![Vec::new(); all.len()];
    for batch in table.batches(&all)? {
        let batch = batch?;
        columns.iter_mut().zip(&batch.columns).for_each(|(all, some)| all.extend(some));
    }
    Ok((table.names().to_vec(), columns))
}

fn resolve(header: &str, columns: &Columns) -> Result<Resolved, TableError> {
    columns.resolve(&table(format!("{header}\n").as_bytes())?)
}

#[test]
fn every_delimiter_is_found_by_content() {
    for content in ["t,r\n1,2\n3,4\n", "t;r\n1;2\n3;4", "t\tr\r\n1\t2\r\n3\t4\r\n", "  t   r\n 1 2\n3    4\n"] {
        let (names, columns) = read(content).unwrap();
        assert_eq!((names, columns), (vec!["t".into(), "r".into()], vec![vec![1.0, 3.0], vec![2.0, 4.0]]));
    }
}

#[test]
fn a_table_without_a_header_has_numbered_columns() {
    let (names, columns) = read("1,2.5\n3,-4e-3\n").unwrap();
    assert_eq!(names, ["column_1", "column_2"]);
    assert_eq!(columns, [[1.0, 3.0], [2.5, -4e-3]]);
}

#[test]
fn a_missing_cell_is_nan() {
    let (_, columns) = read("a,b\n1,\nnan,2\nNULL,n/a\n").unwrap();
    assert!((columns[0][0] - 1.0).abs() < 1e-12);
    assert!(columns[0][1].is_nan() && columns[0][2].is_nan());
    assert!(columns[1][0].is_nan() && columns[1][2].is_nan());
}

#[test]
fn text_for_a_number_is_named_by_line_and_column() {
    let error = read("a,b\n1,2\n3,oops\n").unwrap_err().to_string();
    assert!(error.contains("log: line 3: column 'b' holds 'oops'"), "{error}");
}

#[test]
fn a_line_cut_short_is_named() {
    let error = read("a,b\n1,2\n3\n").unwrap_err().to_string();
    assert!(error.contains("log: line 3: 1 cells where the first line has 2"), "{error}");
}

#[test]
fn what_is_no_table_says_so() {
    assert!(matches!(read("").unwrap_err().fault, TableFault::Empty));
    assert!(matches!(read("\n\n").unwrap_err().fault, TableFault::Empty));
    assert!(matches!(read("hello\n").unwrap_err().fault, TableFault::NotATable));
    assert!(matches!(read("a\0b").unwrap_err().fault, TableFault::NotATable));
    assert!(matches!(read("PAR1 and then nothing").unwrap_err().fault, TableFault::Parquet { .. }));
    let missing = Table::open(&"/nowhere/log.csv".into()).unwrap_err().to_string();
    assert!(missing.starts_with("/nowhere/log.csv: cannot be read"), "{missing}");
}

#[test]
fn a_long_table_comes_in_batches_that_join_up() {
    let content: String = (0..20_000).map(|i| format!("{i},{}\n", 2 * i)).collect();
    let mut next = 0;
    for batch in table(content.as_bytes()).unwrap().batches(&[1]).unwrap() {
        let batch = batch.unwrap();
        assert_eq!(batch.first_row, next);
        assert!((batch.columns[0][0] - 2.0 * next as f64).abs() < 1e-12);
        next += batch.rows() as u64;
    }
    assert_eq!(next, 20_000);
}

#[test]
fn parquet_gives_only_the_columns_asked_for_with_nulls_as_nan() {
    let columns: Vec<(&str, ArrayRef)> = vec![
        ("time_us", Arc::new(Int64Array::from(vec![1, 2, 3]))),
        ("note", Arc::new(StringArray::from(vec!["a", "b", "c"]))),
        ("temperature", Arc::new(Float32Array::from(vec![20.5, 21.0, 21.5]))),
        ("gyro_x", Arc::new(Float64Array::from(vec![Some(0.1), None, Some(0.3)]))),
    ];
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();

    let table = table(&writer.into_inner().unwrap()).unwrap();
    let batches: Vec<Batch> = table.batches(&[3, 0]).unwrap().collect::<Result<_, _>>().unwrap();
    assert_eq!(batches[0].columns[1], [1.0, 2.0, 3.0]);
    assert!(batches[0].columns[0][1].is_nan());
    let with_cells = table.batches_with_cells(&[2]).unwrap().next().unwrap().unwrap();
    assert_eq!(with_cells.cells[1], ["2", "b", "21.0", ""]);
    assert!(matches!(table.batches(&[1]).err().unwrap().fault, TableFault::NotNumeric { .. }));
}

#[test]
fn columns_are_guessed_where_the_names_make_it_plain() {
    for (header, time, temperature, rates) in [
        ("t_s,temperature_c,x_rad_s,y_rad_s,z_rad_s", Some(0), 1, vec![2, 3, 4]),
        ("timestamp,imu.gyro.x,imu.gyro.y,imu.gyro.z,imu.acc.x,imu.status,imu.temperature", Some(0), 6, vec![1, 2, 3]),
        ("TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T", Some(0), usize::MAX, vec![]),
        ("timestamp,timestamp_sample,device_id,x,y,z,temperature", Some(0), 6, vec![3, 4, 5]),
        ("temp,rate_dps", None, 0, vec![1]),
    ] {
        match resolve(header, &Columns::default()) {
            Ok(found) => assert_eq!((found.time, found.temperature, found.rates), (time, temperature, rates)),
            Err(error) => {
                assert_eq!(temperature, usize::MAX, "{error}");
                assert!(error.to_string().contains("say which (`temperature`); the columns are TimeUS, I,"));
            }
        }
    }
}

#[test]
fn units_come_from_the_names() {
    let named = resolve("TimeUS,temp_counts,GyrX_dps", &Columns::default()).unwrap();
    assert_eq!(named.time_unit, Some(TimeUnit::Us));
    assert_eq!(named.rate_unit, RateUnit::Dps);
    assert_eq!(named.temperature_unit, TemperatureUnit::Counts);
    assert!(named.notes.is_empty());
    let bare = resolve("timestamp,temperature,gyro.x", &Columns::default()).unwrap();
    assert_eq!((bare.time_unit, bare.rate_unit), (None, RateUnit::RadPerS));
    assert!(bare.notes[0].contains("taken as rad/s"));
}

#[test]
fn a_time_without_a_unit_is_read_by_how_long_the_log_lasts() {
    assert_eq!(TimeUnit::by_duration(4.245e9), Some(TimeUnit::Us));
    assert_eq!(TimeUnit::by_duration(4245.0), Some(TimeUnit::S));
    assert_eq!(TimeUnit::by_duration(60.0), None);
}

#[test]
fn a_column_asked_for_wins_and_a_wrong_one_lists_those_there_are() {
    let asked = Columns { rates: vec!["b".into()], temperature: Some("a".into()), ..Columns::default() };
    let found = resolve("a,b,gyro_x", &asked).unwrap();
    assert_eq!((found.temperature, found.rates), (0, vec![1]));
    let wrong = Columns { temperature: Some("heat".into()), ..Columns::default() };
    let error = resolve("a,b", &wrong).unwrap_err().to_string();
    assert!(error.ends_with("there is no column 'heat'; the columns are a, b"), "{error}");
    let two = resolve("temp_1,temp_2,gyro_x", &Columns::default()).unwrap_err().to_string();
    assert!(two.contains("more than one column could be the temperature"), "{two}");
}

#[test]
fn a_unit_that_a_name_says_is_taken_or_refused_and_never_mistaken() {
    let guessed = Columns::default();
    for (head, unit) in [
        ("time_s,temp_F,gyro_x_dps,gyro_y_dps", "degrees Fahrenheit"),
        ("time_s,Temp [°F],gyro_x_dps,gyro_y_dps", "degrees Fahrenheit"),
        ("time_s,temperature_k,gyro_x_dps,gyro_y_dps", "kelvin"),
        ("time_s,temp_c,gyro_x_mdps,gyro_y_mdps", "mdps"),
        ("time_s,temp_c,x_deg_h,y_deg_h", "deg/h"),
        ("time_s,temp_c,x [°/h],y [°/h]", "deg/h"),
        ("time_s,temp_c,gyro_x_mrad_s,gyro_y_mrad_s", "mrad/s"),
    ] {
        let refused = resolve(head, &guessed).unwrap_err().to_string();
        assert!(refused.contains(unit) && refused.contains("unit is not read"), "{head}: {refused}");
    }
    for (head, unit) in [
        ("time_s,temp_c,x [°/s],y [°/s]", RateUnit::Dps),
        ("time_s,Temperature [°C],x_deg_s,y_deg_s", RateUnit::Dps),
        ("time_s,temp_c,gx,gy", RateUnit::RadPerS),
    ] {
        assert_eq!(resolve(head, &guessed).unwrap().rate_unit, unit, "{head}");
    }
    let given = Columns { rate_unit: Some(RateUnit::Dps), ..Columns::default() };
    assert_eq!(resolve("time_s,temp_c,gyro_x_mdps,gyro_y_mdps", &given).unwrap().rate_unit, RateUnit::Dps);
}
