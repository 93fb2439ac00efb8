use super::*;
use crate::compensate::{
    CurveNumbers, EdgeTable, HistoryNumbers, LowPass, MemoryNumbers, Part, PolynomialNumbers, TermNumbers,
};
use crate::drift::{Drift, History, Memory, Polynomial, Scale, Shape, Term, ValidRange};
use crate::trim::{Trim, TrimLine};
use crate::units::{Counts, Taps};

const SCALE: TemperatureScale = TemperatureScale::QUARTER_COUNTS;

fn model() -> AxisModel {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let shape =
        Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap());
    let line = TrimLine::new(-0.031_990_6, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap();
    let mut axis = AxisModel {
        drift: Drift { shape, valid: ValidRange::new(8500.0, 11_900.0).unwrap() },
        trim: Trim { line, measured: None },
        dead_band: 0.05,
        low_pass: LowPass::first_order(40.0, 0.003, 0.0001),
        start_up_mode: Mode::Hybrid,
        edges: None,
        history: None,
    };
    axis.edges = Some(EdgeTable::solve(&axis.static_law(SCALE)).unwrap());
    axis
}

fn record() -> DeviceRecord {
    DeviceRecord::new(UnitSerial::try_from("ZR-0001").unwrap(), SCALE, BoardNumbers::PAPER, &[model(), model()])
        .unwrap()
}

#[test]
fn a_record_reads_back_as_it_was_written() {
    let mut buffer = [0; MAX_RECORD_BYTES];
    let bytes = record().encode(&mut buffer).unwrap();
    let read = DeviceRecord::decode(bytes).unwrap();
    assert_eq!(read, record());
    assert!(read.axis(Axis::X).law().is_ok());
}

