//! A small web server for this machine only.

use std::fs::File;
use std::io::{self, BufReader, Seek, SeekFrom};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Context, Result};

use crate::http::{Request, Response};
use crate::site::{self, Site};

/// Ports tried in turn where the user names none.
const USUAL_PORTS: std::ops::Range<u16> = 8080..8100;

/// A browser that says nothing for this long, or takes nothing, is let go.
const PATIENCE: Duration = Duration::from_secs(30);

/// A running server; dropping it stops it.
pub struct Serving {
    address: SocketAddr,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Serves the site on 127.0.0.1: on the given port (0: any), else on the first usual one that is free.
pub fn start(site: Site, port: Option<u16>) -> Result<Serving> {
    start_with(site, port, &[])
}

/// What keeps a page apart from others, so that its workers may share memory.
const ISOLATION: [(&str, &str); 2] =
    [("Cross-Origin-Opener-Policy", "same-origin"), ("Cross-Origin-Embedder-Policy", "require-corp")];

/// The same with pages that are cross-origin isolated: their avatars may have several threads.
pub fn start_isolated(site: Site, port: Option<u16>) -> Result<Serving> {
    start_with(site, port, &ISOLATION)
}

fn start_with(site: Site, port: Option<u16>, headers: &'static [(&str, &str)]) -> Result<Serving> {
    let listener = match port {
        Some(port) => listen(port).with_context(|| format!("cannot use port {port}"))?,
        None => USUAL_PORTS.chain([0]).find_map(|port| listen(port).ok()).context("no free port")?,
    };
    let address = listener.local_addr()?;
    let is_over = Arc::new(AtomicBool::new(false));
    let (site, flag) = (Arc::new(site), is_over.clone());
    let thread = thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            if flag.load(Ordering::Relaxed) {
                return;
            }
            let site = site.clone();
            // The browser may go away in the middle of a file: no error of ours.
            thread::spawn(move || converse(&stream, &site, address.port(), headers).ok());
        }
    });
    Ok(Serving { address, is_over, thread: Some(thread) })
}

impl Serving {
    /// The address of a place on this server.
    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        // Wakes the thread that waits for the next browser.
        if TcpStream::connect(self.address).is_ok()
            && let Some(thread) = self.thread.take()
        {
            // A thread that panicked has said so already.
            let _ = thread.join();
        }
    }
}

fn listen(port: u16) -> io::Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port))
}

