//! Numbers out of a file's accessors and tables, each checked before it is used.

use super::AvatarError;
use super::deflate::unpack;
use super::document::{self, Document};
use super::extension::{Extension, Number, Table};
use crate::memory::Allowance;
use glam::Vec3A;
use half::f16;
use std::borrow::Cow;

/// What is kept of a table, in multiples of its bytes.
const KEPT_TIMES: usize = 3;

/// A file's document and binary chunk.
pub struct Reader<'a> {
    /// Its name, for messages.
    pub file: &'a str,
    /// The BIN chunk.
    pub binary: &'a [u8],
    /// The JSON chunk.
    pub document: &'a Document<Extension>,
    /// Memory that tables may take.
    pub allowance: Allowance,
}

impl<'a> Reader<'a> {
    pub fn error(&self, field: &str, expected: impl ToString, found: impl ToString) -> AvatarError {
        AvatarError::new(self.file, field, expected, found)
    }

    /// Entry `index` of one of the document's lists.
    pub fn entry<T>(&self, list: &'a [T], index: usize, field: &str) -> Result<&'a T, AvatarError> {
        list.get(index).ok_or_else(|| self.error(field, format!("an index below {}", list.len()), index))
    }

    pub fn view(&self, index: usize, field: &str) -> Result<&'a [u8], AvatarError> {
        let field = format!("{field}.bufferView");
        let view = self.entry(&self.document.buffer_views, index, &field)?;
        let buffer = self.entry(&self.document.buffers, view.buffer, &format!("{field}.buffer"))?;
        if view.buffer != 0 || buffer.uri.is_some() {
            return Err(self.error(&field, "a view of the BIN chunk", format!("buffer {}", view.buffer)));
        }
        let available = self.binary.len().min(buffer.byte_length);
        view.byte_offset
            .checked_add(view.byte_length)
            .filter(|&end| end <= available)
            .map(|end| &self.binary[view.byte_offset..end])
            .ok_or_else(|| {
                let found = format!("{} at {}", view.byte_length, view.byte_offset);
                self.error(&field, format!("bytes within {available}"), found)
            })
    }

    /// Bytes and count of an accessor of the given kind: components of `size` bytes, `width` of them an element.
    pub fn accessor(
        &self,
        index: usize,
        field: &str,
        component_types: &[u32],
        (shape, width): (&str, usize),
        normalized: bool,
    ) -> Result<(&'a [u8], &'a document::Accessor), AvatarError> {
        let accessor = self.entry(&self.document.accessors, index, field)?;
        let size = match accessor.component_type {
            document::UNSIGNED_BYTE => 1,
            document::UNSIGNED_SHORT => 2,
            _ => 4,
        };
        if !component_types.contains(&accessor.component_type)
            || accessor.shape != shape
            || accessor.normalized != normalized
        {
            let found = format!("{} {} normalized {}", accessor.component_type, accessor.shape, accessor.normalized);
            return Err(self.error(field, format!("{component_types:?} {shape} normalized {normalized}"), found));
        }
        let stride = self.entry(&self.document.buffer_views, accessor.buffer_view, field)?.byte_stride;
        if accessor.is_sparse || stride.is_some_and(|stride| stride != size * width) {
            return Err(self.error(field, "a packed accessor", "a sparse or strided one"));
        }
        let view = self.view(accessor.buffer_view, field)?;
        accessor
            .count
            .checked_mul(size * width)
            .and_then(|length| accessor.byte_offset.checked_add(length))
            .and_then(|end| view.get(accessor.byte_offset..end))
            .map(|bytes| (bytes, accessor))
            .ok_or_else(|| {
                let found = format!("{} elements at {}", accessor.count, accessor.byte_offset);
                self.error(field, format!("elements within {} bytes", view.len()), found)
            })
    }

