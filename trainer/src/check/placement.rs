//! How scans lie in space, and beside the body of given poses: what is up, mirror images, normals that point inwards.

use super::{FrameFacts, Report, median};
use crate::closest::ClosestPoint;
use crate::sequence::{Axis, Capture, Frame, Orientation, Up, WrittenBody};
use crease::body::{Body, Pose, Rig, posed_from_rest};
use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

/// Frames that are held against the body, spread over the sequence …
const FRAME_COUNT: usize = 5;
/// … and points of each.
const POINT_COUNT: usize = 500;
/// People are at least this many times as tall as they are deep.
const TALLNESS: f32 = 1.3;
/// A head is narrower than two feet: ends of a figure are so much of its height …
const END_SHARE: f32 = 0.06;
/// … and an upper end so many times as wide as the lower tells that the figure stands on its head.
const HEADSTAND: f32 = 1.3;
/// Another placement has to be this much closer, as a share of the distance and in metres, to count as the right one.
const CLOSER: (f32, f32) = (0.6, 0.01);
/// Normals whose share outward is below this point inwards.
const LEAST_OUTWARD: f32 = 0.35;
/// Height of the slices whose middle is taken for the inside, metres.
const SLICE: f32 = 0.1;

/// A few scans of a capture.
pub(super) struct Placement<'a> {
    capture: &'a Capture,
    scans: Vec<Frame>,
    /// How the scans seem to lie; at first, as they are read.
    orientation: Orientation,
}

impl<'a> Placement<'a> {
    /// Reads the scans; those that cannot be read are left out.
    pub fn new(capture: &'a Capture) -> Self {
        let step = capture.frame_count.div_ceil(FRAME_COUNT);
        let scans = (0..capture.frame_count).step_by(step).filter_map(|index| capture.scan(index).ok()).collect();
        Self { capture, scans, orientation: capture.orientation }
    }

    /// The scans.
    pub fn scans(&self) -> &[Frame] {
        &self.scans
    }

    /// What is up, by the frames' median extents and the width of the ends.
    pub fn judge_up(&mut self, frames: &[FrameFacts], report: &mut Report) {
        if frames.is_empty() || self.scans.is_empty() {
            return;
        }
        let extents: [f32; 3] = std::array::from_fn(|axis| {
            median(frames.iter().map(|frame| frame.bounds[1][axis] - frame.bounds[0][axis]).collect())
        });
        let longest = (0..3).max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(1);
        let lies = longest != 1 && extents[longest] > TALLNESS * extents[1];
        let axis = if lies { Vec3A::AXES[longest] } else { Vec3A::Y };
        let is_upside_down = median(self.scans.iter().map(|scan| end_ratio(&scan.points, axis)).collect()) > HEADSTAND;
        let direction = if is_upside_down { -axis } else { axis };
        let up = Up::nearest(self.capture.orientation.matrix().transpose() * direction);
        let read = self.capture.orientation.up.name();
        if lies {
            self.orientation.up = up;
            report.problems.push(format!(
                "sequence.json: up: expected people to be tallest along {read}, found {:.2} m there and {:.2} m along {}: say \"up\": \
                 \"{}\", or --up {}",
                extents[1],
                extents[longest],
                up.name().trim_start_matches('-'),
                up.name(),
                up.name()
            ));
        } else if is_upside_down {
            report.notes.push(format!(
                "the upper end is wider than the lower, as of people who stand on their heads: if they do not, say \"up\": \"{}\"",
                up.name()
            ));
        }
    }

    /// Whether normals that came with the scans point outward.
    pub fn judge_normals(&self, report: &mut Report) {
        let outward: Vec<f32> = self.scans.iter().filter(|scan| scan.camera.is_none()).filter_map(outward).collect();
        if outward.is_empty() || median(outward.clone()) >= LEAST_OUTWARD {
            return;
        }
        report.problems.push(format!(
            "sequence.json: normals: expected them to point outward, found {:.0} % that do, as where a mesh's faces run clockwise: say \
             \"normals\": \"inward\"",
            100.0 * median(outward)
        ));
    }

