//! Point clouds from PLY files: ASCII and both byte orders; properties that are not asked for are skipped.

mod header;

use crease::memory::{Allowance, MemoryLimit};
use crease::mesh::Triangle;
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
    /// Triangles over the points, if the file is a mesh; larger polygons are cut into fans.
    pub triangles: Vec<Triangle>,
}

impl PointCloud {
    /// Reads the elements `vertex` and `face` of a PLY file. `file` is its name for messages.
    ///
    /// Fails on a malformed header, on fewer bytes than the header promises, on zero points, on coordinates that are not finite, on
    /// faces of vertices that are not there, and where it would take more memory than the default [`MemoryLimit`].
    pub fn read(bytes: &[u8], file: &str) -> Result<Self, ReadError> {
        let header = Header::read(bytes, file)?;
        let allowance = Allowance::new(MemoryLimit::default(), bytes.len());
        let mut values = Values { body: &bytes[header.body_offset..], encoding: header.encoding, file, allowance };
        let (mut cloud, mut triangles) = (None, Vec::new());
        for element in &header.elements {
            match element.name.as_str() {
                "vertex" if element.count == 0 => {
                    return Err(values.error("element vertex", "at least one point", "0"));
                }
                "vertex" => cloud = Some(read_vertices(&mut values, element.count, &element.properties)?),
                "face" => triangles = read_faces(&mut values, element.count, &element.properties)?,
                _ => {
                    values.require(element.count, &element.properties)?;
                    let mut row = vec![0.0; element.properties.len()];
                    for _ in 0..element.count {
                        values.row(&element.properties, &mut row, None)?;
                    }
                }
            }
        }
        let mut cloud: Self = cloud.ok_or_else(|| values.error("header", "an element vertex", "none"))?;
        let count = cloud.points.len();
        if let Some(&vertex) = triangles.iter().flatten().find(|&&vertex| vertex as usize >= count) {
            return Err(values.error(
                "element face",
                &format!("vertices from 0 to {}", count - 1),
                &vertex.to_string(),
            ));
        }
        cloud.triangles = triangles;
        Ok(cloud)
    }
}

/// Polygons as fans of triangles. Faces without a list of vertices are skipped.
fn read_faces(values: &mut Values, count: usize, properties: &[Property]) -> Result<Vec<Triangle>, ReadError> {
    let is_corners = |p: &Property| p.is_list() && ["vertex_indices", "vertex_index"].contains(&p.name.as_str());
    let corners = properties.iter().position(is_corners);
    values.require(count, properties)?;
    let mut triangles = Vec::new();
    let mut row = vec![0.0; properties.len()];
    let mut polygon = Vec::new();
    for index in 0..count {
        polygon.clear();
        values.row(properties, &mut row, corners.map(|column| (column, &mut polygon)))?;
        if let Some(bad) = polygon.iter().find(|&&vertex| !(0.0..=f64::from(u32::MAX)).contains(&vertex)) {
            return Err(values.error(&format!("face {index}"), "indices of vertices", &bad.to_string()));
        }
        values.grow(&mut triangles, polygon.len().saturating_sub(2))?;
        for corner in 2..polygon.len() {
            triangles.push([polygon[0] as u32, polygon[corner - 1] as u32, polygon[corner] as u32]);
        }
    }
    Ok(triangles)
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
        points: Vec::new(),
        normals: normal.map(|_| Vec::new()),
        colours: colour.map(|_| Vec::new()),
        triangles: Vec::new(),
    };
    values.grow(&mut cloud.points, count)?;
    cloud.normals.as_mut().map_or(Ok(()), |normals| values.grow(normals, count))?;
    cloud.colours.as_mut().map_or(Ok(()), |colours| values.grow(colours, count))?;
    let mut row = vec![0.0; properties.len()];
    for index in 0..count {
        values.row(properties, &mut row, None)?;
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
    allowance: Allowance,
}

impl Values<'_> {
    fn error(&self, field: &str, expected: &str, found: &str) -> ReadError {
        ReadError { file: self.file.into(), field: field.into(), expected: expected.into(), found: found.into() }
    }

    /// Makes room in a list that is kept, or says that it would take too much memory.
    fn grow<T>(&self, items: &mut Vec<T>, more: usize) -> Result<(), ReadError> {
        self.allowance.grow(items, more).map_err(|short| self.error("data", &short.expected, &short.found))
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

    /// One row; a list gives its length. `kept` takes the values of the list in a column.
    fn row(
        &mut self,
        properties: &[Property],
        row: &mut [f64],
        mut kept: Option<(usize, &mut Vec<f64>)>,
    ) -> Result<(), ReadError> {
        for (column, (value, property)) in row.iter_mut().zip(properties).enumerate() {
            *value = match property.list_length {
                None => self.number(property.scalar)?,
                Some(length) => {
                    let length = self.number(length)?;
                    for _ in 0..length as u64 {
                        let item = self.number(property.scalar)?;
                        if let Some((_, list)) = kept.as_mut().filter(|(wanted, _)| *wanted == column) {
                            self.grow(list, 1)?;
                            list.push(item);
                        }
                    }
                    length
                }
            };
        }
        Ok(())
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
