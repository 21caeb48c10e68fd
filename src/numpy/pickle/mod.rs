//! Pickles that carry arrays, as numpy 1 and 2, scipy.sparse and chumpy write them (protocols 0 to 5).
//!
//! Nothing is executed and nothing is constructed: [`machine`] turns the opcodes into a graph of [`Node`]s, in which a
//! call is only noted down, and refuses every class outside the list in [`class`]; [`arrays`] then recognises arrays
//! in that graph, when one is asked for.

mod arrays;
mod class;
mod input;
mod literal;
mod machine;

use super::{Array, Place, ReadError};
use crate::memory::Allowance;
use class::Class;
use std::borrow::Cow;

/// Bytes of a text that is a name or a list's element. Values may be shared, so that small pickles can stand for
/// huge ones: whatever is copied is limited.
const SHORT_TEXT: usize = 256;
/// Texts in a list, entries in the outermost dictionary.
const TEXT_LIMIT: usize = 1 << 16;

/// Index into [`Pickle::nodes`].
type NodeId = usize;

/// A Python value. Values refer to each other by index, so a pickle that refers to itself does no harm.
#[derive(Debug)]
enum Node<'a> {
    None,
    Bool(bool),
    Integer(i128),
    Float(f64),
    Bytes(Cow<'a, [u8]>),
    Text(Cow<'a, str>),
    /// List, tuple or set.
    Sequence(Vec<NodeId>),
    Dictionary(Vec<(NodeId, NodeId)>),
    Class(Class),
    /// What a call would have returned.
    Object {
        class: Class,
        arguments: Vec<NodeId>,
        state: Option<NodeId>,
        items: Vec<(NodeId, NodeId)>,
    },
}

/// A pickled dictionary.
pub(super) struct Pickle<'a> {
    file: String,
    nodes: Vec<Node<'a>>,
    /// Keys and values of the outermost dictionary.
    entries: Vec<(String, NodeId)>,
}

impl<'a> Pickle<'a> {
    pub(super) fn open(bytes: &'a [u8], file: &str, allowance: &Allowance) -> Result<Self, ReadError> {
        let (nodes, root) = machine::run(bytes, file, allowance)?;
        let items = match &nodes[root] {
            Node::Dictionary(items) | Node::Object { class: Class::Dictionary, items, .. } => items,
            other => {
                let place = Place { file, field: "pickle" };
                return Err(place.error("a dictionary of arrays", other.description()));
            }
        };
        if items.len() > TEXT_LIMIT {
            let expected = format!("a dictionary of at most {TEXT_LIMIT} arrays");
            return Err(Place { file, field: "pickle" }.error(expected, items.len().to_string()));
        }
        // Keys are copied, and may be shared.
        let place = Place { file, field: "pickle" };
        let entry_size = size_of::<(String, NodeId)>() + SHORT_TEXT;
        allowance.hold(entry_size * items.len()).map_err(|shortage| place.short(shortage))?;
        let entries = (items.iter())
            .filter_map(|&(key, value)| Some((nodes[key].as_short_text()?.into_owned(), value)))
            .collect();
        Ok(Self { file: file.to_owned(), entries, nodes })
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.entries.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Reads an array, if there is one of that name.
    pub(super) fn array(&self, name: &str, allowance: &Allowance) -> Result<Option<Array>, ReadError> {
        let place = Place { file: &self.file, field: name };
        // As in Python, the last of equal keys counts.
        let entry = self.entries.iter().rev().find(|(key, _)| key == name);
        entry.map(|&(_, id)| arrays::Graph { nodes: &self.nodes, allowance, place }.array(id, 0)).transpose()
    }
}

impl Node<'_> {
    /// A name: text, or a Python 2 byte string as text.
    fn as_short_text(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Text(text) if text.len() <= SHORT_TEXT => Some(Cow::Borrowed(text)),
            Self::Bytes(bytes) if bytes.len() <= SHORT_TEXT => {
                Some(Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()))
            }
            _ => None,
        }
    }

    fn as_integer(&self) -> Option<i64> {
        match self {
            Self::Bool(value) => Some(i64::from(*value)),
            Self::Integer(value) => i64::try_from(*value).ok(),
            _ => None,
        }
    }

    fn as_number(&self) -> Option<f64> {
        match self {
            Self::Integer(value) => Some(*value as f64),
            Self::Float(value) => Some(*value),
            _ => None,
        }
    }

    /// What it is, for errors.
    fn description(&self) -> String {
        match self {
            Self::None => "None".to_owned(),
            Self::Bool(value) => format!("the truth value {value}"),
            Self::Integer(value) => format!("the number {value}"),
            Self::Float(value) => format!("the number {value}"),
            Self::Bytes(bytes) => format!("{} bytes", bytes.len()),
            Self::Text(text) => format!("the text {:?}", text.chars().take(40).collect::<String>()),
            Self::Sequence(items) => format!("a sequence of {}", items.len()),
            Self::Dictionary(items) => format!("a dictionary of {}", items.len()),
            Self::Class(class) => format!("the class {class:?}"),
            Self::Object { class, .. } => format!("an object of {class:?}"),
        }
    }
}
