//! A master that reads when and how it likes: nothing torn, nothing silent.

#![allow(clippy::unwrap_used)] // All of it is a test.

use zerorate_gateware::{Bench, Head, Port, Random, Scale, Timing, head, scans};

const SCAN_PERIOD: u8 = 0x03;
const STATUS: u8 = 0x05;
const SET: u8 = 0x10;

/// Keeps count for a block that runs with one set length.
struct Watch {
    port: Port,
    length: usize,
    /// Sets that the master has had whole, so that they were released.
    released: u32,
    last: Option<Head>,
}

impl Watch {
    fn new(seed: u64, period_us: u32, length: usize, timing: Timing) -> Self {
        let mut samples = Random::new(seed);
        let bench = Bench::new(Scale::Fast, u32::try_from(seed).unwrap(), move |_| samples.counts());
        let mut port = Port::new(bench, timing, seed);
        port.start(period_us, u32::try_from(length).unwrap());
        Self { port, length, released: 0, last: None }
    }

    /// The scans of a set as the A/D delivered them.
    fn taken(&self, number: u32) -> Vec<[u16; 4]> {
        let first = number as usize * self.length;
        self.port.bench.scans()[first..first + self.length].iter().map(|scan| scan.samples).collect()
    }

    /// Reads a burst of so many words and so many bits of the next, and holds it against what was taken.
    fn read(&mut self, words: usize, bits: u32) {
        let port = &mut self.port;
        port.select();
        port.byte(SET);
        port.byte(0);
        let burst: Vec<u32> = (0..words).map(|_| port.word()).collect();
        (0..bits / 8).for_each(|_| _ = port.byte(0));
        port.bits(0, bits % 8);
        port.deselect();

        if burst.iter().all(|&word| word == 0) {
            // No set waited, or the words read are nought in the first set too: its number.
            return;
        }
        let number = burst[0];
        let taken = self.taken(number);
        let lost = burst.get(2).copied();
        let lost_before = burst.get(1).map(|word| word & 1 == 1);
        // Every word that came is the right one, whether or not the master read far enough to see a CRC.
        if let (Some(lost), Some(lost_before)) = (lost, lost_before) {
            let right = Head::of(number, lost_before, lost, &taken);
            assert_eq!(burst[1], right.length << 16 | u32::from(lost_before));
            for (word, channel) in burst.iter().skip(3).take(4).zip(0..) {
                assert_eq!(u64::from(*word), right.sums[channel], "set {number}");
            }
            for (pair, channel) in burst.get(7..15).unwrap_or_default().chunks(2).zip(0..) {
                assert_eq!(u64::from(pair[0]) << 32 | u64::from(pair[1]), right.squares[channel], "set {number}");
            }
            for (word, index) in burst.iter().skip(16).take(2 * self.length).zip(0..) {
                let scan = taken[index / 2];
                let [high, low] = if index % 2 == 0 { [scan[0], scan[1]] } else { [scan[2], scan[3]] };
                assert_eq!(*word, u32::from(high) << 16 | u32::from(low), "set {number}");
            }
        }
        if words >= 16 {
            let found = head(&burst).expect("the head's CRC matches");
            if burst.len() > 16 + 2 * self.length {
                assert_eq!(scans(&burst, self.length), Some(taken), "the samples' CRC matches");
            }
            self.note_release(found);
        }
    }

    fn note_release(&mut self, found: Head) {
        // A gap in the numbers is a loss, which the set after it tells.
        let expected = self.last.map_or(0, |last| last.number + 1);
        assert!(found.number >= expected, "no set twice after its release");
        assert_eq!(found.lost_before, found.number != expected, "set {}", found.number);
        // The count at the burst's beginning holds all that were lost before this set, and those lost while an earlier
        // burst of it was cut short.
        assert!(found.lost >= found.number - self.released);
        self.released += 1;
        self.last = Some(found);
    }

    /// Every set that was full was read, or waits, or is in the count, which this returns.
    fn settle_accounts(&mut self) -> u32 {
        // From the next set on there is a scan every 100 ms: time to look while nothing moves.
        self.port.write(SCAN_PERIOD, 100_000);
        self.port.bench.pass(self.port.bench.period_ps(100 * (self.length as u64 + 1)));
        let scans = self.port.bench.scans().len();
        assert_eq!(scans % self.length, 0);
        let full = u32::try_from(scans / self.length).unwrap();
        let status = self.port.read(STATUS, 1)[0];
        let (lost, ready) = (status >> 16, status & 1);
        assert_eq!(full, self.released + lost + ready);
        assert_eq!(ready == 1, self.port.bench.data_ready());
        lost
    }
}

