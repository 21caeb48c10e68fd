//! Shaders as the module carries them: without comments and indentation, which every page would download.

/// The files named, one after the other, after the words before them.
macro_rules! wgsl {
    ($($part:expr),+ $(,)?) => {{
        const SOURCE: &str = concat!($($part),+);
        const BYTES: [u8; $crate::wgsl::stripped_length(SOURCE)] = $crate::wgsl::stripped(SOURCE);
        match std::str::from_utf8(&BYTES) {
            Ok(text) => text,
            Err(_) => panic!("whole lines and whole comments were left out"),
        }
    }};
}
pub(crate) use wgsl;

/// Bytes that [`stripped`] leaves of `source`.
pub(crate) const fn stripped_length(source: &str) -> usize {
    let (mut at, mut length) = (0, 0);
    while at < source.len() {
        let (start, end, next) = line(source.as_bytes(), at);
        if end > start {
            length += end - start + 1;
        }
        at = next;
    }
    length
}

/// `source` without comments (`// …` to the end of the line, none within texts, which WGSL has not), indentation and empty lines.
pub(crate) const fn stripped<const LENGTH: usize>(source: &str) -> [u8; LENGTH] {
    let bytes = source.as_bytes();
    let mut out = [b'\n'; LENGTH];
    let (mut at, mut length) = (0, 0);
    while at < bytes.len() {
        let (start, end, next) = line(bytes, at);
        let mut from = start;
        while from < end {
            out[length] = bytes[from];
            length += 1;
            from += 1;
        }
        if end > start {
            length += 1;
        }
        at = next;
    }
    out
}

/// Of the line that begins at `at`: where its words begin and end, and where the next line begins.
const fn line(bytes: &[u8], at: usize) -> (usize, usize, usize) {
    let mut start = at;
    while start < bytes.len() && bytes[start] == b' ' {
        start += 1;
    }
    let mut end = start;
    while end < bytes.len()
        && bytes[end] != b'\n'
        && !(bytes[end] == b'/' && end + 1 < bytes.len() && bytes[end + 1] == b'/')
    {
        end += 1;
    }
    let mut next = end;
    while next < bytes.len() && bytes[next] != b'\n' {
        next += 1;
    }
    while end > start && bytes[end - 1] == b' ' {
        end -= 1;
    }
    (start, end, next + 1)
}

#[cfg(test)]
mod tests {
    #[test]
    fn comments_indentation_and_empty_lines_are_left_out() {
        const TEXT: &str = wgsl!("// what it is\n\n", "fn f() -> f32 {\n    return 1.0 / 2.0; // half\n    // ö\n}");
        assert_eq!(TEXT, "fn f() -> f32 {\nreturn 1.0 / 2.0;\n}\n");
        const NOTHING: &str = wgsl!("  // only this");
        assert_eq!(NOTHING, "");
    }
}
