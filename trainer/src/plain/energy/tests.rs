use super::*;
use crate::plain::{numbers, scalar, test_devices};
use crate::sampling::random_points;
use crate::shapes::{sphere, sphere_points};

const NONE: Weights = Weights { regulariser: 0.0, anchor: 0.0, mesh_to_scan: 0.0 };

fn scan(radius: f32, seed: u64) -> Scan {
    let points = sphere_points(60, radius, seed);
    let weights = (0..60).map(|i| 0.5 + i as f32 / 60.0).collect();
    Scan::new(points, weights, None)
}

fn energy(weights: Weights) -> (Energy, Vec<Vec3A>) {
    let mesh = sphere(1.0, 1);
    let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
    let anchors = Rows::new(&[vec![(0, 0.5), (5, 0.5)], vec![(7, 1.0)], vec![(1, 0.25), (2, 0.25), (3, 0.5)]]);
    (Energy::new(&mesh.triangles, &adjacency, anchors, weights), mesh.positions)
}

/// The energy and its gradient on the processor, with which every other device has to agree.
fn value(energy: &Energy, positions: &[Vec3A], scans: &[&Scan]) -> (f32, Vec<f32>) {
    let flat: Vec<f32> = positions.iter().flat_map(|p| p.to_array()).collect();
    let on = |device: &Device| {
        let data = TensorData::new(flat.clone(), [positions.len(), 3]);
        let posed = Tensor::<2>::from_data(data, device).require_grad();
        let total = energy.evaluate(&posed, positions, scans).unwrap();
        let gradients = total.backward();
        (scalar(total), numbers(posed.grad(&gradients).unwrap()))
    };
    let mut devices = test_devices().into_iter();
    let (total, gradient) = on(&devices.next().expect("the processor").1);
    let largest = gradient.iter().fold(0.0, |a: f32, b| a.max(b.abs()));
    for (choice, device) in devices {
        let (other_total, other) = on(&device);
        assert!((other_total - total).abs() <= 1e-5 * total.abs().max(1e-3), "{choice:?}: {other_total} for {total}");
        let apart = gradient.iter().zip(&other).fold(0.0, |a: f32, (b, c)| a.max((b - c).abs()));
        assert!(apart <= 1e-4 * largest, "{choice:?}: {apart} of {largest}");
    }
    (total, gradient)
}

/// Compares the gradient with central differences in which correspondences are found anew.
fn check_gradient(weights: Weights) {
    let (energy, sphere) = energy(weights);
    let scans = [scan(1.1, 1), scan(0.8, 2)];
    let scans: Vec<&Scan> = scans.iter().collect();
    let jitter = random_points(2 * sphere.len(), 0.05, 3);
    let positions: Vec<Vec3A> = jitter.iter().enumerate().map(|(i, j)| sphere[i % sphere.len()] + *j).collect();
    let (_, gradient) = value(&energy, &positions, &scans);
    let largest = gradient.iter().fold(0.0, |a: f32, b| a.max(b.abs()));
    assert!(largest > 1e-4, "there is a gradient");
    let mut errors = Vec::new();
    for vertex in (0..positions.len()).step_by(5) {
        for axis in 0..3 {
            let step = 2e-3;
            let [below, above] = [-step, step].map(|step| {
                let mut moved = positions.clone();
                moved[vertex][axis] += step;
                value(&energy, &moved, &scans).0
            });
            errors.push((gradient[3 * vertex + axis] - (above - below) / (2.0 * step)).abs() / largest);
        }
    }
    let greatest = errors.iter().copied().fold(0.0, f32::max);
    assert!(greatest < 0.02, "greatest error over the largest entry: {greatest}");
}

#[test]
fn gradient_of_scan_to_mesh() {
    check_gradient(NONE);
}

#[test]
fn gradient_of_the_regulariser() {
    check_gradient(Weights { regulariser: 1.5, ..NONE });
}

#[test]
fn gradient_of_the_anchors() {
    check_gradient(Weights { anchor: 2.0, ..NONE });
}

#[test]
fn gradient_of_mesh_to_scan() {
    check_gradient(Weights { mesh_to_scan: 1.0, ..NONE });
}

