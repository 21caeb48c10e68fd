//! A posed mesh as a file for other programs: GLB, OBJ, PLY.

mod glb;
mod obj;
mod ply;
mod texels;

pub use texels::Texels;

use crate::avatar::Texture;
use crate::mesh::{Triangle, vertex_normals};
use glam::Vec3A;

/// Kind of mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// glTF in one binary file, with the texture in it.
    Glb,
    /// Wavefront OBJ: text; colours after the positions.
    Obj,
    /// PLY, binary little endian; colours and texture coordinates at the vertices.
    Ply,
}

impl MeshFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Glb, Self::Obj, Self::Ply];

    /// The file name's end.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Obj => "obj",
            Self::Ply => "ply",
        }
    }
}

/// A mesh, and what is on it. Lists that are not empty have one entry a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportedMesh {
    /// Metres, y up.
    pub positions: Vec<Vec3A>,
    /// Unit vectors.
    pub normals: Vec<Vec3A>,
    /// Counter-clockwise from outside.
    pub triangles: Vec<Triangle>,
    /// (u, v), v down, as glTF has it.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// sRGB.
    pub colours: Vec<[u8; 3]>,
    /// The texture.
    pub texture: Option<Texture>,
}

impl ExportedMesh {
    /// A bare surface, with its normals.
    pub fn of_surface(positions: &[Vec3A], triangles: &[Triangle]) -> Self {
        let mut normals = vec![Vec3A::ZERO; positions.len()];
        vertex_normals(positions, triangles, &mut normals);
        Self { positions: positions.to_vec(), normals, triangles: triangles.to_vec(), ..Self::default() }
    }

    /// The file's bytes. Of the texture, GLB holds the picture, and the others what [`Self::colours`] hold.
    pub fn encode(&self, format: MeshFormat) -> Vec<u8> {
        match format {
            MeshFormat::Glb => glb::encode(self),
            MeshFormat::Obj => obj::encode(self).into_bytes(),
            MeshFormat::Ply => ply::encode(self),
        }
    }

    /// Takes each vertex's colour from the texture, decoded.
    pub fn colour_by(&mut self, texels: &Texels<'_>) {
        self.colours = self.texture_coordinates.iter().map(|&at| texels.at(at)).collect();
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A square of two triangles in the plane z = 0.
    pub fn square() -> ExportedMesh {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3A::from_array);
        ExportedMesh::of_surface(&positions, &[[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn a_bare_surface_gets_its_normals() {
        assert_eq!(square().normals, [Vec3A::Z; 4]);
    }

    #[test]
    fn colours_come_from_the_texture() {
        let mut mesh = square();
        mesh.texture_coordinates = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.5]];
        let pixels = [[10, 0, 0, 255], [20, 0, 0, 255], [30, 0, 0, 255], [40, 0, 0, 255]].concat();
        mesh.colour_by(&Texels::new(2, 2, &pixels).unwrap());
        let red: Vec<u8> = mesh.colours.iter().map(|colour| colour[0]).collect();
        assert_eq!(red, [10, 20, 40, 25], "corners, and the middle of all four");
    }
}
