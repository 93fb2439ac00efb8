use std::collections::VecDeque;
use std::rc::Rc;
use std::vec::Vec;

use embedded_hal::spi::{Operation, SpiDevice};

use super::*;
use crate::message::SERIAL_BYTES;

/// A host with prepared answers, which keeps what it was asked.
#[derive(Clone, Default)]
struct Host {
    asked: Rc<RefCell<Vec<u8>>>,
    answers: Rc<RefCell<VecDeque<u8>>>,
}

impl Line for Host {
    type Error = ();

    fn write(&mut self, bytes: &[u8]) -> Result<(), ()> {
        self.asked.borrow_mut().extend_from_slice(bytes);
        Ok(())
    }

    fn read(&mut self, bytes: &mut [u8]) -> Result<(), ()> {
        for byte in bytes {
            *byte = self.answers.borrow_mut().pop_front().ok_or(())?;
        }
        Ok(())
    }
}

fn board(answers: &[u8]) -> (Host, Channel<Host>) {
    let host = Host::default();
    host.answers.borrow_mut().extend(answers);
    (host.clone(), Channel::new(host))
}

impl Host {
    /// Looks at the only request, checked to be whole.
    fn request(&self, look: impl FnOnce(Request<'_>)) {
        let asked = self.asked.borrow();
        let (head, body) = asked.split_first_chunk::<2>().unwrap();
        assert_eq!(usize::from(u16::from_le_bytes(*head)), body.len());
        look(Request::decode(body).unwrap());
        assert!(self.answers.borrow().is_empty(), "the whole answer was read");
    }
}

#[test]
fn a_burst_is_one_request_and_its_answer_fills_every_read() {
    let (host, channel) = board(&[0, 1, 2, 3, 4, 5]);
    let (mut first, mut second) = ([0; 2], [0; 3]);
    let header = [0x10, 0];
    let mut burst = [Operation::Write(&header), Operation::Read(&mut first), Operation::Read(&mut second)];
    LockstepSpi::new(&channel, Bus::Port).transaction(&mut burst).unwrap();
    assert_eq!((first, second), ([1, 2], [3, 4, 5]));
    host.request(|request| {
        let transfers = [Transfer::Write(&[0x10, 0]), Transfer::Read(2), Transfer::Read(3)];
        let transfers = transfers.into_iter().collect();
        assert_eq!(request, Request::Transaction { bus: Bus::Port, transfers });
    });
}

#[test]
fn bytes_exchanged_go_out_and_come_in() {
    let (host, channel) = board(&[0, 7, 8]);
    let mut bytes = [1, 2];
    LockstepSpi::new(&channel, Bus::Potentiometer).transfer_in_place(&mut bytes).unwrap();
    assert_eq!(bytes, [7, 8]);
    host.request(|request| {
        let transfers = [Transfer::Exchange(&[1, 2])].into_iter().collect();
        assert_eq!(request, Request::Transaction { bus: Bus::Potentiometer, transfers });
    });
}

#[test]
fn a_bus_that_fails_and_a_host_that_is_gone_are_errors() {
    let (_, channel) = board(&[Answer::Failed as u8]);
    assert_eq!(LockstepSpi::new(&channel, Bus::Potentiometer).write(&[1]), Err(BusFailed));
    let (_, channel) = board(&[0, 1]);
    assert_eq!(LockstepSpi::new(&channel, Bus::Port).read(&mut [0; 4]), Err(BusFailed));
    let (_, channel) = board(&[99]);
    assert_eq!(channel.poll(Poll::default()), Err(BusFailed));
}

#[test]
fn a_host_of_another_version_is_not_taken_for_ours() {
    let serial = [0; SERIAL_BYTES];
    let mut says = Board { version: VERSION, set_length: 500, scan_period_us: 3000, oversampling: 16, serial };
    says.serial[..4].copy_from_slice(b"ZR-7");
    let hello = |board: &Board| {
        let mut answer = std::vec![0];
        answer.extend(board.to_bytes());
        let host = Host::default();
        host.answers.borrow_mut().extend(answer);
        Channel::closed().open(host)
    };
    let got = hello(&says).unwrap();
    assert_eq!((got, got.serial()), (says, "ZR-7"));
    assert_eq!(hello(&Board { version: VERSION + 1, ..says }), Err(BusFailed));
}

#[test]
fn flash_is_read_and_written_in_pieces_that_fit_a_request() {
    type Flash<'c> = LockstepFlash<'c, Host, 16_384, 4096>;
    let mut answers = std::vec![0];
    answers.extend([5; 512]);
    answers.push(0);
    answers.extend([6; 88]);
    let (host, channel) = board(&answers);
    let mut bytes = [0; 600];
    Flash::new(&channel).read(4096, &mut bytes).unwrap();
    assert!(bytes[..512].iter().all(|&b| b == 5) && bytes[512..].iter().all(|&b| b == 6));
    assert!(host.answers.borrow().is_empty());
    let (host, channel) = board(&[0, 0]);
    Flash::new(&channel).write(8, &[3; 600]).unwrap();
    let asked = host.asked.borrow();
    let first = 2 + usize::from(u16::from_le_bytes([asked[0], asked[1]]));
    let second = Request::decode(&asked[first + 2..]).unwrap();
    assert_eq!(second, Request::FlashWrite { offset: 520, bytes: &[3; 88] });
}

#[test]
fn a_set_is_ready_a_second_has_gone_by_or_neither() {
    let answers = [Answer::SetReady, Answer::Second, Answer::Done];
    let (host, channel) = board(&answers.map(|answer| answer as u8));
    let say = Poll { received: u32::MAX, sent: u32::MAX };
    assert_eq!(answers.map(|_| channel.poll(say)), answers.map(Ok));
    assert_eq!(host.asked.borrow().len(), 3 * 13);
}
