#![doc = include_str!("../README.md")]

mod modbus;
mod order;
mod scpi;
mod socket;

use std::io;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};

use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Celsius, Seconds};
use zerorate_device::port::PortAcquisition;
use zerorate_sim::{Plant, PortSpi, SharedPlant};

use self::modbus::Controller;
use self::order::Order;
use self::scpi::FineSupply;
use self::socket::Socket;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated::NativeDevice;

pub use self::socket::{ListenOn, UnknownPlace};

/// The most that the board's time falls behind before it lets the rest go: a process that was halted goes on where it
/// was, as a board in a debugger does.
const MOST_BEHIND: Duration = Duration::from_millis(250);
/// Bytes on their way to a host that does not take them, at the speed of the wall clock: some twenty seconds of samples. What
/// comes on top is lost. A faster board keeps as many seconds, for its host is no faster.
const MOST_PENDING: f64 = 65_536.0;
/// How long sets are made before the host is looked at again.
const SLICE: Duration = Duration::from_millis(20);

/// A board on a socket.
pub struct VirtualBoard {
    device: NativeDevice<PortAcquisition<PortSpi>>,
    socket: Socket,
    speed: f64,
    /// Where the board's time should be by the wall clock.
    due: Seconds,
    looked: Instant,
    pending: Vec<u8>,
    /// The second line, and the bytes on their way to who listens there.
    scans: Option<(Socket, Vec<u8>)>,
    remote: Vec<Remote>,
    /// The orders of boards in the same chamber, and where that was sent when they were last told.
    beside: (Vec<Sender<String>>, Celsius),
    damage: Damage,
    acquiring: bool,
}

/// An instrument that is spoken to on a line of its own.
struct Remote {
    socket: Socket,
    instrument: Instrument,
    incoming: Vec<u8>,
    pending: Vec<u8>,
}

enum Instrument {
    Chamber(Controller),
    Supply(FineSupply),
}

impl Remote {
    fn exchange(&mut self, plant: &SharedPlant) -> io::Result<()> {
        self.socket.look(&mut self.incoming, &mut self.pending)?;
        self.pending.extend(match &mut self.instrument {
            Instrument::Chamber(controller) => controller.hear(&mut self.incoming, plant),
            Instrument::Supply(supply) => supply.hear(&mut self.incoming, plant),
        });
        Ok(())
    }
}

impl VirtualBoard {
    /// A board about a plant, listening. At `speed` its time, and so the chamber's, runs so many times faster.
    ///
    /// # Errors
    /// When it cannot listen there.
    pub fn new(plant: Plant, setup: &SetUp, unit: &UnitSerial, on: &ListenOn, speed: f64) -> io::Result<Self> {
        let device = NativeDevice::of_plant(plant, setup, unit);
        let (due, sent_to) = (device.plant().borrow().time(), device.plant().borrow().chamber_sent_to());
        let socket = Socket::open(on)?;
        let damage = Damage { rate: 0.0, state: 0x9E37_79B9_7F4A_7C15 };
        let (looked, pending) = (Instant::now(), Vec::new());
        Ok(Self {
            device,
            socket,
            speed,
            due,
            looked,
            pending,
            scans: None,
            remote: Vec::new(),
            beside: (Vec::new(), sent_to),
            damage,
            acquiring: false,
        })
    }

    /// Has a second line, on which each scan goes out, corrected; here a group of them at a time.
    ///
    /// # Errors
    /// When it cannot listen there.
    pub fn send_scans(&mut self, on: &ListenOn) -> io::Result<String> {
        let socket = Socket::open(on)?;
        let address = socket.address();
        self.scans = Some((socket, Vec::new()));
        Ok(address)
    }

    /// Has its chamber listen to Modbus, as a Watlow F4T does: on TCP, or in RTU frames on a pseudo-terminal. Returns where,
    /// as `--chamber` takes it.
    ///
    /// # Errors
    /// When it cannot listen there.
    pub fn remote_chamber(&mut self, on: &ListenOn) -> io::Result<String> {
        let is_serial = matches!(on, ListenOn::Pty(_));
        let controller = Controller::new(self.device.plant(), is_serial);
        let place = self.remote(on, Instrument::Chamber(controller))?;
        Ok(format!("modbus-{}:{place}", if is_serial { "rtu" } else { "tcp" }))
    }

    /// Has its supply and voltmeter listen to SCPI. Returns where, as `--supply` takes it.
    ///
    /// # Errors
    /// When it cannot listen there.
    pub fn remote_supply(&mut self, on: &ListenOn) -> io::Result<String> {
        let place = self.remote(on, Instrument::Supply(FineSupply::new()))?;
        Ok(format!("scpi:{place}"))
    }

    /// Has other boards stand in its chamber: they get the order when it is sent anywhere.
    pub fn share_chamber(&mut self, orders: Vec<Sender<String>>) {
        self.beside.0 = orders;
    }

    fn tell_those_beside(&mut self) {
        let sent_to = self.device.plant().borrow().chamber_sent_to();
        let (beside, told) = &mut self.beside;
        if sent_to != std::mem::replace(told, sent_to) {
            // One that has ended does not mind.
            beside.retain(|orders| orders.send(format!("chamber {}", sent_to.0)).is_ok());
        }
    }

    fn remote(&mut self, on: &ListenOn, instrument: Instrument) -> io::Result<String> {
        let socket = Socket::open(on)?;
        let address = socket.address();
        self.remote.push(Remote { socket, instrument, incoming: Vec::new(), pending: Vec::new() });
        Ok(address.split_once(':').map_or(address.as_str(), |(_, place)| place).to_owned())
    }