#[test]
fn values_are_means_of_squares() {
    let (energy, positions) = energy(NONE);
    let points = vec![Vec3A::Y * 0.0 + positions[3] * 1.5, positions[7] * 1.5];
    let one = Scan::new(points.clone(), vec![1.0, 1.0], None);
    assert!((value(&energy, &positions, &[&one]).0 - 0.25).abs() < 1e-5);
    let half = Scan::new(points, vec![1.0, 0.0], None);
    assert!((value(&energy, &positions, &[&half]).0 - 0.125).abs() < 1e-5, "μ weighs points");
    let twice: Vec<Vec3A> = positions.iter().chain(&positions).copied().collect();
    assert!((value(&energy, &twice, &[&one, &half]).0 - 0.1875).abs() < 1e-5, "frames are averaged");
}

#[test]
fn the_regulariser_of_a_flat_even_patch_is_zero_inside() {
    let (energy, positions) = energy(Weights { regulariser: 1.0, ..NONE });
    let on_surface = Scan::new(vec![positions[0]], vec![1.0], None);
    let smooth = value(&energy, &positions, &[&on_surface]).0;
    let mut spiky = positions.clone();
    spiky[20] *= 1.5;
    assert!(value(&energy, &spiky, &[&on_surface]).0 > smooth + 1e-3);
    let point = vec![Vec3A::X; positions.len()];
    let at_point = Scan::new(vec![Vec3A::X], vec![1.0], None);
    assert!(value(&energy, &point, &[&at_point]).0 < 1e-9, "a mesh shrunk to a point has no umbrella Laplacian");
}

#[test]
fn drawn_points_pull_and_the_whole_scan_is_pulled_to() {
    let (energy, positions) = energy(Weights { anchor: 1.0, ..NONE });
    let whole = scan(1.1, 1);
    let drawn = whole.drawn(500, &mut crate::sampling::generator(2));
    let (all, some) = (value(&energy, &positions, &[&whole]).0, value(&energy, &positions, &[&drawn]).0);
    assert!((all - some).abs() < 0.1 * all, "{some} against {all}");
    assert_ne!(all, some);
    let one = whole.drawn(1, &mut crate::sampling::generator(3));
    let only_anchors = |scan: &Scan| energy.to_scans(&energy.anchors, &[&positions], &[scan]).targets;
    assert_eq!(only_anchors(&one), only_anchors(&whole));
}

#[test]
fn a_camera_pulls_the_anchors_that_it_sees() {
    use glam::{Affine3A, Vec3};
    let mesh = sphere(1.0, 1);
    let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
    let index = |direction: Vec3A| {
        let along =
            |&a: &usize, &b: &usize| mesh.positions[a].dot(direction).total_cmp(&mesh.positions[b].dot(direction));
        (0..mesh.positions.len()).max_by(along).unwrap() as u32
    };
    let anchors = Rows::new(&[vec![(index(-Vec3A::Z), 1.0)], vec![(index(Vec3A::Z), 1.0)]]);
    let energy = Energy::new(&mesh.triangles, &adjacency, anchors, Weights { anchor: 1.0, ..NONE });
    let world_from_camera = Affine3A::from_translation(Vec3::new(0.0, 0.0, -4.0));
    let camera = Camera {
        width: 100,
        height: 100,
        focal: [100.0; 2],
        centre: [50.0; 2],
        depth_scale: 1e-3,
        world_from_camera,
        camera_from_world: world_from_camera.inverse(),
    };
    // One point of no weight: only anchors pull.
    let point = mesh.positions[index(-Vec3A::Z) as usize] * 1.5;
    let pulled = |camera: Option<Camera>| {
        let scan = Scan::new(vec![point], vec![0.0], camera);
        value(&energy, &mesh.positions, &[&scan]).1
    };
    let (seen, all) = (pulled(Some(camera)), pulled(None));
    let gradient = |values: &[f32], vertex: u32| Vec3A::from_slice(&values[3 * vertex as usize..]).length();
    assert!(gradient(&seen, index(-Vec3A::Z)) > 0.1);
    assert_eq!(gradient(&seen, index(Vec3A::Z)), 0.0, "the far side is not seen");
    assert!(gradient(&all, index(Vec3A::Z)) > 0.1);
}
