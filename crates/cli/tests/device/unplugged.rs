//! Lines that damage, boards that go away, hang, or are none.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::bench;
use crate::board::{Board, await_end, await_that};

fn monitor(board: &Board, folder: &Path) -> (Child, impl Iterator<Item = String> + use<>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["device", "--port", &board.port, "monitor"])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    (child, lines)
}

fn told(child: &mut Child) -> String {
    let mut text = String::new();
    child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    text
}

#[test]
fn a_deploy_over_a_line_that_damages_bytes_ends_whole_or_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("record.bin"), bench::device_record()).unwrap();
    let mut board = Board::start("pty", &[], folder.path());
    let mut deployed = 0;
    for _ in 0..3 {
        board.order("byte-errors 0.001");
        let ran = board.device(&["deploy", "record.bin"], folder.path());
        assert!(ran.code == Some(0) || ran.err.contains("error: "), "{ran:?}");
        deployed += u32::from(ran.code == Some(0));
        board.order("mend");
        let read = board.device(&["read", "back.bin"], folder.path());
        // Never a wrong record: none, or the one that was sent.
        if read.code == Some(0) {
            assert_eq!(fs::read(folder.path().join("back.bin")).unwrap(), bench::device_record());
        } else {
            read.ends(1, &["no calibration stored"]);
        }
    }
    assert!(deployed > 0, "a line that damages one byte in a thousand can be worked with");
}

#[test]
fn a_socket_that_closes_ends_the_monitor() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::start("tcp:127.0.0.1:0", &["--speed", "30"], folder.path());
    let (mut child, mut lines) = monitor(&board, folder.path());
    lines.next().unwrap();
    board.kill();
    assert_eq!(await_end(&mut child), Some(2));
    let text = told(&mut child);
    assert!(text.contains("the line to the device is gone") && text.contains("cable and power"), "{text}");
}

#[test]
fn a_board_that_hangs_is_an_error_and_can_be_used_again() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::start("pty", &["--speed", "30"], folder.path());
    let (mut child, mut lines) = monitor(&board, folder.path());
    lines.next().unwrap();
    board.signal("STOP");
    assert_eq!(await_end(&mut child), Some(2));
    let text = told(&mut child);
    assert!(text.contains("the device says nothing"), "{text}");
    board.device(&["info"], folder.path()).ends(2, &["the device says nothing"]);
    board.signal("CONT");
    board.device(&["monitor", "--groups", "2"], folder.path()).ends(0, &["axis=x"]);
}

#[test]
fn a_monitor_whose_lines_nobody_reads_any_more_is_ended_by_ctrl_c() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::start("pty", &["--speed", "30"], folder.path());
    let (mut child, mut lines) = monitor(&board, folder.path());
    assert_eq!(lines.by_ref().take(200).count(), 200);
    crate::board::send("INT", child.id());
    // Nobody reads on: the rest must not hold it up.
    drop(lines);
    assert_eq!(await_end(&mut child), Some(0));
}

#[test]
fn ctrl_c_ends_the_monitor_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::start("pty", &["--speed", "30"], folder.path());
    let (mut child, mut lines) = monitor(&board, folder.path());
    lines.next().unwrap();
    crate::board::send("INT", child.id());
    lines.for_each(drop);
    assert_eq!(await_end(&mut child), Some(0));
    // It had started the acquisition, and has stopped it.
    await_that("the acquisition stands still", || board.order("status").contains("stands still"));
}

#[test]
fn what_is_no_board_is_told_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let run = |port: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(["device", "--port", port, "info"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    fs::write(folder.path().join("file"), "").unwrap();
    let closed = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    for (port, part) in [
        ("serial:/dev/no-such-port".to_owned(), "plugged in?"),
        (format!("serial:{}", folder.path().join("file").display()), "no serial port"),
        (format!("tcp:{closed}"), "nothing listens there"),
        ("usb".to_owned(), "serial:PATH"),
    ] {
        let text = run(&port);
        assert!(text.contains(part), "{port}: {text}");
    }
    // Somebody listens, and is no board: silent, or talking about something else.
    let silent = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let text = run(&format!("tcp:{}", silent.local_addr().unwrap()));
    assert!(text.contains("the device says nothing"), "{text}");
    let chatty = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = chatty.local_addr().unwrap();
    std::thread::spawn(move || {
        let (mut stream, _) = chatty.accept().unwrap();
        while std::io::Write::write_all(&mut stream, b"login: \0\x07hello\0").is_ok() {
            std::thread::sleep(Duration::from_millis(50));
        }
    });
    let text = run(&format!("tcp:{address}"));
    assert!(text.contains("no message is whole"), "{text}");
}
