//! The host's end of a line in real time, against a device that does what a test says. The time is the line's own, so that
//! a promise of seconds is held to on a machine of any speed.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use zerorate_bench::client::{ClientError, DeviceClient};
use zerorate_bench::link::{Link, LinkError};
use zerorate_core::compensate::Mode;
use zerorate_core::drift::Coverage;
use zerorate_core::group::GroupSums;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{
    Answer, AxisReport, CalibrationState, Command, GroupReport, Identity, Message, Request, ResetCause, Upload,
    WIRE_VERSION,
};

/// What a device says to a command: whole frames, or anything.
type Script = Box<dyn FnMut(&Command, &mut Device)>;

struct Device {
    said: Vec<u8>,
    uploads: u32,
    heard: Vec<Command>,
    /// The line's time, which passes while somebody listens.
    now: Instant,
    /// Until when it hangs: it hears nothing, and what it says stays in it.
    hangs_until: Instant,
}

impl Device {
    fn hangs_for(&mut self, seconds: f64) {
        self.hangs_until = self.now + Duration::from_secs_f64(seconds);
    }

    fn is_hanging(&self) -> bool {
        self.now < self.hangs_until
    }

    fn say(&mut self, message: Message) {
        let upload = Upload { sequence: self.uploads, message };
        self.uploads += 1;
        self.said.extend_from_slice(&frame::encode(&upload).unwrap());
    }

    fn answer(&mut self, command: &Command, answer: Answer) {
        self.say(Message::Answer { to: command.sequence, group: GroupNumber(0), answer });
    }

    fn group(&mut self, group: u32) {
        let axis = AxisReport {
            sums: GroupSums::default(),
            tap: Taps::MIDDLE,
            mode: Mode::Off,
            corrected_q16: 0,
            coverage: Coverage::Invalid,
            saturated: false,
            moved_to: None,
            temperature: Default::default(),
            trim_failed: false,
        };
        let axes = [axis.clone(), axis];
        self.say(Message::Group(GroupReport { group: GroupNumber(group), lost: 0, acquisition_errors: 0, axes }));
    }
}

struct Line {
    device: Rc<RefCell<Device>>,
    script: Script,
    receiver: Receiver,
}

impl Link for Line {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut device = self.device.borrow_mut();
        if device.is_hanging() {
            return Ok(());
        }
        for &byte in bytes {
            if let Some(Ok(command)) = self.receiver.push::<Command>(byte) {
                device.heard.push(command.clone());
                (self.script)(&command, &mut device);
            }
        }
        Ok(())
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut device = self.device.borrow_mut();
        device.now += Duration::from_millis(10);
        if !device.is_hanging() {
            into.append(&mut device.said);
        }
        Ok(())
    }

    fn now(&self) -> Instant {
        self.device.borrow().now
    }

    fn in_real_time(&self) -> bool {
        true
    }
}

fn client(script: impl FnMut(&Command, &mut Device) + 'static) -> (DeviceClient, Rc<RefCell<Device>>) {
    let now = Instant::now();
    let device = Device { said: Vec::new(), uploads: 0, heard: Vec::new(), now, hangs_until: now };
    let device = Rc::new(RefCell::new(device));
    let line = Line { device: Rc::clone(&device), script: Box::new(script), receiver: Receiver::new() };
    (DeviceClient::new(Box::new(line)), device)
}

fn identity(wire_version: u16) -> Answer {
    Answer::Identity(board(wire_version))
}

fn board(wire_version: u16) -> Identity {
    Identity {
        wire_version,
        unit: Default::default(),
        firmware: [0, 1, 0],
        samples_per_group: 500,
        sample_period_us: 3000,
        calibration: CalibrationState::Blank,
        group: GroupNumber(0),
        running: false,
        taps: [Taps::MIDDLE; 2],
        modes: [Mode::Off; 2],
        reset: ResetCause::Power,
    }
}

/// A device that answers everything at once.
fn obliging(command: &Command, device: &mut Device) {
    match command.request {
        Request::Identity => device.answer(command, identity(WIRE_VERSION)),
        Request::Faults => device.answer(command, Answer::Faults(Default::default())),
        _ => device.answer(command, Answer::Done),
    }
}