/// The device reads an axis after the other, the host the whole.
#[test]
fn the_laws_of_a_record_are_those_of_its_axes() {
    let mut other = model();
    (other.dead_band, other.start_up_mode) = (0.1, Mode::Trim);
    other.edges = Some(EdgeTable::solve(&other.static_law(SCALE)).unwrap());
    let record = DeviceRecord { axes: [model().record(SCALE).unwrap(), other.record(SCALE).unwrap()], ..record() };
    let mut buffer = [0; MAX_RECORD_BYTES];
    let bytes = record.encode(&mut buffer).unwrap();
    let laws = laws_for(Some(b"ZR-0001"), bytes).unwrap();
    assert_eq!(laws.axes, [record.axes[0].law().unwrap(), record.axes[1].law().unwrap()]);
    assert_eq!((laws.start_up_modes, laws.board), ([Mode::Hybrid, Mode::Trim], record.board));
    assert_eq!(laws_for(Some(b"ZR-0002"), bytes), Err(RecordRefused::OtherUnit));
    // Two boards that cannot read their serials may call themselves alike, and are not one unit.
    let unread = DeviceRecord { unit: UnitSerial::try_from("?").unwrap(), ..record };
    let bytes = unread.encode(&mut buffer).unwrap();
    assert_eq!(laws_for(Some(b"?"), bytes), Err(RecordRefused::OtherUnit));
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

/// A table of edges that was solved for another law does not get into a record; one changed on the way, with a CRC that
/// fits, is refused by the device, by the integers alone.
#[test]
fn a_table_that_does_not_belong_to_the_law_is_refused() {
    let mut other = model().static_law(SCALE);
    other.dead_band = 0.4;
    let of_another = Some(EdgeTable::solve(&other).unwrap());
    let wrong = AxisModel { edges: of_another.clone(), ..model() };
    assert!(matches!(wrong.record(SCALE), Err(LawRefused::Edges(_))));
    let mut changed = record();
    changed.axes[0].law.edges = of_another;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let read = DeviceRecord::decode(changed.encode(&mut buffer).unwrap()).unwrap();
    assert!(matches!(read.axes[0].law(), Err(LawRefused::Edges(_))));
    assert!(read.axes[1].law().is_ok());
}

/// What a device is to be kept from: a number of a record that is another one, and a CRC that fits all the same.
#[test]
fn numbers_that_make_no_law_are_refused_by_the_part_that_is_wrong() {
    let refused = |change: &dyn Fn(&mut LawNumbers)| {
        let mut axis = record().axes[0].clone();
        change(&mut axis.law);
        axis.law().unwrap_err()
    };
    let polynomial = |law: &mut LawNumbers, change: &dyn Fn(&mut PolynomialNumbers)| {
        let CurveNumbers::Polynomial(numbers) = &mut law.drift.curve else { panic!() };
        change(numbers);
    };
    let drift = LawRefused::Senseless(Part::Drift);
    assert_eq!(refused(&|law| law.drift.last = law.drift.first), drift);
    assert_eq!(refused(&|law| polynomial(law, &|numbers| numbers.fraction_bits = 17)), drift);
    assert_eq!(refused(&|law| polynomial(law, &|numbers| numbers.coefficients[1] = i32::MIN)), drift);
    assert_eq!(refused(&|law| polynomial(law, &|numbers| numbers.coefficients.truncate(1))), drift);
    // Fits in its own steps, and not in counts: the correction would wrap.
    let coarse = |numbers: &mut PolynomialNumbers| (numbers.fraction_bits, numbers.coefficients[0]) = (12, 1 << 28);
    assert_eq!(refused(&|law| polynomial(law, &coarse)), drift);
    let trim = LawRefused::Senseless(Part::Trim);
    assert_eq!(refused(&|law| law.trim.per_tap = 0), trim);
    assert_eq!(refused(&|law| law.trim.per_tap = i32::MAX), trim);
    assert_eq!(refused(&|law| law.trim.effects = [5, 5].into_iter().collect()), trim);
    assert_eq!(refused(&|law| law.dead_band = -1), LawRefused::Senseless(Part::DeadBand));
    let forgetful =
        TermNumbers { memory: MemoryNumbers::Lag { kept: 0, part: 0 }, weight: 1, behind: 0, share: 1 << 16 };
    let history = |law: &mut LawNumbers, term: TermNumbers| {
        let terms = core::iter::once(term).collect();
        law.history = Some(HistoryNumbers { curve: law.drift.curve.clone(), terms });
    };
    assert_eq!(refused(&|law| history(law, forgetful)), LawRefused::Senseless(Part::History));
    let half = TermNumbers { memory: MemoryNumbers::Play { half_width: 9 }, weight: 1, behind: 0, share: 1 << 15 };
    assert_eq!(refused(&|law| history(law, half)), LawRefused::Senseless(Part::History));
    // The laws are whole, and are another one than the table's.
    let other = |law: LawRefused| matches!(law, LawRefused::Edges(_));
    assert!(other(refused(&|law| polynomial(law, &|numbers| numbers.coefficients[0] += 2 << 16))));
    assert!(other(refused(&|law| law.trim.per_tap += 2 << 16)));
    assert!(other(refused(&|law| law.trim.intercept += 2 << 16)));
    assert!(other(refused(&|law| polynomial(law, &|numbers| numbers.coefficients[0] -= 2 << 16))));
    assert!(other(refused(&|law| law.dead_band = 0)));
}

/// A history makes the law dynamic, and one that a device cannot run gets into no record.
#[test]
fn a_history_travels_with_the_record_and_is_checked() {
    let mut with = model();
    let terms = [
        Term { memory: Memory::Play { half_width: 200.0 }, weight: 0.1, behind: 0.0, share: 0.75 },
        Term { memory: Memory::Lag { time_constant_s: 240.0 }, weight: -0.02, behind: 0.3, share: 0.25 },
    ];
    let history = History::new(with.drift.shape.clone(), &terms).unwrap();
    with.history = Some(HistoryModel { history, group_period_s: 0.5 });
    let record = DeviceRecord { axes: [with.record(SCALE).unwrap(), model().record(SCALE).unwrap()], ..record() };
    let mut buffer = [0; MAX_RECORD_BYTES];
    let read = DeviceRecord::decode(record.encode(&mut buffer).unwrap()).unwrap();
    assert_eq!(read, record);
    assert!(read.axis(Axis::X).law().is_ok() && read.axis(Axis::X).law.history.is_some());
    assert!(read.axis(Axis::Y).law().is_ok() && read.axis(Axis::Y).law.history.is_none());
    with.history.as_mut().unwrap().group_period_s = f64::NAN;
    assert!(matches!(with.record(SCALE), Err(LawRefused::Unrepresentable(_))));
}
