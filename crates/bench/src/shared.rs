//! One chamber, and one supply, for several boards at once.
//!
//! Each board's run orders them as if it were alone with them. The chamber goes nowhere before every board that is left waits
//! for it; then it goes where that one wants it which has waited longest, and all that want it there go on. The supply is a
//! board's from its first voltage until the gyros are back. Who waits is told as of an instrument that is away: the run asks
//! again after each group, and records what comes meanwhile. A run that ends leaves both to the others; after the last they
//! are brought to rest.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use zerorate_core::units::{Axis, Celsius, Volts};

use crate::instruments::{Chamber, InstrumentError, OnceMore, REST_WATCHED, Supply};

/// A chamber's air is asked for once in this time, whoever wants to know.
const ASKED_EVERY: Duration = Duration::from_millis(50);

/// What a board's run does in a chamber.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Seat {
    /// It works at the temperature to which the chamber was last sent.
    AtWork,
    /// It wants the chamber somewhere, since so many wishes.
    Waits { to: Celsius, since: u64 },
    /// The chamber was sent there for it, and it does not know yet.
    Sent(Celsius),
    /// It has ended.
    Left,
}

struct Room {
    chamber: Box<dyn Chamber + Send>,
    seats: Vec<Seat>,
    wishes: u64,
    air: Option<(Celsius, Instant)>,
    /// For each board, what it has not been told yet.
    notes: Vec<Vec<String>>,
    astray: Vec<bool>,
}

impl Room {
    /// Sends the chamber where the longest wish wants it, if nobody works in it.
    fn go(&mut self) -> Result<(), InstrumentError> {
        if self.seats.iter().any(|seat| matches!(seat, Seat::AtWork | Seat::Sent(_))) {
            return Ok(());
        }
        let wish = |seat: &Seat| match *seat {
            Seat::Waits { to, since } => Some((since, to)),
            _ => None,
        };
        let Some((_, next)) = self.seats.iter().filter_map(wish).min_by_key(|(since, _)| *since) else {
            return Ok(());
        };
        self.chamber.set(next)?;
        self.air = None;
        for seat in &mut self.seats {
            if matches!(*seat, Seat::Waits { to, .. } if to == next) {
                *seat = Seat::Sent(next);
            }
        }
        Ok(())
    }

    fn set(&mut self, board: usize, to: Celsius) -> Result<(), InstrumentError> {
        if !matches!(self.seats[board], Seat::Waits { to: own, .. } | Seat::Sent(own) if own == to) {
            self.wishes += 1;
            self.seats[board] = Seat::Waits { to, since: self.wishes };
        }
        self.go()?;
        if self.seats[board] == Seat::Sent(to) {
            self.seats[board] = Seat::AtWork;
            return Ok(());
        }
        Err(InstrumentError::InUse("chamber"))
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        if let Some((air, asked)) = self.air
            && asked.elapsed() < ASKED_EVERY
        {
            return Ok(air);
        }
        let air = self.chamber.air()?;
        self.air = Some((air, Instant::now()));
        Ok(air)
    }

    fn leave(&mut self, board: usize, once_more: OnceMore) -> Result<(), InstrumentError> {
        self.seats[board] = Seat::Left;
        if self.seats.iter().all(|seat| *seat == Seat::Left) { self.chamber.rest(once_more) } else { Ok(()) }
    }
}

/// A board's part of a chamber that it shares.
pub struct SharedChamber {
    room: Arc<Mutex<Room>>,
    board: usize,
}

/// A chamber for so many boards. It waits for all of them, from the beginning on.
#[must_use]
pub fn chamber(chamber: Box<dyn Chamber + Send>, boards: usize) -> Vec<SharedChamber> {
    let notes = vec![Vec::new(); boards];
    let astray = vec![false; boards];
    let room = Room { chamber, seats: vec![Seat::AtWork; boards], wishes: 0, air: None, notes, astray };
    let room = Arc::new(Mutex::new(room));
    (0..boards).map(|board| SharedChamber { room: Arc::clone(&room), board }).collect()
}

impl Chamber for SharedChamber {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        lock(&self.room).set(self.board, set_point)
    }

    fn set_point(&self) -> Celsius {
        lock(&self.room).chamber.set_point()
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        lock(&self.room).air()
    }

    fn is_seen(&self) -> bool {
        lock(&self.room).chamber.is_seen()
    }

    fn take_astray(&mut self) -> Result<bool, InstrumentError> {
        let mut room = lock(&self.room);
        if room.chamber.take_astray()? {
            room.astray.fill(true);
        }
        Ok(std::mem::take(&mut room.astray[self.board]))
    }

    fn take_notes(&mut self) -> Vec<String> {
        let mut room = lock(&self.room);
        let new = room.chamber.take_notes();
        room.notes.iter_mut().for_each(|notes| notes.extend(new.iter().cloned()));
        std::mem::take(&mut room.notes[self.board])
    }

    fn rest(&mut self, once_more: OnceMore) -> Result<(), InstrumentError> {
        lock(&self.room).leave(self.board, once_more)
    }
}

impl Drop for SharedChamber {
    fn drop(&mut self) {
        // Whoever ends in order has seen the error of `rest`.
        let _ = self.rest(&|_| false);
    }
}

struct Turns {
    supply: Box<dyn Supply + Send>,
    /// Whose it is.
    of: Option<usize>,
}

impl Turns {
    fn take(&mut self, board: usize) -> Result<&mut (dyn Supply + Send), InstrumentError> {
        if *self.of.get_or_insert(board) == board {
            Ok(&mut *self.supply)
        } else {
            Err(InstrumentError::InUse("supply"))
        }
    }
}

/// A board's turn at a supply that it shares.
pub struct SharedSupply {
    turns: Arc<Mutex<Turns>>,
    board: usize,
}

