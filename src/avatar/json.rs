//! JSON that knows where it stands in its file, so that what is wrong with it can be named.

use super::AvatarError;
use crate::decimal;
use hifijson::value::{Value, parse_bounded};
use hifijson::{SliceLexer, token::Lex};
use std::borrow::Cow;
use std::fmt::Display;
use std::str::FromStr;

/// Objects and lists within each other; glTF needs a dozen.
const DEPTH_LIMIT: usize = 64;
/// Characters of a text that a message shows.
const SHOWN_CHARACTERS: usize = 40;

/// Memory of a parsed text at most, in multiples of its bytes: a list of single digits, while it grows.
pub const PARSED_TIMES: usize = 24 * size_of::<usize>() / 4;

type Parsed<'a> = Value<&'a str, Cow<'a, str>>;

/// A parsed JSON text.
pub struct Document<'a> {
    file: &'a str,
    value: Parsed<'a>,
}

impl<'a> Document<'a> {
    /// Parses the JSON chunk `bytes` of `file`, a name for messages.
    pub fn parse(bytes: &'a [u8], file: &'a str) -> Result<Self, AvatarError> {
        let wrong = |found: String| AvatarError::new(file, "JSON chunk", "JSON", found);
        let text =
            std::str::from_utf8(bytes).map_err(|error| wrong(format!("no UTF-8 at byte {}", error.valid_up_to())))?;
        let mut lexer = SliceLexer::new(text.as_bytes());
        let value = lexer.exactly_one(Lex::ws_peek, |next, lexer| parse_bounded(DEPTH_LIMIT, next, lexer));
        let value =
            value.map_err(|error| wrong(format!("{error} at byte {}", bytes.len() - lexer.as_slice().len())))?;
        Ok(Self { file, value })
    }

    /// The outermost value.
    pub fn root(&self) -> Json<'_> {
        Json { file: self.file, path: String::new(), value: Some(&self.value) }
    }
}

/// A value, or the lack of one, and its path from the root.
pub struct Json<'a> {
    file: &'a str,
    path: String,
    value: Option<&'a Parsed<'a>>,
}

/// What can be read from JSON.
pub trait FromJson: Sized {
    /// The value of `json`, or what is wrong with it.
    fn from_json(json: &Json) -> Result<Self, AvatarError>;
}

impl<'a> Json<'a> {
    /// The member `name` of an object.
    pub fn get<T: FromJson>(&self, name: &str) -> Result<T, AvatarError> {
        T::from_json(&self.member(name)?)
    }

    /// The member `name` of an object, or what stands for it where it is missing.
    pub fn get_or_default<T: FromJson + Default>(&self, name: &str) -> Result<T, AvatarError> {
        Ok(self.get::<Option<T>>(name)?.unwrap_or_default())
    }