    /// Whether the scans are on the body of the poses, or would be if one or the other lay otherwise.
    pub fn judge_body(&self, body: &Body, written: &WrittenBody, report: &mut Report) {
        let joint_count = written.parameters.poses.first().map_or(0, |pose| pose.rotations.len());
        if self.scans.is_empty() || joint_count != body.parents.len() {
            return;
        }
        let rig = body.shaped(&written.parameters.betas);
        let mirrors = [None].into_iter().chain(Axis::ALL.map(Some));
        let poses_up = match (written.up, self.capture.poses_up == self.capture.orientation.up) {
            (Some(up), _) => up,
            (None, true) => self.orientation.up,
            (None, false) => self.capture.poses_up,
        };
        let mut best: Option<(f32, Up, Option<Axis>)> = None;
        let mut read = f32::INFINITY;
        for up in Up::ALL {
            let surfaces: Option<Vec<PosedBody>> = (self.scans.par_iter())
                .map(|scan| {
                    PosedBody::new(&rig, body, &up.pose_to_y(&written.parameters.poses[scan.index], rig.rest_joints[0]))
                })
                .collect();
            let Some(surfaces) = surfaces else { return };
            for mirrored in mirrors.clone() {
                let turn = Orientation { mirrored, ..self.orientation }.matrix()
                    * self.capture.orientation.matrix().transpose();
                let pairs = self.scans.par_iter().zip(&surfaces);
                let distance = median(pairs.map(|(scan, surface)| surface.distance(&scan.points, turn)).collect());
                if (up, mirrored) == (poses_up, self.orientation.mirrored) {
                    read = distance;
                }
                if best.is_none_or(|(least, ..)| distance < least) {
                    best = Some((distance, up, mirrored));
                }
            }
        }
        let Some((least, up, mirrored)) = best else { return };
        if least > CLOSER.0 * read || read - least < CLOSER.1 {
            return;
        }
        let mut ways = Vec::new();
        match mirrored {
            same if same == self.orientation.mirrored => {}
            Some(axis) => ways.push(format!("say \"mirrored\": \"{}\", or --mirrored {}", axis.name(), axis.name())),
            None => ways.push("leave \"mirrored\" out".into()),
        }
        if up != poses_up && written.up.is_some() {
            ways.push(format!("write {:?} as up into body.npz", up.direction().to_array()));
        } else if up != poses_up {
            ways.push(format!("say \"poses_up\": \"{}\", or --poses-up {}", up.name(), up.name()));
        }
        let what = if mirrored == self.orientation.mirrored { "poses that lie otherwise" } else { "mirror images" };
        report.problems.push(format!(
            "body.npz: expected poses near the scans, found {:.0} mm between them, and {:.0} mm for {what}: {}",
            1e3 * read,
            1e3 * least,
            ways.join(" and ")
        ));
    }
}

struct PosedBody {
    vertices: Vec<Vec3A>,
    closest: ClosestPoint,
    triangles: Vec<[u32; 3]>,
}

impl PosedBody {
    fn new(rig: &Rig, body: &Body, pose: &Pose) -> Option<Self> {
        let vertices = rig.posed(pose, &posed_from_rest(rig, pose));
        let closest = ClosestPoint::new(&vertices, &body.triangles).ok()?;
        Some(Self { vertices, closest, triangles: body.triangles.clone() })
    }

    /// Median distance of points, turned, metres.
    fn distance(&self, points: &[Vec3A], turn: Mat3A) -> f32 {
        let step = points.len().div_ceil(POINT_COUNT);
        let distance = |&point: &Vec3A| {
            let point = turn * point;
            self.closest.query(point).interpolate(&self.triangles, &self.vertices).distance(point)
        };
        median(points.iter().step_by(step).map(distance).collect())
    }
}

/// Width of the end that `axis` points to over that of the other: mean distance from the ends' middles, across the axis.
fn end_ratio(points: &[Vec3A], axis: Vec3A) -> f32 {
    let heights = || points.iter().map(|point| point.dot(axis));
    let (low, high) = (heights().fold(f32::INFINITY, f32::min), heights().fold(f32::NEG_INFINITY, f32::max));
    let end = END_SHARE * (high - low);
    let width = |is_in: &dyn Fn(f32) -> bool| {
        let across: Vec<Vec3A> =
            points.iter().filter(|point| is_in(point.dot(axis))).map(|&point| point - axis * point.dot(axis)).collect();
        let count = across.len().max(1) as f32;
        let middle = across.iter().sum::<Vec3A>() / count;
        across.iter().map(|point| point.distance(middle)).sum::<f32>() / count
    };
    width(&|height| height > high - end) / width(&|height| height < low + end).max(1e-6)
}

