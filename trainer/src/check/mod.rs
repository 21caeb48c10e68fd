//! What a capture is like and what would go wrong, before training is paid for.

mod placement;

use crate::nearest::NearestPoints;
use crate::sampling::generator;
use crate::sequence::{Capture, Frame, read_body};
use crease::body::Body;
use glam::Vec3A;
use placement::Placement;
use rand::RngExt;
use rayon::prelude::*;
use serde::Serialize;
use std::num::NonZero;
use std::path::Path;

/// Points of a frame that are looked at closely.
const PROBE_COUNT: usize = 2_000;
/// Neighbours of a point in the estimates of noise and holes.
const NEIGHBOUR_COUNT: NonZero<usize> = NonZero::new(24).expect("not zero");
/// A point lies at an edge where its neighbours' mean is off by this share of their mean distance.
const EDGE_SHIFT: f32 = 0.45;
/// Heights of people with room for raised arms and crouching, metres.
const HEIGHTS: std::ops::RangeInclusive<f32> = 0.5..=2.7;
/// Fewer points a frame leave wrinkles out, more noise (mm) drowns them.
const FEW_POINTS: usize = 5_000;
const MUCH_NOISE_MM: f32 = 4.0;

/// What one frame is like.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameFacts {
    /// Which frame.
    pub index: usize,
    /// How many points.
    pub points: usize,
    /// Least and greatest coordinates, metres.
    pub bounds: [[f32; 3]; 2],
    /// Distance between neighbouring points, mm.
    pub spacing_mm: f32,
    /// Root mean square distance of points from a plane through their neighbours, mm: noise, and a little curvature.
    pub noise_mm: f32,
    /// Share of points at an edge: of holes, and of the figure where one camera sees it.
    pub edge_share: f32,
}

/// What a capture is like.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Name.
    pub name: String,
    /// Frames the description promises.
    pub frame_count: usize,
    /// Frames a second.
    pub frames_per_second: f32,
    /// Whether the scans are depth images.
    pub is_depth: bool,
    /// Whether points have colours, in the first frame that can be read.
    pub has_colours: bool,
    /// Frames that have a ground truth.
    pub ground_truth_count: usize,
    /// The frames that can be read.
    pub frames: Vec<FrameFacts>,
    /// What would go wrong, each with a way out.
    pub problems: Vec<String>,
    /// What is worth knowing.
    pub notes: Vec<String>,
}

/// Looks at every frame of a capture, and at the poses of `body` where there are any. What is wrong with single frames is in the report.
pub fn check(capture: &Capture, body: &Body) -> Report {
    let mut report = Report {
        name: capture.name.clone(),
        frame_count: capture.frame_count,
        frames_per_second: capture.frames_per_second,
        is_depth: capture.camera().is_some(),
        ..Report::default()
    };
    let frames: Vec<_> = (0..capture.frame_count)
        .into_par_iter()
        .map(|index| capture.scan(index).map(|frame| (facts(&frame), frame.colours.is_some())))
        .collect();
    for frame in frames {
        match frame {
            Ok((facts, has_colours)) => {
                report.has_colours |= has_colours;
                report.frames.push(facts);
            }
            Err(error) => report.problems.push(error.to_string()),
        }
    }
    if report.frames.len() < capture.frame_count {
        report
            .notes
            .push("frames that cannot be read: write them again, or leave them out of training with --frames".into());
    }
    report.ground_truth_count = (0..capture.frame_count).filter(|&index| capture.has_ground_truth(index)).count();
    judge_size(&mut report);
    let mut placement = Placement::new(capture);
    placement.judge_up(&report.frames.clone(), &mut report);
    placement.judge_normals(&mut report);
    judge_quality(&mut report);
    judge_count(capture, &mut report);
    judge_body(capture, body, &placement, &mut report);
    report
}

/// What a few scans tell in a second or two: units, what is up, mirror images, and `poses` (a file, where there is one) that lie otherwise.
/// Each problem has a way out; what cannot be read has none here.
pub fn misplacement(capture: &Capture, body: &Body, poses: &Path) -> Vec<String> {
    let mut placement = Placement::new(capture);
    let frames: Vec<FrameFacts> = placement.scans().par_iter().map(facts).collect();
    let mut report = Report { is_depth: capture.camera().is_some(), frames: frames.clone(), ..Report::default() };
    judge_size(&mut report);
    placement.judge_up(&frames, &mut report);
    placement.judge_normals(&mut report);
    if let Ok(written) = read_body(poses)
        && written.parameters.poses.len() == capture.frame_count
    {
        placement.judge_body(body, &written, &mut report);
    }
    report.problems
}