#[test]
fn a_serial_that_a_terminal_would_obey_is_one_that_the_board_cannot_read() {
    let unit: UnitSerial = "ZR\u{1b}[31m-1".try_into().unwrap();
    let (mut client, _) = client(move |command, device| {
        device.answer(command, Answer::Identity(Identity { unit: unit.clone(), ..board(WIRE_VERSION) }));
    });
    assert_eq!(client.identify().unwrap().unit, "ZR?[31m-1");
}

#[test]
fn what_is_not_answered_is_sent_again_with_the_same_number() {
    let mut deaf = 2;
    let (mut client, device) = client(move |command, device| match command.request {
        Request::SetTap { .. } if deaf > 0 => deaf -= 1,
        _ => obliging(command, device),
    });
    client.identify().unwrap();
    client.order(Request::SetTap { axis: Axis::X, tap: Taps::MIDDLE }).unwrap();
    let taps: Vec<u16> = device.borrow().heard.iter().skip(1).map(|command| command.sequence).collect();
    assert_eq!(taps.len(), 3);
    assert!(taps.iter().all(|&sequence| sequence == taps[0]), "{taps:?}");
    assert_eq!(client.counts().sent_again, 2);
}

#[test]
fn a_device_that_answers_nothing_is_dead_within_five_seconds_and_one_that_hears_badly_is_told_apart() {
    let took = |device: &RefCell<Device>, began: Instant| device.borrow().now - began;
    let (mut silent, device) = client(|_, _| {});
    let began = device.borrow().now;
    assert!(matches!(silent.identify(), Err(ClientError::Link(LinkError::Silent))));
    assert!(took(&device, began) < Duration::from_secs(5), "{:?}", took(&device, began));

    // Somebody is there, and it is no device.
    let (mut chatty, device) = client(|_, device| device.said.extend_from_slice(b"login: \0\x07hello\0"));
    let began = device.borrow().now;
    assert!(matches!(chatty.identify(), Err(ClientError::Noise)));
    assert!(took(&device, began) < Duration::from_secs(5), "{:?}", took(&device, began));

    let (mut deaf, _) = client(|command, device| match command.request {
        Request::SetTap { .. } => device.group(0),
        _ => obliging(command, device),
    });
    deaf.identify().unwrap();
    let error = deaf.order(Request::SetTap { axis: Axis::X, tap: Taps::MIDDLE });
    // Once groups come, it is the group's end that is waited for: the tries take longer, and are as many.
    assert!(matches!(error, Err(ClientError::Unanswered { tries: 8, .. })), "{error:?}");
}

#[test]
fn a_device_that_falls_silent_when_it_is_asked_is_dead_and_its_line_is_not_to_blame() {
    let (mut client, device) = client(obliging);
    client.identify().unwrap();
    device.borrow_mut().hangs_for(60.0);
    assert!(matches!(client.faults(), Err(ClientError::Link(LinkError::Silent))));
}

#[test]
fn a_device_that_hangs_for_four_seconds_goes_on_and_one_that_hangs_for_five_is_dead() {
    for (seconds, goes_on) in [(4.0, true), (5.0, false)] {
        let (mut client, device) = client(obliging);
        client.identify().unwrap();
        client.order(Request::SetAcquisition { run: true }).unwrap();
        device.borrow_mut().group(0);
        client.next_group().unwrap();
        device.borrow_mut().hangs_for(seconds);
        device.borrow_mut().group(1);
        match client.next_group() {
            Ok(group) => assert!(goes_on && group.report.group.0 == 1, "{seconds} s"),
            Err(error) => assert!(!goes_on && matches!(error, ClientError::Link(LinkError::Silent)), "{error}"),
        }
    }
}