    /// Where it listens, as `--device` and `--port` take it.
    #[must_use]
    pub fn address(&self) -> String {
        self.socket.address()
    }

    /// Serves until it is told to end, by `quit` or by `go_on`. Orders come as lines; `answer` gets what is said to them.
    ///
    /// # Errors
    /// When the socket fails.
    pub fn serve(
        &mut self,
        orders: &Receiver<String>,
        mut answer: impl FnMut(&str),
        mut go_on: impl FnMut() -> bool,
    ) -> io::Result<()> {
        let mut incoming = Vec::new();
        self.looked = Instant::now();
        while go_on() {
            loop {
                match orders.try_recv() {
                    Ok(line) if line.trim().is_empty() => {}
                    Ok(line) => match line.parse() {
                        Ok(Order::Quit) => return Ok(()),
                        Ok(order) => answer(&self.obey(order)),
                        Err(unknown) => answer(&unknown),
                    },
                    // Nobody gives orders any more: the board stays as it is.
                    Err(TryRecvError::Empty | TryRecvError::Disconnected) => break,
                }
            }
            self.socket.exchange(&mut incoming, &mut self.pending)?;
            self.damage.do_to(&mut incoming);
            self.device.hear(&incoming);
            incoming.clear();
            for remote in &mut self.remote {
                remote.exchange(self.device.plant())?;
            }
            self.tell_those_beside();
            self.pass_time();
            let said = self.device.said();
            let most = MOST_PENDING * self.speed.max(1.0);
            #[allow(clippy::cast_precision_loss)] // bytes
            let has_room = |pending: &[u8]| (pending.len() as f64) < most;
            if let Some((socket, pending)) = &mut self.scans {
                // Nobody speaks on it.
                socket.exchange(&mut Vec::new(), pending)?;
                let scans = self.device.scans_said(socket.is_connected());
                if socket.is_connected() && has_room(pending) {
                    pending.extend(scans);
                }
            }
            if self.socket.is_connected() && has_room(&self.pending) {
                let from = self.pending.len();
                self.pending.extend(said);
                self.damage.do_to(&mut self.pending[from..]);
            }
        }
        Ok(())
    }

    /// Lets the board's time follow the wall clock.
    fn pass_time(&mut self) {
        let passed = self.looked.elapsed().min(MOST_BEHIND);
        self.looked = Instant::now();
        self.due = self.due + Seconds(passed.as_secs_f64() * self.speed);
        let began = Instant::now();
        let period = self.device.group_period();
        while self.behind() >= period.0 {
            self.acquiring = self.device.run_set().is_ok();
            if !self.acquiring {
                let behind = self.behind();
                self.device.stand(Seconds(behind));
            } else if began.elapsed() > SLICE {
                // Faster than this machine can: as fast as it can, then.
                let most = self.speed * MOST_BEHIND.as_secs_f64();
                let now = self.device.plant().borrow().time();
                self.due = Seconds(self.due.0.min(now.0 + most.max(period.0)));
                return;
            }
        }
    }

    fn behind(&self) -> f64 {
        (self.due - self.device.plant().borrow().time()).0
    }

    fn obey(&mut self, order: Order) -> String {
        let plant = self.device.plant().clone();
        match order {
            Order::Chamber(set_point) => match plant.borrow_mut().chamber_set_point(set_point) {
                Ok(()) => format!("chamber: on its way to {:.1} C", set_point.0),
                Err(outside) => format!("chamber: refused: {outside}"),
            },
            Order::Feed(volts) => {
                plant.borrow_mut().connect_supply(volts);
                format!("supply: {:.6} V to both inputs", volts.0)
            }
            Order::Gyros => {
                plant.borrow_mut().connect_gyro();
                "supply: off, the gyros are back".into()
            }
            Order::Voltmeter => {
                let volts = Axis::BOTH.map(|axis| plant.borrow().rate_volts(axis).0);
                format!("voltmeter: x {:.6} y {:.6}", volts[0], volts[1])
            }
            Order::Power => {
                self.device.power_cycle();
                "power: off and on".into()
            }
            Order::Break(fault) => {
                plant.borrow_mut().inject(fault);
                format!("broken: {fault:?}")
            }
            Order::Mend => {
                plant.borrow_mut().clear_faults();
                self.damage.rate = 0.0;
                "everything is mended".into()
            }
            Order::ByteErrors(rate) => {
                self.damage.rate = rate;
                format!("line: one byte in {:.0} is damaged", 1.0 / rate)
            }
            Order::Status => {
                let plant = plant.borrow();
                format!(
                    "status: air {:.2} C, {:.1} s, acquisition {}",
                    plant.chamber_air().0,
                    plant.time().0,
                    if self.acquiring { "runs" } else { "stands still" }
                )
            }
            Order::Quit => String::new(),
        }
    }
}

/// A bad line: single bits of it turned over now and then.
struct Damage {
    rate: f64,
    state: u64,
}

impl Damage {
    fn do_to(&mut self, bytes: &mut [u8]) {
        if self.rate <= 0.0 {
            return;
        }
        for byte in bytes {
            // xorshift64: any sequence without a pattern will do.
            self.state ^= self.state << 13;
            self.state ^= self.state >> 7;
            self.state ^= self.state << 17;
            #[allow(clippy::cast_precision_loss)] // a probability
            let drawn = (self.state >> 11) as f64 / (1_u64 << 53) as f64;
            if drawn < self.rate {
                *byte ^= 1 << (self.state % 8);
            }
        }
    }
}
