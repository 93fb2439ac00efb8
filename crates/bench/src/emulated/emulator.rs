//! QEMU as a child process: its UART0 on two FIFOs, its semihosting on two more.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use nix::fcntl::OFlag;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::stat::Mode;
use tempfile::TempDir;
use zerorate_lockstep::{Answer, Poll, Request};

use super::bus::Buses;

/// The channel's two lines, and UART0's: to the board and from it, as QEMU names them.
const FIFOS: [&str; 4] = ["requests", "answers", "uart0.in", "uart0.out"];
/// The emulator of the board's processor.
const QEMU: &str = "qemu-system-arm";
/// How often the child and its UART are looked at while it asks nothing.
const LOOK_MS: u8 = 50;
/// A child whose line broke has ended, or will within this time.
const LAST_MOMENTS: Duration = Duration::from_secs(5);
/// An emulator that says nothing for so long has failed. One that was stopped for a while (a debugger, a suspended
/// machine) goes on where it was.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why there is no emulated board, or no longer.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// QEMU is not there.
    #[error("{QEMU} cannot be started: {0}; on Debian it is in the package qemu-system-arm")]
    NotStarted(io::Error),
    /// Its lines cannot be made.
    #[error("the lines to the emulated board cannot be made: {0}")]
    Lines(io::Error),
    /// What was given is no program.
    #[error("{} is no firmware (it is not an ELF file): `cargo xtask firmware` builds one", .0.display())]
    NotFirmware(PathBuf),
    /// QEMU has ended.
    #[error("QEMU, which emulates the board, has ended ({status}){}", if said.is_empty() { String::new() } else { format!(": {said}") })]
    Ended {
        /// How.
        status: ExitStatus,
        /// What it said first.
        said: String,
    },
    /// QEMU runs and says nothing.
    #[error("the emulated board has said nothing for {} s although QEMU runs: the firmware hangs", PATIENCE.as_secs())]
    Hangs,
    /// The firmware has panicked.
    #[error("the emulated firmware panicked at {file}:{line} and started anew; the wiper was left where it was")]
    Panicked {
        /// The source file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// The firmware is of another time.
    #[error(
        "the firmware is not of this program's version (it sent what is no request): build it anew with `cargo xtask firmware`"
    )]
    OtherVersion,
}

/// What the board did.
pub(super) enum Event {
    /// It has sent bytes to the host.
    Heard,
    /// It has asked something in the channel.
    Asked,
}

/// The emulator and its lines.
pub(super) struct Emulator {
    firmware: PathBuf,
    folder: TempDir,
    running: Option<Running>,
}

/// An emulator that runs.
struct Running {
    child: Child,
    requests: File,
    answers: File,
    to_board: File,
    from_board: File,
    /// The request that is being answered.
    request: Vec<u8>,
    /// The board's last word in the channel, held back while there is nothing for it.
    idle: Option<Poll>,
    /// Bytes sent to the board, and received from it.
    sent: u32,
    received: u32,
    heard: Vec<u8>,
}

impl Emulator {
    /// Starts the firmware.
    pub(super) fn new(firmware: &Path) -> Result<Self, EmulatorError> {
        let mut magic = [0; 4];
        let read = File::open(firmware).and_then(|mut file| file.read_exact(&mut magic));
        if read.is_err() || magic != *b"\x7FELF" {
            return Err(EmulatorError::NotFirmware(firmware.into()));
        }
        let folder = tempfile::Builder::new().prefix("zerorate-").tempdir().map_err(EmulatorError::Lines)?;
        for name in FIFOS {
            let made = nix::unistd::mkfifo(&folder.path().join(name), Mode::S_IRUSR | Mode::S_IWUSR);
            made.map_err(|error| EmulatorError::Lines(error.into()))?;
        }
        let mut emulator = Self { firmware: firmware.into(), folder, running: None };
        emulator.start()?;
        Ok(emulator)
    }