/// A supply for so many boards, one after the other.
#[must_use]
pub fn supply(supply: Box<dyn Supply + Send>, boards: usize) -> Vec<SharedSupply> {
    let turns = Arc::new(Mutex::new(Turns { supply, of: None }));
    (0..boards).map(|board| SharedSupply { turns: Arc::clone(&turns), board }).collect()
}

impl Supply for SharedSupply {
    fn feed(&mut self, volts: Volts) -> Result<(), InstrumentError> {
        lock(&self.turns).take(self.board)?.feed(volts)
    }

    fn connect_gyros(&mut self) -> Result<(), InstrumentError> {
        let mut turns = lock(&self.turns);
        if turns.of.is_none_or(|of| of == self.board) {
            turns.supply.connect_gyros()?;
            turns.of = None;
        }
        Ok(())
    }

    fn hold(&mut self) -> Result<(), InstrumentError> {
        lock(&self.turns).take(self.board)?.hold()
    }

    fn gyro_output(&mut self, axis: Axis) -> Result<Volts, InstrumentError> {
        lock(&self.turns).take(self.board)?.gyro_output(axis)
    }

    fn take_notes(&mut self) -> Vec<String> {
        let mut turns = lock(&self.turns);
        if turns.of == Some(self.board) { turns.supply.take_notes() } else { Vec::new() }
    }

    fn rest(&mut self, once_more: OnceMore) -> Result<(), InstrumentError> {
        let mut turns = lock(&self.turns);
        if turns.of == Some(self.board) {
            // The others wait meanwhile, and their groups: not as long as an own one is told.
            turns.supply.rest(&|waited| waited < REST_WATCHED && once_more(waited))?;
            turns.of = None;
        }
        Ok(())
    }
}

impl Drop for SharedSupply {
    fn drop(&mut self) {
        // As the chamber's. One that cannot be switched off now is the others' to use, and is tried again when it is let go of.
        if self.rest(&|_| false).is_err() {
            lock(&self.turns).of = None;
        }
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    // A run that has panicked has left what it held as it was.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{self, Receiver, Sender};

    use super::*;

    /// Writes down what it is told.
    struct Told(Sender<String>);

    impl Told {
        fn hears(&self, what: String) -> Result<(), InstrumentError> {
            let _ = self.0.send(what);
            Ok(())
        }
    }

    impl Chamber for Told {
        fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
            self.hears(format!("to {}", set_point.0))
        }
        fn set_point(&self) -> Celsius {
            Celsius(25.0)
        }
        fn air(&mut self) -> Result<Celsius, InstrumentError> {
            Ok(Celsius(25.0))
        }
        fn rest(&mut self, _: OnceMore) -> Result<(), InstrumentError> {
            self.hears("rest".into())
        }
    }

    impl Supply for Told {
        fn feed(&mut self, volts: Volts) -> Result<(), InstrumentError> {
            self.hears(format!("feeds {}", volts.0))
        }
        fn connect_gyros(&mut self) -> Result<(), InstrumentError> {
            self.hears("gyros".into())
        }
        fn gyro_output(&mut self, _: Axis) -> Result<Volts, InstrumentError> {
            Ok(Volts(2.5))
        }
        fn rest(&mut self, _: OnceMore) -> Result<(), InstrumentError> {
            self.hears("off".into())
        }
    }

    fn heard(told: &Receiver<String>) -> Vec<String> {
        told.try_iter().collect()
    }

    fn waits(done: &Result<(), InstrumentError>) -> bool {
        done.as_ref().is_err_and(InstrumentError::may_pass)
    }

    #[test]
    fn a_chamber_goes_when_all_wait_and_first_where_it_was_wanted_first() {
        let (tell, told) = mpsc::channel();
        let mut boards = chamber(Box::new(Told(tell)), 3);
        let [cold, hot] = [Celsius(-40.0), Celsius(60.0)];
        assert!(waits(&boards[0].set(cold)) && waits(&boards[1].set(hot)) && waits(&boards[0].set(cold)));
        assert!(heard(&told).is_empty());
        // With the last one's wish it goes to the cold; the first knows when it asks again, and who wants it hot waits.
        assert!(boards[2].set(cold).is_ok());
        assert_eq!(heard(&told), ["to -40"]);
        assert!(waits(&boards[1].set(hot)) && boards[0].set(cold).is_ok() && waits(&boards[0].set(hot)));
        assert!(heard(&told).is_empty());
        // One that dies is not waited for.
        drop(boards.remove(2));
        assert!(boards[1].set(hot).is_ok() && boards[0].set(hot).is_ok());
        assert_eq!(heard(&told), ["to 60"]);
        boards[0].rest(&|_| false).unwrap();
        drop(boards.remove(0));
        assert!(heard(&told).is_empty());
        boards[0].rest(&|_| false).unwrap();
        assert_eq!(heard(&told), ["rest"]);
    }

    #[test]
    fn a_supply_is_one_boards_until_its_gyros_are_back() {
        let (tell, told) = mpsc::channel();
        let mut boards = supply(Box::new(Told(tell)), 2);
        assert!(boards[0].gyro_output(Axis::X).is_ok());
        assert!(
            boards[1].gyro_output(Axis::X).is_err_and(|error| error.may_pass()) && waits(&boards[1].feed(Volts(1.0)))
        );
        boards[0].feed(Volts(2.5)).unwrap();
        boards[1].connect_gyros().unwrap();
        boards[0].connect_gyros().unwrap();
        boards[1].feed(Volts(2.0)).unwrap();
        drop(boards);
        assert_eq!(heard(&told), ["feeds 2.5", "gyros", "feeds 2", "off"]);
    }
}
