//! Baking scan colours into the body's texture.
//!
//! Every coloured scan point is carried to the surface point closest to it, splatted into the texture there, and texels that no point
//! reaches are filled from coarser levels of a pyramid, over the seams too, so that filtering never picks up a background.

use crease::body::TextureCoordinates;

/// A scan point on the body's surface, with its colour.
#[derive(Clone, Copy, Debug)]
pub struct ColouredPoint {
    /// Triangle of level 0.
    pub triangle: u32,
    /// Barycentrics in it.
    pub barycentrics: [f32; 3],
    /// sRGB.
    pub colour: [u8; 3],
    /// Its weight in the average.
    pub weight: f32,
}

/// Sums of weighted colour, texel by texel.
#[derive(Clone, Debug)]
pub struct TextureAccumulator {
    size: usize,
    /// Red, green, blue times weight, then weight.
    sums: Vec<[f32; 4]>,
}

impl TextureAccumulator {
    /// An empty texture of `size` × `size` texels; `size` is a power of two.
    pub fn new(size: usize) -> Self {
        assert!(size.is_power_of_two(), "the filling pyramid halves the size down to one");
        Self { size, sums: vec![[0.0; 4]; size * size] }
    }

    /// Adds points by bilinear splats.
    pub fn splat(&mut self, coordinates: &TextureCoordinates, points: &[ColouredPoint]) {
        let last = self.size as i64 - 1;
        for point in points {
            let corners = coordinates.triangles[point.triangle as usize];
            let (mut u, mut v) = (0.0, 0.0);
            for (corner, weight) in corners.iter().zip(point.barycentrics) {
                let coordinate = coordinates.coordinates[*corner as usize];
                u += coordinate[0] * weight;
                v += coordinate[1] * weight;
            }
            // Texel centres are at half-integers; v points up, rows go down.
            let x = u * self.size as f32 - 0.5;
            let y = (1.0 - v) * self.size as f32 - 0.5;
            let (left, top) = (x.floor(), y.floor());
            for (column, row, weight) in [
                (0, 0, (1.0 - (x - left)) * (1.0 - (y - top))),
                (1, 0, (x - left) * (1.0 - (y - top))),
                (0, 1, (1.0 - (x - left)) * (y - top)),
                (1, 1, (x - left) * (y - top)),
            ] {
                let column = (left as i64 + column).clamp(0, last) as usize;
                let row = (top as i64 + row).clamp(0, last) as usize;
                let weight = weight * point.weight;
                let sum = &mut self.sums[row * self.size + column];
                for channel in 0..3 {
                    sum[channel] += weight * f32::from(point.colour[channel]);
                }
                sum[3] += weight;
            }
        }
    }

    /// The finished texture: sRGB bytes, rows from the top.
    pub fn finish(&self) -> Vec<u8> {
        let filled = fill(self.size, &self.sums);
        filled.iter().flat_map(|colour| colour.map(|c| c.round().clamp(0.0, 255.0) as u8)).collect()
    }
}

/// Colours of a level of the pyramid, holes filled from the level above (pull, then push).
fn fill(size: usize, sums: &[[f32; 4]]) -> Vec<[f32; 3]> {
    if size == 1 {
        let [r, g, b, weight] = sums[0];
        let weight = weight.max(1e-6);
        return vec![[r / weight, g / weight, b / weight]];
    }
    let half = size / 2;
    let mut coarse = vec![[0.0; 4]; half * half];
    for row in 0..size {
        for column in 0..size {
            let sum = sums[row * size + column];
            // A well-covered texel weighs no more than one: coarse levels average surface, not density.
            let share = if sum[3] > 1.0 { 1.0 / sum[3] } else { 1.0 };
            let target = &mut coarse[(row / 2) * half + column / 2];
            for channel in 0..4 {
                target[channel] += sum[channel] * share;
            }
        }
    }
    let above = fill(half, &coarse);
    (0..size * size)
        .map(|i| {
            let (row, column) = (i / size, i % size);
            let background = bilinear(half, &above, (column as f32 - 0.5) / 2.0, (row as f32 - 0.5) / 2.0);
            let sum = sums[i];
            let share = sum[3].min(1.0);
            std::array::from_fn(|c| {
                let own = if sum[3] > 0.0 { sum[c] / sum[3] } else { 0.0 };
                own * share + background[c] * (1.0 - share)
            })
        })
        .collect()
}

fn bilinear(size: usize, texels: &[[f32; 3]], x: f32, y: f32) -> [f32; 3] {
    let last = size as i64 - 1;
    let (left, top) = (x.floor(), y.floor());
    let at = |column: f32, row: f32| {
        texels[(row as i64).clamp(0, last) as usize * size + (column as i64).clamp(0, last) as usize]
    };
    let (s, t) = (x - left, y - top);
    std::array::from_fn(|c| {
        (at(left, top)[c] * (1.0 - s) + at(left + 1.0, top)[c] * s) * (1.0 - t)
            + (at(left, top + 1.0)[c] * (1.0 - s) + at(left + 1.0, top + 1.0)[c] * s) * t
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> TextureCoordinates {
        TextureCoordinates {
            coordinates: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    #[test]
    fn points_land_where_their_coordinates_say() {
        let mut texture = TextureAccumulator::new(8);
        // Corner (0, 1) of the square is the texture's top left.
        texture.splat(
            &square(),
            &[
                ColouredPoint { triangle: 1, barycentrics: [0.0, 0.0, 1.0], colour: [200, 0, 0], weight: 1.0 },
                ColouredPoint { triangle: 0, barycentrics: [0.0, 1.0, 0.0], colour: [0, 0, 100], weight: 1.0 },
            ],
        );
        let bytes = texture.finish();
        assert_eq!(&bytes[..3], &[200, 0, 0], "top left");
        assert_eq!(&bytes[bytes.len() - 3..], &[0, 0, 100], "bottom right");
    }

    #[test]
    fn holes_take_their_neighbours_colours() {
        let mut texture = TextureAccumulator::new(16);
        let points: Vec<ColouredPoint> = (0..40)
            .map(|i| ColouredPoint {
                triangle: 0,
                barycentrics: [1.0 - i as f32 / 40.0, i as f32 / 40.0, 0.0],
                colour: [90, 120, 150],
                weight: 1.0,
            })
            .collect();
        texture.splat(&square(), &points);
        for texel in texture.finish().chunks_exact(3) {
            for (channel, expected) in texel.iter().zip([90u8, 120, 150]) {
                assert!(channel.abs_diff(expected) <= 1, "{texel:?}");
            }
        }
    }
}
