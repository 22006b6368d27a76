//! F at a point of an element of any order.
#![allow(non_snake_case)]

use fem_kinematics::{Mat, RestShape, deformation_gradient, deformation_gradient_at, shape_matrix};

/// ∇N of the nodes but the first of a quadratic triangle with corners `X` at barycentric `at`:
/// corners 1 and 2, then the middles of edges 01, 12 and 20.
fn quadratic(X: &[[f64; 2]; 3], at: [f64; 3]) -> [[f64; 2]; 5] {
    let shape = RestShape::from_vertices(X).unwrap();
    let g = [0, 1, 2].map(|a| shape.barycentric_gradient(a));
    let corner = |a: usize| g[a].map(|c| (4.0 * at[a] - 1.0) * c);
    let edge = |a: usize, b: usize| [0, 1].map(|j| 4.0 * (at[a] * g[b][j] + at[b] * g[a][j]));
    [corner(1), corner(2), edge(0, 1), edge(1, 2), edge(2, 0)]
}

#[test]
fn a_quadratic_triangle_follows_a_quadratic_map_at_every_point() {
    let X = [[0.1, -0.2], [1.3, 0.1], [0.4, 0.9]];
    let middle = |a: usize, b: usize| [0, 1].map(|i| 0.5 * (X[a][i] + X[b][i]));
    let nodes = [X[0], X[1], X[2], middle(0, 1), middle(1, 2), middle(2, 0)];
    // x = (X + 0.3 XY + 0.1 Y², Y − 0.2 X²) and its derivative.
    let map = |[x, y]: [f64; 2]| [x + 0.3 * x * y + 0.1 * y * y, y - 0.2 * x * x];
    let exact = |[x, y]: [f64; 2]| Mat([[1.0 + 0.3 * y, 0.3 * x + 0.2 * y], [-0.4 * x, 1.0]]);
    let moved = nodes.map(map);
    let edges: Vec<[f64; 2]> = (1..6)
        .map(|a| [0, 1].map(|i| moved[a][i] - moved[0][i]))
        .collect();
    for at in [[1.0 / 3.0; 3], [0.7, 0.2, 0.1], [0.0, 1.0, 0.0]] {
        let place = [0, 1].map(|i| (0..3).map(|a| at[a] * X[a][i]).sum());
        let F = deformation_gradient_at(&edges, &quadratic(&X, at));
        let error = (F - exact(place)).norm_squared().sqrt();
        assert!(error < 1e-14, "{F:?} at {place:?}: {error:e}");
    }
}

#[test]
fn a_linear_simplex_is_the_product_of_its_shape_matrices_to_the_bit() {
    let X = [
        [0.0, 0.1, 0.2],
        [1.1, 0.0, -0.3],
        [0.2, 0.9, 0.0],
        [0.0, 0.3, 1.2],
    ];
    let x = [
        [0.3, 0.0, 0.1],
        [1.0, 0.2, -0.5],
        [-0.2, 1.4, 0.1],
        [0.1, 0.1, -0.9],
    ];
    let rest = RestShape::from_vertices(&X).unwrap();
    let Ds = shape_matrix(&x);
    assert_eq!(deformation_gradient(&Ds, &rest.inverse), Ds * rest.inverse);
}

#[test]
fn the_shorter_list_ends_the_sum_and_a_negative_zero_stays() {
    let edges: [[f64; 2]; 2] = [[2.0, -0.0], [5.0, 5.0]];
    let F = deformation_gradient_at(&edges, &[[1.0, 3.0]]);
    assert_eq!(F, Mat([[2.0, 6.0], [0.0, 0.0]]));
    assert!(F.0[1][0].is_sign_negative());
    assert_eq!(deformation_gradient_at::<f64, 2>(&[], &edges), Mat::zeros());
}
