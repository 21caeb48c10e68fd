//! The factor's pattern, values, size and checks.

use super::direct::DirectSolver;
use super::factor_pattern::{FactorPattern, inverse_permutation};
use super::*;
use crate::mesh::SparseMatrix;
use crate::mesh::test_meshes::{grid, icosphere, noise_vectors};
use half::f16;

const ANCHORS: [u32; 4] = [1, 50, 90, 140];

fn example() -> (Subdivision, CoarseFactor) {
    let mesh = icosphere(1);
    let subdivision = Subdivision::new(42, &mesh.triangles, 1);
    let factor = CoarseFactor::new(&subdivision, &ANCHORS, 1.0);
    (subdivision, factor)
}

fn coarsest_matrix(subdivision: &Subdivision) -> SparseMatrix {
    galerkin::coarsest_operator(subdivision, &ANCHORS, 1.0)
}

/// The Galerkin operator of level 0, dense and in double precision.
fn dense_matrix(subdivision: &Subdivision) -> Vec<Vec<f64>> {
    let matrix = coarsest_matrix(subdivision);
    let mut dense = vec![vec![0.0; 42]; 42];
    for (i, dense) in dense.iter_mut().enumerate() {
        matrix.row(i).for_each(|(j, value)| dense[j as usize] = f64::from(value));
    }
    dense
}

#[test]
fn factor_is_the_dense_factor_of_the_permuted_matrix_rounded() {
    let (subdivision, factor) = example();
    let dense = dense_matrix(&subdivision);
    let at = |step: usize| factor.permutation[step] as usize;
    let mut l = vec![vec![0.0f64; 42]; 42];
    let mut d = [0.0; 42];
    for j in 0..42 {
        d[j] = dense[at(j)][at(j)] - (0..j).map(|k| l[j][k] * l[j][k] * d[k]).sum::<f64>();
        for i in j + 1..42 {
            l[i][j] = (dense[at(i)][at(j)] - (0..j).map(|k| l[i][k] * l[j][k] * d[k]).sum::<f64>()) / d[j];
        }
    }
    let step_of = inverse_permutation(&factor.permutation).unwrap();
    let pattern = FactorPattern::new(&galerkin::coupling(&subdivision), &factor.permutation, &step_of);
    for j in 0..42 {
        assert!((f64::from(factor.diagonal[j]) / d[j] - 1.0).abs() < 1e-5);
        let rows = &pattern.rows[pattern.column(j)];
        assert!(rows.is_sorted_by(|a, b| a < b));
        for i in j + 1..42 {
            match rows.binary_search(&(i as u32)) {
                Ok(entry) => {
                    let value = f64::from(factor.values[pattern.offsets[j] as usize + entry].to_f32());
                    assert!((value - l[i][j]).abs() < 6e-4 * l[i][j].abs() + 1e-5, "{value} against {}", l[i][j]);
                }
                Err(_) => assert!(l[i][j].abs() < 1e-12, "{} outside of the pattern", l[i][j]),
            }
        }
    }
}

#[test]
fn direct_solve_inverts_up_to_half_precision() {
    let (subdivision, factor) = example();
    let matrix = coarsest_matrix(&subdivision);
    let x = noise_vectors(42, 4);
    let (mut b, mut solved) = (x.clone(), x.clone());
    matrix.apply(&x, &mut b);
    DirectSolver::new(&galerkin::coupling(&subdivision), &factor).unwrap().solve(&b, &mut solved);
    assert!(x.iter().zip(&solved).all(|(x, solved)| (*x - *solved).length() < 0.02));
}

#[test]
fn size_is_two_bytes_an_entry_and_the_same_every_time() {
    let (subdivision, factor) = example();
    assert_eq!(factor.permutation.len(), 42);
    assert!(factor.values.len() <= 42 * 41 / 2);
    assert_eq!(size_of_val(&factor.values[..]), 2 * factor.values.len());
    assert_eq!(factor, CoarseFactor::new(&subdivision, &ANCHORS, 1.0));

    // Fill stays low where there is something to order: a quarter of all pairs at 642 vertices, and falling.
    let larger = Subdivision::new(642, &icosphere(3).triangles, 1);
    let factor = CoarseFactor::new(&larger, &ANCHORS, 1.0);
    assert!(factor.values.len() < 642 * 641 / 2 / 3, "{}", factor.values.len());
}

#[test]
fn a_factor_that_does_not_fit_is_refused_with_field_expected_and_found() {
    let (subdivision, factor) = example();
    let refused = |change: &dyn Fn(&mut CoarseFactor)| {
        let mut factor = factor.clone();
        change(&mut factor);
        Solver::new(&subdivision, &ANCHORS, 1.0, &factor).map(|_| ()).unwrap_err().to_string()
    };
    let count = factor.values.len();
    assert_eq!(refused(&|f| f.values.truncate(7)), format!("solver factor: values has 7 entries, expected {count}"));
    assert_eq!(refused(&|f| f.diagonal.push(1.0)), "solver factor: diagonal has 43 entries, expected 42");
    assert_eq!(refused(&|f| f.permutation.clear()), "solver factor: permutation has 0 entries, expected 42");
    for wrong in [42, factor.permutation[1]] {
        assert_eq!(
            refused(&|f| f.permutation[0] = wrong),
            "solver factor: permutation is expected to name each of 42 vertices once"
        );
    }
    assert_eq!(refused(&|f| f.diagonal[3] = -1.0), "solver factor: diagonal[3] is -1, expected positive and finite");
    assert_eq!(refused(&|f| f.values[5] = f16::NAN), "solver factor: values[5] is NaN, expected finite");
    assert!(Solver::new(&subdivision, &ANCHORS, 1.0, &factor).is_ok());
}

#[test]
fn the_galerkin_operator_couples_three_rings_and_nothing_else() {
    for (mesh, level_count) in
        [(icosphere(3), 0), (icosphere(3), 1), (icosphere(2), 2), (icosphere(2), 3), (grid(9, 8), 2)]
    {
        let subdivision = Subdivision::new(mesh.positions.len(), &mesh.triangles, level_count);
        let matrix = galerkin::coarsest_operator(&subdivision, &[0, 7], 1.0);
        let coupling = galerkin::coupling(&subdivision).sorted();
        for k in 0..matrix.row_count() {
            let others = matrix.row(k).map(|(column, _)| column).filter(|&column| column as usize != k);
            assert!(others.eq(coupling.of(k).iter().copied()), "{level_count} levels, vertex {k}");
        }
    }
}
