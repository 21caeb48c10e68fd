//! How the figure's surface is drawn.

/// What the surface's colours tell. The numbers are those in figure.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum View {
    /// Cloth under light.
    #[default]
    Lit = 0,
    /// Clay under light, and the mesh's edges.
    Wireframe = 1,
    /// Normals as colours: x, y, z from -1 to 1 are red, green, blue from none to full.
    Normals = 2,
    /// One number a vertex, in place of its normal: red above zero, blue below.
    Values = 3,
}

/// With [`View::Values`], numbers from minus this to this take the whole scale of colours; figure.wgsl has it, too.
pub const VALUE_RANGE: f32 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_has_the_same_range() {
        assert!(include_str!("figure.wgsl").contains(&format!("const VALUE_RANGE = {VALUE_RANGE:.1};")));
    }
}
