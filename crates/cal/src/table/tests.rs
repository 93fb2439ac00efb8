use std::sync::Arc;

use ::parquet::arrow::ArrowWriter;
use arrow_array::{ArrayRef, Float32Array, Float64Array, Int64Array, RecordBatch, StringArray};

use super::*;
use crate::units::{RateUnit, TimeUnit, WrittenRate, WrittenTemperature};

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

/// The places of the first sensor's rates.
fn places(found: &Resolved) -> Vec<usize> {
    found.sensors[0].rates.iter().map(|rate| rate.column).collect()
}

#[test]
fn every_delimiter_is_found_by_content() {
    for content in ["t,r\n1,2\n3,4\n", "t;r\n1;2\n3;4\n", "t\tr\r\n1\t2\r\n3\t4\r\n", "  t   r\n 1 2\n3    4\n"] {
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
fn commas_in_numbers_between_commas_are_told_apart_from_a_damaged_line() {
    let mixed = read("t_s,temp_c,x\n0,20,5\n1,20,5,-0,25\n").unwrap_err().to_string();
    assert!(mixed.contains("line 3: 5 cells where the first line has 3: commas seem to stand both"), "{mixed}");
    let damaged = read("t_s,temp_c,x\n0,20.5,5\n1,20.5,5,1,20.5,5\n").unwrap_err().to_string();
    assert!(damaged.contains("cut off or damaged"), "{damaged}");
}

#[test]
fn what_is_no_table_says_so() {
    assert!(matches!(read("").unwrap_err().fault, TableFault::Empty));
    assert!(matches!(read("\n\n").unwrap_err().fault, TableFault::Empty));
    assert!(matches!(read("hello\n").unwrap_err().fault, TableFault::NotATable));
    assert!(matches!(read("a\0b").unwrap_err().fault, TableFault::NotATable));
    let wide: Vec<u8> = "\u{feff}a,b\n1,2\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let told = Table::open(&Source::bytes("log.csv", wide)).unwrap_err().to_string();
    assert!(told.contains("UTF-16: save it as UTF-8"), "{told}");
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

/// By polars: 200 rows of 0, 1, 2... s, a degree more every fourth row, and rates of 0 to 6 in turn.
#[test]
fn parquet_is_read_however_it_is_packed_and_else_it_is_said_how_to_pack_it() {
    let packed: [&[u8]; 4] = [
        include_bytes!("tests/packed/snappy.parquet"),
        include_bytes!("tests/packed/lz4.parquet"),
        include_bytes!("tests/packed/gzip.parquet"),
        include_bytes!("tests/packed/zstd.parquet"),
    ];
    for packed in packed {
        let batch = table(packed).unwrap().batches(&[0, 1, 2]).unwrap().next().unwrap().unwrap();
        let wanted = |of: fn(u32) -> u32| (0..200).map(of).map(f64::from).collect::<Vec<_>>();
        assert_eq!(batch.columns, [wanted(|row| row), wanted(|row| row / 4), wanted(|row| row % 7)]);
    }
    // The same with its codec changed by hand: whatever else is built beside this crate, nothing unpacks LZO.
    let lzo = table(include_bytes!("tests/packed/lzo.parquet")).unwrap();
    let told = lzo.batches(&[0]).unwrap().next().unwrap().unwrap_err().to_string();
    assert!(told.ends_with("it is packed by LZO: write it again, packed by snappy"), "{told}");
    // What only some builds unpack.
    let left_out = "Parquet argument error: Disabled feature at compile time: brotli";
    assert_eq!(super::parquet::unknown_packing(left_out), Some("brotli"));
}

#[test]
fn a_time_without_a_unit_is_read_by_how_long_the_log_lasts() {
    assert_eq!(TimeUnit::by_duration(4.245e9), Some(TimeUnit::Us));
    assert_eq!(TimeUnit::by_duration(4245.0), Some(TimeUnit::S));
    assert_eq!(TimeUnit::by_duration(60.0), None);
}

#[test]
fn decimal_commas_are_read_where_cells_are_not_delimited_by_commas() {
    let (names, columns) = read("t;temp;x\n0,5;20;-1,25e-3\n1,0;20,5;2\n").unwrap();
    assert_eq!(names, ["t", "temp", "x"]);
    assert_eq!(columns, [[0.5, 1.0], [20.0, 20.5], [-1.25e-3, 2.0]]);
    let both = read("t;x\n0,5;1.5\n1,0;2.5\n").unwrap_err().to_string();
    assert!(both.contains("line 2: column 't' holds '0,5' where a number should be"), "{both}");
}

#[test]
fn comments_are_no_rows_and_may_hold_the_names() {
    let (names, columns) = read("# a chamber, by hand\n# in May\nt,x\n1,2\n# the door was opened\n3,4\n").unwrap();
    assert_eq!((names, columns), (vec!["t".into(), "x".into()], vec![vec![1.0, 3.0], vec![2.0, 4.0]]));
    // As numpy.savetxt writes a header.
    assert_eq!(read("# t x\n1.0 2.0\n3.0 4.0\n").unwrap().0, ["t", "x"]);
    assert_eq!(read("# only, a, remark\n1.0,2.0\n").unwrap().0, ["column_1", "column_2"]);
}

#[test]
fn a_row_of_units_below_the_names_is_no_row_and_its_units_are_taken() {
    let content = "time,temperature,x,y,z,status\nms,°F,mdps,mdps,mdps,-\n0,50,1,2,3,0\n1000,51,1,2,3,0\n";
    let found = Columns::default().resolve(&table(content.as_bytes()).unwrap()).unwrap();
    assert_eq!((found.time, found.time_unit, places(&found)), (Some(0), Some(TimeUnit::Ms), vec![2, 3, 4]));
    assert_eq!(found.sensors[0].written_temperature, WrittenTemperature::Fahrenheit);
    assert!((found.sensors[0].rates[0].factor - 1e-3).abs() < 1e-12 && found.guesses.is_empty());
    let (names, columns) = read(content).unwrap();
    assert_eq!((names[2].as_str(), &columns[1][..]), ("x", &[50.0, 51.0][..]));
    // An older program's degree sign, one byte.
    let latin = table(b"t_s,Temp [\xB0F],x_dps\n1,50,2\n").unwrap();
    assert_eq!(latin.names()[1], "Temp [°F]");
}

#[test]
fn a_name_and_a_row_of_units_that_differ_ask_which_is_true() {
    let resolve = |units: &str, columns: &Columns| {
        columns.resolve(&table(format!("t_s,temp_c,x_rad_s\n{units}\n0,20,1\n").as_bytes()).unwrap())
    };
    let guessed = Columns::default();
    assert!(resolve("s,°C,rad/s", &guessed).unwrap().guesses.is_empty());
    for (units, told) in [
        ("s,°C,deg/s", "'x_rad_s' says rad/s by its name and dps in the row of units: say which is true (`rate_unit`)"),
        ("s,°C,rpm", "rad/s by its name and turns a minute in the row"),
        (
            "s,K,rad/s",
            "'temp_c' says degrees C by its name and kelvin in the row of units: say which is true (`temperature_unit`)",
        ),
        ("ms,°C,rad/s", "'t_s' says s by its name and ms in the row of units: say which is true (`time_unit`)"),
    ] {
        let refused = resolve(units, &guessed).unwrap_err().to_string();
        assert!(refused.contains(told), "{refused}");
    }
    let given = Columns { rate_unit: Some(WrittenRate::Dps), ..Columns::default() };
    assert_eq!(resolve("s,°C,deg/s", &given).unwrap().sensors[0].rate_unit, RateUnit::Dps);
}

#[test]
fn iso_times_are_seconds() {
    let content = "date,temp_c,x_dps\n2026-03-01T08:00:00.250+02:00,20,1\n2026-03-01T06:00:01Z,21,2\n,22,3\n";
    let (_, columns) = read(content).unwrap();
    // By `date -u -d 2026-03-01T06:00:00.25 +%s.%N`.
    assert!((columns[0][0] - 1_772_344_800.25).abs() < 1e-6 && (columns[0][1] - 1_772_344_801.0).abs() < 1e-6);
    assert!(columns[0][2].is_nan());
    let found = Columns::default().resolve(&table(content.as_bytes()).unwrap()).unwrap();
    assert_eq!((found.time, found.time_unit), (Some(0), Some(TimeUnit::S)));
    let wrong = read(&content.replace("2026-03-01T06:00:01Z", "later")).unwrap_err().to_string();
    assert!(wrong.contains("line 3: column 'date' holds 'later' where a time like 2026-03-01T08:00:00"), "{wrong}");
}

#[test]
fn a_last_line_without_its_line_feed_is_left_out_and_told() {
    for (content, cut_line) in [("a,b\n1,2\n3,4.5\n", None), ("a,b\n1,2\n3,4.", Some(3)), ("a,b\n1,2\n3", Some(3))] {
        let batches: Vec<Batch> =
            table(content.as_bytes()).unwrap().batches(&[0, 1]).unwrap().collect::<Result<_, _>>().unwrap();
        let rows: usize = batches.iter().map(Batch::rows).sum();
        assert_eq!((batches[batches.len() - 1].cut_line, rows), (cut_line, if cut_line.is_some() { 1 } else { 2 }));
    }
}

#[test]
fn a_line_without_end_is_refused_before_it_takes_the_memory() {
    let content = ["a,b\n1,", &"2".repeat(3 << 20)].concat();
    let endless = read(&content).unwrap_err().to_string();
    assert!(endless.contains("line 2 is longer than a megabyte"), "{endless}");
    // A quote that is never closed does not swallow the rows after it.
    let open = read("a,b\n1,\"2\n3,4\n").unwrap();
    assert_eq!(open.1[0], [1.0, 3.0]);
}

#[test]
fn a_time_stamp_of_parquet_says_its_unit() {
    let times: ArrayRef = Arc::new(arrow_array::TimestampMillisecondArray::from(vec![1000, 2500]));
    let values: ArrayRef = Arc::new(Float64Array::from(vec![20.0, 21.0]));
    let batch =
        RecordBatch::try_from_iter([("time", times), ("temp_c", values.clone()), ("gyro_x_dps", values)]).unwrap();
    let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    let table = table(&writer.into_inner().unwrap()).unwrap();
    assert_eq!(Columns::default().resolve(&table).unwrap().time_unit, Some(TimeUnit::Ms));
}
