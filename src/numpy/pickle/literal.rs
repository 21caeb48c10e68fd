//! Text forms of strings in protocol 0.

/// Python 2's literal of a byte string, quotes included: `'a\x00\n'`.
pub(super) fn byte_string(literal: &[u8]) -> Option<Vec<u8>> {
    let inside = match literal {
        [b'\'', inside @ .., b'\''] | [b'"', inside @ .., b'"'] => inside,
        _ => return None,
    };
    let mut bytes = Vec::with_capacity(inside.len());
    let mut rest = inside;
    while let [first, after @ ..] = rest {
        let (byte, after) = match (first, after) {
            (b'\\', [b'x', high, low, after @ ..]) => (hexadecimal(&[*high, *low])? as u8, after),
            (b'\\', [escaped, after @ ..]) => (simple_escape(*escaped)?, after),
            (b'\\', []) => return None,
            (&byte, after) => (byte, after),
        };
        bytes.push(byte);
        rest = after;
    }
    Some(bytes)
}

/// Latin-1 with `\uXXXX` and `\UXXXXXXXX` for all else.
pub(super) fn raw_unicode(line: &[u8]) -> Option<String> {
    let mut text = String::with_capacity(line.len());
    let mut rest = line;
    while let [first, after @ ..] = rest {
        let (code, after) = match (first, after) {
            (b'\\', [b'u', after @ ..]) if after.len() >= 4 => (hexadecimal(&after[..4])?, &after[4..]),
            (b'\\', [b'U', after @ ..]) if after.len() >= 8 => (hexadecimal(&after[..8])?, &after[8..]),
            (&byte, after) => (u32::from(byte), after),
        };
        text.push(char::from_u32(code)?);
        rest = after;
    }
    Some(text)
}

fn hexadecimal(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0u32, |number, &digit| Some(number << 4 | char::from(digit).to_digit(16)?))
}

fn simple_escape(escaped: u8) -> Option<u8> {
    match escaped {
        b'\\' | b'\'' | b'"' => Some(escaped),
        b'n' => Some(b'\n'),
        b'r' => Some(b'\r'),
        b't' => Some(b'\t'),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn byte_strings() {
        assert_eq!(byte_string(br#"'a\x00\xff\n\'"\\'"#), Some(b"a\x00\xff\n'\"\\".to_vec()));
        assert_eq!(byte_string(b"\"it's\""), Some(b"it's".to_vec()));
        for wrong in [&b"a"[..], b"'a", b"'", br"'\q'", br"'\x0'", br"'\xgg'"] {
            assert_eq!(byte_string(wrong), None, "{wrong:?}");
        }
    }

    #[test]
    fn raw_unicode_strings() {
        assert_eq!(raw_unicode(b"\xe9\\u00e9\\U0001f600\\n").as_deref(), Some("éé😀\\n"));
        for wrong in [&br"\ud800"[..], br"\uxxxx", br"\Uffffffff"] {
            assert_eq!(raw_unicode(wrong), None, "{wrong:?}");
        }
    }
}
