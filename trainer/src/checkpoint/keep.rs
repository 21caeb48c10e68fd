//! Results that a checkpoint can keep, exactly as they are.

use crease::body::Pose;
use glam::{Quat, Vec3, Vec3A};

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
        let numbers = numbers(bytes)?;
        let (vectors, []) = numbers.as_chunks() else { return None };
        Some(vectors.iter().copied().map(Vec3A::from_array).collect())
    }
}

impl Keep for Pose {
    /// The translation's numbers, then four of each rotation.
    fn to_bytes(&self) -> Vec<u8> {
        let rotations = self.rotations.iter().flat_map(|rotation| rotation.to_array());
        self.translation.to_array().into_iter().chain(rotations).flat_map(f32::to_le_bytes).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let numbers = numbers(bytes)?;
        let (&translation, rotations) = numbers.split_first_chunk()?;
        let (rotations, []) = rotations.as_chunks() else { return None };
        let rotations = rotations.iter().copied().map(Quat::from_array).collect();
        Some(Self { rotations, translation: Vec3::from_array(translation) })
    }
}

impl Keep for Vec<Pose> {
    /// The number of poses, 8 bytes; then those of each, which are as many for all.
    fn to_bytes(&self) -> Vec<u8> {
        let count = (self.len() as u64).to_le_bytes();
        count.into_iter().chain(self.iter().flat_map(Keep::to_bytes)).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (&count, bytes) = bytes.split_first_chunk()?;
        match usize::try_from(u64::from_le_bytes(count)).ok()? {
            0 => bytes.is_empty().then(Vec::new),
            count if bytes.is_empty() || !bytes.len().is_multiple_of(count) => None,
            count => bytes.chunks_exact(bytes.len() / count).map(Pose::from_bytes).collect(),
        }
    }
}

fn numbers(bytes: &[u8]) -> Option<Vec<f32>> {
    let (numbers, []) = bytes.as_chunks() else { return None };
    Some(numbers.iter().map(|&number| f32::from_le_bytes(number)).collect())
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
        assert_eq!(Vec::<Vec3A>::from_bytes(&[0; 16]), None);
    }

    #[test]
    fn poses_come_back_bit_for_bit() {
        let pose = |w: f32| Pose {
            rotations: vec![Quat::from_xyzw(0.1, -0.0, w, 0.9), Quat::IDENTITY],
            translation: Vec3::new(w, 0.3, f32::MIN_POSITIVE),
        };
        for poses in [vec![pose(0.2), pose(-0.7)], vec![]] {
            let bytes = poses.to_bytes();
            let back = Vec::<Pose>::from_bytes(&bytes).unwrap();
            assert_eq!(back, poses);
            assert_eq!(back.to_bytes(), bytes);
        }
        let bytes = vec![pose(0.2), pose(-0.7)].to_bytes();
        for length in [0, 7, 8, bytes.len() - 4, bytes.len() - 1] {
            assert_eq!(Vec::<Pose>::from_bytes(&bytes[..length]), None, "{length}");
        }
    }
}
