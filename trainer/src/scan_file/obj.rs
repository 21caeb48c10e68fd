//! Wavefront OBJ: vertices with colours if they have any, and polygons.

use crate::ply::PointCloud;
use crease::numpy::ReadError;
use glam::Vec3A;

/// Reads a mesh, or a cloud where there are no faces; `file` is its name for messages.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<PointCloud, ReadError> {
    let error = |field: &str, expected: &str, found: String| ReadError {
        file: file.into(),
        field: field.into(),
        expected: expected.into(),
        found,
    };
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut &*bytes, &options, materials)
        .map_err(|problem| error("text", "vertices and faces", problem.to_string()))?;
    let mut cloud = PointCloud::default();
    let mut colours = Vec::new();
    for model in models {
        let first = cloud.points.len() as u32;
        cloud.points.extend(model.mesh.positions.chunks_exact(3).map(Vec3A::from_slice));
        colours.extend(
            model
                .mesh
                .vertex_color
                .chunks_exact(3)
                .map(|c| [0, 1, 2].map(|i| (255.0 * c[i]).round().clamp(0.0, 255.0) as u8)),
        );
        cloud.triangles.extend(model.mesh.indices.chunks_exact(3).map(|c| [c[0] + first, c[1] + first, c[2] + first]));
    }
    if cloud.points.is_empty() {
        return Err(error("vertices", "at least one in a face", "none".into()));
    }
    if let Some(index) = cloud.points.iter().position(|point| !point.is_finite()) {
        return Err(error(&format!("vertex {index}"), "finite coordinates", cloud.points[index].to_string()));
    }
    cloud.colours = (colours.len() == cloud.points.len()).then_some(colours);
    Ok(cloud)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_and_colours_are_read() {
        let text = "o one\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 0 0 0.5\nf 1 2 3 4\n";
        let mesh = read(text.as_bytes(), "quad.obj").unwrap();
        assert_eq!((mesh.points.len(), mesh.triangles.len()), (4, 2));
        assert_eq!(mesh.colours.unwrap()[3], [0, 0, 128]);
    }

    #[test]
    fn broken_text_is_refused() {
        assert_eq!(read(b"v 0 0 zero\n", "a.obj").unwrap_err().field, "text");
        assert_eq!(read(b"# empty\n", "a.obj").unwrap_err().field, "vertices");
        assert!(read(b"v 0 0 0\nf 1 2 3\n", "a.obj").is_err(), "faces of vertices that are not there");
    }
}
