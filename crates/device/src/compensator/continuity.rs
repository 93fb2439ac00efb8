//! Whether sets come as they should, and the groups' numbers where the acquisition has had to be set up anew.

use zerorate_core::units::GroupNumber;

use crate::acquisition::{Set, Timing};

/// Microseconds from tick to tick.
const TICK_US: u64 = 1_000_000;
/// Group periods without a set after which the acquisition is set up anew.
const MISSED: u64 = 2;

/// What is known of the acquisition.
pub(super) struct Continuity {
    /// A set has come since the last tick.
    came: bool,
    /// Time without a set, by ticks, as far as no lost group stands for it yet.
    quiet_us: u64,
    /// The acquisition has taken its last start.
    reached: bool,
    /// It has never taken one.
    awaited: bool,
    /// The group that its set 0 is, and the sets that were lost before it.
    first: GroupNumber,
    lost: u32,
    /// The number of the last set that came since the acquisition's start.
    last: Option<u32>,
}

impl Continuity {
    /// An acquisition that begins at group 0. One that could not be `reached` is tried again with the next tick.
    pub(super) const fn beginning(reached: bool) -> Self {
        Self { came: false, quiet_us: 0, reached, awaited: !reached, first: GroupNumber(0), lost: 0, last: None }
    }

    /// Whether a set came before.
    pub(super) fn is_known(&self, set: &Set) -> bool {
        self.last == Some(set.number)
    }

    /// A set has come: its group, and the sets lost up to it.
    pub(super) const fn set_came(&mut self, set: &Set) -> (GroupNumber, u32) {
        self.came = true;
        self.last = Some(set.number);
        (GroupNumber(self.first.0.wrapping_add(set.number)), self.lost.wrapping_add(set.lost))
    }

    /// A second has gone by; whether the acquisition is to be set up anew.
    pub(super) fn is_broken(&mut self, timing: Timing) -> bool {
        self.quiet_us = if core::mem::take(&mut self.came) { 0 } else { self.quiet_us + TICK_US };
        !self.reached || self.quiet_us >= MISSED * timing.period_us()
    }

    /// The acquisition is set up anew while a group is filling, with so many sets lost: it counts from 0, the groups go on,
    /// and those of the time without sets are lost.
    pub(super) fn set_up_anew(&mut self, filling: GroupNumber, lost: u32, timing: Timing) {
        let missed = u32::try_from(self.quiet_us / timing.period_us()).unwrap_or(u32::MAX);
        self.quiet_us %= timing.period_us();
        self.last = None;
        self.first = GroupNumber(self.first.max(filling).0.saturating_add(missed));
        self.lost = self.lost.max(lost).saturating_add(missed);
    }

    /// Whether the acquisition has taken its start.
    pub(super) const fn started(&mut self, reached: bool) {
        self.reached = reached;
        self.awaited = self.awaited && !reached;
    }

    /// Whether it has yet to take its first.
    pub(super) const fn is_awaited(&self) -> bool {
        self.awaited
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(number: u32, lost: u32) -> Set {
        Set { number, lost, ..Set::default() }
    }

    #[test]
    fn two_periods_without_a_set_are_a_broken_acquisition_and_groups_shorter_than_a_tick_are_not() {
        let mut paper = Continuity::beginning(true);
        let _ = paper.set_came(&set(0, 0));
        let ticks = [(); 5].map(|()| paper.is_broken(Timing::PAPER));
        assert_eq!(ticks, [false, false, false, true, true], "3 s after the tick that still saw a set");
        let short = Timing { scan_period_us: 100, ..Timing::PAPER };
        let mut quick = Continuity::beginning(true);
        for number in 0..10 {
            let _ = quick.set_came(&set(number, 0));
            assert!(!quick.is_broken(short));
        }
        assert!(quick.is_broken(short));
        assert!(Continuity::beginning(false).is_broken(Timing::PAPER), "not reached: tried with each tick");
    }

    #[test]
    fn the_groups_go_on_where_the_acquisition_begins_again_at_0() {
        let mut continuity = Continuity::beginning(true);
        assert_eq!(continuity.set_came(&set(40, 2)), (GroupNumber(40), 2));
        (0..4).for_each(|_| _ = continuity.is_broken(Timing::PAPER));
        continuity.set_up_anew(GroupNumber(41), 2, Timing::PAPER);
        assert_eq!(
            continuity.set_came(&set(1, 1)),
            (GroupNumber(44), 5),
            "41 and 42 in 3 s; 43, which the port lost; this one"
        );
        // Once more, and no set in between.
        for _ in 0..2 {
            (0..4).for_each(|_| _ = continuity.is_broken(Timing::PAPER));
            continuity.set_up_anew(GroupNumber(45), 5, Timing::PAPER);
        }
        assert_eq!(continuity.set_came(&set(0, 0)), (GroupNumber(45 + 2 + 2), 9));
    }
}