    /// The member `name` of an object, as it is; `null` counts as none.
    pub fn member(&self, name: &str) -> Result<Json<'a>, AvatarError> {
        let Some(Value::Object(members)) = self.value else {
            return Err(self.expected("an object"));
        };
        let path = if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) };
        let mut found = members.iter().filter(|(key, _)| key.as_ref() == name);
        let value = found.next().map(|(_, value)| value).filter(|value| !matches!(value, Value::Null));
        let member = Json { file: self.file, path, value };
        if found.next().is_some() {
            return Err(member.error("one member of this name", "two"));
        }
        Ok(member)
    }

    /// The same value under another path, for a part of the file that has a name of its own.
    pub fn named(&self, path: &str) -> Json<'a> {
        Json { file: self.file, path: path.to_owned(), value: self.value }
    }

    /// Whether there is a value.
    pub fn is_some(&self) -> bool {
        self.value.is_some()
    }

    /// The entries of a list.
    pub fn entries(&self) -> Result<impl ExactSizeIterator<Item = Json<'a>>, AvatarError> {
        let Some(Value::Array(entries)) = self.value else {
            return Err(self.expected("a list"));
        };
        let entry = |(i, value)| Json { file: self.file, path: format!("{}[{i}]", self.path), value: Some(value) };
        Ok(entries.iter().enumerate().map(entry))
    }

    /// A text.
    pub fn text(&self) -> Result<&'a str, AvatarError> {
        match self.value {
            Some(Value::String(text)) => Ok(text),
            _ => Err(self.expected("a text")),
        }
    }

    /// An error about this value.
    pub fn error(&self, expected: impl Display, found: impl Display) -> AvatarError {
        AvatarError::new(self.file, if self.path.is_empty() { "JSON chunk" } else { &self.path }, expected, found)
    }

    /// The error that says what stands here in place of what was `expected`.
    pub fn expected(&self, expected: impl Display) -> AvatarError {
        let found = match self.value {
            None => "nothing".into(),
            Some(Value::Null) => "null".into(),
            Some(Value::Bool(flag)) => flag.to_string(),
            Some(Value::Number((digits, _))) => shown(digits),
            Some(Value::String(text)) => format!("\"{}\"", shown(text)),
            Some(Value::Array(_)) => "a list".into(),
            Some(Value::Object(_)) => "an object".into(),
        };
        self.error(expected, found)
    }

    fn number<T: FromStr>(&self, kind: &str) -> Result<T, AvatarError> {
        match self.value {
            Some(Value::Number((digits, _))) => digits.parse().map_err(|_| self.expected(kind)),
            _ => Err(self.expected(kind)),
        }
    }
}

fn shown(text: &str) -> String {
    text.chars().take(SHOWN_CHARACTERS).collect()
}

impl FromJson for usize {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        json.number("a whole number")
    }
}

impl FromJson for u32 {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        json.number("a whole number of 32 bits")
    }
}

impl FromJson for f32 {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        let Some(Value::Number((digits, _))) = json.value else { return Err(json.expected("a number")) };
        let number = decimal::parse(digits).map(|number| number as f32).filter(|number| number.is_finite());
        number.ok_or_else(|| json.expected("a number that 32 bits can hold"))
    }
}

impl FromJson for bool {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        match json.value {
            Some(Value::Bool(flag)) => Ok(*flag),
            _ => Err(json.expected("true or false")),
        }
    }
}

impl FromJson for String {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        json.text().map(ToOwned::to_owned)
    }
}

impl<T: FromJson> FromJson for Vec<T> {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        json.entries()?.map(|entry| T::from_json(&entry)).collect()
    }
}

impl<T: FromJson, const N: usize> FromJson for [T; N] {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        let entries = Vec::from_json(json)?;
        let found = entries.len();
        entries.try_into().map_err(|_| json.error(format_args!("{N} entries"), found))
    }
}

impl<T: FromJson> FromJson for Option<T> {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        if json.is_some() { T::from_json(json).map(Some) } else { Ok(None) }
    }
}

/// Free facts, of any shape.
impl FromJson for serde_json::Map<String, serde_json::Value> {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        match json.value.map(free) {
            Some(serde_json::Value::Object(members)) => Ok(members),
            _ => Err(json.expected("an object")),
        }
    }
}

