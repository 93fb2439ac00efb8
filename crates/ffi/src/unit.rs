//! A calibrated unit in storage that C gives: laws and state of both axes.

use core::mem::MaybeUninit;

use zerorate_core::compensate::{AxisCompensation, AxisLaw, GroupOutcome, Mode};
use zerorate_core::group::GroupSums;
use zerorate_core::record::{Laws, RecordRefused, laws_for};
use zerorate_core::units::Taps;

/// 64-bit words of a unit's storage: more than its laws and state take on any target.
pub const ZERORATE_UNIT_WORDS: usize = 768;

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

/// Both axes, X then Y.
pub(crate) struct Unit(pub(crate) [CalibratedAxis; 2]);

/// Law and state of an axis.
pub(crate) struct CalibratedAxis {
    law: AxisLaw,
    state: AxisCompensation,
    codes_per_count: u16,
    /// Samples of the group being filled that `correct` has seen.
    seen: u32,
}

impl Unit {
    /// A unit at start-up, both wipers at the middle tap, in the modes that the record gives for start-up. A `serial`
    /// that is not the record's refuses it.
    pub(crate) fn from_record(bytes: &[u8], serial: Option<&[u8]>) -> Result<Self, RecordRefused> {
        let Laws { axes: [x, y], start_up_modes: modes, board } = laws_for(serial, bytes)?;
        let axis = |law: AxisLaw, mode| {
            let mut state = AxisCompensation::new(Some(&law), Taps::MIDDLE);
            state.set_mode(mode);
            CalibratedAxis { law, state, codes_per_count: board.codes_per_count, seen: 0 }
        };
        Ok(Self([axis(x, modes[0]), axis(y, modes[1])]))
    }
}

impl CalibratedAxis {
    /// `false` when the mode moves the wiper and the calibration cannot.
    pub(crate) fn set_mode(&mut self, mode: Mode) -> bool {
        let possible = !mode.moves_wiper() || self.law.moves_wiper();
        if possible {
            self.state.set_mode(mode);
        }
        possible
    }

    pub(crate) fn correct(&mut self, zro: u16) -> i32 {
        self.seen += 1;
        self.state.sample(zro).0
    }

    /// Closes a group; samples that `correct` was not shown are passed over first.
    pub(crate) fn update(&mut self, sums: &GroupSums) -> (GroupOutcome, Taps) {
        self.state.skip_samples(sums.n.saturating_sub(core::mem::take(&mut self.seen)));
        let code = sums.temperature_code(self.codes_per_count);
        let outcome = self.state.close_group_at(Some(&self.law), sums, code);
        (outcome, outcome.move_to.unwrap_or(self.state.tap()))
    }

    pub(crate) fn wiper_written(&mut self, tap: Taps) {
        self.state.wiper_written(Some(&self.law), tap);
    }

    pub(crate) fn groups_lost(&mut self, groups: u32, n: u32) {
        self.state.skip_lost(groups.saturating_mul(n));
        self.state.lose_groups(groups);
    }
}
