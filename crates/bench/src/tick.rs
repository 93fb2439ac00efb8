//! A board's tick on a plant's time: once a second.

use zerorate_core::units::Seconds;

const PERIOD: Seconds = Seconds(1.0);

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
        if late >= 0.0 {
            self.next = self.next + PERIOD;
        }
        late >= 0.0
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
        assert_eq!([12.0, 12.9, 13.0].map(due), [1, 0, 1]);
    }
}
