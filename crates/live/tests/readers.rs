//! What readers get, and that nobody waits for those that do not read.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use zerorate_live::{Listen, Live};

const PAGE: &str = "<!DOCTYPE html><title>Run</title>";

fn live(on: &str, parts: impl Fn() -> Vec<(&'static str, String)> + Send + Sync + 'static) -> Live {
    let listen: Listen = on.parse().unwrap();
    Live::open(&listen, PAGE.to_owned(), parts).unwrap()
}

/// Asks for something, and gives the stream.
fn ask(live: &Live, path: &str, more: &str) -> TcpStream {
    let port = live.address().port();
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{more}\r\n").unwrap();
    stream
}

fn answer(live: &Live, path: &str, more: &str) -> String {
    let mut text = String::new();
    ask(live, path, more).read_to_string(&mut text).unwrap();
    text
}

#[test]
fn the_page_is_itself_and_lets_nothing_in_from_elsewhere() {
    let live = live("127.0.0.1:0", Vec::new);
    let answer = answer(&live, "/", "");
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with(PAGE), "{answer}");
    for header in ["default-src 'none'", "connect-src 'self'", "Cache-Control: no-store", "frame-ancestors 'none'"] {
        assert!(answer.contains(header), "{header}");
    }
    assert!(!answer.contains("Access-Control"));
    assert_eq!(live.url(), format!("http://{}/", live.address()));
}

#[test]
fn beyond_loopback_a_token_is_needed() {
    let live = live("0.0.0.0:0", Vec::new);
    let (_, token) = live.url().rsplit_once("token=").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    assert_eq!(token.len(), 32);
    assert!(answer(&live, "/", "").starts_with("HTTP/1.1 401 "));
    assert!(answer(&live, "/events", "").starts_with("HTTP/1.1 401 "));
    assert!(answer(&live, &format!("/?token={token}"), "").starts_with("HTTP/1.1 200 "));
    assert!(answer(&live, &format!("/?token={token}"), "Origin: http://evil.example\r\n").starts_with("HTTP/1.1 403 "));
}

#[test]
fn connections_that_say_nothing_keep_nobody_out() {
    let live = live("127.0.0.1:0", Vec::new);
    // More than are taken at a time.
    let silent: Vec<TcpStream> = (0..300).map(|_| TcpStream::connect(live.address()).unwrap()).collect();
    assert!((0..5).all(|_| answer(&live, "/", "").starts_with("HTTP/1.1 200 ")));
    drop(silent);
}

#[test]
fn the_first_event_tells_pages_apart() {
    let first = |page: &str| {
        let live =
            Live::open(&"127.0.0.1:0".parse().unwrap(), page.to_owned(), || vec![("now", "1".to_owned())]).unwrap();
        let lines = BufReader::new(ask(&live, "/events", "")).lines().map(Result::unwrap);
        let [event, mark] =
            lines.skip_while(|line| !line.starts_with("event: ")).take(2).collect::<Vec<_>>().try_into().unwrap();
        assert_eq!(event, "event: page");
        mark
    };
    assert_eq!(first(PAGE), first(PAGE));
    assert_ne!(first(PAGE), first("<!DOCTYPE html><title>Another run</title>"));
}

#[test]
fn a_part_with_lines_is_one_event() {
    let live = live("127.0.0.1:0", || vec![("notes", "<pre>a\nb</pre>".to_owned())]);
    let mut lines = BufReader::new(ask(&live, "/events", "")).lines().map(Result::unwrap);
    assert!(lines.any(|line| line == "data: notes"));
    assert_eq!(lines.by_ref().take(3).collect::<Vec<_>>(), ["data: <pre>a", "data: b</pre>", ""]);
}

#[test]
fn nothing_is_made_while_nobody_looks_on() {
    let made = Arc::new(AtomicUsize::new(0));
    let own = Arc::clone(&made);
    let live = live("127.0.0.1:0", move || vec![("now", own.fetch_add(1, Ordering::SeqCst).to_string())]);
    answer(&live, "/", "");
    assert_eq!(made.load(Ordering::SeqCst), 0);
    let mut lines = BufReader::new(ask(&live, "/events", "")).lines().map(Result::unwrap);
    assert!(lines.any(|line| line == "data: 0"));
}

/// Twenty readers of parts of a megabyte, of which ten stop reading: those that read get the end, and nobody waits.
#[test]
fn who_does_not_read_delays_nobody() {
    let turn = Arc::new(AtomicUsize::new(0));
    let own = Arc::clone(&turn);
    let large = move || {
        let turn = own.fetch_add(1, Ordering::SeqCst);
        vec![("figure", format!("{turn}{}", "x".repeat(1 << 20))), ("now", format!("turn {turn}"))]
    };
    let live = live("127.0.0.1:0", large);
    let asleep: Vec<TcpStream> = (0..10).map(|_| ask(&live, "/events", "")).collect();
    let awake: Vec<_> = (0..10)
        .map(|_| {
            let mut stream = ask(&live, "/events", "");
            std::thread::spawn(move || {
                let mut text = String::new();
                stream.read_to_string(&mut text).map(|_| text)
            })
        })
        .collect();
    while turn.load(Ordering::SeqCst) < 3 {
        std::thread::sleep(Duration::from_millis(20));
    }
    live.finish();
    let last = turn.load(Ordering::SeqCst) - 1;
    for reader in awake {
        let text = reader.join().unwrap().unwrap();
        assert!(text.contains(&format!("data: turn {last}\n")) && text.ends_with("event: over\ndata:\n\n"));
    }
    drop(asleep);
}

#[test]
fn what_is_no_request_is_told_so() {
    let live = live("127.0.0.1:0", Vec::new);
    let mut stream = TcpStream::connect(live.address()).unwrap();
    stream.write_all(b"\x16\x03\x01\x02\x00 hello\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 400 "), "{answer}");
}
