//! Recognises arrays in the graph of a pickle.

use super::class::Class;
use super::{Node, NodeId, SHORT_TEXT, TEXT_LIMIT};
use crate::memory::Allowance;
use crate::numpy::element_type::ElementType;
use crate::numpy::{Array, Elements, Place, ReadError};
use std::borrow::Cow;

/// Wrappers around an array: a chumpy object may hold another.
const DEPTH_LIMIT: usize = 8;
/// Elements of a sparse matrix written out in full; SMPL-X's joint regressor has 0.6 million.
const DENSE_LIMIT: usize = 1 << 23;

pub(super) struct Graph<'a> {
    pub(super) nodes: &'a [Node<'a>],
    pub(super) allowance: &'a Allowance,
    pub(super) place: Place<'a>,
}

impl<'a> Graph<'a> {
    /// The array that a value is or carries. Sparse matrices are written out in full.
    pub(super) fn array(&self, id: NodeId, depth: usize) -> Result<Array, ReadError> {
        if depth > DEPTH_LIMIT {
            return Err(self.place.error("an array", format!("more than {DEPTH_LIMIT} wrappers around it")));
        }
        match &self.nodes[id] {
            Node::Sequence(items) => self.list(items),
            Node::Object { class: Class::Reconstructor, arguments, state, .. } => match arguments.first() {
                Some(&first) => match self.nodes[first] {
                    Node::Class(class) => self.object(class, &[], *state, depth),
                    _ => Err(self.unexpected("a class", first)),
                },
                None => Err(self.unexpected("an array", id)),
            },
            Node::Object { class, arguments, state, .. } => self.object(*class, arguments, *state, depth),
            _ => {
                let elements = self.list(&[id])?.elements;
                Ok(Array { shape: Vec::new(), elements })
            }
        }
    }

    fn object(
        &self,
        class: Class,
        arguments: &[NodeId],
        state: Option<NodeId>,
        depth: usize,
    ) -> Result<Array, ReadError> {
        match (class, arguments, state) {
            (Class::Reconstruct, _, Some(state)) => self.reconstructed(state),
            (Class::FromBuffer, &[buffer, dtype, shape, order], _) => {
                let fortran_order = self.text(order)? == "F";
                self.decoded(dtype, shape, &self.bytes(buffer)?, fortran_order)
            }
            (Class::Scalar, &[dtype, bytes], _) => {
                self.element_type(dtype)?.decode(&self.bytes(bytes)?, &[], false, self.allowance, self.place)
            }
            (Class::SparseColumns, _, Some(state)) => self.sparse(state, true, depth),
            (Class::SparseRows, _, Some(state)) => self.sparse(state, false, depth),
            (Class::Chumpy, _, Some(state)) => self.array(self.item(state, "x")?, depth + 1),
            (Class::ChumpySelect, _, Some(state)) => self.selected(state, depth),
            (class, ..) => Err(self.place.error("an array", format!("an object of {class:?} without one"))),
        }
    }

    /// `ndarray.__setstate__`: (version, shape, dtype, is in Fortran order, bytes); early numpy had no version.
    fn reconstructed(&self, state: NodeId) -> Result<Array, ReadError> {
        match *self.sequence(state)? {
            [_, shape, dtype, fortran_order, data] | [shape, dtype, fortran_order, data] => {
                let fortran_order = match self.nodes[fortran_order] {
                    Node::Bool(flag) => flag,
                    Node::Integer(flag) => flag != 0,
                    _ => return Err(self.unexpected("a truth value", fortran_order)),
                };
                self.decoded(dtype, shape, &self.bytes(data)?, fortran_order)
            }
            _ => Err(self.unexpected("the five parts of an array's state", state)),
        }
    }

    fn decoded(&self, dtype: NodeId, shape: NodeId, bytes: &[u8], fortran_order: bool) -> Result<Array, ReadError> {
        let shape = self.lengths(shape)?;
        self.element_type(dtype)?.decode(bytes, &shape, fortran_order, self.allowance, self.place)
    }

    /// `numpy.dtype('f8', False, True)` with the state (version, byte order, …).
    fn element_type(&self, id: NodeId) -> Result<ElementType, ReadError> {
        match &self.nodes[id] {
            Node::Object { class: Class::Dtype, arguments, state, .. } if !arguments.is_empty() => {
                let element_type = ElementType::parse(&self.text(arguments[0])?, self.place)?;
                match state {
                    None => Ok(element_type),
                    Some(state) => match self.sequence(*state)? {
                        [_, order, ..] => Ok(element_type.with_byte_order(&self.text(*order)?)),
                        _ => Err(self.unexpected("a state with the byte order", *state)),
                    },
                }
            }
            _ => Err(self.unexpected("a numpy.dtype", id)),
        }
    }

