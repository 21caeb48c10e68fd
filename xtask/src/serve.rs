//! A small web server for this machine only.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use anyhow::{Context, Result, anyhow};
use tiny_http::{Header, Method, Request, Response, ResponseBox, Server, StatusCode};

use crate::site::{self, Site};

const THREADS: usize = 4;

/// Ports tried in turn where the user names none.
const USUAL_PORTS: std::ops::Range<u16> = 8080..8100;

/// A running server; dropping it stops it.
pub struct Serving {
    server: Arc<Server>,
    address: SocketAddr,
    threads: Vec<JoinHandle<()>>,
}

/// Serves the site on 127.0.0.1: on the given port (0: any), else on the first usual one that is free.
pub fn start(site: Site, port: Option<u16>) -> Result<Serving> {
    let listener = match port {
        Some(port) => listen(port).with_context(|| format!("cannot use port {port}"))?,
        None => USUAL_PORTS.chain([0]).find_map(|port| listen(port).ok()).context("no free port")?,
    };
    let address = listener.local_addr()?;
    let server = Server::from_listener(listener, None).map_err(|error| anyhow!("cannot start the server: {error}"))?;
    let (server, site) = (Arc::new(server), Arc::new(site));
    let threads = (0..THREADS)
        .map(|_| {
            let (server, site) = (server.clone(), site.clone());
            thread::spawn(move || {
                for request in server.incoming_requests() {
                    let response = answer(&request, &site, address.port());
                    // The browser may have gone away in the middle of a file.
                    let _ = request.respond(response);
                }
            })
        })
        .collect();
    Ok(Serving { server, address, threads })
}

impl Serving {
    /// The address of a place on this server.
    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        for _ in &self.threads {
            self.server.unblock();
        }
        for thread in self.threads.drain(..) {
            // A thread that panicked has said so already.
            let _ = thread.join();
        }
    }
}

fn listen(port: u16) -> std::io::Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port))
}

fn answer(request: &Request, site: &Site, port: u16) -> ResponseBox {
    if !is_for_this_machine(header(request, "Host"), port) {
        // Else any site could point its own name at this address and read the answers.
        return plain(403, "This server answers to localhost only.");
    }
    if !matches!(request.method(), Method::Get | Method::Head) {
        return plain(405, "Only GET and HEAD.");
    }
    if request.url() == "/favicon.ico" {
        return plain(204, "");
    }
    match site.file(request.url()) {
        None => plain(404, "There is no such file."),
        Some(path) => {
            let opened = File::open(&path).and_then(|file| file.metadata().map(|data| (file, data.len())));
            match opened {
                Ok((file, length)) => {
                    let range = header(request, "Range").and_then(|text| byte_range(text, length));
                    content(file, length, range, site::media_type(&path))
                }
                Err(error) => plain(500, &format!("Cannot read the file: {error}.")),
            }
        }
    }
}

fn header<'a>(request: &'a Request, name: &'static str) -> Option<&'a str> {
    request.headers().iter().find(|header| header.field.equiv(name)).map(|header| header.value.as_str())
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

fn content(mut file: File, file_length: u64, range: Option<ByteRange>, media_type: &str) -> ResponseBox {
    let (status, start, length) = match range {
        None => (200, 0, file_length),
        Some(ByteRange::Part { start, length }) => (206, start, length),
        Some(ByteRange::Unsatisfiable) => return plain(416, "The range lies beyond the end of the file."),
    };
    if let Err(error) = file.seek(SeekFrom::Start(start)) {
        return plain(500, &format!("Cannot read the file: {error}."));
    }
    let mut headers = common_headers(media_type);
    headers.push(field("Accept-Ranges", "bytes"));
    if status == 206 {
        headers.push(field("Content-Range", &format!("bytes {start}-{}/{file_length}", start + length - 1)));
    }
    Response::new(StatusCode(status), headers, file.take(length), Some(length as usize), None)
        .with_chunked_threshold(usize::MAX)
        .boxed()
}

fn plain(status: u16, text: &str) -> ResponseBox {
    let mut response = Response::from_string(text).with_status_code(status);
    for header in common_headers("text/plain; charset=utf-8") {
        response.add_header(header);
    }
    response.boxed()
}

/// Nothing is cached: whoever rebuilds sees the new files.
fn common_headers(media_type: &str) -> Vec<Header> {
    vec![
        field("Content-Type", media_type),
        field("Cache-Control", "no-store"),
        field("X-Content-Type-Options", "nosniff"),
    ]
}

fn field(name: &str, value: &str) -> Header {
    Header::from_bytes(name, value).expect("our own header fields are ASCII")
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::net::TcpStream;
    use std::path::Path;

    use super::*;

    fn serving() -> Serving {
        start(Site::new(Path::new("tests/pages/tiny.html")).unwrap(), Some(0)).unwrap()
    }

    fn ask(serving: &Serving, request: &str) -> String {
        let mut stream = TcpStream::connect(serving.address).unwrap();
        let request = request.replace("PORT", &serving.address.port().to_string());
        write!(stream, "{request}\r\nConnection: close\r\n\r\n").unwrap();
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
    fn a_range_is_a_part_of_the_file() {
        let answer = ask(&serving(), "GET /web/package.json HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nRange: bytes=0-1");
        assert!(answer.starts_with("HTTP/1.1 206") && answer.contains("Content-Range: bytes 0-1/"), "{answer}");
        assert!(answer.ends_with("\r\n\r\n{\n"), "{answer}");
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
