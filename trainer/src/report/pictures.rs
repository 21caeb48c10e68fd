//! What a report shows of a frame: the scan, the base, the detailed mesh and its error, side by side, from two sides.

use crate::comparison::Comparison;
use crate::nearest::NearestPoints;
use crate::normals::unit_normals;
use crate::sequence::GroundTruth;
use crate::studio::{Figure, Studio, splats};
use crease::animate::{Animator, Options, Stage};
use crease::body::Pose;
use crease::mesh::Triangle;
use crease::render::{Scene, VALUE_RANGE, View};
use glam::{Quat, Vec3, Vec3A};
use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, RgbaImage};
use std::f32::consts::PI;
use std::num::NonZero;

/// The error that takes the whole scale of colours, metres.
pub const WHOLE_SCALE_METRES: f32 = 0.02;
/// Width and height of a picture.
const SIZE: [u32; 2] = [300, 400];
const JPEG_QUALITY: u8 = 82;
/// From the eye to the figure.
const EYE_METRES: f32 = 3.4;
/// Eyes: before the figure, somewhat from its left, and behind it.
const AZIMUTHS: [f32; 2] = [0.35, 0.35 + PI];
/// Half the width of a drawn point, as a share of the usual distance to the nearest one: points at random leave larger gaps, too.
const SPLAT_SHARE: f32 = 1.7;
/// Points whose neighbours' distance tells how large a point is drawn.
const SPACING_SAMPLES: usize = 500;

/// A row of pictures of one frame, seen from one side, as JPEG.
pub struct Row {
    /// Frame of the sequence.
    pub frame: usize,
    /// A file for each of [`COLUMNS`].
    pub pictures: [Vec<u8>; COLUMNS.len()],
}

/// What the pictures of a row show.
pub const COLUMNS: [&str; 5] = ["scan", "base", "detailed", "detailed, in its colours", "error of the detailed mesh"];

/// Draws frames of one avatar.
pub struct Photographer<'a> {
    animator: Animator,
    liveliness: f32,
    triangles: Vec<Triangle>,
    clay: Figure<'a>,
    dressed: Figure<'a>,
    studio: &'a Studio,
}

impl<'a> Photographer<'a> {
    /// Prepares to draw what `animator` poses, as lively as [`Options::liveliness`] says.
    pub fn new(studio: &'a Studio, animator: Animator, liveliness: f32) -> anyhow::Result<Self> {
        let triangles = animator.triangles().to_vec();
        let (clay, dressed) = (studio.clay(&animator)?, studio.dressed(&animator)?);
        Ok(Self { animator, liveliness, triangles, clay, dressed, studio })
    }

    /// Pictures of a frame: its `scan`, which is drawn, and its `truth`, which the error is measured against.
    pub fn rows(
        &mut self,
        frame: usize,
        pose: &Pose,
        scan: &GroundTruth,
        truth: &GroundTruth,
    ) -> anyhow::Result<Vec<Row>> {
        let options = Options { liveliness: self.liveliness, ..Options::default() };
        let [base, detailed] = [Stage::Base, Stage::Detailed]
            .map(|stage| self.animator.animate(pose, &Options { stage, ..options }).to_vec());
        let comparison = Comparison::new(&detailed, &self.triangles, truth)?;
        let gaps = comparison.gaps_at_vertices(detailed.len(), &self.triangles);
        let values: Vec<f32> =
            gaps.iter().map(|gap| gap.unwrap_or_default() / WHOLE_SCALE_METRES * VALUE_RANGE).collect();
        let splats = splats(&scan.points, &scan.normals, None, SPLAT_SHARE * spacing(&scan.points));
        let mut points = self.studio.figure(&splats.surface, splats.positions.len(), None);

        let root = self.animator.avatar().rig.root(pose);
        let facing = pose.rotations.first().copied().unwrap_or(Quat::IDENTITY) * Vec3::Z;
        let mut rows = Vec::new();
        for azimuth in AZIMUTHS {
            let mut scene = Scene::default();
            scene.camera.follow(root);
            scene.camera.set_orbit(Some(azimuth + facing.x.atan2(facing.z)), None, Some(EYE_METRES), 1.0);
            scene.camera.set_target(Some(Vec3::new(0.0, root.y.clamp(0.4, 1.2), 0.0)));
            scene.camera.jump();
            let mut lit = |figure: &mut Figure, positions: &[Vec3A], normals: &[Vec3A]| {
                scene.set_figure(positions, normals, 0);
                jpeg(figure.picture(&scene, SIZE)?)
            };
            let base_normals = unit_normals(&base, &self.triangles);
            let detailed_normals = unit_normals(&detailed, &self.triangles);
            let mut pictures = [
                lit(&mut points, &splats.positions, &splats.normals)?,
                lit(&mut self.clay, &base, &base_normals)?,
                lit(&mut self.clay, &detailed, &detailed_normals)?,
                lit(&mut self.dressed, &detailed, &detailed_normals)?,
                Vec::new(),
            ];
            scene.view = View::Values;
            scene.set_figure_of_values(&detailed, &values, 0);
            pictures[4] = jpeg(self.clay.picture(&scene, SIZE)?)?;
            rows.push(Row { frame, pictures });
        }
        Ok(rows)
    }
}

