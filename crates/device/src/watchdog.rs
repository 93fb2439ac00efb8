//! The watchdog: fed only while the device does its work.
//!
//! The watchdog is hardware with a time of its own; this decides when it is fed: by the task that speaks to the host, as
//! long as that task runs, and as long as sets arrive where they should. So a hung task, a hung interrupt and an
//! acquisition that stays dead though it was set up anew each end in a restart, after which the device compensates again by
//! itself. The board's tick has the task go round every second: where the acquisition was stopped and nobody speaks, too.
//!
//! The hardware's time must exceed three group periods and two ticks (6.5 s of the paper's), in which an acquisition that was
//! set up anew has its next set, and the longest commit of a record.

use crate::compensator::Status;

/// A watchdog.
pub trait Watchdog {
    /// Begins its time anew.
    fn feed(&mut self);
}

/// No watchdog.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoWatchdog;

impl Watchdog for NoWatchdog {
    fn feed(&mut self) {}
}

/// Feeds a watchdog while the device does its work.
#[derive(Debug)]
pub struct Supervisor<W> {
    watchdog: W,
    sets: u32,
}

impl<W: Watchdog> Supervisor<W> {
    /// A supervisor of a watchdog that has just been started.
    pub const fn new(watchdog: W) -> Self {
        Self { watchdog, sets: 0 }
    }

    /// Called by the task below the interrupt, each time round. Feeds the watchdog if sets have arrived since it last did,
    /// or none are to arrive.
    pub fn task_ran(&mut self, status: &Status) {
        if !status.running || status.sets != self.sets {
            self.sets = status.sets;
            self.watchdog.feed();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::idle;

    #[derive(Default)]
    struct Fed(u32);

    impl Watchdog for Fed {
        fn feed(&mut self) {
            self.0 += 1;
        }
    }

    #[test]
    fn it_is_fed_while_sets_arrive_or_none_are_to() {
        let mut supervisor = Supervisor::new(Fed::default());
        let mut fed = |running, sets| {
            supervisor.task_ran(&Status { running, sets, ..idle() });
            core::mem::take(&mut supervisor.watchdog.0) == 1
        };
        assert!(fed(false, 0) && fed(false, 0), "the acquisition stands still");
        assert!(!fed(true, 0), "started, and no set yet");
        assert!(fed(true, 1));
        assert!(!fed(true, 1), "no set since");
        assert!(fed(true, 2));
        assert!(fed(false, 2));
    }
}