#[test]
fn groups_that_never_came_are_named_and_damaged_frames_counted() {
    let (mut client, device) = client(obliging);
    client.identify().unwrap();
    client.order(Request::SetAcquisition { run: true }).unwrap();
    {
        let mut device = device.borrow_mut();
        device.group(0);
        device.group(1);
        let whole = device.said.len();
        // Two groups on their way: the one is damaged, the other does not arrive at all.
        device.group(2);
        device.said[whole + 3] ^= 0x10;
        let damaged = device.said.len();
        device.group(3);
        device.said.truncate(damaged);
        device.group(4);
    }
    let numbers = [(); 3].map(|()| client.next_group().unwrap().report.group.0);
    assert_eq!(numbers, [0, 1, 4]);
    assert_eq!(client.take_lost_groups(), [2..=3]);
    assert_eq!(client.take_lost_groups(), []);
    let counts = client.counts();
    assert_eq!((counts.lost_uploads, counts.damaged_frames, counts.sent_again), (2, 1, 0));
}

#[test]
fn another_version_is_told_with_what_to_update() {
    for (version, update) in [(WIRE_VERSION - 1, "the device's firmware"), (WIRE_VERSION + 1, "this program")] {
        let (mut client, _) = client(move |command, device| device.answer(command, identity(version)));
        let error = client.identify().unwrap_err().to_string();
        assert!(error.contains(&format!("update {update}")) && error.contains(&version.to_string()), "{error}");
    }
    // A version so far away that its answers cannot even be read.
    let (mut client, _) = client(|_, device| {
        let frame = frame::encode(&(7_u32, [250_u8; 9])).unwrap();
        device.said.extend_from_slice(&frame);
    });
    assert!(matches!(client.identify(), Err(ClientError::OtherTongue)));
}

#[test]
fn a_device_that_starts_anew_in_the_middle_of_something_is_noticed() {
    let (mut client, device) = client(obliging);
    client.identify().unwrap();
    client.order(Request::SetAcquisition { run: true }).unwrap();
    device.borrow_mut().group(0);
    client.next_group().unwrap();
    device.borrow_mut().uploads = 0;
    device.borrow_mut().group(0);
    assert!(matches!(client.next_group(), Err(ClientError::Restarted)));
    client.identify().unwrap();
}

#[test]
fn an_order_for_a_later_group_is_not_sent_again_before_that_group_and_the_line_is_known_to_live() {
    let mut orders = 0;
    let (mut client, device) = client(move |command, device| match command.request {
        Request::SetMode { .. } if orders == 0 => orders += 1,
        _ => obliging(command, device),
    });
    client.identify().unwrap();
    client.order(Request::SetAcquisition { run: true }).unwrap();
    // Two groups of 1.5 s until group 1 begins at the latest, and the half second that an answer may take.
    let began = device.borrow().now;
    let order = Request::SetMode { axis: Axis::X, mode: Mode::Off };
    client.order_at(order, Some(GroupNumber(1))).unwrap();
    let took = device.borrow().now - began;
    assert!((Duration::from_millis(3400)..Duration::from_secs(8)).contains(&took), "{took:?}");
    let heard = &device.borrow().heard;
    assert_eq!(heard.iter().filter(|command| command.at == Some(GroupNumber(1))).count(), 2);
    assert!(heard.iter().any(|command| command.request == Request::Faults), "a quiet line is asked: {heard:?}");
}

#[test]
fn a_board_that_works_alone_is_met_without_taking_what_it_said_before_for_an_answer_or_a_loss() {
    let (mut client, device) = client(|command, device| match command.request {
        Request::Identity => {
            let identity = Identity { running: true, group: GroupNumber(40), ..board(WIRE_VERSION) };
            device.answer(command, Answer::Identity(identity));
        }
        // A mode changes between groups: it is answered when the next begins.
        Request::SetMode { .. } => {
            device.now += Duration::from_millis(1400);
            obliging(command, device);
        }
        _ => obliging(command, device),
    });
    // Another program left the stream on; of its uploads some still lie in the line, from before the power went.
    device.borrow_mut().uploads = 9000;
    (36..38).for_each(|group| device.borrow_mut().group(group));
    device.borrow_mut().uploads = 7;
    device.borrow_mut().group(39);
    assert!(client.identify().unwrap().running);
    client.order(Request::SetMode { axis: Axis::X, mode: Mode::Off }).unwrap();
    assert_eq!(client.counts(), Default::default(), "nothing was lost, nothing sent again");
    device.borrow_mut().group(41);
    assert_eq!(client.next_group().unwrap().report.group.0, 41, "the first that was said to this program");
    assert!(client.take_lost_groups().is_empty());
}
