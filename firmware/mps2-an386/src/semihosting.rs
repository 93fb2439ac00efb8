//! Two FIFOs of the host by semihosting ("Semihosting for AArch32 and AArch64", release 2.0): requests out, answers in.

use cortex_m::asm::semihosting_syscall;
use zerorate_lockstep::Line;

const SYS_OPEN: u32 = 0x01;
const SYS_WRITE: u32 = 0x05;
const SYS_READ: u32 = 0x06;
const SYS_GET_CMDLINE: u32 = 0x15;

/// fopen's "rb" and "wb".
const READ_BINARY: u32 = 1;
const WRITE_BINARY: u32 = 5;

/// The longest path of the folder with the FIFOs, its zero included.
const PATH: usize = 256;

/// The host is not there, or has closed a FIFO.
#[derive(Debug, Clone, Copy)]
pub struct HostGone;

/// The FIFOs, open.
pub struct Fifos {
    requests: u32,
    answers: u32,
}

/// A call with its block of parameters.
fn call(operation: u32, parameters: &mut [u32]) -> u32 {
    let block = parameters.as_mut_ptr() as u32;
    #[allow(unsafe_code)]
    // SAFETY: every operation used here takes the address of a block of words that outlives the call; the addresses in
    // it are of buffers whose lengths stand beside them.
    unsafe {
        semihosting_syscall(operation, block)
    }
}

impl Fifos {
    /// Opens `requests` and `answers` in the folder that the emulator's command line names.
    pub fn open() -> Result<Self, HostGone> {
        let mut folder = [0_u8; PATH];
        let mut block = [folder.as_mut_ptr() as u32, PATH as u32 - 1];
        if call(SYS_GET_CMDLINE, &mut block) != 0 {
            return Err(HostGone);
        }
        let length = folder.iter().position(|&byte| byte == 0).ok_or(HostGone)?;
        Ok(Self {
            requests: open(&folder[..length], b"/requests", WRITE_BINARY)?,
            answers: open(&folder[..length], b"/answers", READ_BINARY)?,
        })
    }
}

fn open(folder: &[u8], name: &[u8], mode: u32) -> Result<u32, HostGone> {
    let mut path = [0_u8; PATH + 16];
    let length = folder.len() + name.len();
    path.get_mut(..folder.len()).ok_or(HostGone)?.copy_from_slice(folder);
    path.get_mut(folder.len()..length).ok_or(HostGone)?.copy_from_slice(name);
    let handle = call(SYS_OPEN, &mut [path.as_ptr() as u32, mode, length as u32]);
    if handle == u32::MAX { Err(HostGone) } else { Ok(handle) }
}

impl Line for Fifos {
    type Error = HostGone;

    fn write(&mut self, bytes: &[u8]) -> Result<(), HostGone> {
        let left = call(SYS_WRITE, &mut [self.requests, bytes.as_ptr() as u32, bytes.len() as u32]);
        if left == 0 { Ok(()) } else { Err(HostGone) }
    }

    fn read(&mut self, bytes: &mut [u8]) -> Result<(), HostGone> {
        let mut done = 0;
        while let Some(rest) = bytes.get_mut(done..).filter(|rest| !rest.is_empty()) {
            let wanted = rest.len();
            let left = call(SYS_READ, &mut [self.answers, rest.as_mut_ptr() as u32, wanted as u32]) as usize;
            // Nothing at all came: the FIFO's other end is closed.
            if left >= wanted {
                return Err(HostGone);
            }
            done += wanted - left;
        }
        Ok(())
    }
}

/// Prints a text that ends in a zero and ends the emulation.
pub fn give_up(why: &'static [u8]) -> ! {
    const SYS_WRITE0: u32 = 0x04;
    const SYS_EXIT: u32 = 0x18;
    const RUN_TIME_ERROR: u32 = 0x2_0023;
    debug_assert!(why.ends_with(&[0]));
    #[allow(unsafe_code)]
    // SAFETY: the text ends in a zero; the other operation takes a number.
    unsafe {
        semihosting_syscall(SYS_WRITE0, why.as_ptr() as u32);
        semihosting_syscall(SYS_EXIT, RUN_TIME_ERROR);
    }
    loop {
        cortex_m::asm::wfi();
    }
}
