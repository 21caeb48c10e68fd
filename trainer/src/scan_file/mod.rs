//! One scan from a file of any kind: point clouds as PLY or `.npz`, meshes as PLY or OBJ, which are sampled.

mod npz;
mod obj;

use crate::ply::PointCloud;
use crate::sampling::area_uniform;
use crate::sequence::{read, read_error};
use crease::mesh::vertex_normals;
use crease::numpy::ReadError;
use glam::Vec3A;
use std::path::Path;

/// File name endings of scans, in the order in which they are looked for.
pub const ENDINGS: [&str; 3] = ["ply", "npz", "obj"];
/// Points drawn from a mesh.
const MESH_SAMPLE_COUNT: usize = 40_000;

/// Reads a scan; the ending tells its kind. Meshes are sampled evenly by area, with normals and the colours of their vertices.
pub fn read_scan(path: &Path) -> Result<PointCloud, ReadError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let cloud = decode_scan(&read(path)?, &ending, &path.display().to_string())?;
    Ok(if cloud.triangles.is_empty() { cloud } else { sampled(&cloud, MESH_SAMPLE_COUNT) })
}

/// The cloud or mesh in a file's bytes; `ending` tells its kind, `file` is its name for messages.
pub fn decode_scan(bytes: &[u8], ending: &str, file: &str) -> Result<PointCloud, ReadError> {
    match ending {
        "ply" => PointCloud::read(bytes, file),
        "npz" => npz::read(bytes, file),
        "obj" => obj::read(bytes, file),
        other => Err(read_error(Path::new(file), "ending", "ply, npz or obj", other.into())),
    }
}

/// A cloud of `count` points of a mesh; its vertices where it has no area, or none that can be told.
pub fn sampled(mesh: &PointCloud, count: usize) -> PointCloud {
    let triangles = &mesh.triangles;
    let area = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|vertex| mesh.points[vertex as usize]);
        (b - a).cross(c - a).length()
    };
    let total = triangles.iter().map(area).sum::<f32>();
    if !(total.is_finite() && total > 0.0) {
        return PointCloud { triangles: Vec::new(), ..mesh.clone() };
    }
    let mut normals = vec![Vec3A::ZERO; mesh.points.len()];
    vertex_normals(&mesh.points, triangles, &mut normals);
    let normals = mesh.normals.as_ref().unwrap_or(&normals);
    let samples = area_uniform(&mesh.points, triangles, count, 0);
    let colours = mesh.colours.as_ref().map(|colours| {
        let colours: Vec<Vec3A> = colours.iter().map(|colour| Vec3A::from_array(colour.map(f32::from))).collect();
        let colour = |sample: &crate::closest::SurfacePoint| sample.interpolate(triangles, &colours);
        samples.iter().map(|sample| colour(sample).to_array().map(|value| value.round() as u8)).collect()
    });
    PointCloud {
        points: samples.iter().map(|sample| sample.interpolate(triangles, &mesh.points)).collect(),
        normals: Some(
            samples.iter().map(|sample| sample.interpolate(triangles, normals).normalize_or_zero()).collect(),
        ),
        colours,
        triangles: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_file::MeshFormat;
    use crate::shapes::sphere;

    #[test]
    fn meshes_are_sampled_evenly_with_normals() {
        let mesh = sphere(0.5, 3);
        for format in [MeshFormat::Ply, MeshFormat::Obj] {
            let path = std::env::temp_dir().join(format!("crease-scan-{}.{}", std::process::id(), format.extension()));
            std::fs::write(&path, format.encode(&mesh.positions, &mesh.triangles)).unwrap();
            let cloud = read_scan(&path).unwrap();
            std::fs::remove_file(&path).unwrap();
            assert_eq!(cloud.points.len(), MESH_SAMPLE_COUNT);
            assert!(cloud.triangles.is_empty());
            let upper = cloud.points.iter().filter(|point| point.y > 0.25).count() as f32;
            // A cap of half the radius has a quarter of a sphere's area.
            assert!((upper / MESH_SAMPLE_COUNT as f32 - 0.25).abs() < 0.02);
            for (point, normal) in cloud.points.iter().zip(cloud.normals.as_ref().unwrap()) {
                assert!(normal.dot(point.normalize()) > 0.98);
            }
        }
    }

    #[test]
    fn other_endings_are_refused() {
        let path = std::env::temp_dir().join(format!("crease-scan-{}.xyz", std::process::id()));
        std::fs::write(&path, "0 0 0").unwrap();
        assert_eq!(read_scan(&path).unwrap_err().field, "ending");
        std::fs::remove_file(&path).unwrap();
    }
}
