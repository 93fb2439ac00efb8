//! A line between a client and a server that does what lines do, on TCP or with a serial line's end.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

/// What the line does with an answer, or once with a question.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Does {
    Pass,
    /// Every third answer comes so late.
    Late(Duration),
    /// Every answer comes twice, the second after so long.
    Twice(Duration),
    /// Half of it comes, and the rest never.
    Half,
    /// Another unit answers: the byte at this place is another.
    OtherUnit(usize),
    /// Answers of Modbus TCP that begin so after the unit become exceptions of this number: 6 is busy, 4 a failure.
    Refuse(&'static [u8], u8),
    /// Nothing comes.
    Cut,
    /// The next question that begins so is lost with its connection, and the server hears the other bytes instead; then it passes.
    Instead(&'static [u8], &'static [u8]),
}

pub struct FaultLine {
    does: Arc<Mutex<Does>>,
    /// As an address has it, after the protocol.
    pub place: String,
    /// The end of a serial line that is held open.
    _host: Option<TTYPort>,
}

impl FaultLine {
    pub fn tcp(to: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        let does = Arc::new(Mutex::new(Does::Pass));
        let shared = Arc::clone(&does);
        thread::spawn(move || {
            for client in listener.incoming().map_while(Result::ok) {
                if *shared.lock().unwrap() == Does::Cut {
                    continue;
                }
                // A server that is away refuses.
                let Ok(server) = TcpStream::connect(("127.0.0.1", to)) else { continue };
                let (back, does) = (client.try_clone().unwrap(), Arc::clone(&shared));
                between(client, back, server, does);
            }
        });
        Self { does, place, _host: None }
    }

    pub fn serial(to: u16) -> Self {
        let (mut board, host) = TTYPort::pair().unwrap();
        board.set_timeout(Duration::from_secs(3600)).unwrap();
        let does = Arc::new(Mutex::new(Does::Pass));
        let back = board.try_clone_native().unwrap();
        between(board, back, TcpStream::connect(("127.0.0.1", to)).unwrap(), Arc::clone(&does));
        Self { does, place: host.name().unwrap(), _host: Some(host) }
    }

    pub fn does(&self, what: Does) {
        *self.does.lock().unwrap() = what;
    }
}

fn between(
    mut client: impl Read + Send + 'static,
    mut back: impl Write + Send + 'static,
    mut server: TcpStream,
    does: Arc<Mutex<Does>>,
) {
    let mut answers = server.try_clone().unwrap();
    let asked = Arc::clone(&does);
    thread::spawn(move || {
        let mut buffer = [0; 512];
        while let Ok(length) = client.read(&mut buffer) {
            let does = *asked.lock().unwrap();
            if let Does::Instead(these, heard) = does
                && buffer[..length].starts_with(these)
            {
                *asked.lock().unwrap() = Does::Pass;
                let _ = server.write_all(heard);
                // Until it has heard it.
                thread::sleep(Duration::from_millis(100));
                break;
            }
            if length == 0 || (does != Does::Cut && server.write_all(&buffer[..length]).is_err()) {
                break;
            }
        }
        let _ = server.shutdown(std::net::Shutdown::Both);
    });
    thread::spawn(move || {
        let mut buffer = [0; 512];
        let mut count = 0;
        while let Ok(length @ 1..) = answers.read(&mut buffer) {
            let mut answer = buffer[..length].to_vec();
            let does = *does.lock().unwrap();
            count += 1;
            let mut again = None;
            match does {
                Does::Late(by) if count % 3 == 0 => thread::sleep(by),
                Does::Twice(after) => again = Some(after),
                Does::Half => answer.truncate(length / 2),
                Does::OtherUnit(place) => answer[place] ^= 4,
                Does::Refuse(these, exception) if answer[7..].starts_with(these) => {
                    answer[4..6].copy_from_slice(&[0, 3]);
                    answer[7] |= 0x80;
                    answer[8] = exception;
                    answer.truncate(9);
                }
                Does::Cut => continue,
                Does::Pass | Does::Late(_) | Does::Refuse(..) | Does::Instead(..) => {}
            }
            if back.write_all(&answer).is_err() {
                break;
            }
            if let Some(after) = again {
                thread::sleep(after);
                if back.write_all(&answer).is_err() {
                    break;
                }
            }
        }
    });
}
