use super::*;
use crate::sampling::generator;
use crate::shapes::sphere_points;
use glam::{Quat, Vec3};
use rand::RngExt;

const BY_COUNT: QuadraticOptions = QuadraticOptions { neighbourhood: Neighbourhood::Nearest(25), clamp: f32::INFINITY };

fn by_radius(radius: f32) -> QuadraticOptions {
    QuadraticOptions { neighbourhood: Neighbourhood::Radius(radius), clamp: f32::INFINITY }
}

/// Mean and greatest error relative to `expected`'s length.
fn errors(points: &[Vec3A], options: &QuadraticOptions, expected: impl Fn(Vec3A) -> Vec3A) -> (f32, f32) {
    let errors: Vec<f32> = fit_quadratics(points, options)
        .iter()
        .zip(points)
        .map(|(fit, &point)| (fit.unwrap().laplacian - expected(point)).length() / expected(point).length())
        .collect();
    (errors.iter().sum::<f32>() / errors.len() as f32, errors.iter().copied().fold(0.0, f32::max))
}

#[test]
fn a_sphere_gives_twice_its_curvature_outward() {
    let radius = 0.5;
    let points = sphere_points(20_000, radius, 1);
    for options in [BY_COUNT, by_radius(0.04)] {
        let (mean, greatest) = errors(&points, &options, |point| 2.0 * point / (radius * radius));
        assert!(mean < 0.005, "{options:?}: mean error {mean}");
        assert!(greatest < 0.05, "{options:?}: greatest error {greatest}");
        // Negative case: the opposite sign is far off.
        assert!(errors(&points, &options, |point| -2.0 * point / (radius * radius)).0 > 1.9);
    }
}

/// Point of a torus about the y axis, and its δ = 2 H n, by the angles around the axis and around the tube.
fn torus(major: f32, minor: f32, around: f32, tube: f32) -> (Vec3A, Vec3A) {
    let ring = Vec3A::new(around.cos(), 0.0, around.sin());
    let normal = ring * tube.cos() + Vec3A::Y * tube.sin();
    let curvature = 1.0 / minor + tube.cos() / (major + minor * tube.cos());
    (ring * major + normal * minor, normal * curvature)
}

#[test]
fn a_torus_agrees_with_its_formula() {
    let mut generator = generator(2);
    let samples: Vec<(Vec3A, Vec3A)> = (0..60_000)
        .map(|_| {
            let mut angle = || generator.random_range(0.0..std::f32::consts::TAU);
            torus(0.5, 0.2, angle(), angle())
        })
        .collect();
    let points: Vec<Vec3A> = samples.iter().map(|sample| sample.0).collect();
    let fits = fit_quadratics(&points, &BY_COUNT);
    let mean: f32 =
        fits.iter().zip(&samples).map(|(fit, sample)| (fit.unwrap().laplacian - sample.1).length()).sum::<f32>()
            / points.len() as f32;
    assert!(mean < 0.05, "mean error {mean} 1/m of 3 to 6.4");
    for (fit, sample) in fits.iter().zip(&samples) {
        assert!(fit.unwrap().normal.dot(sample.1.normalize()).abs() > 0.99);
    }
}

#[test]
fn a_plane_has_none() {
    let mut generator = generator(3);
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
    let points: Vec<Vec3A> = (0..2_000)
        .map(|_| {
            Vec3A::from(turn * Vec3::new(generator.random_range(-1.0..1.0), 0.0, generator.random_range(-1.0..1.0)))
        })
        .collect();
    for fit in fit_quadratics(&points, &BY_COUNT) {
        assert!(fit.unwrap().laplacian.length() < 0.01);
    }
}

#[test]
fn turning_the_cloud_turns_the_answer() {
    let points: Vec<Vec3A> = sphere_points(3_000, 0.4, 4).iter().map(|p| *p * Vec3A::new(1.0, 0.6, 1.5)).collect();
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 1.0, 0.3, -2.0);
    let turned: Vec<Vec3A> = points.iter().map(|&point| turn * point).collect();
    for (before, after) in fit_quadratics(&points, &BY_COUNT).iter().zip(fit_quadratics(&turned, &BY_COUNT)) {
        let expected = turn * before.unwrap().laplacian;
        assert!((after.unwrap().laplacian - expected).length() < 0.02 * expected.length() + 0.01);
    }
}

/// A1, A2 and Δz as printed by Liang & Zhao.
fn printed_formula(a: &[f64; 6]) -> [f64; 3] {
    let [_, a2, a3, a4, a5, a6] = *a;
    let g = 1.0 + a2 * a2 + a3 * a3;
    let first = (a2 * a3 * (a2 * a5 + 2.0 * a3 * a6) - (1.0 + a3 * a3) * (2.0 * a2 * a4 + a3 * a5)) / (g * g)
        + (a3 * a5 - 2.0 * a2 * a6) / g;
    let second = (a2 * a3 * (a3 * a5 + 2.0 * a2 * a4) - (1.0 + a2 * a2) * (2.0 * a3 * a6 + a2 * a5)) / (g * g)
        + (a2 * a5 - 2.0 * a3 * a4) / g;
    let third =
        first * a2 + second * a3 + (2.0 * (1.0 + a3 * a3) * a4 - 2.0 * a2 * a3 * a5 + 2.0 * (1.0 + a2 * a2) * a6) / g;
    [first, second, third]
}

#[test]
fn the_short_form_is_the_printed_formula() {
    let mut generator = generator(5);
    for _ in 0..100 {
        let a: [f64; 6] = std::array::from_fn(|_| generator.random_range(-2.0..2.0));
        for (short, printed) in laplacian_of_graph(&a).iter().zip(printed_formula(&a)) {
            assert!((short - printed).abs() < 1e-9 * (1.0 + printed.abs()), "{a:?}: {short} against {printed}");
        }
    }
}

#[test]
fn outliers_are_clamped_and_thin_neighbourhoods_refused() {
    let points = sphere_points(2_000, 0.1, 6);
    let clamped = QuadraticOptions { clamp: 5.0, ..BY_COUNT };
    for fit in fit_quadratics(&points, &clamped) {
        assert!((fit.unwrap().laplacian.length() - 5.0).abs() < 1e-3, "20 1/m shortened to 5");
    }
    let line: Vec<Vec3A> = (0..40).map(|i| Vec3A::X * i as f32 * 0.01).collect();
    assert!(fit_quadratics(&line, &BY_COUNT).iter().all(Option::is_none));
    assert!(fit_quadratics(&points[..5], &BY_COUNT).iter().all(Option::is_none));
    assert!(fit_quadratics(&points, &by_radius(1e-4)).iter().all(Option::is_none));
    assert!(fit_quadratics(&[], &BY_COUNT).is_empty());
}