/// A value as the trainer handles it. Numbers that nothing can hold become null.
fn free(value: &Parsed) -> serde_json::Value {
    match value {
        Value::Null => serde_json::Value::Null,
        Value::Bool(flag) => (*flag).into(),
        Value::Number((digits, _)) => {
            let whole = digits.parse::<u64>().map(Into::into).or_else(|_| digits.parse::<i64>().map(Into::into));
            whole.unwrap_or_else(|_| decimal::parse(digits).unwrap_or(f64::NAN).into())
        }
        Value::String(text) => text.as_ref().into(),
        Value::Array(entries) => entries.iter().map(free).collect(),
        Value::Object(members) => {
            let mut freed = serde_json::Map::new();
            for (name, value) in members {
                freed.insert(name.to_string(), free(value));
            }
            freed.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<T: FromJson>(text: &str, name: &str) -> Result<T, AvatarError> {
        Document::parse(text.as_bytes(), "test.glb").and_then(|document| document.root().get(name))
    }

    fn error_of<T: FromJson>(text: &str, name: &str) -> String {
        read::<T>(text, name).err().expect("should be refused").to_string()
    }

    #[test]
    fn values_of_every_kind_are_read() {
        let text = r#" {"count": 12, "scale": -1.5e-3, "packed": true, "name": "größe \n \u00e9", "shape": [1, 2], "none": null} "#;
        assert_eq!(read::<usize>(text, "count").unwrap(), 12);
        assert_eq!(read::<f32>(text, "scale").unwrap(), -1.5e-3);
        assert!(read::<bool>(text, "packed").unwrap());
        assert_eq!(read::<String>(text, "name").unwrap(), "größe \n é");
        assert_eq!(read::<[u32; 2]>(text, "shape").unwrap(), [1, 2]);
        assert_eq!(read::<Option<usize>>(text, "none").unwrap(), None);
        assert_eq!(read::<Option<usize>>(text, "missing").unwrap(), None);
    }

    #[test]
    fn errors_name_the_path_and_what_stands_there() {
        for (text, message) in [
            (r#"{"a": [1, -2]}"#, "a[1]: expected a whole number, found -2"),
            (r#"{"a": [1, 2.0]}"#, "a[1]: expected a whole number, found 2.0"),
            (r#"{"a": ["x"]}"#, "a[0]: expected a whole number, found \"x\""),
            (r#"{"a": {}}"#, "a: expected a list, found an object"),
            (r#"{"b": 1}"#, "a: expected a list, found nothing"),
            (r#"{"a": [], "a": []}"#, "a: expected one member of this name, found two"),
            ("[]", "JSON chunk: expected an object, found a list"),
        ] {
            assert_eq!(error_of::<Vec<usize>>(text, "a"), format!("test.glb: {message}"));
        }
        assert!(
            error_of::<f32>(r#"{"a": 1e39}"#, "a").ends_with("expected a number that 32 bits can hold, found 1e39")
        );
        assert!(error_of::<u32>(r#"{"a": 4294967296}"#, "a").ends_with("32 bits, found 4294967296"));
        assert!(error_of::<[u32; 3]>(r#"{"a": [1]}"#, "a").ends_with("expected 3 entries, found 1"));
    }

    #[test]
    fn text_that_is_no_json_is_refused_with_its_place() {
        for text in ["", "{", "{} {}", "{\"a\": 01}", "{\"a\": 1,}", "{\"a\": \"\n\"}", "{'a': 1}", "nul"] {
            let error = Document::parse(text.as_bytes(), "test.glb").err().expect("should be refused");
            assert!(error.field == "JSON chunk" && error.found.contains("at byte"), "{text}: {error}");
        }
        assert!(Document::parse(b"{\"a\": \"\xff\"}", "test.glb").is_err());
        let deep = "[".repeat(100_000);
        let error = Document::parse(deep.as_bytes(), "test.glb").err().expect("should be refused");
        assert!(error.found.contains("depth"), "{error}");
    }

    #[test]
    fn a_parsed_text_takes_no_more_memory_than_is_reckoned_with() {
        // An entry of a list has two bytes of text, a member of an object six; both double their room as they grow.
        let entry = 2 * size_of::<Parsed>() + size_of::<Parsed>();
        let member = 3 * size_of::<(Cow<str>, Parsed)>();
        assert!(entry <= 2 * PARSED_TIMES && member <= 6 * PARSED_TIMES, "{entry} and {member} bytes");
    }

    #[test]
    fn free_facts_come_back_as_they_are() {
        let text = r#"{"facts": {"seed": 7, "below": -1, "share": 0.30000000000000004, "deep": [null, {"ö": false}]}}"#;
        let facts: serde_json::Map<String, serde_json::Value> = read(text, "facts").unwrap();
        let expected: serde_json::Value = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::Value::Object(facts), expected["facts"]);
    }
}
