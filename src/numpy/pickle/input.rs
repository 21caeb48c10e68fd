//! Reads arguments and plain values from a pickle's bytes.

use super::machine::Machine;
use super::{Node, literal};
use crate::decimal;
use crate::numpy::ReadError;
use std::borrow::Cow;

impl<'a> Machine<'a, '_> {
    pub(super) fn take(&mut self, length: u64) -> Result<&'a [u8], ReadError> {
        let rest = &self.bytes[self.at..];
        match usize::try_from(length).ok().and_then(|length| rest.get(..length)) {
            Some(taken) => {
                self.at += taken.len();
                Ok(taken)
            }
            None => Err(self.error(format!("{length} more bytes"), format!("{} before the end", rest.len()))),
        }
    }

    pub(super) fn take_word<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let mut word = [0; N];
        word.copy_from_slice(self.take(N as u64)?);
        Ok(word)
    }

    /// A little-endian number of `N` bytes, at most eight.
    pub(super) fn take_number<const N: usize>(&mut self) -> Result<u64, ReadError> {
        let word: [u8; N] = self.take_word()?;
        Ok(word.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    pub(super) fn take_raw_line(&mut self) -> Result<&'a [u8], ReadError> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| byte == b'\n');
        let length = length.ok_or_else(|| self.error("a line", "no line end"))?;
        self.at += length + 1;
        Ok(&rest[..length])
    }

    pub(super) fn take_line(&mut self) -> Result<&'a str, ReadError> {
        let line = self.take_raw_line()?;
        let line = std::str::from_utf8(line).map_err(|_| self.error("text in UTF-8", "other bytes"))?;
        Ok(line.trim_end_matches('\r'))
    }

    pub(super) fn protocol(&mut self) -> Result<(), ReadError> {
        match self.take_word()? {
            [0..=5] => Ok(()),
            [version] => Err(self.error("pickle protocol 0 to 5", format!("protocol {version}"))),
        }
    }

    pub(super) fn binary_long<const N: usize>(&mut self) -> Result<(), ReadError> {
        let length = self.take_number::<N>()?;
        let bytes = self.take(length)?;
        if bytes.len() > 16 {
            return Err(self.error("an integer of at most 16 bytes", format!("{length} bytes")));
        }
        let negative = bytes.last().is_some_and(|&byte| byte >= 0x80);
        let mut word = [if negative { 0xff } else { 0 }; 16];
        word[..bytes.len()].copy_from_slice(bytes);
        self.push(Node::Integer(i128::from_le_bytes(word)))
    }

    /// INT and LONG: decimal digits, an L after a long one; `00` and `01` are protocol 0's truth values.
    pub(super) fn decimal_integer(&mut self) -> Result<(), ReadError> {
        let text = self.take_line()?;
        match text {
            "00" => return self.push(Node::Bool(false)),
            "01" => return self.push(Node::Bool(true)),
            _ => {}
        }
        let number = text.strip_suffix('L').unwrap_or(text).parse();
        let number = number.map_err(|_| self.error("a whole number", quoted(text)))?;
        self.push(Node::Integer(number))
    }

    pub(super) fn decimal_float(&mut self) -> Result<(), ReadError> {
        let text = self.take_line()?;
        let number = decimal::parse(text).ok_or_else(|| self.error("a number", quoted(text)))?;
        self.push(Node::Float(number))
    }

    pub(super) fn decimal_key(&mut self) -> Result<u64, ReadError> {
        let text = self.take_line()?;
        text.parse().map_err(|_| self.error("a whole number", quoted(text)))
    }

    pub(super) fn binary_bytes<const N: usize>(&mut self) -> Result<(), ReadError> {
        let length = self.take_number::<N>()?;
        let bytes = self.take(length)?;
        self.push(Node::Bytes(Cow::Borrowed(bytes)))
    }

    pub(super) fn binary_text<const N: usize>(&mut self) -> Result<(), ReadError> {
        let length = self.take_number::<N>()?;
        let bytes = self.take(length)?;
        let text = std::str::from_utf8(bytes).map_err(|_| self.error("text in UTF-8", "other bytes"))?;
        self.push(Node::Text(Cow::Borrowed(text)))
    }

    /// STRING: Python 2's byte string as a quoted literal.
    pub(super) fn quoted_bytes(&mut self) -> Result<(), ReadError> {
        let bytes = literal::byte_string(self.take_raw_line()?.trim_ascii_end());
        let bytes = bytes.ok_or_else(|| self.error("a Python string literal", "another line"))?;
        self.push(Node::Bytes(Cow::Owned(bytes)))
    }

    /// UNICODE: a line of text with escapes.
    pub(super) fn escaped_text(&mut self) -> Result<(), ReadError> {
        let text = literal::raw_unicode(self.take_raw_line()?);
        let text = text.ok_or_else(|| self.error("text with unicode escapes", "an escape of no character"))?;
        self.push(Node::Text(Cow::Owned(text)))
    }
}

/// A text for errors, shortened: it may be as long as the file.
fn quoted(text: &str) -> String {
    format!("{:?}", text.chars().take(80).collect::<String>())
}