/// One request and its answer.
fn converse(mut stream: &TcpStream, site: &Site, port: u16, headers: &[(&'static str, &str)]) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let request = Request::read(&mut BufReader::new(stream))?;
    let has_body = request.as_ref().is_none_or(|request| request.method != "HEAD");
    let response = match request {
        Some(request) => answer(&request, site, port),
        None => Response::text(400, "This is no HTTP request."),
    };
    // Nothing is cached: whoever rebuilds sees the new files. No other site may embed what is here.
    let response = response.with("Cache-Control", "no-store").with("X-Content-Type-Options", "nosniff");
    let response = response.with("Cross-Origin-Resource-Policy", "same-origin");
    let response = headers.iter().fold(response, |response, (name, value)| response.with(name, *value));
    response.write(&mut stream, has_body)
}

fn answer(request: &Request, site: &Site, port: u16) -> Response {
    if !is_for_this_machine(request.header("Host"), port) {
        // Else any site could point its own name at this address and read the answers.
        return Response::text(403, "This server answers to localhost only.");
    }
    if !matches!(request.method.as_str(), "GET" | "HEAD") {
        return Response::text(405, "Only GET and HEAD.");
    }
    if request.target == "/favicon.ico" {
        return Response::text(200, "");
    }
    let Some(path) = site.file(&request.target) else { return Response::text(404, "There is no such file.") };
    let range = request.header("Range");
    content(&path, range).unwrap_or_else(|error| Response::text(500, &format!("Cannot read the file: {error}.")))
}

fn is_for_this_machine(host: Option<&str>, port: u16) -> bool {
    host.is_some_and(|host| host == format!("127.0.0.1:{port}") || host == format!("localhost:{port}"))
}

/// What part of a file a Range header asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ByteRange {
    /// First byte and number of bytes.
    Part { start: u64, length: u64 },
    /// Beyond the end of the file.
    Unsatisfiable,
}

/// Reads a Range header with one range; any other form is ignored, as HTTP allows.
fn byte_range(text: &str, file_length: u64) -> Option<ByteRange> {
    let (first, last) = text.strip_prefix("bytes=")?.split_once('-')?;
    let (start, end) = match (first.parse::<u64>(), last.parse::<u64>()) {
        (Ok(start), Ok(last)) if last >= start => (start, last.saturating_add(1).min(file_length)),
        (Ok(start), Err(_)) if last.is_empty() => (start, file_length),
        (Err(_), Ok(length)) if first.is_empty() => (file_length.saturating_sub(length), file_length),
        _ => return None,
    };
    if start >= end { Some(ByteRange::Unsatisfiable) } else { Some(ByteRange::Part { start, length: end - start }) }
}

fn content(path: &Path, range: Option<&str>) -> io::Result<Response> {
    let mut file = File::open(path)?;
    let file_length = file.metadata()?.len();
    let media_type = site::media_type(path);
    let response = match range.and_then(|text| byte_range(text, file_length)) {
        None => Response::new(200, media_type, file_length, file),
        Some(ByteRange::Unsatisfiable) => Response::text(416, "The range lies beyond the end of the file.")
            .with("Content-Range", format!("bytes */{file_length}")),
        Some(ByteRange::Part { start, length }) => {
            file.seek(SeekFrom::Start(start))?;
            let range = format!("bytes {start}-{}/{file_length}", start + length - 1);
            Response::new(206, media_type, length, file).with("Content-Range", range)
        }
    };
    Ok(response.with("Accept-Ranges", "bytes"))
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};

    use super::*;

    fn serving() -> Serving {
        start(Site::new(Path::new("tests/pages/tiny.html")).unwrap(), Some(0)).unwrap()
    }

    fn ask(serving: &Serving, request: &str) -> String {
        let mut stream = TcpStream::connect(serving.address).unwrap();
        let request = request.replace("PORT", &serving.address.port().to_string());
        write!(stream, "{request}\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn files_come_whole_with_their_type_and_without_caching() {
        let answer = ask(&serving(), "GET /web/package.json HTTP/1.1\r\nHost: localhost:PORT");
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert!(answer.contains("Content-Type: application/json") && answer.contains("Cache-Control: no-store"));
        assert!(answer.trim_end().ends_with('}') && answer.contains("crease-avatar"));
    }

    #[test]
    fn only_isolated_pages_are_told_to_be() {
        let site = || Site::new(Path::new("tests/pages/tiny.html")).unwrap();
        let request = "HEAD /web/package.json HTTP/1.1\r\nHost: localhost:PORT";
        let isolated = ask(&start_isolated(site(), Some(0)).unwrap(), request);
        assert!(isolated.contains("Cross-Origin-Opener-Policy: same-origin\r\n"), "{isolated}");
        assert!(isolated.contains("Cross-Origin-Embedder-Policy: require-corp\r\n"), "{isolated}");
        assert!(!ask(&serving(), request).contains("Embedder"));
    }

    #[test]
    fn a_range_is_a_part_of_the_file() {
        let answer = ask(&serving(), "GET /web/package.json HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nRange: bytes=0-1");
        assert!(answer.starts_with("HTTP/1.1 206") && answer.contains("Content-Range: bytes 0-1/"), "{answer}");
        assert!(answer.ends_with("\r\n\r\n{\n"), "{answer}");
    }

    #[test]
    fn a_range_beyond_the_end_tells_where_that_is() {
        let answer = ask(&serving(), "GET /web/package.json HTTP/1.1\r\nHost: localhost:PORT\r\nRange: bytes=999999-");
        let length = std::fs::metadata(crate::workspace::web().join("package.json")).unwrap().len();
        assert!(answer.starts_with("HTTP/1.1 416"), "{answer}");
        assert!(answer.contains(&format!("Content-Range: bytes */{length}\r\n")), "{answer}");
    }

    #[test]
    fn only_this_machine_is_listened_to() {
        assert!(serving().address.ip().is_loopback());
        for port in [None, Some(0)] {
            let serving = start(Site::new(Path::new("tests/pages/tiny.html")).unwrap(), port).unwrap();
            assert!(serving.address.ip().is_loopback());
        }
    }

    #[test]
    fn no_way_leads_out_of_the_site() {
        let serving = serving();
        for path in [
            "/../Cargo.toml",
            "/web/../../etc/passwd",
            "/web/%2e%2e/Cargo.toml",
            "/web/..%2f..%2fetc/passwd",
            "/web/%5c..%5cCargo.toml",
            "//etc/passwd",
            "/%2fetc%2fpasswd",
            "file:///etc/passwd",
            "http://localhost/etc/passwd",
            "/web/.npmrc",
            "/.git/config",
        ] {
            let answer = ask(&serving, &format!("GET {path} HTTP/1.1\r\nHost: localhost:PORT"));
            assert!(answer.starts_with("HTTP/1.1 404"), "{path}: {answer}");
        }
    }

    #[test]
    fn a_head_has_all_headers_and_no_body() {
        let serving = serving();
        let [get, head] = ["GET", "HEAD"]
            .map(|method| ask(&serving, &format!("{method} /web/package.json HTTP/1.1\r\nHost: localhost:PORT")));
        let (headers, body) = get.split_once("\r\n\r\n").unwrap();
        assert_eq!(head.strip_suffix("\r\n\r\n"), Some(headers));
        for header in
            ["Accept-Ranges: bytes", "X-Content-Type-Options: nosniff", "Cross-Origin-Resource-Policy: same-origin"]
        {
            assert!(headers.contains(header), "{header}");
        }
        assert!(headers.contains(&format!("Content-Length: {}", body.len())));
    }

    #[test]
    fn other_names_for_this_machine_are_refused() {
        for host in ["example.org", "example.org:PORT", "localhost", "localhost:1"] {
            let answer = ask(&serving(), &format!("GET /web/package.json HTTP/1.1\r\nHost: {host}"));
            assert!(answer.starts_with("HTTP/1.1 403"), "{host}: {answer}");
        }
        assert!(!is_for_this_machine(None, 8080));
    }

    #[test]
    fn what_is_not_there_and_what_is_not_allowed_say_so() {
        assert!(ask(&serving(), "GET /Cargo.toml HTTP/1.1\r\nHost: localhost:PORT").starts_with("HTTP/1.1 404"));
        assert!(ask(&serving(), "DELETE / HTTP/1.1\r\nHost: localhost:PORT").starts_with("HTTP/1.1 405"));
    }

    #[test]
    fn many_browsers_are_served_while_others_say_nothing() {
        let serving = serving();
        let silent: Vec<_> = (0..16).map(|_| TcpStream::connect(serving.address).unwrap()).collect();
        for _ in 0..16 {
            assert!(ask(&serving, "HEAD / HTTP/1.1\r\nHost: localhost:PORT").starts_with("HTTP/1.1 4"));
        }
        drop(silent);
    }

    #[test]
    fn ranges_have_every_form_that_browsers_send() {
        let part = |start, length| Some(ByteRange::Part { start, length });
        assert_eq!(byte_range("bytes=2-5", 10), part(2, 4));
        assert_eq!(byte_range("bytes=2-", 10), part(2, 8));
        assert_eq!(byte_range("bytes=-3", 10), part(7, 3));
        assert_eq!(byte_range("bytes=2-99", 10), part(2, 8));
        assert_eq!(byte_range("bytes=10-", 10), Some(ByteRange::Unsatisfiable));
        for other in ["bytes=5-2", "bytes=-", "bytes=a-b", "items=0-1", "bytes=0-1,3-4"] {
            assert_eq!(byte_range(other, 10), None, "{other}");
        }
    }

    #[test]
    fn a_taken_port_is_an_error_only_when_it_was_asked_for() {
        let first = serving();
        let site = || Site::new(Path::new("tests/pages/tiny.html")).unwrap();
        assert!(start(site(), Some(first.address.port())).is_err());
        assert!(start(site(), None).is_ok());
    }
}
