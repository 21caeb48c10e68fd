//! Joints from other tools: OpenPose, MediaPipe and COCO in pictures, and joints in space, all as JSON.
//!
//! - In space: `{"joints": [frame, …]}`, each frame a list of `[x, y, z]` in metres or `null`, in SMPL's order; or, with
//!   `"names": ["left_wrist", …]`, in the order of the names.
//! - OpenPose: a folder of one JSON a frame, in the order of their names, each with `people[0].pose_keypoints_2d` (BODY_25 or COCO-18);
//!   of several people the most confident is taken.
//! - COCO: a list of annotations, or `{"annotations": [...]}`, each with `image_id` (the frame, from 0) and `keypoints` (17 × 3).
//! - MediaPipe: a list of one entry a frame, each 33 landmarks `{x, y, visibility}` in shares of the picture, or `{"pose_landmarks": [...]}`.

use super::keypoints::Keypoints;
use crate::sequence::{Camera, read, read_error};
use crease::numpy::ReadError;
use glam::Vec3A;
use serde_json::Value;
use std::path::Path;

/// Detections less sure than this are left out.
const LEAST_CONFIDENCE: f32 = 0.2;

/// SMPL's joint names at the places of each layout's list.
type Places = &'static [(usize, &'static str)];

const BODY_25: Places = &[
    (1, "neck"),
    (2, "right_shoulder"),
    (3, "right_elbow"),
    (4, "right_wrist"),
    (5, "left_shoulder"),
    (6, "left_elbow"),
    (7, "left_wrist"),
    (9, "right_hip"),
    (10, "right_knee"),
    (11, "right_ankle"),
    (12, "left_hip"),
    (13, "left_knee"),
    (14, "left_ankle"),
];
const COCO_18: Places = &[
    (1, "neck"),
    (2, "right_shoulder"),
    (3, "right_elbow"),
    (4, "right_wrist"),
    (5, "left_shoulder"),
    (6, "left_elbow"),
    (7, "left_wrist"),
    (8, "right_hip"),
    (9, "right_knee"),
    (10, "right_ankle"),
    (11, "left_hip"),
    (12, "left_knee"),
    (13, "left_ankle"),
];
const COCO_17: Places = &[
    (5, "left_shoulder"),
    (6, "right_shoulder"),
    (7, "left_elbow"),
    (8, "right_elbow"),
    (9, "left_wrist"),
    (10, "right_wrist"),
    (11, "left_hip"),
    (12, "right_hip"),
    (13, "left_knee"),
    (14, "right_knee"),
    (15, "left_ankle"),
    (16, "right_ankle"),
];
const MEDIAPIPE_33: Places = &[
    (11, "left_shoulder"),
    (12, "right_shoulder"),
    (13, "left_elbow"),
    (14, "right_elbow"),
    (15, "left_wrist"),
    (16, "right_wrist"),
    (23, "left_hip"),
    (24, "right_hip"),
    (25, "left_knee"),
    (26, "right_knee"),
    (27, "left_ankle"),
    (28, "right_ankle"),
];

/// Reads joints of `frame_count` frames; `names` are the body's joints. Pictures need the `camera` that took them.
pub fn read_keypoints(
    path: &Path,
    frame_count: usize,
    names: &[String],
    camera: Option<&Camera>,
) -> Result<Vec<Keypoints>, ReadError> {
    let reader = Reader { path, names, camera };
    let frames = if path.is_dir() {
        reader.openpose_folder()?
    } else {
        let value: Value = serde_json::from_slice(&read(path)?)
            .map_err(|error| read_error(path, "JSON", "joints or keypoints", error.to_string()))?;
        reader.file(&value, frame_count)?
    };
    if frames.len() == frame_count {
        return Ok(frames);
    }
    Err(read_error(path, "frames", &format!("{frame_count} as in sequence.json"), frames.len().to_string()))
}

