//! Meshes for other programs: OBJ and PLY, with vertex normals.

use crease::mesh::{Triangle, vertex_normals};
use glam::Vec3A;
use std::fmt::Write;

/// Kind of mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MeshFormat {
    /// Wavefront OBJ: text.
    Obj,
    /// PLY, binary little endian.
    Ply,
}

impl MeshFormat {
    /// The file name's end.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
        }
    }

    /// The file's bytes. Positions are metres.
    pub fn encode(self, positions: &[Vec3A], triangles: &[Triangle]) -> Vec<u8> {
        let mut normals = vec![Vec3A::ZERO; positions.len()];
        vertex_normals(positions, triangles, &mut normals);
        match self {
            Self::Obj => obj(positions, &normals, triangles).into_bytes(),
            Self::Ply => ply(positions, &normals, triangles),
        }
    }
}

fn obj(positions: &[Vec3A], normals: &[Vec3A], triangles: &[Triangle]) -> String {
    let mut text = String::new();
    let lines = |text: &mut String, word: &str, vectors: &[Vec3A]| {
        for v in vectors {
            writeln!(text, "{word} {:.6} {:.6} {:.6}", v.x, v.y, v.z).expect("a string takes all");
        }
    };
    lines(&mut text, "v", positions);
    lines(&mut text, "vn", normals);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}").expect("a string takes all");
    }
    text
}

fn ply(positions: &[Vec3A], normals: &[Vec3A], triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face {}\nproperty list uchar uint vertex_indices\n\
         end_header\n",
        positions.len(),
        triangles.len()
    )
    .into_bytes();
    for (position, normal) in positions.iter().zip(normals) {
        for number in position.to_array().into_iter().chain(normal.to_array()) {
            bytes.extend(number.to_le_bytes());
        }
    }
    for triangle in triangles {
        bytes.push(3);
        for vertex in triangle {
            bytes.extend(vertex.to_le_bytes());
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ply::PointCloud;
    use crate::shapes::sphere;

    #[test]
    fn ply_reads_back() {
        let mesh = sphere(0.5, 1);
        let cloud = PointCloud::read(&MeshFormat::Ply.encode(&mesh.positions, &mesh.triangles), "mesh.ply").unwrap();
        assert_eq!(cloud.points, mesh.positions);
        assert!(cloud.normals.unwrap()[3].dot(mesh.positions[3].normalize()) > 0.99);
    }

    #[test]
    fn obj_counts_from_one() {
        let text = obj(&[Vec3A::ZERO, Vec3A::X, Vec3A::Y], &[Vec3A::Z; 3], &[[0, 1, 2]]);
        assert!(text.contains("v 1.000000 0.000000 0.000000\n") && text.ends_with("f 1//1 2//2 3//3\n"), "{text}");
    }
}
