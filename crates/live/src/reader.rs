//! One who looks on: its request, and what it is sent.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::guard::Guard;
use crate::parts::Parts;
use crate::request::{Refusal, Wanted, decide};

/// How long a head may be, and how long it may take.
const LONGEST_HEAD: usize = 8192;
const HEAD_WITHIN: Duration = Duration::from_secs(10);
/// A reader that takes nothing for so long is gone; a telephone that wakes opens the page's connection again.
const WRITTEN_WITHIN: Duration = Duration::from_secs(20);
/// A line that says nothing, so that whoever stands between does not cut it.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Readers at a time: each is a thread.
const MOST_READERS: usize = 64;
/// How soon a browser opens a lost connection again, milliseconds.
const AGAIN_AFTER_MS: u32 = 2000;

/// What every answer says: nothing but this page's own, kept nowhere, shown in no other page.
const ALWAYS: &str = "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\nContent-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; \
    script-src 'unsafe-inline'; img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n";

/// Answers a request; one for the events until its reader goes or the end has come. `heard` is told when it has said what it wants.
///
/// # Errors
/// The reader is gone.
pub fn serve(mut stream: TcpStream, guard: &Guard, page: &str, parts: &Parts, heard: impl FnOnce()) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITTEN_WITHIN))?;
    let local = stream.local_addr()?;
    let head = head(&mut stream)?;
    heard();
    match decide(&head, guard, local) {
        Ok(Wanted::Page) => whole(&mut stream, "200 OK", "text/html; charset=utf-8", page),
        Ok(Wanted::Events) if parts.enter(MOST_READERS) => {
            let served = events(&mut stream, page, parts);
            parts.leave();
            served
        }
        Ok(Wanted::Events) => refuse(&mut stream, Refusal::Full),
        Err(refusal) => refuse(&mut stream, refusal),
    }
}

/// The bytes up to the empty line; what comes after it is nobody's.
fn head(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let until = Instant::now() + HEAD_WITHIN;
    let mut head = Vec::new();
    let mut buffer = [0; 1024];
    while !head.windows(4).any(|four| four == b"\r\n\r\n") && head.len() < LONGEST_HEAD {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut buffer)? {
            0 => break,
            read => head.extend_from_slice(&buffer[..read]),
        }
    }
    Ok(head)
}

fn refuse(stream: &mut TcpStream, refusal: Refusal) -> io::Result<()> {
    let (status, told) = refusal.status();
    whole(stream, status, "text/plain; charset=utf-8", told)
}

fn whole(stream: &mut TcpStream, status: &str, kind: &str, body: &str) -> io::Result<()> {
    let length = body.len();
    stream.write_all(
        format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{ALWAYS}\r\n{body}")
            .as_bytes(),
    )?;
    stream.flush()
}

fn events(stream: &mut TcpStream, page: &str, parts: &Parts) -> io::Result<()> {
    // First, which page the parts are of: an open page may be that of a server that was here before.
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{ALWAYS}\r\nretry: {AGAIN_AFTER_MS}\nevent: page\ndata: {:016x}\n\n",
        mark(page)
    );
    stream.write_all(head.as_bytes())?;
    let mut changes = 0;
    loop {
        let news = parts.since(changes, KEEP_ALIVE);
        let mut text = String::new();
        for (id, html) in &news.parts {
            event(&mut text, id, html);
        }
        if news.is_over {
            text.push_str("event: over\ndata:\n\n");
        } else if text.is_empty() {
            text.push_str(":\n\n");
        }
        stream.write_all(text.as_bytes())?;
        stream.flush()?;
        changes = news.changes;
        if news.is_over || news.is_closed {
            return Ok(());
        }
    }
}

/// Tells pages apart.
fn mark(page: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    page.hash(&mut hasher);
    hasher.finish()
}

/// A part as an event: its id in the first line, its HTML in the others.
fn event(text: &mut String, id: &str, html: &str) {
    for line in std::iter::once(id).chain(html.split(['\n', '\r'])) {
        text.push_str("data: ");
        text.push_str(line);
        text.push('\n');
    }
    text.push('\n');
}
