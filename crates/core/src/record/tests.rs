use super::*;
use crate::drift::{Memory, Polynomial, Scale, Shape, Term, ValidRange};
use crate::trim::TrimLine;
use crate::units::{Counts, Taps};

fn record() -> DeviceRecord {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let shape =
        Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap());
    let line = TrimLine::new(-0.031_990_6, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap();
    let mut axis = AxisRecord {
        drift: Drift { shape, valid: ValidRange::new(8500.0, 11_900.0).unwrap() },
        trim: Trim { line, measured: None },
        dead_band: 0.05,
        low_pass: LowPass::first_order(40.0, 0.003, 0.0001),
        start_up_mode: Mode::Hybrid,
        edges: None,
        history: None,
    };
    let law = axis.static_law(TemperatureScale::QUARTER_COUNTS);
    axis.edges = Some(EdgeTable::solve(&law).unwrap());
    DeviceRecord {
        unit: UnitSerial::try_from("ZR-0001").unwrap(),
        temperature_scale: TemperatureScale::QUARTER_COUNTS,
        axes: [axis.clone(), axis],
    }
}

#[test]
fn a_record_reads_back_as_it_was_written() {
    let mut buffer = [0; MAX_RECORD_BYTES];
    let bytes = record().encode(&mut buffer).unwrap();
    let read = DeviceRecord::decode(bytes).unwrap();
    assert_eq!(read, record());
    assert!(read.axis(Axis::X).law(read.temperature_scale).is_ok());
}

#[test]
fn every_flipped_bit_and_every_cut_is_noticed() {
    let mut buffer = [0; MAX_RECORD_BYTES];
    let bytes = record().encode(&mut buffer).unwrap();
    for cut in 0..bytes.len() {
        assert!(DeviceRecord::decode(&bytes[..cut]).is_err());
    }
    let mut flipped = std::vec::Vec::from(bytes);
    for bit in 0..flipped.len() * 8 {
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(DeviceRecord::decode(&flipped).is_err(), "bit {bit}");
        flipped[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn an_unknown_version_is_named_before_anything_else() {
    let mut buffer = [0; MAX_RECORD_BYTES];
    let length = record().encode(&mut buffer).unwrap().len();
    buffer[4] = 9;
    assert_eq!(DeviceRecord::decode(&buffer[..length]), Err(RecordError::UnknownVersion { found: 9 }));
    assert!(std::format!("{}", RecordError::UnknownVersion { found: 9 }).contains("version 9"));
}

#[test]
fn a_buffer_too_small_is_an_error_and_not_a_cut_record() {
    let mut buffer = [0; 100];
    assert_eq!(record().encode(&mut buffer), Err(RecordError::TooLong));
    assert_eq!(record().encode(&mut [0; 3]), Err(RecordError::TooLong));
}

/// A table of edges changed on the way, with a CRC that fits, is still refused: the device checks it against the law.
#[test]
fn a_table_that_does_not_belong_to_the_law_is_refused() {
    let mut wrong = record();
    let mut other = wrong.axes[0].static_law(wrong.temperature_scale);
    other.dead_band = 0.4;
    wrong.axes[0].edges = Some(EdgeTable::solve(&other).unwrap());
    assert!(matches!(wrong.axes[0].law(wrong.temperature_scale), Err(LawRefused::Edges(_))));
}

/// A history makes the law dynamic, and a device refuses one that it cannot run.
#[test]
fn a_history_travels_with_the_record_and_is_checked() {
    let mut with = record();
    let curve = with.axes[0].drift.shape.clone();
    let terms = [
        Term { memory: Memory::Play { half_width: 200.0 }, weight: 0.1, share: 0.75 },
        Term { memory: Memory::Lag { time_constant_s: 240.0 }, weight: -0.02, share: 0.25 },
    ];
    let history = History::new(curve, &terms).unwrap();
    with.axes[0].history = Some(HistoryRecord { history, group_period_s: 0.5 });
    let mut buffer = [0; MAX_RECORD_BYTES];
    let read = DeviceRecord::decode(with.encode(&mut buffer).unwrap()).unwrap();
    assert_eq!(read, with);
    let dynamic = |axis: Axis| read.axis(axis).law(read.temperature_scale).map(|law| law.is_dynamic());
    assert_eq!((dynamic(Axis::X), dynamic(Axis::Y)), (Ok(true), Ok(false)));
    with.axes[0].history.as_mut().unwrap().group_period_s = f64::NAN;
    assert!(matches!(with.axes[0].law(with.temperature_scale), Err(LawRefused::Unrepresentable(_))));
}