fn facts(frame: &Frame) -> FrameFacts {
    let points = &frame.points;
    let bound = |pick: fn(Vec3A, Vec3A) -> Vec3A| points.iter().copied().reduce(pick).unwrap_or_default().to_array();
    let nearest = NearestPoints::new(points);
    let mut generator = generator(frame.index as u64);
    let probes: Vec<Vec3A> =
        (0..PROBE_COUNT.min(points.len())).map(|_| points[generator.random_range(0..points.len())]).collect();
    let looks: Vec<[f32; 3]> = probes.iter().map(|&probe| look(points, &nearest, probe)).collect();
    let mean = |column: usize| looks.iter().map(|look| look[column]).sum::<f32>() / looks.len().max(1) as f32;
    FrameFacts {
        index: frame.index,
        points: points.len(),
        bounds: [bound(Vec3A::min), bound(Vec3A::max)],
        spacing_mm: 1e3 * mean(0),
        noise_mm: 1e3 * mean(1).sqrt(),
        edge_share: mean(2),
    }
}

/// Distance to the nearest neighbour, squared residual of the plane, and whether the point is at an edge.
fn look(points: &[Vec3A], nearest: &NearestPoints, probe: Vec3A) -> [f32; 3] {
    let neighbours = nearest.several(probe, NEIGHBOUR_COUNT);
    let offsets: Vec<Vec3A> = neighbours.iter().map(|neighbour| points[neighbour.index as usize] - probe).collect();
    let count = offsets.len() as f32;
    if offsets.len() < 4 {
        return [0.0; 3];
    }
    let [_, _, normal] = crate::normals::principal_frame(points, probe, &neighbours);
    let mean = offsets.iter().sum::<Vec3A>() / count;
    let squares: f32 = offsets.iter().map(|offset| (*offset - mean).dot(normal).powi(2)).sum();
    let reach = offsets.iter().map(|offset| offset.length()).sum::<f32>() / count;
    let shift = mean - normal * mean.dot(normal);
    let spacing = neighbours.get(1).map_or(0.0, |neighbour| neighbour.squared_distance.sqrt());
    // A plane has three numbers, which the neighbours pay for.
    [spacing, squares / (count - 3.0), if shift.length() > EDGE_SHIFT * reach { 1.0 } else { 0.0 }]
}

/// Units, and height over the floor, from the median extents.
fn judge_size(report: &mut Report) {
    if report.frames.is_empty() {
        return;
    }
    let extent =
        |axis: usize| median(report.frames.iter().map(|frame| frame.bounds[1][axis] - frame.bounds[0][axis]).collect());
    let extents = [extent(0), extent(1), extent(2)];
    let longest = (0..3).max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(1);
    let size = extents[longest];
    let units = [("centimetre", 0.01), ("millimetre", 0.001)];
    if report.is_depth && !HEIGHTS.contains(&size) {
        report.problems.push(format!(
            "camera.json: depth_scale: expected a person of {HEIGHTS:?} m, found {size:.3} m: it is the metres of one unit of the depth \
             images, which show the person alone"
        ));
    } else if let Some((unit, _)) =
        units.iter().find(|(_, scale)| HEIGHTS.contains(&(size * scale))).filter(|_| size > 10.0)
    {
        report.problems.push(format!(
            "sequence.json: units: expected a person of {HEIGHTS:?} m, found {size:.0} m: say \"units\": \"{unit}\""
        ));
    } else if !HEIGHTS.contains(&size) {
        report.problems.push(format!(
            "sequence.json: units: expected a person of {HEIGHTS:?} m, found {size:.3} m: scale the scans to metres"
        ));
    }
    let floor = median(report.frames.iter().map(|frame| frame.bounds[0][1]).collect());
    if floor.abs() > 0.1 && longest == 1 {
        report.notes.push(format!("the lowest point is at y = {floor:.2} m: the page's floor is at 0"));
    }
}

fn judge_quality(report: &mut Report) {
    if report.frames.is_empty() {
        return;
    }
    let points = median(report.frames.iter().map(|frame| frame.points as f32).collect());
    if (points as usize) < FEW_POINTS {
        report.notes.push(format!("{points} points a frame: fewer than {FEW_POINTS} leave wrinkles out"));
    }
    for frame in report.frames.iter().filter(|frame| (frame.points as f32) < 0.3 * points) {
        report.notes.push(format!("frame {}: {} points, much fewer than most", frame.index, frame.points));
    }
    let noise = median(report.frames.iter().map(|frame| frame.noise_mm).collect());
    if noise > MUCH_NOISE_MM {
        report.notes.push(format!(
            "noise of {noise:.1} mm: smooth more, for instance --set compact.view_smoothness=8 for depth"
        ));
    }
    if !report.has_colours {
        report.notes.push("no colours: the avatar will be grey".into());
    }
}

/// Files beyond the promised frames.
fn judge_count(capture: &Capture, report: &mut Report) {
    let (folder, ending) = if report.is_depth { ("depth", "png") } else { ("frames", "ply") };
    let Ok(entries) = std::fs::read_dir(capture.directory.join(folder)) else { return };
    let count = entries.flatten().filter(|entry| entry.path().extension().is_some_and(|e| e == ending)).count();
    if count > capture.frame_count {
        report.problems.push(format!(
            "sequence.json: frame_count: expected {count} as there are files in {folder}/, found {}",
            capture.frame_count
        ));
    }
}

