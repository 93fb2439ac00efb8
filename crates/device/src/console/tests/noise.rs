//! A console on a line that damages, cuts and joins what is said.

use super::*;

/// A small generator, so that a run of a seed is the same everywhere (Numerical Recipes' 64-bit LCG, its upper bits).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        u32::try_from(self.0 >> 32).unwrap()
    }

    fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n
    }

    fn byte(&mut self) -> u8 {
        self.next().to_be_bytes()[0]
    }
}

/// A store that must not be written.
struct Sealed;

impl RecordStore for Sealed {
    fn stored(&self) -> Stored {
        Stored::Blank
    }

    fn read(&mut self, _: usize, _: &mut [u8]) -> Result<usize, StoreFailed> {
        Ok(0)
    }

    fn commit(&mut self, _: &[u8]) -> Result<(), StoreFailed> {
        panic!("a commit that nobody sent")
    }
}

/// Frames of everything that would do harm, without their zeros.
fn harmful(encoded: &[u8]) -> Vec<Vec<u8>> {
    let requests = [
        Request::SetTap { axis: Axis::X, tap: zerorate_core::units::Taps::LAST },
        Request::SetMode { axis: Axis::Y, mode: Mode::Hybrid },
        Request::StorePowerUpTap,
        Request::RecallPowerUpTap,
        Request::SetAcquisition { run: false },
        Request::CommitCalibration { length: 700 },
        Request::WriteCalibration { offset: 256, bytes: encoded[..CHUNK].iter().copied().collect() },
    ];
    requests
        .into_iter()
        .enumerate()
        .map(|(k, request)| {
            let command = Command { sequence: u16::try_from(k).unwrap(), at: None, request };
            let mut frame = frame::encode(&command).unwrap().to_vec();
            frame.pop();
            frame
        })
        .collect()
}

/// A frame that nobody sent, made of those that somebody could.
fn damaged(dice: &mut Dice, whole: &[Vec<u8>]) -> Vec<u8> {
    let mut frame = whole[dice.below(whole.len())].clone();
    let good = frame.clone();
    match dice.below(5) {
        // Random bytes.
        0 => frame = (0..dice.below(80)).map(|_| dice.byte()).collect(),
        // Some bytes changed.
        1 => {
            for _ in 0..=dice.below(4) {
                let at = dice.below(frame.len());
                frame[at] = dice.byte();
            }
        }
        // One bit turned.
        2 => {
            let at = dice.below(frame.len());
            frame[at] ^= 1 << dice.below(8);
        }
        // Cut, at either end.
        3 => {
            let at = 1 + dice.below(frame.len() - 1);
            frame = if dice.below(2) == 0 { frame[..at].to_vec() } else { frame[at..].to_vec() };
        }
        // The beginning of one joined to the end of another, or both whole without the zero between them.
        _ => {
            let other = &whole[dice.below(whole.len())];
            let (here, there) = (dice.below(frame.len() + 1), dice.below(other.len() + 1));
            frame.truncate(here);
            frame.extend_from_slice(&other[there..]);
        }
    }
    // What came out whole after all was sent by somebody.
    let is_whole = frame == good || frame.split(|&byte| byte == 0).any(|part| whole.iter().any(|whole| whole == part));
    if is_whole { Vec::new() } else { frame }
}

#[test]
fn of_a_million_damaged_frames_none_is_obeyed() {
    let mut dice = Dice(20_251_121);
    let whole = harmful(&encoded("ZR-7"));
    let mut console = console(Sealed);
    let mut frames = 0_u32;
    while frames < 1_000_000 {
        let frame = damaged(&mut dice, &whole);
        frames += u32::from(!frame.is_empty());
        for &byte in frame.iter().chain(&[0]) {
            assert!(console.hear(byte).is_none(), "frame {frames}: {frame:?}");
        }
    }
    assert_eq!(console.uploads, 0, "no answer either: nobody asked");
    let Some(Answer::Faults(faults)) = ask(&mut console, Request::Faults) else { panic!("it still listens") };
    assert!(faults.damaged_frames >= 990_000, "{faults:?}");
    assert_eq!(faults.unknown_frames, 0, "no CRC-32 matched by chance");
}