struct Reader<'a> {
    path: &'a Path,
    names: &'a [String],
    camera: Option<&'a Camera>,
}

impl Reader<'_> {
    fn error(&self, field: &str, expected: &str, found: impl ToString) -> ReadError {
        read_error(self.path, field, expected, found.to_string())
    }

    fn file(&self, value: &Value, frame_count: usize) -> Result<Vec<Keypoints>, ReadError> {
        if let Some(frames) = value.get("joints").and_then(Value::as_array) {
            return self.space(frames, value.get("names"));
        }
        let entries = value.get("annotations").unwrap_or(value).as_array();
        let Some(entries) = entries.filter(|entries| !entries.is_empty()) else {
            return Err(self.error(
                "JSON",
                "joints, a list of COCO annotations, or a list of MediaPipe landmarks",
                "neither",
            ));
        };
        if entries[0].get("keypoints").is_some() { self.coco(entries, frame_count) } else { self.mediapipe(entries) }
    }

    fn space(&self, frames: &[Value], names: Option<&Value>) -> Result<Vec<Keypoints>, ReadError> {
        let order: Vec<usize> = match names.and_then(Value::as_array) {
            None => (0..self.names.len()).collect(),
            Some(names) => names
                .iter()
                .map(|name| {
                    let joint = self.names.iter().position(|own| Some(own.as_str()) == name.as_str());
                    joint.ok_or_else(|| self.error("names", "names of the body's joints", name))
                })
                .collect::<Result<_, _>>()?,
        };
        frames
            .iter()
            .enumerate()
            .map(|(frame, joints)| {
                let field = format!("joints[{frame}]");
                let joints = joints.as_array().filter(|joints| joints.len() <= order.len()).ok_or_else(|| {
                    self.error(&field, &format!("a list of at most {} joints", order.len()), "another")
                })?;
                let mut space = Vec::new();
                for (&joint, value) in order.iter().zip(joints).filter(|(_, value)| !value.is_null()) {
                    let numbers = numbers(value).filter(|numbers| numbers.len() == 3);
                    let numbers = numbers.ok_or_else(|| self.error(&field, "three finite numbers or null", value))?;
                    space.push((joint, Vec3A::from_slice(&numbers)));
                }
                Ok(Keypoints { space, ..Keypoints::default() })
            })
            .collect()
    }

    fn openpose_folder(&self) -> Result<Vec<Keypoints>, ReadError> {
        let entries = std::fs::read_dir(self.path).map_err(|error| self.error("folder", "a readable folder", error))?;
        let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
        files.retain(|path| path.extension().is_some_and(|end| end == "json"));
        files.sort();
        files.iter().map(|path| Reader { path, ..*self }.openpose(&read(path)?)).collect()
    }

    fn openpose(&self, bytes: &[u8]) -> Result<Keypoints, ReadError> {
        let value: Value =
            serde_json::from_slice(bytes).map_err(|error| self.error("JSON", "OpenPose's people", error))?;
        let people = value.get("people").and_then(Value::as_array);
        let people = people.ok_or_else(|| self.error("people", "a list", "none"))?;
        let found = people.iter().filter_map(|person| person.get("pose_keypoints_2d").and_then(numbers));
        let sureness = |numbers: &Vec<f32>| numbers.chunks_exact(3).map(|point| point[2]).sum::<f32>();
        match found.max_by(|a, b| sureness(a).total_cmp(&sureness(b))) {
            None => self.picture(&[], &[]),
            Some(numbers) => match numbers.len() {
                75 => self.picture(&numbers, BODY_25),
                54 => self.picture(&numbers, COCO_18),
                other => Err(self.error("people[].pose_keypoints_2d", "75 numbers (BODY_25) or 54 (COCO)", other)),
            },
        }
    }

    fn coco(&self, entries: &[Value], frame_count: usize) -> Result<Vec<Keypoints>, ReadError> {
        let mut frames = vec![Keypoints::default(); frame_count];
        for (index, entry) in entries.iter().enumerate() {
            let field = |name: &str| format!("annotations[{index}].{name}");
            let frame = entry.get("image_id").and_then(Value::as_u64).map(|frame| frame as usize);
            let frame = frame.filter(|&frame| frame < frame_count).ok_or_else(|| {
                self.error(
                    &field("image_id"),
                    &format!("a frame from 0 to {}", frame_count - 1),
                    entry["image_id"].clone(),
                )
            })?;
            let numbers = entry.get("keypoints").and_then(numbers).filter(|numbers| numbers.len() == 51);
            let numbers =
                numbers.ok_or_else(|| self.error(&field("keypoints"), "51 finite numbers", "another list"))?;
            // COCO's visibility is 0, 1 or 2; detectors write confidences there.
            let sure: Vec<f32> = (0..51).map(|i| if i % 3 == 2 { numbers[i].min(1.0) } else { numbers[i] }).collect();
            frames[frame] = self.picture(&sure, COCO_17)?;
        }
        Ok(frames)
    }

    fn mediapipe(&self, entries: &[Value]) -> Result<Vec<Keypoints>, ReadError> {
        let camera = self.need_camera()?;
        entries
            .iter()
            .enumerate()
            .map(|(frame, entry)| {
                let field = format!("[{frame}]");
                let landmarks = entry.get("pose_landmarks").or_else(|| entry.get("landmarks")).unwrap_or(entry);
                let landmarks = landmarks.as_array().filter(|landmarks| [0, 33].contains(&landmarks.len()));
                let landmarks = landmarks.ok_or_else(|| self.error(&field, "33 landmarks", "another entry"))?;
                let number = |landmark: &Value, name: &str, instead: Option<f64>| {
                    let number = landmark.get(name).and_then(Value::as_f64).or(instead).filter(|n| n.is_finite());
                    number.map(|n| n as f32).ok_or_else(|| self.error(&field, &format!("a number {name}"), landmark))
                };
                let mut flat = Vec::new();
                for landmark in landmarks {
                    flat.push(number(landmark, "x", None)? * camera.width as f32);
                    flat.push(number(landmark, "y", None)? * camera.height as f32);
                    flat.push(number(landmark, "visibility", Some(1.0))?);
                }
                self.picture(&flat, if flat.is_empty() { &[] } else { MEDIAPIPE_33 })
            })
            .collect()
    }

    fn need_camera(&self) -> Result<&Camera, ReadError> {
        self.camera.ok_or_else(|| {
            self.error("camera", "a sequence with camera.json: pictures need the camera that took them", "none")
        })
    }

    /// From x, y, confidence of each place.
    fn picture(&self, numbers: &[f32], places: Places) -> Result<Keypoints, ReadError> {
        let camera = Some(self.need_camera()?.clone());
        let found = places.iter().filter_map(|&(place, name)| {
            let joint = self.names.iter().position(|own| own == name)?;
            let [u, v, confidence] = [0, 1, 2].map(|i| numbers[3 * place + i]);
            (confidence >= LEAST_CONFIDENCE).then_some((joint, [u, v], confidence.min(1.0)))
        });
        Ok(Keypoints { space: Vec::new(), picture: found.collect(), camera })
    }
}

