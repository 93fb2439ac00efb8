//! The functions that C calls, and what they take and give.
//!
//! Every pointer may be null: the call then does nothing and says so. What C must see to is that a pointer which is not
//! null leads to a whole object of its type, and that a unit is used by one call at a time.

use core::ffi::{CStr, c_char};

use zerorate_core::compensate::Mode;
use zerorate_core::drift::{Coverage, Knowledge};
use zerorate_core::group::GroupSums;
use zerorate_core::record::{RecordError, RecordRefused};
use zerorate_core::units::{Axis, Taps};

use crate::unit::{CalibratedAxis, Stored, Unit, ZerorateUnit};

/// Axis X.
pub const ZERORATE_AXIS_X: u32 = 0;
/// Axis Y.
pub const ZERORATE_AXIS_Y: u32 = 1;

/// Nothing is compensated: the control of a compensation test.
pub const ZERORATE_MODE_OFF: u32 = 0;
/// The wiper follows the temperature.
pub const ZERORATE_MODE_TRIM: u32 = 1;
/// The wiper stays; the drift is subtracted in numbers.
pub const ZERORATE_MODE_DIGITAL: u32 = 2;
/// The wiper follows the temperature, and what is left below a tap is subtracted in numbers.
pub const ZERORATE_MODE_HYBRID: u32 = 3;

/// The temperature lies in the calibrated range.
pub const ZERORATE_INSIDE: u32 = 0;
/// Below the calibrated range: the temperature was held at its lower end.
pub const ZERORATE_BELOW: u32 = 1;
/// Above the calibrated range: the temperature was held at its upper end.
pub const ZERORATE_ABOVE: u32 = 2;
/// The group was empty.
pub const ZERORATE_INVALID: u32 = 3;

/// What came of a call.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZerorateResult {
    /// It was done.
    Done = 0,
    /// A pointer was null.
    NullPointer = 1,
    /// The unit was not initialised from a record.
    NotInitialised = 2,
    /// There is no such axis, mode or tap.
    OutOfRange = 3,
    /// The bytes are not a record, or were cut or changed: fetch them again.
    DamagedRecord = 4,
    /// The record is of a version that this library does not know: make it anew from calibration.json.
    UnknownVersion = 5,
    /// The record belongs to a unit of another serial.
    OtherUnit = 6,
    /// The record's law cannot be run: compose it again.
    LawRefused = 7,
    /// The mode moves the wiper and this calibration cannot: use digital.
    NoEdges = 8,
}

impl From<()> for ZerorateResult {
    fn from((): ()) -> Self {
        Self::Done
    }
}

/// The sums of one axis's samples in a group. Start from zeros; `zerorate_push` adds a sample.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ZerorateGroup {
    /// Number of samples.
    pub n: u32,
    /// Sum of the temperature samples, counts.
    pub temperature: u64,
    /// Sum of the zero-rate samples, counts.
    pub zro: u64,
}

/// What closing a group came to.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ZerorateOutcome {
    /// The group's mean, corrected, in steps of 1/65536 count; the plain mean in the modes that do not correct.
    /// Of a reading from 32768 counts on, less 65536 counts.
    pub corrected_q16: i32,
    /// Where the temperature lies against the calibrated range: `ZERORATE_INSIDE`, `_BELOW`, `_ABOVE` or `_INVALID`.
    pub coverage: u32,
    /// The tap at which the wiper should be.
    pub tap: u16,
    /// Whether the wiper is elsewhere: write `tap`, then call `zerorate_wiper_written`.
    pub write_wiper: bool,
    /// Whether the history that the correction rests on was seen; always so for a calibration without history. Until it
    /// was, after a start, the correction is uncertain by up to what it adds.
    pub history_known: bool,
}

/// Fills a unit from the bytes of a device record (`device-record.bin`). `serial` is the unit's own, ended by a zero byte;
/// a record of another serial is refused; null takes any. Both wipers are taken to stand at the middle tap, 511: write
/// that tap before the first group. The modes are those that the record gives for start-up.
///
/// Takes some 20 KiB of stack: call it once, at start-up, not from an interrupt.
///
/// # Safety
/// `unit` is null or leads to a `ZerorateUnit` (its contents may be anything), `record` is null or leads to `length` bytes,
/// `serial` is null or leads to a string ended by a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_init(
    unit: *mut ZerorateUnit,
    record: *const u8,
    length: usize,
    serial: *const c_char,
) -> ZerorateResult {
    // SAFETY: the caller's word; storage of any contents is a `Stored`, since its mark tells whether the rest is filled.
    let Some(stored) = (unsafe { unit.cast::<Stored>().as_mut() }) else {
        return ZerorateResult::NullPointer;
    };
    stored.clear();
    if record.is_null() {
        return ZerorateResult::NullPointer;
    }
    // SAFETY: not null, and the caller's word for its length.
    let bytes = unsafe { core::slice::from_raw_parts(record, length) };
    // SAFETY: the caller's word that what is not null is a string.
    let serial = (!serial.is_null()).then(|| unsafe { CStr::from_ptr(serial) }.to_bytes());
    match Unit::from_record(bytes, serial) {
        Ok(unit) => {
            stored.fill(unit);
            ZerorateResult::Done
        }
        Err(RecordRefused::Bytes(RecordError::UnknownVersion { .. })) => ZerorateResult::UnknownVersion,
        Err(RecordRefused::Bytes(_)) => ZerorateResult::DamagedRecord,
        Err(RecordRefused::OtherUnit) => ZerorateResult::OtherUnit,
        Err(RecordRefused::Law) => ZerorateResult::LawRefused,
    }
}

