//! As much of HTTP/1.1 as a page on this machine needs: one request and one answer for each connection.

use std::io::{self, BufRead, Cursor, Read, Write};

/// A longer request line with its headers is refused.
const LONGEST_HEAD: u64 = 64 * 1024;

/// A request without its body.
#[derive(Debug)]
pub struct Request {
    /// GET, HEAD and so on.
    pub method: String,
    /// Path and query.
    pub target: String,
    headers: Vec<(String, String)>,
}

impl Request {
    /// Reads up to the empty line that ends the headers; none where that is no HTTP.
    pub fn read(stream: &mut impl BufRead) -> io::Result<Option<Self>> {
        let mut lines = Vec::new();
        let mut head = stream.take(LONGEST_HEAD);
        loop {
            let mut line = String::new();
            head.read_line(&mut line)?;
            let Some(line) = line.strip_suffix('\n') else { return Ok(None) };
            let line = line.strip_suffix('\r').unwrap_or(line);
            if line.is_empty() {
                return Ok(Self::parse(&lines));
            }
            lines.push(line.to_owned());
        }
    }

    fn parse(lines: &[String]) -> Option<Self> {
        let (first, rest) = lines.split_first()?;
        let mut words = first.split(' ');
        let (method, target, version) = (words.next()?, words.next()?, words.next()?);
        if !version.starts_with("HTTP/1.") || words.next().is_some() {
            return None;
        }
        let header =
            |line: &String| line.split_once(':').map(|(name, value)| (name.to_owned(), value.trim().to_owned()));
        let headers = rest.iter().map(header).collect::<Option<_>>()?;
        Some(Request { method: method.to_owned(), target: target.to_owned(), headers })
    }

    /// The value of a header, whatever the case of its name.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(found, _)| found.eq_ignore_ascii_case(name)).map(|(_, value)| value.as_str())
    }
}

/// An answer with a body of known length.
pub struct Response {
    status: u16,
    headers: Vec<(&'static str, String)>,
    length: u64,
    body: Box<dyn Read>,
}

impl Response {
    /// An answer whose body is the next `length` bytes of a reader.
    pub fn new(status: u16, media_type: &str, length: u64, body: impl Read + 'static) -> Self {
        let headers = vec![("Content-Type", media_type.to_owned())];
        Response { status, headers, length, body: Box::new(body) }
    }

    /// A short message.
    pub fn text(status: u16, message: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", message.len() as u64, Cursor::new(message.to_owned()))
    }

    /// Adds a header.
    pub fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.headers.push((name, value.into()));
        self
    }

    /// Writes the headers and, unless it was asked for the headers only, the body.
    pub fn write(self, stream: &mut impl Write, has_body: bool) -> io::Result<()> {
        let mut head = format!("HTTP/1.1 {} {}\r\n", self.status, reason(self.status));
        for (name, value) in &self.headers {
            head += &format!("{name}: {value}\r\n");
        }
        // No connection is kept: nothing waits for one that is idle.
        head += &format!("Content-Length: {}\r\nConnection: close\r\n\r\n", self.length);
        stream.write_all(head.as_bytes())?;
        if has_body {
            io::copy(&mut self.body.take(self.length), stream)?;
        }
        stream.flush()
    }
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        206 => "Partial Content",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        416 => "Range Not Satisfiable",
        _ => "Internal Server Error",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<Request> {
        Request::read(&mut text.as_bytes()).unwrap()
    }

    #[test]
    fn requests_have_a_method_a_target_and_headers() {
        let request = read("GET /a?b HTTP/1.1\r\nHost: localhost:80\r\nRANGE:bytes=0-\r\n\r\nrest").unwrap();
        assert_eq!((request.method.as_str(), request.target.as_str()), ("GET", "/a?b"));
        assert_eq!(request.header("host"), Some("localhost:80"));
        assert_eq!(request.header("Range"), Some("bytes=0-"));
        assert_eq!(request.header("Cookie"), None);
    }

    #[test]
    fn what_is_no_request_is_refused() {
        for text in
            ["", "GET / HTTP/1.1\r\n", "\r\n", "GET /\r\n\r\n", "GET / SSH/2\r\n\r\n", "GET / HTTP/1.1\r\nx\r\n\r\n"]
        {
            assert!(read(text).is_none(), "{text:?}");
        }
        let endless = format!("GET /{} HTTP/1.1\r\n\r\n", "a".repeat(LONGEST_HEAD as usize));
        assert!(read(&endless).is_none());
    }

    #[test]
    fn an_answer_names_its_length_and_ends_after_it() {
        let write = |has_body| {
            let mut bytes = Vec::new();
            let response = Response::new(200, "text/plain", 3, Cursor::new("abcdef")).with("X", "y");
            response.write(&mut bytes, has_body).unwrap();
            String::from_utf8(bytes).unwrap()
        };
        let head =
            "HTTP/1.1 200 OK\r\nContent-Type: text/plain\r\nX: y\r\nContent-Length: 3\r\nConnection: close\r\n\r\n";
        assert_eq!(write(false), head);
        assert_eq!(write(true), format!("{head}abc"));
    }
}
