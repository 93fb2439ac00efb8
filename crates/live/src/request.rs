//! What a request asks for, and whether it gets it.

use std::net::SocketAddr;

use crate::guard::Guard;

/// A browser sends some twenty.
const HEADERS: usize = 64;

/// What there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// The page.
    Page,
    /// Its parts as they come.
    Events,
}

/// Why a request gets nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// It is no request.
    Malformed,
    /// It does not know the token.
    WithoutToken,
    /// It names another host.
    OtherHost,
    /// A page of another site sent it.
    OtherSite,
    /// There is no such thing here.
    NotHere,
    /// Something is to be changed, and nothing can be.
    OnlyRead,
    /// Too many look on.
    Full,
}

impl Refusal {
    /// The status line's number and words, and a sentence for people.
    pub(crate) const fn status(self) -> (&'static str, &'static str) {
        match self {
            Self::Malformed => ("400 Bad Request", "This is no request that is understood here."),
            Self::WithoutToken => {
                ("401 Unauthorized", "The address is not whole: open the one that was printed, with its token.")
            }
            Self::OtherHost => (
                "403 Forbidden",
                "The address names another machine than the one that answers: open the one that was printed.",
            ),
            Self::OtherSite => ("403 Forbidden", "Pages of other sites get nothing here."),
            Self::NotHere => ("404 Not Found", "There is no such page here."),
            Self::OnlyRead => ("405 Method Not Allowed", "There is nothing here but to look on."),
            Self::Full => ("503 Service Unavailable", "Too many look on: close a page elsewhere."),
        }
    }
}

/// What a request's head, up to its empty line, asks for; `local` is where it arrived.
///
/// # Errors
/// [`Refusal`].
pub fn decide(head: &[u8], guard: &Guard, local: SocketAddr) -> Result<Wanted, Refusal> {
    let mut headers = [httparse::EMPTY_HEADER; HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        Ok(httparse::Status::Complete(_)) => {}
        Ok(httparse::Status::Partial) | Err(_) => return Err(Refusal::Malformed),
    }
    let header = |name: &str| {
        let mut values = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
        let value = values.next().map(|header| header.value);
        // Of two nobody knows which a proxy believes.
        if values.next().is_some() { Some(&b"\xff"[..]) } else { value }
    };
    let text = |name: &str| header(name).map(|value| std::str::from_utf8(value).unwrap_or("\u{fffd}").trim());
    let host = text("host").ok_or(Refusal::Malformed)?;
    if !guard.is_here(host, local) {
        return Err(Refusal::OtherHost);
    }
    if text("origin").is_some_and(|origin| !is_of(origin, host)) {
        return Err(Refusal::OtherSite);
    }
    let (path, query) =
        request.path.unwrap_or_default().split_once('?').unwrap_or((request.path.unwrap_or_default(), ""));
    let token = query.split('&').find_map(|pair| pair.strip_prefix("token="));
    if !guard.knows(token) {
        return Err(Refusal::WithoutToken);
    }
    let wanted = match path {
        "/" => Wanted::Page,
        "/events" => Wanted::Events,
        _ => return Err(Refusal::NotHere),
    };
    if request.method != Some("GET") {
        return Err(Refusal::OnlyRead);
    }
    // A link to the page may stand anywhere; its parts are for the page.
    let from_elsewhere = text("sec-fetch-site").is_some_and(|site| !["same-origin", "none"].contains(&site));
    if wanted == Wanted::Events && from_elsewhere {
        return Err(Refusal::OtherSite);
    }
    Ok(wanted)
}

/// Whether an origin is the host that was asked; a proxy may stand before it with TLS.
fn is_of(origin: &str, host: &str) -> bool {
    let authority = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    authority.is_some_and(|authority| authority.eq_ignore_ascii_case(host))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(lines: &[&str], guard: &Guard) -> Result<Wanted, Refusal> {
        let head = lines.join("\r\n") + "\r\n\r\n";
        decide(head.as_bytes(), guard, "127.0.0.1:5495".parse().unwrap())
    }

    #[test]
    fn the_page_and_its_parts_are_there_and_nothing_else() {
        let open = Guard::default();
        let here = "Host: 127.0.0.1:5495";
        assert_eq!(ask(&["GET / HTTP/1.1", here], &open), Ok(Wanted::Page));
        assert_eq!(ask(&["GET /events?x=1 HTTP/1.1", here], &open), Ok(Wanted::Events));
        assert_eq!(ask(&["GET /favicon.ico HTTP/1.1", here], &open), Err(Refusal::NotHere));
        assert_eq!(ask(&["GET /../etc/passwd HTTP/1.1", here], &open), Err(Refusal::NotHere));
        assert_eq!(ask(&["POST / HTTP/1.1", here], &open), Err(Refusal::OnlyRead));
        for lines in [&["GET / HTTP/1.1"][..], &["\u{16}\u{3}\u{1}"], &["GET /"], &["GET / HTTP/1.1", "no colon"]] {
            assert_eq!(ask(lines, &open), Err(Refusal::Malformed), "{lines:?}");
        }
    }

    #[test]
    fn what_is_asked_whole_is_no_request_when_it_is_cut() {
        let seeds = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/request");
        let guard = Guard { token: Some("0123456789abcdef".into()), name: None };
        let local = "192.168.1.7:5495".parse().unwrap();
        for (file, wanted) in [("events.bin", Wanted::Events), ("page.bin", Wanted::Page)] {
            let head = std::fs::read(seeds.join(file)).unwrap();
            assert_eq!(decide(&head, &guard, local), Ok(wanted));
            for cut in 0..head.len() {
                assert_eq!(decide(&head[..cut], &guard, local), Err(Refusal::Malformed), "{file}, {cut} bytes");
            }
        }
    }

    #[test]
    fn without_the_token_there_is_nothing_not_even_what_is_missing() {
        let guard = Guard { token: Some("abc".into()), name: None };
        let here = "Host: localhost:5495";
        for path in ["/", "/events", "/elsewhere", "/?token=", "/?token=abd", "/?Token=abc", "/token=abc"] {
            let line = format!("GET {path} HTTP/1.1");
            assert_eq!(ask(&[&line, here], &guard), Err(Refusal::WithoutToken), "{path}");
        }
        assert_eq!(ask(&["GET /?token=abc HTTP/1.1", here], &guard), Ok(Wanted::Page));
    }

    #[test]
    fn other_hosts_and_other_sites_get_nothing() {
        let open = Guard::default();
        let rebound = ask(&["GET /events HTTP/1.1", "Host: evil.example:5495"], &open);
        assert_eq!(rebound, Err(Refusal::OtherHost));
        let twice = ask(&["GET / HTTP/1.1", "Host: localhost", "Host: localhost"], &open);
        assert_eq!(twice, Err(Refusal::OtherHost));
        let here = "Host: localhost:5495";
        for origin in ["http://evil.example", "null", "http://localhost:8080", "localhost:5495"] {
            let line = format!("Origin: {origin}");
            assert_eq!(ask(&["GET /events HTTP/1.1", here, &line], &open), Err(Refusal::OtherSite), "{origin}");
        }
        let own = ask(&["GET /events HTTP/1.1", here, "Origin: http://localhost:5495"], &open);
        assert_eq!(own, Ok(Wanted::Events));
        let embedded = |path: &str| ask(&[&format!("GET {path} HTTP/1.1"), here, "Sec-Fetch-Site: cross-site"], &open);
        assert_eq!(embedded("/events"), Err(Refusal::OtherSite));
        // Followed from a message, say.
        assert_eq!(embedded("/"), Ok(Wanted::Page));
    }
}