/// The usual distance from a point to its nearest neighbour, metres: the median over some of them.
fn spacing(points: &[Vec3A]) -> f32 {
    let nearest = NearestPoints::new(points);
    let step = points.len().div_ceil(SPACING_SAMPLES).max(1);
    let two = NonZero::<usize>::MIN.saturating_add(1);
    let to_neighbour = |point: &Vec3A| {
        let neighbours = nearest.several(*point, two);
        neighbours.iter().map(|neighbour| neighbour.squared_distance.sqrt()).fold(0.0, f32::max)
    };
    let mut distances: Vec<f32> = points.iter().step_by(step).map(to_neighbour).collect();
    distances.sort_unstable_by(f32::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(0.01)
}

fn jpeg(picture: RgbaImage) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let picture = DynamicImage::ImageRgba8(picture).to_rgb8();
    picture.write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::{bent_pose, compact_avatar};

    #[test]
    fn spacing_is_that_of_a_grid() {
        let points: Vec<Vec3A> = (0..400).map(|i| 0.01 * Vec3A::new((i % 20) as f32, (i / 20) as f32, 0.0)).collect();
        assert!((spacing(&points) - 0.01).abs() < 1e-5);
    }

    #[test]
    fn every_column_follows_the_pose_from_frame_to_frame() {
        let studio = Studio::open().unwrap();
        let avatar = std::sync::Arc::new(compact_avatar());
        let joint_count = avatar.rig.parents.len();
        let mut photographer = Photographer::new(&studio, Animator::new(avatar).unwrap(), 0.0).unwrap();
        let points = GroundTruth { points: vec![Vec3A::Y; 40], normals: vec![Vec3A::Z; 40] };
        let mut drawn =
            |pose: &Pose| photographer.rows(0, pose, &points, &points).unwrap().remove(0).pictures[1..].to_vec();
        let (bent, rest) = (bent_pose(), Pose::rest(joint_count));
        let [first, second] = [&bent, &rest].map(&mut drawn);
        for column in 0..first.len() {
            assert!(first[column] != second[column], "{}", COLUMNS[1 + column]);
        }
    }

    #[test]
    fn every_column_is_as_lively_as_is_asked_for() {
        let studio = Studio::open().unwrap();
        let avatar = std::sync::Arc::new(compact_avatar());
        // Far from the poses that the tables have.
        let mut pose = bent_pose();
        pose.rotations[1..].iter_mut().for_each(|rotation| *rotation *= Quat::from_rotation_z(0.9));
        let points = GroundTruth { points: vec![Vec3A::Y; 40], normals: vec![Vec3A::Z; 40] };
        let drawn = |liveliness: f32| {
            let animator = Animator::new(avatar.clone()).unwrap();
            let mut photographer = Photographer::new(&studio, animator, liveliness).unwrap();
            photographer.rows(0, &pose, &points, &points).unwrap().remove(0).pictures
        };
        let (calm, lively) = (drawn(0.0), drawn(1.0));
        assert!(calm[0] == lively[0], "the scan is what it is");
        for column in 1..calm.len() {
            assert!(calm[column] != lively[column], "{}", COLUMNS[column]);
        }
    }
}
