//! A calibrated unit in storage that C gives: laws and state of both axes.

use core::mem::MaybeUninit;

use zerorate_core::compensate::{AxisCompensation, AxisLaw, GroupOutcome, Mode};
use zerorate_core::group::GroupSums;
use zerorate_core::record::{RecordRefused, laws_for};
use zerorate_core::units::{Axis, Taps};

/// 64-bit words of a unit's storage: more than its laws and state take on any target.
pub const ZERORATE_UNIT_WORDS: usize = 512;

/// A unit's storage. C provides it, `zerorate_init` fills it; what is in it is nobody else's business.
#[repr(C)]
pub struct ZerorateUnit {
    /// Opaque; words, so that it lies where laws may lie.
    pub opaque: [u64; ZERORATE_UNIT_WORDS],
}

/// Says that storage was filled by [`Stored::fill`]: chance memory does not begin with it.
const FILLED: u64 = u64::from_le_bytes(*b"ZRunit\x02\x01");

/// What the storage holds.
#[repr(C)]
pub(crate) struct Stored {
    filled: u64,
    unit: MaybeUninit<Unit>,
}

const _: () =
    assert!(size_of::<Stored>() <= size_of::<ZerorateUnit>() && align_of::<Stored>() <= align_of::<ZerorateUnit>());

impl Stored {
    pub(crate) fn fill(&mut self, unit: Unit) {
        self.unit.write(unit);
        self.filled = FILLED;
    }

    pub(crate) fn clear(&mut self) {
        self.filled = 0;
    }

    pub(crate) fn unit(&mut self) -> Option<&mut Unit> {
        // SAFETY: only `fill` writes the mark, after it has written the unit.
        (self.filled == FILLED).then(|| unsafe { self.unit.assume_init_mut() })
    }
}

/// Laws and state of both axes.
pub(crate) struct Unit {
    laws: [AxisLaw; 2],
    axes: [AxisCompensation; 2],
    /// Samples of the group being filled that `correct` has seen.
    seen: [u32; 2],
}

impl Unit {
    /// A unit at start-up, both wipers at the middle tap, in the modes that the record gives for start-up. A `serial`
    /// that is not the record's refuses it.
    pub(crate) fn from_record(bytes: &[u8], serial: Option<&[u8]>) -> Result<Self, RecordRefused> {
        let (laws, modes) = laws_for(serial, bytes)?;
        let axes = Axis::BOTH.map(|axis| {
            let mut state = AxisCompensation::new(Some(&laws[axis.index()]), Taps::MIDDLE);
            state.set_mode(modes[axis.index()]);
            state
        });
        Ok(Self { laws, axes, seen: [0; 2] })
    }

    /// `false` when the mode moves the wiper and the calibration cannot.
    pub(crate) fn set_mode(&mut self, axis: Axis, mode: Mode) -> bool {
        let possible = !mode.moves_wiper() || self.laws[axis.index()].moves_wiper();
        if possible {
            self.axes[axis.index()].set_mode(mode);
        }
        possible
    }

    pub(crate) fn correct(&mut self, axis: Axis, zro: u16) -> i32 {
        self.seen[axis.index()] += 1;
        self.axes[axis.index()].sample(zro).0
    }

    /// Closes a group; samples that `correct` was not shown are passed over first.
    pub(crate) fn update(&mut self, axis: Axis, sums: &GroupSums) -> (GroupOutcome, Taps) {
        let state = &mut self.axes[axis.index()];
        let seen = core::mem::take(&mut self.seen[axis.index()]);
        state.skip_samples(sums.n.saturating_sub(seen));
        let outcome = state.close_group(Some(&self.laws[axis.index()]), sums);
        (outcome, outcome.move_to.unwrap_or(state.tap()))
    }

    pub(crate) fn wiper_written(&mut self, axis: Axis, tap: Taps) {
        self.axes[axis.index()].wiper_written(Some(&self.laws[axis.index()]), tap);
    }

    pub(crate) fn groups_lost(&mut self, axis: Axis, groups: u32, n: u32) {
        let state = &mut self.axes[axis.index()];
        state.skip_lost(groups.saturating_mul(n));
        state.lose_groups(groups);
    }
}