/// What a master may do next: words and bits of a burst, by lot.
fn readout(random: &mut Random, length: usize) -> (usize, u32) {
    let whole = 16 + 2 * length + 1;
    let whole_u64 = u64::try_from(whole).unwrap();
    let words = match random.between(0, 5) {
        0 | 1 => 16,
        2 | 3 => whole,
        4 => usize::try_from(random.between(0, whole_u64)).unwrap(),
        _ => whole + usize::try_from(random.between(0, 3)).unwrap(),
    };
    let bits = if random.one_in(3) { u32::try_from(random.between(0, 31)).unwrap() } else { 0 };
    (words, bits)
}

/// Random readouts at random moments; how many sets were released and lost.
fn readouts(seed: u64, count: usize, timing: Timing) -> (u32, u32) {
    let mut random = Random::new(seed);
    let length = usize::try_from(random.between(1, 6)).unwrap();
    let mut watch = Watch::new(seed, 100, length, timing);
    for _ in 0..count {
        match random.between(0, 3) {
            // In step with data ready, at once after it,
            0 => assert!(watch.port.wait_for_data_ready(5000)),
            // or whenever.
            1 | 2 => {
                let pause_us = random.between(0, 150 * u64::try_from(length).unwrap());
                watch.port.bench.pass(watch.port.bench.period_ps(pause_us));
            }
            _ => {}
        }
        let (words, bits) = readout(&mut random, length);
        watch.read(words, bits);
    }
    let lost = watch.settle_accounts();
    assert_eq!(watch.port.bench.converter_faults(), [""; 0]);
    (watch.released, lost)
}

#[test]
fn no_set_is_torn_in_10_000_random_readouts_and_the_lost_ones_are_counted_exactly() {
    let (mut released, mut lost) = (0, 0);
    for seed in 0..100 {
        let timing = [Timing::FASTEST, Timing::QUICK, Timing::UNEVEN][usize::try_from(seed % 3).unwrap()];
        let (of_these, lost_here) = readouts(seed, 100, timing);
        released += of_these;
        lost += lost_here;
    }
    // Enough of both for the test to mean something.
    assert!(released > 2000 && lost > 2000, "{released} released, {lost} lost");
}

#[test]
fn a_set_that_nobody_reads_is_lost_to_the_newer_one() {
    for unread in 0..20_u32 {
        let mut watch = Watch::new(u64::from(unread), 1000, 1, Timing::FASTEST);
        watch.port.bench.pass(watch.port.bench.period_ps(1000 * (u64::from(unread) + 1) + 95));
        let status = watch.port.read(STATUS, 1)[0];
        assert_eq!(status, unread << 16 | u32::from(unread > 0) << 1 | 1);
        let found = head(&watch.port.read(SET, 16)).unwrap();
        assert_eq!(found, Head::of(unread, unread > 0, unread, &watch.taken(unread)));
        assert_eq!(watch.port.read(STATUS, 1)[0] & 0xFFFF_0002, unread << 16, "released: no overrun since");
    }
}

#[test]
fn a_set_that_fills_while_the_other_is_read_is_lost_and_the_one_that_is_read_stays() {
    let mut watch = Watch::new(77, 100, 3, Timing::FASTEST);
    assert!(watch.port.wait_for_data_ready(1000));
    let port = &mut watch.port;
    port.select();
    port.byte(SET);
    port.byte(0);
    let mut burst: Vec<u32> = (0..10).map(|_| port.word()).collect();
    // Four sets' time in the middle of word 10.
    port.bits(0, 3);
    port.bench.pass(port.bench.period_ps(1200));
    port.deselect();
    burst.clear();
    assert_eq!(port.read(STATUS, 1)[0] >> 16, 4);
    burst.extend(port.read(SET, 16 + 6 + 1));
    // Numbers 1 to 4 were lost while 0 was read; what waits since the burst was cut short may be 0 or a later one.
    let found = head(&burst).unwrap();
    let taken = watch.taken(found.number);
    assert_eq!(scans(&burst, 3), Some(taken.clone()));
    assert_eq!(found, Head::of(found.number, found.number != 0, found.lost, &taken));
    assert!(found.number == 0 && found.lost == 4 || found.number == 5 && found.lost == 5);
}

#[test]
fn more_than_65_535_lost_sets_show_whole_in_the_burst() {
    let mut watch = Watch::new(5, 100, 1, Timing::FASTEST);
    watch.port.bench.pass(watch.port.bench.period_ps(100 * 66_000 + 95));
    let status = watch.port.read(STATUS, 1)[0];
    assert_eq!(status, (66_000 - 1 - 65_536) << 16 | 3);
    let found = head(&watch.port.read(SET, 16)).unwrap();
    assert_eq!(found, Head::of(65_999, true, 65_999, &watch.taken(65_999)));
}
