//! The surface as it is drawn: texture seams split vertices, so drawn vertices outnumber the body's.
//!
//! Level 0 of the drawn surface is in the avatar's appearance. Its subdivision runs beside the body's: triangles correspond one to
//! one and corner by corner, which gives the body vertex of every drawn vertex of the finest level.

use crate::avatar::{Appearance, AvatarError};
use crate::mesh::{Adjacency, EdgeIndex, Triangle, VertexValue};
use glam::{Vec2, Vec3};

/// What never changes about a drawn vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct DrawnVertex {
    /// Vertex of the body's finest level whose position and normal it takes.
    pub body_vertex: u32,
    /// (u, v), v down.
    pub texture_coordinates: [f32; 2],
    /// Linear RGB and 255; white where there is a texture.
    pub colour: [u8; 4],
}

impl DrawnVertex {
    /// Its colour in sRGB.
    pub fn srgb(&self) -> [u8; 3] {
        let [red, green, blue, _] = self.colour;
        [red, green, blue].map(|linear| {
            let linear = f32::from(linear) / 255.0;
            let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            (255.0 * encoded).round() as u8
        })
    }
}

/// Drawn vertices of the finest level, and triangles over them.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnSurface {
    /// Vertices.
    pub vertices: Vec<DrawnVertex>,
    /// Triangles of every level over `vertices`, level 0 first: a level's vertices come first in all finer ones. The last entry is in the
    /// order of the body's finest triangles.
    pub levels: Vec<Vec<Triangle>>,
}

impl DrawnSurface {
    /// Subdivides `appearance` until it has as many triangles as the body's finest level, `body_triangles`. New texture coordinates and
    /// colours lie in the middle of their edge. `name` is the avatar's, for messages.
    pub fn new(appearance: &Appearance, body_triangles: &[Triangle], name: &str) -> Result<Self, AvatarError> {
        let level_count = level_count(appearance.drawn_triangles.len(), body_triangles.len(), name)?;
        let mut coordinates = texture_coordinates(appearance);
        let mut colours = colours(appearance);
        let mut levels = vec![appearance.drawn_triangles.clone()];
        for level in 0..level_count {
            let index = EdgeIndex::new(coordinates.len(), &levels[level]);
            let edges = index.edges();
            add_middles(&mut coordinates, &edges);
            add_middles(&mut colours, &edges);
            levels.push(index.split(&levels[level]));
        }
        let body_vertices = body_vertices(coordinates.len(), &levels[level_count], body_triangles);
        let vertices =
            coordinates.iter().zip(&colours).zip(body_vertices).map(|((coordinates, colour), body_vertex)| {
                let [red, green, blue] = colour.to_array().map(|number| number.round() as u8);
                DrawnVertex {
                    body_vertex,
                    texture_coordinates: coordinates.to_array(),
                    colour: [red, green, blue, 255],
                }
            });
        Ok(Self { vertices: vertices.collect(), levels })
    }

    /// The edges of a level's triangles, each once.
    pub fn edges(&self, level: usize) -> Vec<[u32; 2]> {
        Adjacency::new(self.vertices.len(), &self.levels[level]).edges()
    }
}

/// Each subdivision makes four triangles of one.
fn level_count(coarse: usize, fine: usize, name: &str) -> Result<usize, AvatarError> {
    let levels = (0..12).find(|&levels| coarse << (2 * levels) >= fine).unwrap_or(0);
    if coarse << (2 * levels) == fine && coarse > 0 {
        return Ok(levels);
    }
    Err(AvatarError {
        file: name.into(),
        field: "appearance: drawn triangles".into(),
        expected: format!("as many as the body has on level 0, for {fine} on its finest"),
        found: coarse.to_string(),
    })
}

fn texture_coordinates(appearance: &Appearance) -> Vec<Vec2> {
    let mut coordinates: Vec<Vec2> = appearance.texture_coordinates.iter().map(|&uv| Vec2::from(uv)).collect();
    coordinates.resize(appearance.drawn_vertices.len(), Vec2::ZERO);
    coordinates
}

fn colours(appearance: &Appearance) -> Vec<Vec3> {
    let mut colours = Vec::new();
    if appearance.texture.is_none() {
        let numbers = appearance.vertex_colours.iter();
        colours.extend(numbers.map(|colour| Vec3::from(colour.map(f32::from))));
    }
    colours.resize(appearance.drawn_vertices.len(), Vec3::splat(255.0));
    colours
}