fn judge_body(capture: &Capture, body: &Body, placement: &Placement, report: &mut Report) {
    let path = capture.directory.join("body.npz");
    if !path.exists() {
        report
            .notes
            .push("no body.npz: `crease register` estimates it; without poses nothing tells mirror images".into());
        return;
    }
    match read_body(&path) {
        Err(error) => report.problems.push(error.to_string()),
        Ok(written) if written.parameters.poses.len() != capture.frame_count => report.problems.push(format!(
            "{}: poses: expected {} frames as in sequence.json, found {}",
            path.display(),
            capture.frame_count,
            written.parameters.poses.len()
        )),
        Ok(written) => placement.judge_body(body, &written, report),
    }
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_file::MeshFormat;
    use crate::shapes::sphere;
    use crate::test_folder::Folder;
    use crease::fixture::voxel_person;
    use std::fs;

    /// Two frames of an egg of 1.7 m that stands on the floor, after `change`.
    fn egg(name: &str, change: fn(Vec3A) -> Vec3A) -> Folder {
        let folder = Folder::new(&format!("check-{name}"));
        fs::create_dir_all(folder.0.join("frames")).unwrap();
        let mesh = sphere(1.0, 4);
        let positions: Vec<Vec3A> =
            mesh.positions.iter().map(|&p| change(p * Vec3A::new(0.4, 0.85, 0.3) + Vec3A::Y * 0.85)).collect();
        for frame in 0..2 {
            let bytes = MeshFormat::Ply.encode(&positions, &mesh.triangles);
            fs::write(folder.0.join(format!("frames/{frame:04}.ply")), bytes).unwrap();
        }
        describe(&folder, 2);
        folder
    }

    fn describe(folder: &Folder, frame_count: usize) {
        let text = format!(
            r#"{{"name": "egg", "fps": 15, "frame_count": {frame_count}, "capture": {{"kind": "pointcloud"}}}}"#
        );
        fs::write(folder.0.join("sequence.json"), text).unwrap();
    }

    fn report(folder: &Folder) -> Report {
        check(&Capture::open(&folder.0).unwrap(), &voxel_person())
    }

    #[test]
    fn a_good_capture_has_no_problems() {
        let report = report(&egg("good", |p| p));
        assert_eq!(report.problems, Vec::<String>::new());
        assert_eq!(report.frames.len(), 2);
        let frame = &report.frames[0];
        assert_eq!(frame.points, 40_000);
        assert!((frame.bounds[1][1] - frame.bounds[0][1] - 1.7).abs() < 0.02, "{frame:?}");
        assert!(frame.noise_mm < 1.0 && frame.edge_share < 0.05, "{frame:?}");
        assert!(report.notes.iter().any(|note| note.contains("crease register")));
    }

    #[test]
    fn units_and_axes_are_told_with_a_way_out() {
        let problem = |name: &str, change: fn(Vec3A) -> Vec3A| report(&egg(name, change)).problems.join("\n");
        assert!(problem("millimetres", |p| p * 1000.0).contains("\"millimetre\""));
        assert!(problem("centimetres", |p| p * 100.0).contains("\"centimetre\""));
        assert!(problem("tiny", |p| p * 0.001).contains("scale the scans"));
        assert!(problem("lying", |p| Vec3A::new(p.x, -p.z, p.y)).contains("\"up\": \"z\""));
        assert!(problem("aside", |p| Vec3A::new(p.y, p.x, -p.z)).contains("--up x"));
    }

    #[test]
    fn noise_and_holes_are_measured() {
        let noisy = |p: Vec3A| p + Vec3A::splat(0.02 * (1e4 * p.x).sin() * (1e4 * p.y).cos());
        let report_noisy = report(&egg("noisy", noisy));
        assert!(report_noisy.frames[0].noise_mm > 2.0, "{:?}", report_noisy.frames[0]);
        // A band around the waist is gone.
        let torn = |p: Vec3A| if (p.y - 0.85).abs() < 0.2 { Vec3A::new(0.0, 0.0, 0.0) } else { p };
        let whole = report(&egg("whole", |p| p)).frames[0].edge_share;
        let edges = report(&egg("torn", torn)).frames[0].edge_share;
        assert!(edges > whole, "{edges} against {whole}");
    }

    #[test]
    fn bad_frames_and_counts_are_named() {
        let folder = egg("bad", |p| p);
        fs::write(folder.0.join("frames/0001.ply"), b"ply\nformat ascii 1.0\n").unwrap();
        assert!(report(&folder).problems[0].contains("0001.ply"));
        describe(&folder, 1);
        assert!(report(&folder).problems[0].contains("frame_count: expected 2"));
        describe(&folder, 3);
        assert!(report(&folder).problems.iter().any(|problem| problem.contains("0002.ply")));
    }
}