    /// Gives the board power.
    pub(super) fn start(&mut self) -> Result<(), EmulatorError> {
        let path = |name: &str| self.folder.path().join(name);
        // Opened both ways: so opening waits for nobody, and what an earlier board left unread is gone.
        let mut options = OpenOptions::new();
        options.read(true).write(true);
        let open = |options: &OpenOptions, name: &str| options.open(path(name)).map_err(EmulatorError::Lines);
        let [requests, answers, to_board, _] = FIFOS.map(|name| open(&options, name));
        let from_board = open(options.custom_flags(OFlag::O_NONBLOCK.bits()), FIFOS[3])?;
        let said = File::create(path("said")).map_err(EmulatorError::Lines)?;
        let child = Command::new(QEMU)
            .args(["-machine", "mps2-an386", "-nodefaults", "-display", "none", "-monitor", "none"])
            .arg("-chardev")
            .arg(option("pipe,id=host,path=", &path("uart0")))
            .args(["-serial", "chardev:host"])
            // One instruction 32 ns, and no waiting for real time: every run is the same.
            .args(["-icount", "shift=5,sleep=off"])
            .arg("-semihosting-config")
            .arg(option("enable=on,target=native,arg=", self.folder.path()))
            .arg("-kernel")
            .arg(&self.firmware)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(said)
            .spawn()
            .map_err(EmulatorError::NotStarted)?;
        self.running = Some(Running {
            child,
            requests: requests?,
            answers: answers?,
            to_board: to_board?,
            from_board,
            request: Vec::new(),
            idle: None,
            sent: 0,
            received: 0,
            heard: Vec::new(),
        });
        Ok(())
    }

    /// Takes the board's power.
    pub(super) fn stop(&mut self) {
        if let Some(mut running) = self.running.take() {
            // It may have ended by itself.
            let _ = running.child.kill();
            let _ = running.child.wait();
        }
    }

    /// What has ended, and what it said.
    fn ended(&self, status: ExitStatus) -> EmulatorError {
        let said = std::fs::read_to_string(self.folder.path().join("said")).unwrap_or_default();
        EmulatorError::Ended { status, said: said.lines().next().unwrap_or_default().to_owned() }
    }

    fn running(&mut self) -> Result<&mut Running, EmulatorError> {
        self.running.as_mut().ok_or_else(|| EmulatorError::Lines(ErrorKind::NotConnected.into()))
    }

    /// Whether the board has acted on all that it was sent and waits in the channel.
    pub(super) fn is_idle(&self) -> bool {
        let waits = |running: &Running| running.idle.is_some_and(|poll| poll.received == running.sent);
        self.running.as_ref().is_some_and(waits)
    }

    /// Whether all that the waiting board has sent has come.
    pub(super) fn has_heard_all(&self) -> bool {
        let came = |running: &Running| running.idle.is_some_and(|poll| poll.sent == running.received);
        self.running.as_ref().is_some_and(came)
    }

    /// Whether there are bytes for the host.
    pub(super) fn has_heard(&self) -> bool {
        self.running.as_ref().is_some_and(|running| !running.heard.is_empty())
    }

    /// Hands out the bytes for the host.
    pub(super) fn take_heard(&mut self, into: &mut Vec<u8>) {
        if let Some(running) = &mut self.running {
            into.append(&mut running.heard);
        }
    }

