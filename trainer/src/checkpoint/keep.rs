//! Results that a checkpoint can keep, exactly as they are.

use glam::Vec3A;

/// A result with a form in bytes from which it comes back bit for bit.
pub trait Keep: Sized {
    /// The bytes.
    fn to_bytes(&self) -> Vec<u8>;

    /// What [`Self::to_bytes`] was given; none where the bytes are of another kind.
    fn from_bytes(bytes: &[u8]) -> Option<Self>;
}

impl Keep for Vec<Vec3A> {
    fn to_bytes(&self) -> Vec<u8> {
        self.iter().flat_map(|vector| vector.to_array()).flat_map(f32::to_le_bytes).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (vectors, []) = bytes.as_chunks::<12>() else { return None };
        let number =
            |bytes: &[u8], at: usize| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        Some(vectors.iter().map(|b| Vec3A::new(number(b, 0), number(b, 4), number(b, 8))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_come_back_bit_for_bit() {
        let vectors = vec![Vec3A::new(0.1, -0.0, f32::MIN_POSITIVE), Vec3A::splat(f32::INFINITY)];
        let back = Vec::<Vec3A>::from_bytes(&vectors.to_bytes()).unwrap();
        let bits = |vectors: &[Vec3A]| vectors.iter().flat_map(|v| v.to_array()).map(f32::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&vectors));
        assert_eq!(Vec::<Vec3A>::from_bytes(&[0; 13]), None);
    }
}
