//! Wavefront OBJ: vertices with colours if they have any, and polygons; everything else is skipped.

use crate::ply::PointCloud;
use crease::memory::{Allowance, MemoryLimit, Shortage};
use crease::numpy::ReadError;
use glam::Vec3A;

/// Reads a mesh, or a cloud where there are no faces; `file` is its name for messages.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<PointCloud, ReadError> {
    let allowance = Allowance::new(MemoryLimit::default(), bytes.len());
    let mut cloud = PointCloud::default();
    let mut colours = Vec::new();
    let mut corners = Vec::new();
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let error = |expected: &str, found: &str| ReadError {
            file: file.into(),
            field: format!("line {}", index + 1),
            expected: expected.into(),
            found: found.chars().take(60).collect(),
        };
        let shortage = |short: Shortage| error(&short.expected, &short.found);
        let line = String::from_utf8_lossy(line);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut numbers = [0.0f32; 7];
                let mut count = 0;
                for word in words.take(numbers.len()) {
                    numbers[count] = word.parse().map_err(|_| error("numbers", word))?;
                    count += 1;
                }
                let point = Vec3A::from_slice(&numbers);
                if count < 3 || !point.is_finite() {
                    return Err(error("three finite coordinates", line.trim()));
                }
                allowance.grow(&mut cloud.points, 1).map_err(shortage)?;
                cloud.points.push(point);
                // A fourth number alone is a weight.
                if count >= 6 && colours.len() + 1 == cloud.points.len() {
                    allowance.grow(&mut colours, 1).map_err(shortage)?;
                    let colour = |channel: usize| (255.0 * numbers[3 + channel]).round().clamp(0.0, 255.0) as u8;
                    colours.push(std::array::from_fn(colour));
                }
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    let corner = vertex(word, cloud.points.len())
                        .ok_or_else(|| error(&format!("corners from 1 to {}", cloud.points.len()), word))?;
                    allowance.grow(&mut corners, 1).map_err(shortage)?;
                    corners.push(corner);
                }
                let more = corners.len().saturating_sub(2);
                allowance.grow(&mut cloud.triangles, more).map_err(shortage)?;
                cloud.triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
            }
            _ => {}
        }
    }
    if cloud.points.is_empty() {
        let (field, expected, found) = ("vertices".into(), "at least one".into(), "none".into());
        return Err(ReadError { file: file.into(), field, expected, found });
    }
    cloud.colours = (colours.len() == cloud.points.len()).then_some(colours);
    Ok(cloud)
}

/// The vertex of a corner `v`, `v/vt` or `v/vt/vn`: from 1 on, or from the last back where it is negative.
fn vertex(corner: &str, count: usize) -> Option<u32> {
    let number: i64 = corner.split('/').next()?.parse().ok()?;
    let count = i64::try_from(count).ok()?;
    let index = if number < 0 { count.checked_add(number)? } else { number - 1 };
    (0..count).contains(&index).then_some(u32::try_from(index).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_and_colours_are_read() {
        let text = "o one\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 0 0 0.5\nf 1 2 3 4\n";
        let mesh = read(text.as_bytes(), "quad.obj").unwrap();
        assert_eq!((mesh.points.len(), mesh.triangles), (4, vec![[0, 1, 2], [0, 2, 3]]));
        assert_eq!(mesh.colours.unwrap()[3], [0, 0, 128]);
    }

    #[test]
    fn corners_count_from_either_end_and_may_name_more() {
        let text = "v 0 0 0\r\nv 1 0 0 1.0\r\nvn 0 0 1\r\nv 0 1 0\r\nf -3/1 2//1 3/1/1\r\n# f 9 9 9\r\nl 1 2\r\n";
        let mesh = read(text.as_bytes(), "a.obj").unwrap();
        assert_eq!((mesh.triangles, mesh.colours), (vec![[0, 1, 2]], None));
    }

    #[test]
    fn broken_text_is_refused() {
        for (text, field) in [
            ("v 0 0 zero\n", "line 1"),
            ("v 0 0\n", "line 1"),
            ("v 0 0 inf\n", "line 1"),
            ("# empty\n", "vertices"),
            ("v 0 0 0\nf 1 2 3\n", "line 2"),
            ("v 0 0 0\nf 1 0 1\n", "line 2"),
            ("v 0 0 0\nf -2 1 1\n", "line 2"),
            ("v 0 0 0\nf -9223372036854775808 1 1\n", "line 2"),
        ] {
            assert_eq!(read(text.as_bytes(), "a.obj").unwrap_err().field, field, "{text}");
        }
    }
}
