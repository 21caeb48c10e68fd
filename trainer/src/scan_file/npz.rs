//! Point clouds from `.npz`: `points (N, 3)`, optional `normals (N, 3)` and `colors (N, 3)`; also as ReSynth and PoP name them, `scan_pc` and
//! `scan_n`.

use crate::ply::PointCloud;
use crease::numpy::{Archive, Elements, Field, ReadError};
use glam::Vec3A;

/// Reads a cloud; `file` is its name for messages.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<PointCloud, ReadError> {
    let mut archive = Archive::open(bytes, file)?;
    let mut first = |names: &[&str]| -> Result<Option<Field>, ReadError> {
        for name in names {
            if let Some(field) = archive.optional(name)? {
                return Ok(Some(field));
            }
        }
        Ok(None)
    };
    let (points, normals, colours) =
        (first(&["points", "scan_pc"])?, first(&["normals", "scan_n"])?, first(&["colors", "colours"])?);
    let Some(points) = points else { return Err(archive.missing("points or scan_pc")) };
    let count = points.rows_of(3)?;
    if count == 0 {
        return Err(points.error("at least one point", "0"));
    }
    let vectors = |field: &Field| -> Result<Vec<Vec3A>, ReadError> {
        field.expect_shape(&[count, 3])?;
        Ok(field.finite_numbers()?.chunks_exact(3).map(Vec3A::from_slice).collect())
    };
    Ok(PointCloud {
        points: vectors(&points)?,
        normals: normals.as_ref().map(vectors).transpose()?,
        colours: colours.as_ref().map(|field| bytes_of(field, &vectors(field)?)).transpose()?,
        triangles: Vec::new(),
    })
}

/// Colours are bytes where the file has whole numbers, and fractions of 1 where it has floats.
fn bytes_of(field: &Field, colours: &[Vec3A]) -> Result<Vec<[u8; 3]>, ReadError> {
    let is_fraction = matches!(field.array().elements, Elements::F32(_) | Elements::F64(_));
    let (scale, greatest) = if is_fraction { (255.0, 1.0) } else { (1.0, 255.0) };
    if let Some(colour) = colours.iter().find(|colour| colour.min_element() < 0.0 || colour.max_element() > greatest) {
        return Err(field.error(format!("colours from 0 to {greatest}"), colour.to_string()));
    }
    Ok(colours.iter().map(|&colour| (colour * scale).to_array().map(|value| value.round() as u8)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::numpy::{Array, Compression, write_npz};

    fn file(arrays: &[(&str, Array)]) -> Vec<u8> {
        let arrays: Vec<(&str, &Array)> = arrays.iter().map(|(name, array)| (*name, array)).collect();
        write_npz(&arrays, Compression::Deflated).unwrap()
    }

    #[test]
    fn both_sets_of_names_are_read() {
        let points = Array::new(&[2, 3], vec![0f32, 1.0, 2.0, 3.0, 4.0, 5.0]);
        let normals = Array::new(&[2, 3], vec![0f32, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let colours = Array::new(&[2, 3], vec![1u64, 2, 3, 255, 0, 9]);
        let bytes = file(&[("points", points.clone()), ("normals", normals.clone()), ("colors", colours)]);
        let cloud = read(&bytes, "a.npz").unwrap();
        assert_eq!(cloud.points[1], Vec3A::new(3.0, 4.0, 5.0));
        assert_eq!(cloud.normals.unwrap()[1], Vec3A::Z);
        assert_eq!(cloud.colours, Some(vec![[1, 2, 3], [255, 0, 9]]));
        let fractions = Array::new(&[2, 3], vec![0f32, 0.5, 1.0, 0.2, 0.2, 0.2]);
        let bytes = file(&[("scan_pc", points), ("scan_n", normals), ("colors", fractions)]);
        let cloud = read(&bytes, "packed.npz").unwrap();
        assert_eq!((cloud.points.len(), cloud.colours.unwrap()[0]), (2, [0, 128, 255]));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let points = || Array::new(&[1, 3], vec![0f32, 1.0, 2.0]);
        for (arrays, field) in [
            (vec![("vertices", points())], "points or scan_pc"),
            (vec![("points", Array::new(&[0, 3], Vec::<f32>::new()))], "points"),
            (vec![("points", Array::new(&[1, 3], vec![0f32, f32::NAN, 0.0]))], "points"),
            (vec![("points", points()), ("normals", Array::new(&[2, 3], vec![0f32; 6]))], "normals"),
            (vec![("points", points()), ("colors", Array::new(&[1, 3], vec![300u64; 3]))], "colors"),
        ] {
            assert_eq!(read(&file(&arrays), "bad.npz").unwrap_err().field, field);
        }
    }
}
