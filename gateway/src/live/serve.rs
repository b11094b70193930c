//! Shows a run to other programs of this computer: a local socket for `status`, and on request a page
//! on 127.0.0.1. Both only read. Their threads end with the process.

use serde_json::Value;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::time::Duration;

use super::error::{LiveError, LiveFault};

const PAGE: &str = include_str!("page.html");
/// Longest wait for a reader that is slow, and longest request.
const LIMIT: Duration = Duration::from_secs(1);
const LONGEST: usize = 8192;
/// The page holds all that it needs and asks nobody else.
const HEAD: &str =
    "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
     Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src \
     'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'\r\n";

/// Serves the text of `status` to `flexhex-gateway status` on this interface.
pub fn serve_status(
    interface: &str,
    status: impl Fn() -> String + Send + 'static,
) -> Result<(), LiveError> {
    let at = |fault: LiveFault| fault.of(interface);
    let listener = UnixListener::bind_addr(&address(interface).map_err(at)?);
    let listener = listener.map_err(LiveFault::NotServed).map_err(at)?;
    let served = spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let _ = stream.set_write_timeout(Some(LIMIT));
            // the reader may be gone
            let _ = stream.write_all(status().as_bytes());
        }
    });
    served.map_err(at)
}

/// What the gateway on this interface shows; None where none runs.
pub fn ask(interface: &str) -> Result<Option<Value>, LiveError> {
    let at = |fault: LiveFault| fault.of(interface);
    let address = address(interface).map_err(at)?;
    let Ok(stream) = UnixStream::connect_addr(&address) else { return Ok(None) };
    let text = read(stream).map_err(LiveFault::NoAnswer).map_err(at)?;
    serde_json::from_str(&text).map(Some).map_err(|why| at(LiveFault::NoJson(why)))
}

fn read(mut stream: UnixStream) -> io::Result<String> {
    stream.set_read_timeout(Some(2 * LIMIT))?;
    let mut text = String::new();
    stream.read_to_string(&mut text)?;
    Ok(text)
}

/// An abstract name, which leaves no file and is known in this network namespace only.
fn address(interface: &str) -> Result<SocketAddr, LiveFault> {
    SocketAddr::from_abstract_name(format!("flexhex-gateway-status {interface}"))
        .map_err(LiveFault::BadName)
}

/// Serves the page and `/status.json` on this port of 127.0.0.1.
pub fn serve_page(
    interface: &str,
    port: u16,
    status: impl Fn() -> String + Send + 'static,
) -> Result<(), LiveError> {
    let at = |fault: LiveFault| fault.of(interface);
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let listener = listener.map_err(|why| at(LiveFault::NoPage(port, why)))?;
    let served = spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let _ = stream.set_read_timeout(Some(LIMIT));
            let _ = stream.set_write_timeout(Some(LIMIT));
            let head = request(&mut stream);
            // browsers open connections for later: an answer now would be that to a later request
            if !head.is_empty() {
                // the reader may be gone
                let _ = stream.write_all(answer(&head, port, &status).as_bytes());
            }
        }
    });
    served.map_err(at)
}

fn spawn(work: impl FnOnce() + Send + 'static) -> Result<(), LiveFault> {
    let thread = std::thread::Builder::new().name("status".to_owned()).spawn(work);
    thread.map(drop).map_err(LiveFault::NoThread)
}

/// The lines of a request up to the empty one. One read: a local browser sends them at once.
fn request(stream: &mut impl Read) -> Vec<String> {
    let mut bytes = [0; LONGEST];
    let length = stream.read(&mut bytes).unwrap_or(0);
    let text = String::from_utf8_lossy(&bytes[..length]);
    text.lines().take_while(|line| !line.is_empty()).map(str::to_owned).collect()
}

fn answer(head: &[String], port: u16, status: &impl Fn() -> String) -> String {
    let mut words = head.first().map_or("", String::as_str).split(' ');
    let (method, path) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    let host = head.iter().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("host").then(|| value.trim().to_owned())
    });
    // a page of another site that calls itself 127.0.0.1 by its name server is no reader
    let ours = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    if !host.is_some_and(|host| ours.contains(&host)) {
        return response("403 Forbidden", "text/plain", "only for this computer\n");
    }
    match (method, path) {
        ("GET", "/") => response("200 OK", "text/html", PAGE),
        ("GET", "/status.json") => response("200 OK", "application/json", &status()),
        ("GET", _) => response("404 Not Found", "text/plain", "there are / and /status.json\n"),
        _ => response("405 Method Not Allowed", "text/plain", "this page only reads\n"),
    }
}

fn response(status: &str, kind: &str, body: &str) -> String {
    let length = body.len();
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {length}\r\n\
         {HEAD}\r\n{body}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn response_to(text: &str) -> String {
        answer(&request(&mut text.as_bytes()), 4850, &|| "{}".to_owned())
    }

    #[test]
    fn only_get_of_this_computer_is_answered() {
        let host = "Host: 127.0.0.1:4850\r\n\r\n";
        for (line, wanted) in [
            ("GET / HTTP/1.1", "200 OK"),
            ("GET /status.json HTTP/1.1", "200 OK"),
            ("GET /../etc/passwd HTTP/1.1", "404"),
            ("POST / HTTP/1.1", "405"),
            ("DELETE /status.json HTTP/1.1", "405"),
            ("", "405"),
        ] {
            let response = response_to(&format!("{line}\r\n{host}"));
            let wanted = if line.is_empty() { "403" } else { wanted };
            assert!(response.starts_with(&format!("HTTP/1.1 {wanted}")), "{line}: {response}");
        }
        assert!(response_to("GET /status.json HTTP/1.1\r\nhOST:localhost:4850\r\n\r\n")
            .ends_with("\r\n\r\n{}"));
        for other in ["", "Host: evil.example:4850\r\n", "Host: 127.0.0.1:80\r\n"] {
            let response = response_to(&format!("GET /status.json HTTP/1.1\r\n{other}\r\n"));
            assert!(response.starts_with("HTTP/1.1 403"), "{other}: {response}");
        }
    }

    #[test]
    fn a_connection_without_a_request_is_closed_without_an_answer() {
        let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let port = free.local_addr().unwrap().port();
        drop(free);
        serve_page("test0", port, || "{}".to_owned()).unwrap();
        let mut said = String::new();
        let mut stream = std::net::TcpStream::connect((Ipv4Addr::LOCALHOST, port)).unwrap();
        stream.read_to_string(&mut said).unwrap();
        assert_eq!(said, "");
    }

    #[test]
    fn the_page_asks_nobody_else() {
        for word in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }

    #[test]
    fn a_request_without_end_is_cut() {
        let mut endless = std::io::repeat(b'a');
        assert_eq!(request(&mut endless).concat().len(), LONGEST);
    }
}
