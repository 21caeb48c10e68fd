use super::*;
use crate::mesh_file::MeshFormat;
use crate::sequence::{Axis, Capture, Reading, Sequence};
use crate::shapes::sphere;
use crate::test_folder::Folder;
use crease::numpy::{Array, Compression, write_npz};
use glam::Vec3A;

fn source(folder: &Path, scans: Option<PathBuf>) -> Source {
    let (name, orientation) = ("walk".to_owned(), Orientation::default());
    Source {
        frames: folder.to_path_buf(),
        scans,
        name,
        frames_per_second: 30.0,
        units: "metre".into(),
        orientation,
        poses_up: Up::Y,
    }
}

fn write(path: &Path, arrays: &[(&str, Array)]) {
    let arrays: Vec<(&str, &Array)> = arrays.iter().map(|(name, array)| (*name, array)).collect();
    fs::write(path, write_npz(&arrays, Compression::Stored).unwrap()).unwrap();
}

fn pose(frame: usize) -> [(&'static str, Array); 2] {
    let mut numbers = vec![0f32; 72];
    numbers[4] = 0.1 * frame as f32;
    [("pose", Array::new(&[72], numbers)), ("transl", Array::new(&[3], vec![frame as f32, 0.0, 0.0]))]
}

#[test]
fn cape_becomes_a_sequence() {
    let folder = Folder::new("import-cape");
    let scans = folder.0.join("scans");
    fs::create_dir_all(&scans).unwrap();
    let mesh = sphere(0.9, 2);
    for frame in 0..3 {
        write(&folder.0.join(format!("walk.00000{}.npz", frame + 1)), &pose(frame));
        let bytes = MeshFormat::Ply.encode(&mesh.positions, &mesh.triangles);
        fs::write(scans.join(format!("walk.00000{}.ply", frame + 1)), bytes).unwrap();
    }
    let to = folder.0.join("sequence");
    let imported = import(Layout::Cape, &source(&folder.0, Some(scans.clone())), &to).unwrap();
    assert_eq!(imported, Imported { frame_count: 3, body: to.join("poses.npz") });
    let capture = Capture::open(&to).unwrap();
    assert_eq!(capture.scan(2).unwrap().points.len(), 40_000, "the mesh is sampled");
    assert!(
        import(Layout::Cape, &source(&folder.0, Some(scans.clone())), &to).is_err(),
        "a sequence is not overwritten"
    );
    fs::remove_file(scans.join("walk.000002.ply")).unwrap();
    let error = import(Layout::Cape, &source(&folder.0, Some(scans)), &folder.0.join("other")).unwrap_err();
    assert!(error.to_string().contains("3 scans"), "{error}");
    assert!(!folder.0.join("other/sequence.json").exists());
}

#[test]
fn packed_files_become_a_sequence_with_a_body() {
    let folder = Folder::new("import-packed");
    for frame in 0..2 {
        let points = Array::new(&[4, 3], (0..12).map(|i| 0.1 * i as f32).collect::<Vec<f32>>());
        let normals = Array::new(&[4, 3], [0f32, 1.0, 0.0].repeat(4));
        let [pose, translation] = pose(frame);
        let betas = ("betas", Array::new(&[2], vec![0.5f32, -0.5]));
        let arrays = [("scan_pc", points), ("scan_n", normals), pose, translation, betas];
        write(&folder.0.join(format!("rp_{frame}.npz")), &arrays.map(|(name, array)| (name, array)));
    }
    let to = folder.0.join("sequence");
    import(Layout::Packed, &source(&folder.0, None), &to).unwrap();
    let sequence = Sequence::open(&to, None, &Reading::default(), |_| Vec3A::ZERO).unwrap();
    assert_eq!((sequence.betas.as_slice(), sequence.poses.len()), (&[0.5, -0.5][..], 2));
    assert_eq!(sequence.poses[1].translation.x, 1.0);
    assert_eq!(sequence.capture.scan(1).unwrap().points.len(), 4);

    write(&folder.0.join("rp_2.npz"), &[("pose", Array::new(&[66], vec![0f32; 66]))]);
    let error = import(Layout::Packed, &source(&folder.0, None), &folder.0.join("other")).unwrap_err();
    assert!(error.to_string().contains("rp_2.npz: pose"), "{error}");
}

#[test]
fn scans_and_poses_with_z_up_are_turned_when_they_are_read() {
    let folder = Folder::new("import-z-up");
    let points = Array::new(&[4, 3], (0..12).map(|i| 0.1 * i as f32).collect::<Vec<f32>>());
    let normals = Array::new(&[4, 3], [0f32, 0.0, 1.0].repeat(4));
    let [pose, translation] = pose(1);
    let betas = ("betas", Array::new(&[1], vec![0.5f32]));
    let arrays = [("scan_pc", points), ("scan_n", normals), pose, translation, betas];
    write(&folder.0.join("rp_0.npz"), &arrays.map(|(name, array)| (name, array)));
    let to = folder.0.join("sequence");
    let orientation = Orientation { up: Up::Z, mirrored: Some(Axis::X) };
    let source = Source { orientation, poses_up: Up::Z, ..source(&folder.0, None) };
    import(Layout::Packed, &source, &to).unwrap();
    let root = Vec3A::new(0.0, -0.2, 0.0);
    let sequence = Sequence::open(&to, None, &Reading::default(), |_| root).unwrap();
    let scan = sequence.capture.scan(0).unwrap();
    assert!(scan.points[1].distance(Vec3A::new(-0.3, 0.5, -0.4)) < 1e-6, "{}", scan.points[1]);
    assert!(scan.normals.unwrap()[0].distance(Vec3A::Y) < 1e-6);
    // The root joint, at (1, -0.2, 0) of the files, is at (1, 0, 0.2) where y is up.
    let joint = root + Vec3A::from(sequence.poses[0].translation);
    assert!(joint.distance(Vec3A::new(1.0, 0.0, 0.2)) < 1e-6, "{joint}");
}
