//! Point clouds from PLY files: ASCII and both byte orders; properties that are not asked for are skipped.

mod header;

use crease::numpy::ReadError;
use glam::Vec3A;
use header::{Encoding, Header, Property, Scalar};

/// Points of one scan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointCloud {
    /// Positions, metres. At least one; all finite.
    pub points: Vec<Vec3A>,
    /// Normals as the file has them, if it has any.
    pub normals: Option<Vec<Vec3A>>,
    /// sRGB colours, if the file has any.
    pub colours: Option<Vec<[u8; 3]>>,
}

impl PointCloud {
    /// Reads the `vertex` element of a PLY file. `file` is its name for messages.
    ///
    /// Fails on a malformed header, on fewer bytes than the header promises, on zero points, and on coordinates that are not finite.
    pub fn read(bytes: &[u8], file: &str) -> Result<Self, ReadError> {
        let header = Header::read(bytes, file)?;
        let mut values = Values { body: &bytes[header.body_offset..], encoding: header.encoding, file };
        for element in &header.elements {
            if element.name != "vertex" {
                values.require(element.count, &element.properties)?;
                for _ in 0..element.count {
                    values.skip(&element.properties)?;
                }
                continue;
            }
            if element.count == 0 {
                return Err(values.error("element vertex", "at least one point", "0"));
            }
            return read_vertices(&mut values, element.count, &element.properties);
        }
        Err(values.error("header", "an element vertex", "none"))
    }
}

/// Columns of three properties, if all are there.
fn columns(properties: &[Property], names: [&str; 3]) -> Option<[usize; 3]> {
    let find = |name| properties.iter().position(|property| property.name == name && !property.is_list());
    Some([find(names[0])?, find(names[1])?, find(names[2])?])
}

fn read_vertices(values: &mut Values, count: usize, properties: &[Property]) -> Result<PointCloud, ReadError> {
    let position = columns(properties, ["x", "y", "z"])
        .ok_or_else(|| values.error("element vertex", "properties x, y, z", "not all of them"))?;
    let normal = columns(properties, ["nx", "ny", "nz"]);
    let colour = columns(properties, ["red", "green", "blue"]);
    values.require(count, properties)?;

    let mut cloud = PointCloud {
        points: Vec::with_capacity(count),
        normals: normal.map(|_| Vec::with_capacity(count)),
        colours: colour.map(|_| Vec::with_capacity(count)),
    };
    let mut row = vec![0.0; properties.len()];
    for index in 0..count {
        values.row(properties, &mut row)?;
        let vector = |columns: [usize; 3]| Vec3A::from_array(columns.map(|column| row[column] as f32));
        let point = vector(position);
        if !point.is_finite() {
            return Err(values.error(&format!("vertex {index}"), "finite coordinates", &point.to_string()));
        }
        cloud.points.push(point);
        if let (Some(normals), Some(columns)) = (&mut cloud.normals, normal) {
            normals.push(vector(columns));
        }
        if let (Some(colours), Some(columns)) = (&mut cloud.colours, colour) {
            colours.push(columns.map(|column| properties[column].colour_byte(row[column])));
        }
    }
    Ok(cloud)
}

/// The numbers after the header.
struct Values<'a> {
    body: &'a [u8],
    encoding: Encoding,
    file: &'a str,
}

impl Values<'_> {
    fn error(&self, field: &str, expected: &str, found: &str) -> ReadError {
        ReadError { file: self.file.into(), field: field.into(), expected: expected.into(), found: found.into() }
    }

    /// Checks that `count` rows can be there before anything is allocated or looped over for them.
    fn require(&self, count: usize, properties: &[Property]) -> Result<(), ReadError> {
        let least = match self.encoding {
            Encoding::Ascii => 2,
            _ => properties.iter().map(Property::least_size).sum::<usize>(),
        };
        if count > (self.body.len() + 1) / least.max(1) {
            let expected = format!("at least {least} bytes for each of {count} elements");
            return Err(self.error("data", &expected, &format!("{} bytes", self.body.len())));
        }
        Ok(())
    }

    /// One row; a list gives its length.
    fn row(&mut self, properties: &[Property], row: &mut [f64]) -> Result<(), ReadError> {
        for (value, property) in row.iter_mut().zip(properties) {
            *value = match property.list_length {
                None => self.number(property.scalar)?,
                Some(length) => {
                    let length = self.number(length)?;
                    for _ in 0..length as u64 {
                        self.number(property.scalar)?;
                    }
                    length
                }
            };
        }
        Ok(())
    }

    fn skip(&mut self, properties: &[Property]) -> Result<(), ReadError> {
        let mut row = vec![0.0; properties.len()];
        self.row(properties, &mut row)
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            return self.word();
        }
        let size = scalar.size();
        if self.body.len() < size {
            return Err(self.error("data", "as many values as the header promises", "the end of the file"));
        }
        let (head, rest) = self.body.split_at(size);
        self.body = rest;
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(head);
        if self.encoding == Encoding::BigEndian {
            bytes[..size].reverse();
        }
        Ok(scalar.decode(bytes))
    }

    fn word(&mut self) -> Result<f64, ReadError> {
        let start = self.body.iter().position(|byte| !byte.is_ascii_whitespace());
        let Some(start) = start else {
            return Err(self.error("data", "as many values as the header promises", "the end of the file"));
        };
        let text = &self.body[start..];
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let word = String::from_utf8_lossy(&text[..end]);
        self.body = &text[end..];
        word.parse().map_err(|_| self.error("data", "a number", &word.chars().take(40).collect::<String>()))
    }
}

#[cfg(test)]
mod tests;