/// A list of finite numbers.
fn numbers(value: &Value) -> Option<Vec<f32>> {
    value.as_array()?.iter().map(|number| number.as_f64().map(|n| n as f32).filter(|n| n.is_finite())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::body::SMPL_JOINT_NAMES;
    use glam::Affine3A;
    use std::path::PathBuf;

    fn names() -> Vec<String> {
        SMPL_JOINT_NAMES.map(str::to_owned).to_vec()
    }

    fn camera() -> Camera {
        Camera {
            width: 640,
            height: 480,
            focal: [500.0; 2],
            centre: [320.0, 240.0],
            depth_scale: 1e-3,
            world_from_camera: Affine3A::IDENTITY,
            camera_from_world: Affine3A::IDENTITY,
        }
    }

    fn file(name: &str, text: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("crease-keypoints-{name}-{}.json", std::process::id()));
        std::fs::write(&path, text).unwrap();
        path
    }

    fn read_text(name: &str, text: &str, frame_count: usize) -> Result<Vec<Keypoints>, ReadError> {
        let path = file(name, text);
        let found = read_keypoints(&path, frame_count, &names(), Some(&camera()));
        std::fs::remove_file(path).unwrap();
        found
    }

    /// x, y, confidence for `count` places; the last number of place 5 is low.
    fn flat(count: usize) -> Vec<f32> {
        (0..count).flat_map(|i| [10.0 * i as f32, i as f32, if i == 5 { 0.1 } else { 0.9 }]).collect()
    }

    #[test]
    fn joints_in_space_by_order_and_by_name() {
        let found = read_text("space", r#"{"joints": [[[0, 1, 2], null, [3, 4, 5]]]}"#, 1).unwrap();
        assert_eq!(found[0].space, [(0, Vec3A::new(0.0, 1.0, 2.0)), (2, Vec3A::new(3.0, 4.0, 5.0))]);
        let found = read_text("named", r#"{"names": ["left_wrist"], "joints": [[[1, 1, 1]], [null]]}"#, 2).unwrap();
        assert_eq!(found[0].space, [(20, Vec3A::ONE)]);
        assert!(found[1].space.is_empty());
    }

    #[test]
    fn pictures_of_each_tool() {
        let coco = format!(r#"[{{"image_id": 1, "keypoints": {:?}}}]"#, flat(17));
        let found = read_text("coco", &coco, 2).unwrap();
        assert!(found[0].picture.is_empty());
        assert_eq!(found[1].picture.len(), COCO_17.len() - 1, "an unsure shoulder is left out");
        assert_eq!(found[1].picture[0], (17, [60.0, 6.0], 0.9));

        let landmarks: Vec<String> = (0..33).map(|i| format!(r#"{{"x": {}, "y": 0.5}}"#, i as f32 / 64.0)).collect();
        let found = read_text("mediapipe", &format!("[[{}]]", landmarks.join(",")), 1).unwrap();
        assert_eq!(found[0].picture[0], (16, [110.0, 240.0], 1.0));

        let folder = std::env::temp_dir().join(format!("crease-openpose-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let person = |numbers: Vec<f32>| format!(r#"{{"pose_keypoints_2d": {numbers:?}}}"#);
        let people = format!(r#"{{"people": [{}, {}]}}"#, person(vec![0.0; 75]), person(flat(25)));
        std::fs::write(folder.join("a_keypoints.json"), people).unwrap();
        std::fs::write(folder.join("b_keypoints.json"), r#"{"people": []}"#).unwrap();
        let found = read_keypoints(&folder, 2, &names(), Some(&camera())).unwrap();
        assert_eq!(found[0].picture[0], (12, [10.0, 1.0], 0.9), "the surer person");
        assert!(found[1].picture.is_empty());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (name, text, field) in [
            ("count", r#"{"joints": [[]]}"#, "frames"),
            ("names", r#"{"names": ["tail"], "joints": [[], []]}"#, "names"),
            ("numbers", r#"{"joints": [[[1, 2]], []]}"#, "joints[0]"),
            ("frame", r#"[{"image_id": 9, "keypoints": []}]"#, "annotations[0].image_id"),
            ("empty", "[]", "JSON"),
            ("text", "nothing", "JSON"),
        ] {
            assert_eq!(read_text(name, text, 2).unwrap_err().field, field);
        }
        let path = file("camera", &format!(r#"[{{"image_id": 0, "keypoints": {:?}}}]"#, flat(17)));
        assert_eq!(read_keypoints(&path, 1, &names(), None).unwrap_err().field, "camera");
        std::fs::remove_file(path).unwrap();
    }
}
