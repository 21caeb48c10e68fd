//! What a result depends on, as 32 bytes.

use glam::Vec3A;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// SHA-256 of everything that a result depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(pub [u8; 32]);

/// Collects what a result depends on.
#[derive(Clone)]
pub struct Ingredients(Sha256);

impl Ingredients {
    /// Of the computation called `name`, by this version of the trainer.
    pub fn new(name: &str) -> Self {
        Self(Sha256::new()).bytes(env!("CARGO_PKG_VERSION").as_bytes()).bytes(name.as_bytes())
    }

    /// And bytes; their number counts too, so that neighbours cannot be mistaken for each other.
    pub fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// And vectors.
    pub fn points(mut self, points: &[Vec3A]) -> Self {
        self.0.update((points.len() as u64).to_le_bytes());
        for point in points {
            self.0.update(bytemuck::bytes_of(&point.to_array()));
        }
        self
    }

    /// And anything that can be written as JSON.
    pub fn value(self, value: &impl Serialize) -> Self {
        self.bytes(&serde_json::to_vec(value).expect("what training depends on is plain data"))
    }

    /// All of it.
    pub fn finish(self) -> Fingerprint {
        Fingerprint(self.0.finalize().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_changes_changes_the_fingerprint() {
        let of = |name: &str, parts: &[&[u8]]| {
            parts.iter().fold(Ingredients::new(name), |ingredients, part| ingredients.bytes(part)).finish()
        };
        assert_eq!(of("a", &[b"bc"]), of("a", &[b"bc"]));
        for (name, parts) in [("b", vec![&b"bc"[..]]), ("a", vec![b"bd"]), ("a", vec![b"b", b"c"]), ("a", vec![])] {
            assert_ne!(of(name, &parts), of("a", &[b"bc"]), "{name} {parts:?}");
        }
        let points = |z: f32| Ingredients::new("a").points(&[Vec3A::new(1.0, 2.0, z)]).finish();
        assert_ne!(points(3.0), points(3.0000002));
    }
}
