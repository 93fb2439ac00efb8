//! What C may do wrong: null pointers, storage that was never filled, axes and taps that are none.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use zerorate_ffi::{
    ZERORATE_AXIS_X, ZERORATE_MODE_TRIM, ZERORATE_UNIT_WORDS, ZerorateGroup, ZerorateOutcome, ZerorateResult,
    ZerorateUnit, zerorate_correct, zerorate_groups_lost, zerorate_init, zerorate_push, zerorate_set_mode,
    zerorate_update, zerorate_wiper_written,
};

fn storage(word: u64) -> ZerorateUnit {
    ZerorateUnit { opaque: [word; ZERORATE_UNIT_WORDS] }
}

#[test]
fn a_null_pointer_is_a_result() {
    let (group, mut outcome, mut reading) = (ZerorateGroup::default(), ZerorateOutcome::default(), 0);
    let mut unit = storage(0);
    // SAFETY: each pointer is null or leads to an object of its type.
    let results = unsafe {
        [
            zerorate_init(null_mut(), null(), 0, null()),
            zerorate_init(&raw mut unit, null(), 0, null()),
            zerorate_set_mode(null_mut(), ZERORATE_AXIS_X, ZERORATE_MODE_TRIM),
            zerorate_push(null_mut(), 0, 0),
            zerorate_correct(null_mut(), ZERORATE_AXIS_X, 0, &raw mut reading),
            zerorate_correct(&raw mut unit, ZERORATE_AXIS_X, 0, null_mut()),
            zerorate_update(null_mut(), ZERORATE_AXIS_X, &raw const group, &raw mut outcome),
            zerorate_update(&raw mut unit, ZERORATE_AXIS_X, null(), &raw mut outcome),
            zerorate_update(&raw mut unit, ZERORATE_AXIS_X, &raw const group, null_mut()),
            zerorate_wiper_written(null_mut(), ZERORATE_AXIS_X, 511),
            zerorate_groups_lost(null_mut(), ZERORATE_AXIS_X, 1, 500),
        ]
    };
    assert_eq!(results, [ZerorateResult::NullPointer; 11]);
}

#[test]
fn chance_memory_is_no_unit() {
    for word in [0, u64::MAX, 0xA5A5_A5A5_A5A5_A5A5] {
        let mut unit = storage(word);
        let (group, mut outcome) = (ZerorateGroup::default(), ZerorateOutcome::default());
        // SAFETY: all pointers lead to objects of their types.
        let result = unsafe { zerorate_update(&raw mut unit, 0, &raw const group, &raw mut outcome) };
        assert_eq!(result, ZerorateResult::NotInitialised);
    }
    // A unit whose initialisation was refused is none either, whatever it was before.
    let mut unit = MaybeUninit::new(storage(0));
    let bytes = [0_u8; 64];
    // SAFETY: the unit's storage and 64 bytes.
    let refused = unsafe { zerorate_init(unit.as_mut_ptr(), bytes.as_ptr(), bytes.len(), null()) };
    assert_eq!(refused, ZerorateResult::DamagedRecord);
    // SAFETY: the unit's storage.
    assert_eq!(unsafe { zerorate_groups_lost(unit.as_mut_ptr(), 0, 1, 500) }, ZerorateResult::NotInitialised);
}

#[test]
fn axes_and_taps_that_are_none_are_told() {
    let mut unit = storage(0);
    // SAFETY: the unit's storage.
    unsafe {
        assert_eq!(zerorate_set_mode(&raw mut unit, 2, ZERORATE_MODE_TRIM), ZerorateResult::OutOfRange);
        assert_eq!(zerorate_wiper_written(&raw mut unit, 0, 1024), ZerorateResult::OutOfRange);
    }
}
