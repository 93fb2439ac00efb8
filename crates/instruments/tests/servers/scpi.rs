//! A supply on sinstruments' server.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::Duration;

use zerorate_core::units::{Axis, Volts};
use zerorate_instruments::fault::Fault;
use zerorate_instruments::supply::{PowerSupply, SupplyTable};

use crate::fault_line::{Does, FaultLine};
use crate::server::Server;

fn supply(place: &str) -> PowerSupply {
    let table = SupplyTable { time_out_ms: 200, most_v: 10.0, ..SupplyTable::default() };
    PowerSupply::new(&format!("scpi:{place}").parse().unwrap(), &table).unwrap()
}

#[test]
#[ignore = "needs sinstruments: cargo xtask test instruments"]
fn a_voltage_is_fed_and_taken_off_whatever_the_line_does() {
    let server = Server::start("supply.py", &[]);
    for line in [FaultLine::tcp(server.port), FaultLine::serial(server.port)] {
        let mut supply = supply(&line.place);
        assert!(supply.identity().unwrap().contains("SUPPLY"));
        for does in [Does::Pass, Does::Late(Duration::from_millis(300)), Does::Twice(Duration::ZERO)] {
            line.does(does);
            for volts in [2.4, 2.6] {
                supply.feed(Volts(volts)).unwrap();
                std::thread::sleep(Duration::from_millis(20));
            }
            supply.off().unwrap();
        }
        line.does(Does::Cut);
        assert!(supply.off().unwrap_err().may_pass());
        line.does(Does::Pass);
        supply.off().unwrap();
        assert!((supply.gyro_output(Axis::X).unwrap().0 - 2.5).abs() < 1e-9, "what the set-up says");
    }
}

#[test]
#[ignore = "needs sinstruments: cargo xtask test instruments"]
fn a_supply_in_current_limit_and_one_that_refuses_are_errors() {
    // 0.1 A through 10 ohms are 1 V.
    let server = Server::start("supply.py", &["--load-ohm", "10"]);
    let mut supply = supply(&format!("127.0.0.1:{}", server.port));
    let error = supply.feed(Volts(2.5)).unwrap_err();
    assert!(matches!(error, Fault::CurrentLimit { .. }) && error.to_string().contains("gives 1.0000 V"), "{error}");
    supply.off().unwrap();
    let error = supply.feed(Volts(8.0)).unwrap_err().to_string();
    assert!(error.contains("refuses `VOLT 8.000000`: -222,\"Data out of range\""), "{error}");
    let error = supply.feed(Volts(11.0)).unwrap_err().to_string();
    assert!(error.contains("nothing was sent"), "{error}");
}

/// A supply that feeds 2.4 V, behind a line.
fn feeding() -> (Server, FaultLine, PowerSupply) {
    let server = Server::start("supply.py", &[]);
    let line = FaultLine::tcp(server.port);
    let mut supply = supply(&line.place);
    supply.feed(Volts(2.4)).unwrap();
    (server, line, supply)
}

/// What the server says to somebody else.
fn asked_by_hand(server: &Server, question: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    writeln!(stream, "{question}").unwrap();
    let mut answer = String::new();
    BufReader::new(stream).read_line(&mut answer).unwrap();
    answer.trim().to_owned()
}

#[test]
#[ignore = "needs sinstruments: cargo xtask test instruments"]
fn a_command_that_is_lost_with_its_connection_is_given_once_more() {
    let (server, line, mut supply) = feeding();
    // Nearer to the voltage before than the tolerance.
    line.does(Does::Instead(b"VOLT", b""));
    supply.feed(Volts(2.41)).unwrap();
    let given: f64 = asked_by_hand(&server, "MEAS:VOLT?").parse().unwrap();
    assert!((given - 2.41).abs() < 0.005, "{given}");
    line.does(Does::Instead(b"OUTP OFF", b""));
    supply.off().unwrap();
    assert!(!supply.is_on().unwrap());
}

#[test]
#[ignore = "needs sinstruments: cargo xtask test instruments"]
fn a_supply_that_drops_out_after_it_was_measured_does_not_hold() {
    let (_server, line, mut supply) = feeding();
    supply.hold().unwrap();
    line.does(Does::Instead(b"MEAS", b"OUTP OFF\n"));
    let error = supply.hold().unwrap_err();
    assert!(
        matches!(error, Fault::NotHeld { .. }) && error.to_string().contains("fed 2.4000 V and gives 0.0000"),
        "{error}"
    );
}