    /// Sends the board bytes of the host.
    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<(), EmulatorError> {
        // A command is far shorter than what a FIFO holds, and the board takes in one before the next is sent.
        let written = self.running()?.to_board.write_all(bytes);
        if let Err(error) = written {
            return Err(self.gone(error));
        }
        let running = self.running()?;
        running.sent = running.sent.wrapping_add(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        Ok(())
    }

    /// Tells the waiting board that data ready has risen.
    pub(super) fn give_set(&mut self) -> Result<(), EmulatorError> {
        self.reply(&[Answer::SetReady as u8])
    }

    /// Tells the waiting board that a second has gone by.
    pub(super) fn give_second(&mut self) -> Result<(), EmulatorError> {
        self.reply(&[Answer::Second as u8])
    }

    /// Answers the board. A broken line is a child that has ended.
    fn reply(&mut self, bytes: &[u8]) -> Result<(), EmulatorError> {
        let running = self.running()?;
        running.idle = None;
        match running.answers.write_all(bytes) {
            Ok(()) => Ok(()),
            Err(error) => Err(self.gone(error)),
        }
    }

    /// Why a line has failed: most often its other end has.
    fn gone(&mut self, error: io::Error) -> EmulatorError {
        let began = Instant::now();
        while began.elapsed() < LAST_MOMENTS {
            if let Some(Ok(Some(status))) = self.running.as_mut().map(|running| running.child.try_wait()) {
                return self.ended(status);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        EmulatorError::Lines(error)
    }

    /// Waits for the board's next word.
    pub(super) fn next(&mut self) -> Result<Event, EmulatorError> {
        let began = Instant::now();
        // What the board waits for before it can take in more of what it was sent.
        if !self.is_idle() && self.running()?.idle.is_some() {
            self.reply(&[Answer::Done as u8])?;
        }
        loop {
            if self.hear()? {
                return Ok(Event::Heard);
            }
            let running = self.running()?;
            // While it works, only its requests wake us: it sends byte by byte, and to wake for each costs more than all
            // else. What it has sent is looked at with every request, and now and then.
            let waits = running.idle.is_some();
            let line = if waits { running.from_board.as_fd() } else { running.requests.as_fd() };
            if wait_for(line)? {
                if !waits {
                    return Ok(Event::Asked);
                }
            } else if let Some(status) = running.child.try_wait().map_err(EmulatorError::Lines)? {
                return Err(self.ended(status));
            } else if began.elapsed() > PATIENCE {
                return Err(EmulatorError::Hangs);
            }
        }
    }

    /// Takes the bytes that have come for the host; whether there were any.
    fn hear(&mut self) -> Result<bool, EmulatorError> {
        let mut bytes = [0; 16_384];
        let running = self.running()?;
        let n = match running.from_board.read(&mut bytes) {
            Ok(n) => n,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => 0,
            Err(error) => return Err(self.gone(error)),
        };
        running.heard.extend_from_slice(&bytes[..n]);
        running.received = running.received.wrapping_add(u32::try_from(n).unwrap_or(0));
        Ok(n > 0)
    }

    /// Reads the board's request and answers it; a poll waits for its answer.
    pub(super) fn answer(&mut self, buses: &mut Buses) -> Result<(), EmulatorError> {
        let running = self.running()?;
        let mut bytes = core::mem::take(&mut running.request);
        if let Err(error) = read_request(&mut running.requests, &mut bytes) {
            return Err(self.gone(error));
        }
        let mut reply = Vec::new();
        match Request::decode(&bytes).ok_or(EmulatorError::OtherVersion)? {
            Request::Poll(poll) => running.idle = Some(poll),
            Request::Panicked { file, line } => return Err(EmulatorError::Panicked { file: file.into(), line }),
            request => buses.serve(&request, &mut reply),
        }
        running.request = bytes;
        if reply.is_empty() { Ok(()) } else { self.reply(&reply) }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.stop();
    }
}

/// An option with a path at its end, in which QEMU takes a comma by two.
fn option(head: &str, path: &Path) -> String {
    format!("{head}{}", path.display().to_string().replace(',', ",,"))
}

/// A whole request, its length taken off. A request is written at once, so what has begun is there.
fn read_request(requests: &mut File, into: &mut Vec<u8>) -> io::Result<()> {
    let mut length = [0; 2];
    requests.read_exact(&mut length)?;
    into.clear();
    into.resize(usize::from(u16::from_le_bytes(length)), 0);
    requests.read_exact(into)
}

/// Waits a while; whether the file can be read.
fn wait_for(file: BorrowedFd<'_>) -> Result<bool, EmulatorError> {
    let mut polled = [PollFd::new(file, PollFlags::POLLIN)];
    match poll(&mut polled, PollTimeout::from(LOOK_MS)) {
        Ok(_) | Err(nix::errno::Errno::EINTR) => {}
        Err(error) => return Err(EmulatorError::Lines(error.into())),
    }
    Ok(polled[0].any().unwrap_or(false))
}