    /// Bytes of a table whose numbers are of one of `numbers` and whose shape fits `shape` (None: any length).
    pub fn table(
        &self,
        table: &Table,
        field: &str,
        numbers: &[Number],
        shape: &[Option<usize>],
    ) -> Result<Cow<'a, [u8]>, AvatarError> {
        if !numbers.contains(&table.number) {
            return Err(self.error(&format!("{field}.type"), format!("{numbers:?}"), format!("{:?}", table.number)));
        }
        let fits = table.shape.len() == shape.len()
            && table
                .shape
                .iter()
                .zip(shape)
                .all(|(found, expected)| expected.is_none_or(|expected| *found == expected));
        if !fits {
            let expected: Vec<String> =
                shape.iter().map(|length| length.map_or("any".into(), |length| length.to_string())).collect();
            return Err(self.error(
                &format!("{field}.shape"),
                format!("[{}]", expected.join(", ")),
                format!("{:?}", table.shape),
            ));
        }
        let bytes = self.view(table.buffer_view, field)?;
        let size = table.number.size();
        let length = table.shape.iter().try_fold(size, |product, &length| product.checked_mul(length));
        if let Some(length) = length {
            // Unpacking takes two copies for a while; what is made of them and kept has at most sixteen bytes for six.
            let taken = self.allowance.afford(length.saturating_mul(KEPT_TIMES + 2));
            let taken = taken.and_then(|()| self.allowance.hold(KEPT_TIMES * length));
            taken.map_err(|shortage| self.error(&format!("{field}.bufferView"), shortage.expected, shortage.found))?;
        }
        let unpacked = match length {
            Some(length) if table.packed => unpack(bytes, length, size).map(Cow::Owned),
            Some(length) if length == bytes.len() => Ok(Cow::Borrowed(bytes)),
            _ => Err(format!("{} bytes", bytes.len())),
        };
        unpacked.map_err(|found| {
            let expected = format!("the bytes of {:?} {:?}", table.shape, table.number);
            self.error(&format!("{field}.bufferView"), expected, found)
        })
    }

    pub fn floats(&self, table: &Table, field: &str, shape: &[Option<usize>]) -> Result<Vec<f32>, AvatarError> {
        let bytes = self.table(table, field, &[Number::F16, Number::F32], shape)?;
        let scale = table.scale.unwrap_or(1.0);
        let values: Vec<f32> = match table.number {
            Number::F16 => halves(&bytes).map(|half| half.to_f32() * scale).collect(),
            _ => floats(&bytes).collect(),
        };
        match values.iter().position(|value| !value.is_finite()) {
            Some(i) => Err(self.error(&format!("{field}[{i}]"), "a finite number", values[i])),
            None => Ok(values),
        }
    }

    pub fn points(&self, table: &Table, field: &str, count: Option<usize>) -> Result<Vec<Vec3A>, AvatarError> {
        let numbers = self.floats(table, field, &[count, Some(3)])?;
        Ok(numbers.chunks_exact(3).map(Vec3A::from_slice).collect())
    }

    pub fn indices(&self, table: &Table, field: &str, count: Option<usize>) -> Result<Vec<u32>, AvatarError> {
        let bytes = self.table(table, field, &[Number::U16, Number::U32], &[count])?;
        Ok(if table.number == Number::U16 { shorts(&bytes).map(u32::from).collect() } else { words(&bytes).collect() })
    }
}

pub fn floats(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes.as_chunks::<4>().0.iter().map(|&bytes| f32::from_le_bytes(bytes))
}

pub fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.as_chunks::<4>().0.iter().map(|&bytes| u32::from_le_bytes(bytes))
}

pub fn shorts(bytes: &[u8]) -> impl Iterator<Item = u16> {
    bytes.as_chunks::<2>().0.iter().map(|&bytes| u16::from_le_bytes(bytes))
}

pub fn halves(bytes: &[u8]) -> impl Iterator<Item = f16> {
    bytes.as_chunks::<2>().0.iter().map(|&bytes| f16::from_le_bytes(bytes))
}
