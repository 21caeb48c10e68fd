//! What one avatar can take from another of the same body: its wrinkles, its texture.

use super::{Avatar, AvatarError, Texture};
use glam::Vec3A;

/// Two templates of one body lie no further apart than this, metres: files keep them exactly.
const SAME_PLACE: f32 = 1e-4;
/// The same for texture coordinates, as a share of the picture.
const SAME_TEXEL: f32 = 1e-4;

impl Avatar {
    /// This avatar with the wrinkles of `other` (detail transfer, paper section 6): f_l of `other` on this one's base. Both have f_l over
    /// the same canonical body, so they must have the same template; `file` is the name of the other for messages.
    pub fn with_detail_of(&self, other: &Avatar, file: &str) -> Result<Avatar, AvatarError> {
        let error = |field: &str, expected: String, found: String| AvatarError::new(file, field, expected, found);
        let (joints, other_joints) = (self.rig.parents.len(), other.rig.parents.len());
        if joints != other_joints {
            return Err(error("skin", format!("{joints} joints as in {}", self.name), other_joints.to_string()));
        }
        if self.triangles != other.triangles {
            let found = format!("{} other triangles", other.triangles.len());
            return Err(error("mesh", format!("the triangles of {}'s body", self.name), found));
        }
        let furthest = furthest(&self.canonical, &other.canonical);
        if furthest > SAME_PLACE {
            return Err(error(
                "canonical",
                format!("the template of {}'s body", self.name),
                format!("one that is {furthest:.4} m off"),
            ));
        }
        let level = other.laplacian.level();
        if level > self.level_count as usize {
            return Err(error("laplacian.level", format!("at most {}", self.level_count), level.to_string()));
        }
        Ok(Avatar { laplacian: other.laplacian.clone(), form: other.form, ..self.clone() })
    }

    /// The texture of `other`, which must be laid out on the body as this one's is; `file` is the name of the other for messages.
    pub fn texture_of<'a>(&self, other: &'a Avatar, file: &str) -> Result<&'a Texture, AvatarError> {
        let error = |field: &str, expected: String, found: &str| AvatarError::new(file, field, expected, found);
        let (mine, theirs) = (&self.appearance, &other.appearance);
        let Some(texture) = &theirs.texture else {
            return Err(error("texture", "one".into(), "none"));
        };
        let same_layout = mine.drawn_triangles == theirs.drawn_triangles
            && mine.texture_coordinates.len() == theirs.texture_coordinates.len()
            && mine
                .texture_coordinates
                .iter()
                .flatten()
                .zip(theirs.texture_coordinates.iter().flatten())
                .all(|(a, b)| (a - b).abs() <= SAME_TEXEL);
        if !same_layout {
            return Err(error("texture coordinates", format!("those of {}", self.name), "others"));
        }
        Ok(texture)
    }
}

/// The largest distance between partners; infinite where one has none.
fn furthest(a: &[Vec3A], b: &[Vec3A]) -> f32 {
    if a.len() != b.len() {
        return f32::INFINITY;
    }
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animate::{Options, Stage, animate};
    use crate::body::Pose;
    use crate::fixture::{compact_avatar, plain_avatar};
    use glam::Quat;

    fn bent(avatar: &Avatar) -> Pose {
        let mut pose = Pose::rest(avatar.rig.parents.len());
        pose.rotations[16] = Quat::from_rotation_z(0.7);
        pose
    }

    fn detail(avatar: &Avatar, pose: &Pose) -> Vec<Vec3A> {
        let at = |stage| animate(avatar, pose, &Options { stage, ..Options::default() }).unwrap().positions;
        at(Stage::Detailed).iter().zip(at(Stage::Base)).map(|(detailed, base)| *detailed - base).collect()
    }

    #[test]
    fn wrinkles_of_another_come_on_this_one_s_base() {
        let wearer = compact_avatar();
        let mut other = compact_avatar();
        // The other has wrinkles of its own, and another base.
        other.deformation = plain_avatar().deformation;
        let crate::network::SurfaceFunction::Compact(tables) = &mut other.laplacian else { panic!("tables") };
        for number in &mut tables.mean {
            *number *= -1.5;
        }
        let both = wearer.with_detail_of(&other, "other.glb").unwrap();
        let pose = bent(&wearer);
        let base = |avatar: &Avatar| {
            animate(avatar, &pose, &Options { stage: Stage::Base, ..Options::default() }).unwrap().positions
        };
        assert_eq!(base(&both), base(&wearer), "the base stays");
        let (worn, own) = (detail(&both, &pose), detail(&wearer, &pose));
        let length = |vectors: &[Vec3A]| vectors.iter().map(|v| v.length_squared()).sum::<f32>().sqrt();
        let difference: Vec<Vec3A> = worn.iter().zip(&own).map(|(a, b)| *a - *b).collect();
        assert!(length(&difference) > 0.5 * length(&own), "{} of {}", length(&difference), length(&own));
        assert_eq!(wearer.with_detail_of(&wearer, "").unwrap(), wearer);
    }

    #[test]
    fn wrinkles_need_the_same_body() {
        let wearer = compact_avatar();
        let refused = |change: fn(&mut Avatar)| {
            let mut other = compact_avatar();
            change(&mut other);
            wearer.with_detail_of(&other, "other.glb").unwrap_err()
        };
        assert_eq!(refused(|other| other.triangles.swap(0, 1)).field, "mesh");
        assert_eq!(refused(|other| other.canonical[3].x += 0.01).field, "canonical");
        assert_eq!(refused(|other| other.rig.parents.truncate(1)).field, "skin");
        assert!(refused(|other| other.canonical.truncate(3)).to_string().starts_with("other.glb: canonical: expected"));
    }

    #[test]
    fn a_texture_needs_the_same_layout() {
        let wearer = plain_avatar();
        assert!(wearer.texture_of(&plain_avatar(), "other.glb").is_ok());
        assert_eq!(wearer.texture_of(&compact_avatar(), "other.glb").unwrap_err().field, "texture");
        let mut other = plain_avatar();
        other.appearance.texture_coordinates[0][0] += 0.1;
        assert_eq!(wearer.texture_of(&other, "other.glb").unwrap_err().field, "texture coordinates");
    }
}