/// A host that sends again what is not answered, on a line that damages one byte in a thousand each way.
struct Line {
    dice: Dice,
    console: Console<MemoryStore>,
    receiver: Receiver,
    damaged: u32,
}

impl Line {
    fn damage(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            if self.dice.below(1000) == 0 {
                *byte = self.dice.byte();
                self.damaged += 1;
            }
        }
    }

    /// The answer to a command, if one comes within eight tries.
    fn ask(&mut self, sequence: u16, request: Request) -> Option<Answer> {
        let frame = frame::encode(&Command { sequence, at: None, request }).unwrap();
        for _ in 0..8 {
            let mut bytes = Vec::from([0]);
            bytes.extend_from_slice(&frame);
            self.damage(&mut bytes);
            let mut sent: Vec<u8> = Vec::new();
            for byte in bytes {
                let mut line = |bytes: &[u8]| {
                    sent.extend_from_slice(bytes);
                    true
                };
                assert!(hear(&mut self.console, byte, &mut line).is_none(), "nobody sent any");
                let _ = self.console.take_laws(Laws::clone);
            }
            self.damage(&mut sent);
            for byte in sent {
                if let Some(Ok(Upload { message: Message::Answer { to, answer, .. }, .. })) = self.receiver.push(byte)
                    && to == sequence
                {
                    return Some(answer);
                }
            }
        }
        None
    }

    /// Whether the record was written, committed and read back the same; `None` where an answer failed to come.
    fn deploy(&mut self, bytes: &[u8]) -> Option<bool> {
        let mut sequence = 100;
        let mut ask = |line: &mut Self, request| {
            sequence += 1;
            line.ask(sequence, request)
        };
        for (part, chunk) in bytes.chunks(CHUNK).enumerate() {
            let offset = u16::try_from(part * CHUNK).unwrap();
            let request = Request::WriteCalibration { offset, bytes: chunk.iter().copied().collect() };
            if ask(self, request)? != Answer::Done {
                return Some(false);
            }
        }
        if ask(self, Request::CommitCalibration { length: u16::try_from(bytes.len()).unwrap() })? != Answer::Done {
            return Some(false);
        }
        let mut read = Vec::new();
        while read.len() < bytes.len() {
            let offset = u16::try_from(read.len()).unwrap();
            let Answer::Calibration { bytes, .. } = ask(self, Request::ReadCalibration { offset })? else {
                return Some(false);
            };
            read.extend_from_slice(&bytes);
        }
        Some(read == bytes)
    }
}

#[test]
fn a_deploy_over_a_line_that_damages_a_byte_in_a_thousand_never_commits_a_wrong_record() {
    let (old, new) = (encoded("ZR-7"), {
        let mut record = record("ZR-7");
        record.axes[0].start_up_mode = Mode::Digital;
        let mut buffer = [0; MAX_RECORD_BYTES];
        Vec::from(record.encode(&mut buffer).unwrap())
    });
    assert_ne!(old, new);
    let (mut whole, mut damaged) = (0, 0);
    for seed in 0..2000 {
        let mut store = MemoryStore::default();
        store.commit(&old).unwrap();
        let mut line = Line { dice: Dice(seed), console: console(store), receiver: Receiver::new(), damaged: 0 };
        let _ = line.console.take_laws(Laws::clone);
        let done = line.deploy(&new);
        let kept = stored(&mut line.console);
        assert!(kept == old || kept == new, "seed {seed}: neither");
        if done == Some(true) {
            assert_eq!(kept, new, "seed {seed}: said to be done");
            whole += 1;
        }
        damaged += line.damaged;
    }
    assert!(damaged > 2000, "{damaged} bytes");
    assert!(whole >= 1990, "{whole} of 2000 came through by sending again");
}
