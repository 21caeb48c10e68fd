//! Positional encoding γ of a query point (paper, Function input).

use glam::Vec3A;

/// γ: the raw coordinates, then sin and cos of 2^i π x for i = 0 .. `frequency_count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct PositionalEncoding {
    /// Ten in the paper.
    pub frequency_count: u32,
}

impl PositionalEncoding {
    /// Length of an encoded point: 3 + 6 × frequencies (63 for ten).
    pub fn length(self) -> usize {
        3 + 6 * self.frequency_count as usize
    }

    /// Encodes `point` (metres, on the canonical body) into `out`: x y z, then for each frequency sin x y z, cos x y z.
    pub fn encode(self, point: Vec3A, out: &mut [f32]) {
        out[..3].copy_from_slice(&point.to_array());
        for i in 0..self.frequency_count as usize {
            let angle = point * (std::f32::consts::PI * (1u32 << i) as f32);
            for axis in 0..3 {
                let (sine, cosine) = angle[axis].sin_cos();
                out[3 + 6 * i + axis] = sine;
                out[6 + 6 * i + axis] = cosine;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_frequencies_make_sixty_three_numbers() {
        let encoding = PositionalEncoding { frequency_count: 10 };
        let mut out = vec![f32::NAN; encoding.length()];
        encoding.encode(Vec3A::new(0.5, 0.0, -0.25), &mut out);
        assert_eq!(out.len(), 63);
        assert!(out.iter().all(|x| x.is_finite()));
        assert_eq!(&out[..3], &[0.5, 0.0, -0.25]);
        assert!((out[3] - 1.0).abs() < 1e-6, "sin(π/2)");
        assert!((out[6]).abs() < 1e-6, "cos(π/2)");
        assert!((out[9]).abs() < 1e-6, "sin(π)");
    }
}