/// Appends what lies in the middle of each edge.
fn add_middles<T: VertexValue>(values: &mut Vec<T>, edges: &[[u32; 2]]) {
    values.reserve_exact(edges.len());
    for &[a, b] in edges {
        values.push((values[a as usize] + values[b as usize]) * 0.5);
    }
}

/// The body vertex of each drawn vertex, read off corresponding corners.
fn body_vertices(drawn_count: usize, drawn: &[Triangle], body: &[Triangle]) -> Vec<u32> {
    let mut vertices = vec![0; drawn_count];
    for (drawn, body) in drawn.iter().zip(body) {
        for corner in 0..3 {
            vertices[drawn[corner] as usize] = body[corner];
        }
    }
    vertices
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Scheme, Subdivision};

    /// Two triangles that share the edge 1–2, torn apart along it by a texture seam: six drawn vertices for four of the body.
    const BODY: [Triangle; 2] = [[0, 1, 2], [2, 1, 3]];
    const POSITIONS: [Vec2; 4] = [Vec2::new(0.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0)];

    fn appearance() -> Appearance {
        let drawn_vertices = vec![0, 1, 2, 2, 1, 3];
        let texture_coordinates = drawn_vertices.iter().map(|&v: &u32| POSITIONS[v as usize].to_array());
        Appearance {
            texture_coordinates: texture_coordinates.collect(),
            drawn_triangles: vec![[0, 1, 2], [3, 4, 5]],
            texture: None,
            vertex_colours: vec![[0, 100, 200]; drawn_vertices.len()],
            drawn_vertices,
        }
    }

    fn fine_body(levels: usize) -> (Vec<Triangle>, Vec<Vec2>) {
        let subdivision = Subdivision::new(4, &BODY, levels);
        let mut positions = POSITIONS.to_vec();
        for level in 0..levels {
            let mut fine = vec![Vec2::ZERO; subdivision.vertex_count(level + 1)];
            subdivision.refine(Scheme::Midpoint, level, &positions, &mut fine);
            positions = fine;
        }
        (subdivision.triangles(levels).to_vec(), positions)
    }

    #[test]
    fn every_fine_drawn_vertex_finds_the_body_vertex_at_its_own_place() {
        for levels in 0..4 {
            let (triangles, positions) = fine_body(levels);
            let surface = DrawnSurface::new(&appearance(), &triangles, "test").unwrap();
            let counts: Vec<usize> = surface.levels.iter().map(Vec::len).collect();
            assert_eq!(counts, (0..=levels).map(|level| 2 << (2 * level)).collect::<Vec<_>>());
            assert!(surface.vertices.len() > positions.len(), "the seam stays open");
            for vertex in &surface.vertices {
                // Texture coordinates equal positions here, so that they tell the place.
                assert_eq!(positions[vertex.body_vertex as usize].to_array(), vertex.texture_coordinates);
                assert_eq!(vertex.colour, [0, 100, 200, 255]);
            }
        }
    }

    #[test]
    fn every_edge_is_there_once() {
        let (triangles, _) = fine_body(0);
        let surface = DrawnSurface::new(&appearance(), &triangles, "test").unwrap();
        assert_eq!(surface.edges(0), [[0, 1], [0, 2], [1, 2], [3, 4], [3, 5], [4, 5]], "the seam stays open");
    }

    #[test]
    fn a_shuffled_correspondence_would_be_noticed() {
        let (mut triangles, positions) = fine_body(2);
        triangles.swap(0, 9);
        let surface = DrawnSurface::new(&appearance(), &triangles, "test").unwrap();
        let displaced =
            |vertex: &&DrawnVertex| positions[vertex.body_vertex as usize].to_array() != vertex.texture_coordinates;
        assert!(surface.vertices.iter().filter(displaced).count() > 0);
    }

    #[test]
    fn a_wrong_number_of_triangles_is_an_error_with_both_numbers() {
        let error = DrawnSurface::new(&appearance(), &[[0, 1, 2]; 31], "a.glb").unwrap_err();
        assert_eq!((error.file.as_str(), error.found.as_str()), ("a.glb", "2"));
        assert!(error.expected.contains("31"));
    }
}