/// Share of a scan's normals that point away from the middle of their slice; none without normals.
fn outward(scan: &Frame) -> Option<f32> {
    let normals = scan.normals.as_ref()?;
    let slice = |point: &Vec3A| (point.y / SLICE).floor() as i64;
    let mut middles = std::collections::HashMap::<i64, (Vec3A, f32)>::new();
    for point in &scan.points {
        let (sum, count) = middles.entry(slice(point)).or_default();
        *sum += *point;
        *count += 1.0;
    }
    let is_outward = |(point, normal): &(&Vec3A, &Vec3A)| {
        let (sum, count) = middles[&slice(point)];
        normal.dot(**point - sum / count) > 0.0
    };
    let count = scan.points.iter().zip(normals).filter(is_outward).count();
    Some(count as f32 / scan.points.len() as f32)
}

#[cfg(test)]
mod tests {
    use super::super::check;
    use super::*;
    use crate::mesh_file::MeshFormat;
    use crate::sequence::{BodyParameters, Reading, write_body};
    use crate::test_folder::Folder;
    use crease::animate::PosedSurface;
    use crease::fixture::{bent_pose, voxel_person};
    use crease::mesh::{Scheme, Subdivision};
    use std::fs;

    /// A frame of the bent person, whose vertices are changed, with poses in a file that says that `up` is up, or says nothing of it.
    fn bent(name: &str, change: Mat3A, faces: fn([u32; 3]) -> [u32; 3], up: Up) -> Folder {
        let folder = Folder::new(&format!("placement-{name}"));
        fs::create_dir_all(folder.0.join("frames")).unwrap();
        let body = voxel_person();
        let rig = body.shaped(&[]);
        let pose = bent_pose();
        let posed = PosedBody::new(&rig, &body, &pose).unwrap();
        let vertices: Vec<Vec3A> = posed.vertices.iter().map(|&vertex| change * vertex).collect();
        let triangles: Vec<[u32; 3]> = body.triangles.iter().map(|&triangle| faces(triangle)).collect();
        fs::write(folder.0.join("frames/0000.ply"), MeshFormat::Ply.encode(&vertices, &triangles)).unwrap();
        let text = r#"{"name": "bent", "fps": 15, "frame_count": 1, "capture": {"kind": "pointcloud"}}"#;
        fs::write(folder.0.join("sequence.json"), text).unwrap();
        let parameters = BodyParameters { betas: vec![0.0], poses: vec![pose] };
        write_body(&folder.0.join("body.npz"), &parameters, up, 15.0).unwrap();
        folder
    }

    fn problems(folder: &Folder, reading: Reading) -> Vec<String> {
        check(&Capture::open_as(&folder.0, &reading).unwrap(), &voxel_person()).problems
    }

    fn one_problem(folder: &Folder) -> String {
        let problems = problems(folder, Reading::default());
        assert_eq!(problems.len(), 1, "{problems:?}");
        problems.into_iter().next().unwrap()
    }

    #[test]
    fn scans_on_their_body_are_left_alone() {
        let folder = bent("good", Mat3A::IDENTITY, |triangle| triangle, Up::Y);
        assert_eq!(problems(&folder, Reading::default()), Vec::<String>::new());
    }

