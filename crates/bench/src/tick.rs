//! A board's tick on a plant's time: once a second.

use zerorate_core::units::Seconds;

const PERIOD: Seconds = Seconds(1.0);
/// A plant's time is in whole nanoseconds, and waiting for less lets none pass.
const NOTHING: Seconds = Seconds(1e-9);

/// When the next tick is due.
pub(crate) struct Tick {
    next: Seconds,
    group_period: Seconds,
}

impl Tick {
    /// A tick that is due a period from now, on a board that is looked at once a group.
    pub(crate) fn after(now: Seconds, group_period: Seconds) -> Self {
        Self { next: now + PERIOD, group_period }
    }

    /// When the next is due.
    pub(crate) const fn next(&self) -> Seconds {
        self.next
    }

    /// Whether one is due; each is due once. A processor that was late for longer than a group finds one, however many there
    /// were: an interrupt waits or does not.
    pub(crate) fn is_due(&mut self, now: Seconds) -> bool {
        let late = (now - self.next).0;
        if late > self.group_period.0 {
            self.next = now;
        }
        let is_due = late > -NOTHING.0;
        if is_due {
            self.next = self.next + PERIOD;
        }
        is_due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_due_each_second_and_a_late_processor_finds_one() {
        let mut tick = Tick::after(Seconds(0.5), Seconds(1.5));
        let mut due = |now| std::iter::from_fn(|| tick.is_due(Seconds(now)).then_some(())).count();
        assert_eq!([0.5, 1.4, 1.5, 1.6, 3.0, 4.5].map(&mut due), [0, 0, 1, 0, 1, 2]);
        assert_eq!([12.0, 12.9, 13.0].map(&mut due), [1, 0, 1]);
        assert_eq!([14.0 - 2e-9, 14.0 - 0.5e-9, 14.0].map(due), [0, 1, 0]);
    }
}