    /// scipy.sparse, compressed along columns or rows: `data` and `indices`, cut at `indptr`.
    fn sparse(&self, state: NodeId, by_columns: bool, depth: usize) -> Result<Array, ReadError> {
        let shape_id = self.item(state, "_shape").or_else(|_| self.item(state, "shape"))?;
        let [rows, columns] = self.lengths(shape_id)?[..] else {
            return Err(self.unexpected("a shape of two dimensions", shape_id));
        };
        let count = rows.checked_mul(columns).filter(|&count| count <= DENSE_LIMIT).ok_or_else(|| {
            let expected = format!("a sparse matrix of at most {DENSE_LIMIT} elements");
            self.place.error(expected, format!("shape [{rows}, {columns}]"))
        })?;
        // The matrix in full, and what is made of it next.
        self.allowance.afford(16 * count).map_err(|shortage| self.place.short(shortage))?;
        let wrong = |found: &str| self.place.error("a well-formed sparse matrix", found);
        let part = |name| self.array(self.item(state, name)?, depth + 1);
        let data = part("data")?.to_f64().ok_or_else(|| wrong("data that are no numbers"))?;
        let positions = |array: Array| {
            let whole = array.to_i64()?.into_iter().map(|x| usize::try_from(x).ok());
            whole.collect::<Option<Vec<usize>>>()
        };
        let indices = positions(part("indices")?).ok_or_else(|| wrong("indices that are no indices"))?;
        let starts = positions(part("indptr")?).ok_or_else(|| wrong("indptr that are no indices"))?;
        let (major_count, minor_count) = if by_columns { (columns, rows) } else { (rows, columns) };
        if starts.len() != major_count + 1 {
            return Err(wrong("indptr of another length than the shape"));
        }
        let mut dense = vec![0.0; count];
        for (major, ends) in starts.windows(2).enumerate() {
            let range = ends[0]..ends[1];
            let (Some(minors), Some(values)) = (indices.get(range.clone()), data.get(range)) else {
                return Err(wrong("indptr beyond the data"));
            };
            for (&minor, &value) in minors.iter().zip(values) {
                if minor >= minor_count {
                    return Err(wrong("an index beyond the shape"));
                }
                let (row, column) = if by_columns { (minor, major) } else { (major, minor) };
                dense[row * columns + column] += value;
            }
        }
        Ok(Array { shape: vec![rows, columns], elements: dense.into() })
    }

    /// `chumpy.reordering.Select`: `a.ravel()[idxs].reshape(preferred_shape)`.
    fn selected(&self, state: NodeId, depth: usize) -> Result<Array, ReadError> {
        let whole = self.array(self.item(state, "a")?, depth + 1)?;
        let values = whole.to_f64().ok_or_else(|| self.place.error("numbers to select from", "text"))?;
        let indices = self.array(self.item(state, "idxs")?, depth + 1)?.to_i64().unwrap_or_default();
        let selected = indices.iter().map(|&index| usize::try_from(index).ok().and_then(|i| values.get(i)).copied());
        let selected: Option<Vec<f64>> = selected.collect();
        let selected = selected.ok_or_else(|| self.place.error("indices into the selected array", "one beyond it"))?;
        let shape = match self.item(state, "preferred_shape") {
            Ok(shape) => self.lengths(shape)?,
            Err(_) => vec![selected.len()],
        };
        let expected = shape.iter().try_fold(1usize, |count, &length| count.checked_mul(length));
        if expected != Some(selected.len()) {
            let found = format!("{} elements", selected.len());
            return Err(self.place.error(format!("elements for shape {shape:?}"), found));
        }
        Ok(Array { shape, elements: selected.into() })
    }

