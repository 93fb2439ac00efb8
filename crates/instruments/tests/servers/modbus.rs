//! A chamber's controller on pymodbus's server.

use std::time::{Duration, Instant};

use zerorate_core::units::Celsius;
use zerorate_instruments::controller::{Controller, ControllerTable};
use zerorate_instruments::fault::Fault;

use crate::fault_line::{Does, FaultLine};
use crate::server::Server;

const LIMITS: [Celsius; 2] = [Celsius(-60.0), Celsius(150.0)];
/// How long an answer may take here, and how late a late one is.
const TIME_OUT_MS: u64 = 200;
const LATE: Duration = Duration::from_millis(300);

fn controller(protocol: &str, place: &str, preset: &str) -> Controller {
    let table = ControllerTable { time_out_ms: TIME_OUT_MS, ..ControllerTable::of(preset) };
    Controller::new(&format!("{protocol}:{place}").parse().unwrap(), &table, LIMITS).unwrap()
}

/// A controller of either kind of line, its server standing still at 25 C.
fn both(more: &[&str]) -> [(Server, FaultLine, Controller, usize); 2] {
    let tcp = Server::start("chamber.py", more);
    let line = FaultLine::tcp(tcp.port);
    let by_tcp = controller("modbus-tcp", &line.place, "watlow-f4t");
    let rtu = Server::start("chamber.py", &[&["--rtu"], more].concat());
    let serial = FaultLine::serial(rtu.port);
    let by_rtu = controller("modbus-rtu", &serial.place, "watlow-f4t");
    // The unit stands after a header of six bytes, or first.
    [(tcp, line, by_tcp, 6), (rtu, serial, by_rtu, 0)]
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn a_chamber_that_lags_gets_there_at_its_own_rate_and_is_left_safe() {
    for preset in ["watlow-f4t", "eurotherm"] {
        let server = Server::start("chamber.py", &["--preset", preset, "--speed", "300"]);
        let mut chamber = controller("modbus-tcp", &format!("127.0.0.1:{}", server.port), preset);
        let began = Instant::now();
        chamber.send(Celsius(40.0)).unwrap();
        assert!((chamber.set_point().unwrap().0 - 40.0).abs() < 0.06);
        let (mut most, mut settled) = (f64::MIN, 0);
        while settled < 20 {
            let air = chamber.actual().unwrap().0;
            most = most.max(air);
            settled = if (air - 40.0).abs() < 0.3 { settled + 1 } else { 0 };
            assert!(began.elapsed() < Duration::from_secs(20), "{preset}: {air}");
            std::thread::sleep(Duration::from_millis(20));
        }
        // 15 K at 2.5 K/min are six minutes.
        assert!(began.elapsed().as_secs_f64() * 300.0 > 330.0, "{preset}");
        assert!(most > 40.1, "{preset}: it overshoots: {most}");
        chamber.rest().unwrap();
        assert!((chamber.set_point().unwrap().0 - 25.0).abs() < 0.06);
    }
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn a_late_answer_and_one_that_comes_twice_are_never_taken_for_the_next() {
    for (_server, line, mut chamber, _) in both(&[]) {
        chamber.send(Celsius(40.0)).unwrap();
        for does in [Does::Late(LATE), Does::Twice(Duration::ZERO), Does::Twice(Duration::from_millis(30))] {
            line.does(does);
            for _ in 0..12 {
                // The air stands at 25 C, the set point at 40: one taken for the other is seen.
                assert!((chamber.actual().unwrap().0 - 25.0).abs() < 1e-6);
                assert!((chamber.set_point().unwrap().0 - 40.0).abs() < 1e-6);
                // On a serial line nothing but silence separates answers of one kind.
                std::thread::sleep(Duration::from_millis(40));
            }
        }
    }
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn half_answers_and_another_unit_are_errors_and_gone_when_the_line_is_mended() {
    for (_server, line, mut chamber, unit) in both(&[]) {
        line.does(Does::Half);
        let error = chamber.actual().unwrap_err();
        assert!(matches!(error, Fault::Silent { heard: "only part of an answer came", .. }), "{error}");
        line.does(Does::OtherUnit(unit));
        let error = chamber.actual().unwrap_err();
        // On a serial line its CRC is wrong as well.
        assert!(matches!(error, Fault::OtherUnit { asked: 1, answered: 5 }) || unit == 0, "{error}");
        line.does(Does::Pass);
        assert!((chamber.actual().unwrap().0 - 25.0).abs() < 1e-6);
    }
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn a_controller_that_is_busy_may_answer_later() {
    let server = Server::start("chamber.py", &[]);
    let line = FaultLine::tcp(server.port);
    let mut chamber = controller("modbus-tcp", &line.place, "watlow-f4t");
    for (exception, may_pass) in [(6, true), (4, false)] {
        line.does(Does::Refuse(&[], exception));
        let error = chamber.actual().unwrap_err();
        assert!(
            matches!(error, Fault::Refused { code, .. } if code == exception) && error.may_pass() == may_pass,
            "{error}"
        );
    }
    line.does(Does::Pass);
    assert!((chamber.actual().unwrap().0 - 25.0).abs() < 1e-6);
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn a_line_that_is_cut_is_silence_and_goes_on_when_it_is_back() {
    for (_server, line, mut chamber, _) in both(&[]) {
        chamber.send(Celsius(40.0)).unwrap();
        line.does(Does::Cut);
        for _ in 0..3 {
            assert!(chamber.actual().unwrap_err().may_pass());
        }
        line.does(Does::Pass);
        assert!((chamber.set_point().unwrap().0 - 40.0).abs() < 1e-6);
    }
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn a_controller_that_starts_anew_is_silence_and_then_answers() {
    let server = Server::start("chamber.py", &[]);
    let port = server.port;
    let mut chamber = controller("modbus-tcp", &format!("127.0.0.1:{port}"), "watlow-f4t");
    chamber.send(Celsius(40.0)).unwrap();
    drop(server);
    assert!(chamber.actual().unwrap_err().may_pass());
    let _anew = Server::start("chamber.py", &["--port", &port.to_string()]);
    // It has forgotten, which whoever asks can see.
    let strayed = chamber.strayed_from(Celsius(40.0)).unwrap();
    assert!(strayed.is_some_and(|strayed| strayed.starts_with("set to")));
}

#[test]
#[ignore = "needs pymodbus: cargo xtask test instruments"]
fn what_no_sensor_gives_a_set_point_that_is_ignored_or_refused_and_a_wrong_register_are_told() {
    for (preset, fault, told) in [
        ("watlow-f4t", "nan", "the air's temperature reads NaN"),
        ("eurotherm", "32767", "the air's temperature reads 32767"),
    ] {
        let server = Server::start("chamber.py", &["--preset", preset, "--fault", fault]);
        let error = controller("modbus-tcp", &format!("127.0.0.1:{}", server.port), preset).actual().unwrap_err();
        assert!(error.to_string().contains(told) && !error.may_pass(), "{error}");
    }
    for (fault, told) in [("ignore", "40 was sent, and 25 is read back"), ("refuse", "exception 3")] {
        let server = Server::start("chamber.py", &["--fault", fault]);
        let mut chamber = controller("modbus-tcp", &format!("127.0.0.1:{}", server.port), "watlow-f4t");
        let error = chamber.send(Celsius(40.0)).unwrap_err();
        assert!(error.to_string().contains(told) && !error.may_pass(), "{error}");
    }
    let server = Server::start("chamber.py", &[]);
    let error = controller("modbus-tcp", &format!("127.0.0.1:{}", server.port), "binder").actual().unwrap_err();
    assert!(error.to_string().contains("read register 4521: it has no such register (exception 2)"), "{error}");
}