/// Changes an axis's mode; the wiper stays until the next group.
///
/// # Safety
/// `unit` is null or leads to a `ZerorateUnit`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_set_mode(unit: *mut ZerorateUnit, axis: u32, mode: u32) -> ZerorateResult {
    let mode = match mode {
        ZERORATE_MODE_OFF => Mode::Off,
        ZERORATE_MODE_TRIM => Mode::Trim,
        ZERORATE_MODE_DIGITAL => Mode::Digital,
        ZERORATE_MODE_HYBRID => Mode::Hybrid,
        _ => return ZerorateResult::OutOfRange,
    };
    let act = |axis: &mut CalibratedAxis| match axis.set_mode(mode) {
        true => ZerorateResult::Done,
        false => ZerorateResult::NoEdges,
    };
    // SAFETY: the caller's word.
    unsafe { with_axis(unit, axis, act) }
}

/// Adds one sample of temperature and zero-rate output, counts, to a group.
///
/// # Safety
/// `group` is null or leads to a `ZerorateGroup`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_push(group: *mut ZerorateGroup, temperature: u16, zro: u16) -> ZerorateResult {
    // SAFETY: the caller's word.
    let Some(group) = (unsafe { group.as_mut() }) else {
        return ZerorateResult::NullPointer;
    };
    group.n += 1;
    group.temperature += u64::from(temperature);
    group.zro += u64::from(zro);
    ZerorateResult::Done
}

/// Corrects one sample as it comes, by the temperature of the last closed group and the wiper as far as it has settled;
/// `corrected_q16` gets it in steps of 1/65536 count. The plain sample in the modes that do not correct. Of a reading from 32768 on,
/// less 65536 counts.
///
/// Call it for every sample or for none: `zerorate_update` passes over those that it was not shown.
///
/// # Safety
/// `unit` is null or leads to a `ZerorateUnit`, `corrected_q16` is null or leads to an `int32_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_correct(
    unit: *mut ZerorateUnit,
    axis: u32,
    zro: u16,
    corrected_q16: *mut i32,
) -> ZerorateResult {
    // SAFETY: the caller's word.
    let Some(corrected) = (unsafe { corrected_q16.as_mut() }) else {
        return ZerorateResult::NullPointer;
    };
    // SAFETY: the caller's word.
    unsafe { with_axis(unit, axis, |axis| *corrected = axis.correct(zro)) }
}

/// Closes an axis's group: `outcome` gets its corrected mean, and the tap for its temperature.
///
/// # Safety
/// `unit`, `group` and `outcome` are null or lead to objects of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_update(
    unit: *mut ZerorateUnit,
    axis: u32,
    group: *const ZerorateGroup,
    outcome: *mut ZerorateOutcome,
) -> ZerorateResult {
    // SAFETY: the caller's word.
    let (Some(group), Some(outcome)) = (unsafe { group.as_ref() }, unsafe { outcome.as_mut() }) else {
        return ZerorateResult::NullPointer;
    };
    let ZerorateGroup { n, temperature, zro } = *group;
    let act = |axis: &mut CalibratedAxis| {
        // The law does not look at the squares: they are for whoever records.
        let (closed, tap) = axis.update(&GroupSums { n, temperature, zro, ..GroupSums::default() });
        *outcome = ZerorateOutcome {
            corrected_q16: closed.corrected.0,
            coverage: coverage(closed.coverage),
            tap: tap.get(),
            write_wiper: closed.move_to.is_some(),
            history_known: closed.knowledge == Knowledge::Known,
        };
    };
    // SAFETY: the caller's word.
    unsafe { with_axis(unit, axis, act) }
}

/// Says that the wiper was written. A write that failed is not said: the law then asks again with the next group.
///
/// # Safety
/// `unit` is null or leads to a `ZerorateUnit`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_wiper_written(unit: *mut ZerorateUnit, axis: u32, tap: u16) -> ZerorateResult {
    let Some(tap) = Taps::new(tap) else {
        return ZerorateResult::OutOfRange;
    };
    // SAFETY: the caller's word.
    unsafe { with_axis(unit, axis, |axis| axis.wiper_written(tap)) }
}

/// Says that `groups` groups of `n` samples each were lost before the one that is being filled: the wiper settles
/// meanwhile, and a history goes on.
///
/// # Safety
/// `unit` is null or leads to a `ZerorateUnit`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zerorate_groups_lost(
    unit: *mut ZerorateUnit,
    axis: u32,
    groups: u32,
    n: u32,
) -> ZerorateResult {
    // SAFETY: the caller's word.
    unsafe { with_axis(unit, axis, |axis| axis.groups_lost(groups, n)) }
}

/// Does something to an axis of a unit, if there are both.
///
/// # Safety
/// `unit` is null or leads to a `ZerorateUnit` that nobody else uses meanwhile.
unsafe fn with_axis<R: Into<ZerorateResult>>(
    unit: *mut ZerorateUnit,
    axis: u32,
    act: impl FnOnce(&mut CalibratedAxis) -> R,
) -> ZerorateResult {
    let axis = match axis {
        ZERORATE_AXIS_X => Axis::X,
        ZERORATE_AXIS_Y => Axis::Y,
        _ => return ZerorateResult::OutOfRange,
    };
    // SAFETY: the caller's word; storage of any contents is a `Stored`.
    let Some(stored) = (unsafe { unit.cast::<Stored>().as_mut() }) else {
        return ZerorateResult::NullPointer;
    };
    stored.unit().map_or(ZerorateResult::NotInitialised, |unit| act(&mut unit.0[axis.index()]).into())
}

fn coverage(coverage: Coverage) -> u32 {
    match coverage {
        Coverage::Inside => ZERORATE_INSIDE,
        Coverage::Below => ZERORATE_BELOW,
        Coverage::Above => ZERORATE_ABOVE,
        Coverage::Invalid => ZERORATE_INVALID,
    }
}