    /// A Python list of numbers or of strings.
    fn list(&self, items: &[NodeId]) -> Result<Array, ReadError> {
        self.allowance.afford(16 * items.len()).map_err(|shortage| self.place.short(shortage))?;
        let elements: Elements = if let Some(integers) = self.all(items, Node::as_integer) {
            integers.into()
        } else if let Some(numbers) = self.all(items, Node::as_number) {
            numbers.into()
        } else if let Some(texts) = self.short_texts(items)? {
            texts.into()
        } else {
            let found = items.first().map_or_else(String::new, |&id| self.nodes[id].description());
            return Err(self.place.error("an array, or values of one kind", found));
        };
        Ok(Array { shape: vec![items.len()], elements })
    }

    fn short_texts(&self, items: &[NodeId]) -> Result<Option<Vec<String>>, ReadError> {
        if items.len() > TEXT_LIMIT {
            return Ok(None);
        }
        let size = items.len() * (size_of::<String>() + SHORT_TEXT);
        self.allowance.afford(size).map_err(|shortage| self.place.short(shortage))?;
        Ok(self.all(items, |node| node.as_short_text().map(Cow::into_owned)))
    }

    fn all<T>(&self, items: &[NodeId], value: impl Fn(&Node<'a>) -> Option<T>) -> Option<Vec<T>> {
        items.iter().map(|&id| value(&self.nodes[id])).collect()
    }

    // Parts.

    fn unexpected(&self, expected: &str, id: NodeId) -> ReadError {
        self.place.error(expected, self.nodes[id].description())
    }

    fn sequence(&self, id: NodeId) -> Result<&'a [NodeId], ReadError> {
        match &self.nodes[id] {
            Node::Sequence(items) => Ok(items),
            _ => Err(self.unexpected("a sequence", id)),
        }
    }

    fn text(&self, id: NodeId) -> Result<Cow<'a, str>, ReadError> {
        self.nodes[id].as_short_text().ok_or_else(|| self.unexpected("text", id))
    }

    /// The value under `key` of a dictionary.
    fn item(&self, dictionary: NodeId, key: &str) -> Result<NodeId, ReadError> {
        let Node::Dictionary(items) = &self.nodes[dictionary] else {
            return Err(self.unexpected("a state that is a dictionary", dictionary));
        };
        let found =
            items.iter().rev().find(|&&(name, _)| self.nodes[name].as_short_text().is_some_and(|text| text == key));
        found.map(|&(_, value)| value).ok_or_else(|| self.place.error(format!("a state with {key}"), "none"))
    }

    /// A shape: one length, or a sequence of them.
    fn lengths(&self, id: NodeId) -> Result<Vec<usize>, ReadError> {
        let ids = match &self.nodes[id] {
            Node::Integer(_) => std::slice::from_ref(&id),
            _ => self.sequence(id)?,
        };
        let lengths = self.all(ids, |node| usize::try_from(node.as_integer()?).ok());
        lengths.ok_or_else(|| self.unexpected("a shape of whole numbers", id))
    }

    /// Raw bytes: as they are, or as the text that protocols before 3 make of them.
    fn bytes(&self, id: NodeId) -> Result<Cow<'a, [u8]>, ReadError> {
        match &self.nodes[id] {
            Node::Bytes(bytes) => Ok(Cow::Borrowed(bytes)),
            Node::Object { class: Class::Bytes, arguments, .. } => match arguments[..] {
                [] => Ok(Cow::Borrowed(&[])),
                [bytes] if bytes != id => match &self.nodes[bytes] {
                    Node::Bytes(bytes) => Ok(Cow::Borrowed(bytes)),
                    _ => self.latin1(bytes),
                },
                _ => Err(self.unexpected("bytes", id)),
            },
            _ => self.latin1(id),
        }
    }

    /// `_codecs.encode(text, 'latin1')`.
    fn latin1(&self, id: NodeId) -> Result<Cow<'a, [u8]>, ReadError> {
        let Node::Object { class: Class::Encode, arguments, .. } = &self.nodes[id] else {
            return Err(self.unexpected("bytes", id));
        };
        let [text, encoding] = arguments[..] else {
            return Err(self.unexpected("a text and its encoding", id));
        };
        let encoding = self.text(encoding)?;
        if !matches!(&*encoding, "latin1" | "latin-1") {
            return Err(self.place.error("the encoding latin1", format!("{encoding:?}")));
        }
        let Node::Text(text) = &self.nodes[text] else { return Err(self.unexpected("text", text)) };
        let bytes: Option<Vec<u8>> = text.chars().map(|character| u8::try_from(u32::from(character)).ok()).collect();
        bytes.map(Cow::Owned).ok_or_else(|| self.place.error("latin1 characters", "others"))
    }
}