    #[test]
    fn bodies_with_pose_blend_shapes_are_posed_with_them() {
        let pose = bent_pose();
        let mut body = voxel_person();
        // A bent knee pushes the whole body aside by 20 cm.
        let (count, joint) = (body.template.len(), 4);
        let mut directions = vec![vec![Vec3A::ZERO; count]; 9 * (body.parents.len() - 1)];
        let bend = Mat3A::from_quat(pose.rotations[joint]) - Mat3A::IDENTITY;
        assert!(bend.z_axis.y.abs() > 0.2, "{bend}");
        // Row 1, column 2.
        directions[9 * (joint - 1) + 5] = vec![Vec3A::X * (0.2 / bend.z_axis.y); count];
        let plain = body.shaped(&[]).posed(&pose, &posed_from_rest(&body.shaped(&[]), &pose));
        body.pose_directions = Some(directions);
        let rig = body.shaped(&[]);
        let shaped = PosedBody::new(&rig, &body, &pose).unwrap();
        let mut surface = PosedSurface::new(&Subdivision::new(count, &body.triangles, 0));
        surface.pose(&rig, &[], &pose, &Subdivision::new(count, &body.triangles, 0), Scheme::Loop, 0);
        assert!(shaped.vertices.iter().zip(&plain).any(|(a, b)| a.distance(*b) > 0.15), "the shapes tell");
        for (own, posed) in shaped.vertices.iter().zip(surface.finest()) {
            assert!(own.distance(*posed) < 1e-5, "as everything else is posed: {own} and {posed}");
        }
    }

    #[test]
    fn mirror_images_are_told_and_the_way_out_leads_out() {
        let mirror = Mat3A::from_diagonal(glam::Vec3::new(1.0, 1.0, -1.0));
        let folder = bent("mirrored", mirror, |[a, b, c]| [a, c, b], Up::Y);
        let problem = one_problem(&folder);
        assert!(problem.contains("mirror images") && problem.contains("--mirrored z"), "{problem}");
        let reading = Reading { mirrored: Some(Axis::Z), ..Reading::default() };
        assert_eq!(problems(&folder, reading), Vec::<String>::new());
        let turned = bent("not-mirrored", Mat3A::IDENTITY, |triangle| triangle, Up::Y);
        assert!(problems(&turned, reading)[0].contains("leave \"mirrored\" out"));
    }

    #[test]
    fn poses_that_lie_otherwise_are_told() {
        let folder = bent("poses", Mat3A::IDENTITY, |triangle| triangle, Up::Z);
        let problem = one_problem(&folder);
        assert!(problem.contains("write [0.0, 1.0, 0.0] as up into body.npz"), "{problem}");
    }

    #[test]
    fn scans_and_poses_may_both_have_z_up() {
        // The posed body lies on its back in the file, and so do its scans.
        let folder = bent("both", Mat3A::IDENTITY, |triangle| triangle, Up::Z);
        let reading = Reading { up: Some(Up::Z), ..Reading::default() };
        let capture = Capture::open_as(&folder.0, &reading).unwrap();
        let body = voxel_person();
        let rig = body.shaped(&[]);
        let written = crate::sequence::read_body(&folder.0.join("body.npz")).unwrap();
        let pose = written.y_up(capture.poses_up, |_| rig.rest_joints[0]).poses.remove(0);
        let posed = PosedBody::new(&rig, &body, &pose).unwrap();
        assert!(posed.distance(&capture.scan(0).unwrap().points, Mat3A::IDENTITY) < 1e-4);
    }

    #[test]
    fn normals_that_point_inwards_are_told() {
        let folder = bent("inward", Mat3A::IDENTITY, |[a, b, c]| [a, c, b], Up::Y);
        let problem = one_problem(&folder);
        assert!(problem.contains("\"normals\": \"inward\""), "{problem}");
        let text =
            r#"{"name": "bent", "fps": 15, "frame_count": 1, "normals": "inward", "capture": {"kind": "pointcloud"}}"#;
        fs::write(folder.0.join("sequence.json"), text).unwrap();
        assert_eq!(problems(&folder, Reading::default()), Vec::<String>::new());
    }

    #[test]
    fn two_feet_are_wider_than_a_head() {
        let ball =
            |centre: Vec3A| crate::shapes::sphere_points(500, 0.1, 1).into_iter().map(move |point| centre + point);
        let feet = [-0.2, 0.2].map(|x| ball(Vec3A::new(x, 0.1, 0.0)));
        let points: Vec<Vec3A> = feet.into_iter().flatten().chain(ball(Vec3A::Y * 1.7)).collect();
        assert!(end_ratio(&points, Vec3A::Y) < 1.0 / HEADSTAND);
        assert!(end_ratio(&points, Vec3A::NEG_Y) > HEADSTAND);
    }
}
