//! Meshes for other programs, as the command line names them.

use crease::export::{self, ExportedMesh};
use crease::mesh::Triangle;
use glam::Vec3A;

/// Kind of mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MeshFormat {
    /// glTF in one binary file.
    Glb,
    /// Wavefront OBJ: text.
    Obj,
    /// PLY, binary little endian.
    Ply,
}

impl From<MeshFormat> for export::MeshFormat {
    fn from(format: MeshFormat) -> Self {
        match format {
            MeshFormat::Glb => Self::Glb,
            MeshFormat::Obj => Self::Obj,
            MeshFormat::Ply => Self::Ply,
        }
    }
}

impl MeshFormat {
    /// The file name's end.
    pub fn extension(self) -> &'static str {
        export::MeshFormat::from(self).extension()
    }

    /// The file's bytes, with vertex normals. Positions are metres.
    pub fn encode(self, positions: &[Vec3A], triangles: &[Triangle]) -> Vec<u8> {
        ExportedMesh::of_surface(positions, triangles).encode(self.into())
    }
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
}
