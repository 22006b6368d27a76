//! Strains, invariants, determinants, stress measures, flat tensors and simplices.
#![allow(non_snake_case)]

mod common;
use common::*;
use fem_kinematics::*;

fn close<const D: usize>(a: Mat<f64, D>, b: Mat<f64, D>, tolerance: f64) {
    let error = largest(&(a - b));
    assert!(
        error <= tolerance * (1.0 + largest(&b)),
        "{error:e}: {a:?} {b:?}"
    );
}

/// The gradient of a function of F by dual numbers.
fn gradient<const D: usize>(
    F: &Mat<f64, D>,
    f: impl Fn(&Mat<Dual<f64>, D>) -> Dual<f64>,
) -> Mat<f64, D> {
    Mat::from_fn(|k, l| {
        f(&Mat::from_fn(|i, j| {
            Dual::new(F.0[i][j], f64::from(u8::from((i, j) == (k, l))))
        }))
        .derivative
    })
}

fn invariants_of<const D: usize>() {
    let mut random = Random(3);
    for _ in 0..100 {
        let F = random.tame::<D>();
        let C = right_cauchy_green(&F);
        let invariants = Invariants::new(&F);
        assert!((invariants.first - C.trace()).abs() < 1e-14);
        assert!((invariants.second - (C * C).trace()).abs() < 1e-14);
        let principal = (C.trace().powi(2) - (C * C).trace()) / 2.0;
        assert!((invariants.second_principal - principal).abs() < 1e-13);
        assert!((invariants.third - C.determinant()).abs() < 1e-13);
        let rest = Invariants::minus_rest(&F);
        let n = D as f64;
        assert!((rest.first - (invariants.first - n)).abs() < 1e-14);
        assert!((rest.second - (invariants.second - n)).abs() < 2e-14);
        let at_rest = n * (n - 1.0) / 2.0;
        assert!((rest.second_principal - (principal - at_rest)).abs() < 1e-13);
        assert!((rest.third - (invariants.third - 1.0)).abs() < 1e-13);

        close(
            Invariants::first_gradient(&F),
            gradient(&F, |F| Invariants::new(F).first),
            1e-13,
        );
        close(
            Invariants::second_gradient(&F),
            gradient(&F, |F| Invariants::new(F).second),
            1e-13,
        );
        close(
            Invariants::second_principal_gradient(&F),
            gradient(&F, |F| Invariants::new(F).second_principal),
            1e-13,
        );
        close(
            Invariants::third_gradient(&F),
            gradient(&F, |F| Invariants::new(F).third),
            1e-13,
        );
        let isochoric = IsochoricInvariants::new(&F);
        close(
            isochoric.first_gradient,
            gradient(&F, |F| IsochoricInvariants::new(F).first),
            1e-13,
        );
        close(
            isochoric.second_gradient,
            gradient(&F, |F| IsochoricInvariants::new(F).second),
            1e-13,
        );
        // They do not see the volume.
        let scaled = IsochoricInvariants::new(&F.scale(1.7));
        assert!((scaled.first - isochoric.first).abs() < 1e-14 * scaled.first);
        assert!((scaled.second - isochoric.second).abs() < 1e-14 * scaled.second);
    }
}

#[test]
fn invariants_and_their_gradients() {
    invariants_of::<2>();
    invariants_of::<3>();
}

#[test]
fn the_second_principal_invariant_of_a_flat_element_does_not_cancel() {
    let F = Mat::from_diagonal([1.0, 1e-9, 1e-9]);
    let expected = 2e-18 + 1e-36;
    let got = Invariants::new(&F).second_principal;
    assert!((got - expected).abs() < 1e-15 * expected, "{got:e}");
}

#[test]
fn determinants_keep_their_digits() {
    // (1 + e)(1 − e/2)² − 1 = −3e²/4 + e³/4
    for e in [1e-3, 1e-6, 2f64.powi(-30), 2f64.powi(-40)] {
        let F = Mat::from_diagonal([1.0 + e, 1.0 - e / 2.0, 1.0 - e / 2.0]);
        let (p, q) = (F.0[0][0] - 1.0, F.0[1][1] - 1.0);
        let expected = p + 2.0 * q + q * q + 2.0 * p * q + p * q * q;
        let got = determinant_minus_one(&F);
        assert!((got - expected).abs() <= 4e-16 * p, "{got:e} {expected:e}");
    }
    // Sixteenths: the products of integers are exact.
    let G = [[1, -2, 3], [2, 1, -1], [-3, 1, -2]];
    let F = Mat::<f64, 3>::from_fn(|i, j| f64::from(u8::from(i == j)) + f64::from(G[i][j]) / 16.0);
    let [a, b, c] = [0, 1, 2].map(|i: usize| [0, 1, 2].map(|j| G[i][j] + 16 * i32::from(i == j)));
    let minor = |j: usize, k: usize| b[j] * c[k] - b[k] * c[j];
    let exact = a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1) - 4096;
    assert!(F.0[0][1] != 0.0 && (F - Mat::identity()).norm_squared() < 0.25);
    assert_eq!(determinant_minus_one(&F), f64::from(exact) / 4096.0);
    let stretched = |x: f64| Mat::from_diagonal([x, 1.0, 1.0]);
    assert_eq!(
        log_determinant(&stretched(1.0 + 2f64.powi(-40))),
        (2f64.powi(-40)).ln_1p()
    );
    let small = log_determinant(&stretched(1e-6));
    assert!((small - 1e-6_f64.ln()).abs() < 4e-15);
    assert_eq!(log_determinant(&stretched(0.0)), f64::NEG_INFINITY);
    assert!(log_determinant(&stretched(-0.1)).is_nan());
    let mut random = Random(8);
    for _ in 0..200 {
        let F = random.tame::<3>();
        let j = F.determinant();
        assert!((determinant_minus_one(&F) - (j - 1.0)).abs() < 2e-15 * (1.0 + j));
        close(
            F.cofactor().scale(1.0 / j),
            gradient(&F, log_determinant),
            1e-14,
        );
    }
}

fn strains<const D: usize>() {
    let mut random = Random(9);
    for size in [1.0, 1e-3, 1e-7, 1e-12] {
        for _ in 0..50 {
            let G = random.matrix::<D>().scale(0.3 * size);
            let F = Mat::identity() + G;
            let G = F - Mat::identity();
            close(
                infinitesimal_strain(&F).scale(1.0 / size),
                G.symmetric_part().scale(1.0 / size),
                1e-15,
            );
            let E = green_strain(&F);
            let expected = G.symmetric_part() + G.tr_mul(&G).scale(0.5);
            close(E.scale(1.0 / size), expected.scale(1.0 / size), 1e-15);
            let p = polar(&F);
            let e = corotated_strain(&F, &p);
            close(e, p.S - Mat::identity(), 2e-15);
            // (I + e)² = I + 2E, with no digits lost: 2e + e² = 2E
            let back = e.scale(2.0) + e * e;
            close(back.scale(1.0 / size), E.scale(2.0 / size), 4e-15);

            let dF = random.matrix::<D>();
            let dual: Mat<Dual<f64>, D> = Mat::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]));
            let dE = green_strain(&dual);
            close(
                green_strain_differential(&F, &dF),
                Mat::from_fn(|i, j| dE.0[i][j].derivative),
                1e-15,
            );
            let de = corotated_strain(&dual, &polar(&dual));
            close(
                p.stretch_differential(&dF).ok().unwrap(),
                Mat::from_fn(|i, j| de.0[i][j].derivative),
                1e-13,
            );
        }
    }
    // Inverted elements take the plain form.
    let mut diagonal = [1.0; D];
    diagonal[D - 1] = -1.0;
    diagonal[0] = 2.0;
    let F = Mat::from_diagonal(diagonal);
    close(corotated_strain(&F, &polar(&F)), F - Mat::identity(), 1e-15);
}

#[test]
fn strains_near_rest_and_far() {
    strains::<2>();
    strains::<3>();
}

fn stresses<const D: usize>() {
    let mut random = Random(10);
    for _ in 0..50 {
        let F = random.tame::<D>();
        // An objective stress: P = F S₂ with a symmetric S₂.
        let second = random.matrix::<D>().symmetric_part();
        let P = piola_from_second_piola(&F, &second);
        close(second_piola_from_piola(&F, &P), second, 1e-14);
        let sigma = cauchy_from_piola(&F, &P);
        close(sigma, sigma.transpose(), 1e-14);
        close(piola_from_cauchy(&F, &sigma), P, 1e-14);
        let tau = kirchhoff_from_piola(&F, &P);
        close(tau, sigma.scale(F.determinant()), 1e-14);
        close(piola_from_kirchhoff(&F, &tau), P, 1e-14);
        // Nanson: σ n a = P N A for the area that cof F carries from rest to deformed.
        let N = std::array::from_fn(|_| random.unit());
        let (here, there) = (sigma.mul_vec(F.cofactor().mul_vec(N)), P.mul_vec(N));
        for i in 0..D {
            assert!((here[i] - there[i]).abs() < 1e-14);
        }
    }
}

#[test]
fn stress_measures_convert_back_and_forth() {
    stresses::<2>();
    stresses::<3>();
}

fn identities<const D: usize>() {
    let mut random = Random(12);
    for _ in 0..50 {
        let (A, B, Q) = (
            random.matrix::<D>(),
            random.matrix::<D>(),
            random.rotation::<D>(),
        );
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
        near(A.dot(&B), A.tr_mul(&B).trace());
        near(A.dot(&B), A.mul_tr(&B).trace());
        near((A * B).trace(), (B * A).trace());
        near(A.norm_squared(), A.tr_mul(&A).trace());
        near((Q * A).norm_squared(), A.norm_squared());
        near((A * Q).norm_squared(), A.norm_squared());
        near((A * B).determinant(), A.determinant() * B.determinant());
        near(A.transpose().determinant(), A.determinant());
        // Symmetric : skew = 0.
        near(A.symmetric_part().dot(&(B - B.transpose())), 0.0);
        let sigma = signed_svd(&A).sigma;
        near(A.norm_squared(), sigma.iter().map(|s| s * s).sum());
        near(A.determinant(), sigma.iter().product());
        // Trace and determinant are sum and product of the eigenvalues (not singular values).
        let values = symmetric_eigen(&A.symmetric_part()).values;
        near(A.trace(), values.iter().sum());
        near(A.symmetric_part().determinant(), values.iter().product());
        close(A.cofactor(), gradient(&A, Mat::determinant), 1e-15);
        let along = Mat::<_, D>::from_fn(|i, j| Dual::new(A.0[i][j], B.0[i][j])).cofactor();
        let change = Mat::<_, D>::from_fn(|i, j| along.0[i][j].derivative);
        close(A.cofactor_differential(&B), change, 1e-15);
        let (mut more, mut less) = (A, A);
        more += B;
        less -= B;
        close(more, A + B, 0.0);
        close(less + B, A, 1e-15);
        let svd = signed_svd(&A);
        close(svd.to_world(&Mat::from_diagonal(svd.sigma)), A, 1e-14);
        let (u, v) = (B.column(0), Q.column(D - 1));
        let T = Tensor4::<f64, D>::from_fn(|i, j, k, l| A.0[i][k] + B.0[j][l] * Q.0[i][j]);
        let sum = Mat::<f64, D>::from_fn(|i, k| {
            let pairs = (0..D * D).map(|n| (n / D, n % D));
            pairs
                .map(|(j, l)| u[j] * v[l] * (A.0[i][k] + B.0[j][l] * Q.0[i][j]))
                .sum()
        });
        close(T.contract(u, v), sum, 1e-14);
        close(
            A.tr_mul(&A.cofactor()),
            Mat::identity().scale(A.determinant()),
            1e-15,
        );
    }
}

#[test]
fn linear_algebra_identities() {
    identities::<2>();
    identities::<3>();
}

/// In closed form: what each projection makes of eigenvalues, one by one, of twins and of matrices.
#[test]
fn projections_act_on_eigenvalues() {
    use HessianProjection::{Absolute, Clamp, None};
    for (projection, [low, high]) in [
        (None, [-3.0, 2.0]),
        (Clamp, [0.0, 2.0]),
        (Absolute, [3.0, 2.0]),
    ] {
        assert_eq!(
            [-3.0, 2.0].map(|v: f64| projection.eigenvalue(v)),
            [low, high]
        );
        // [[α, β], [β, α]] has α + β and α − β.
        let (alpha, beta) = projection.twin(-0.5, 2.5);
        assert_eq!((alpha, beta), ((high + low) / 2.0, (high - low) / 2.0));
        let Q = Random(5).rotation::<3>();
        let with = |d: [f64; 3]| (Q * Mat::from_diagonal(d)).mul_tr(&Q);
        let A = with([2.0, 0.5, -3.0]);
        close(projection.matrix(&A), with([high, 0.5, low]), 1e-14);
    }
}

/// Against differences of the functions themselves.
#[test]
fn every_function_of_a_dual_number_carries_its_derivative() {
    type Function = (&'static str, fn(Dual<f64>) -> Dual<f64>);
    let functions: [Function; 9] = [
        ("sqrt", |x| x.sqrt()),
        ("abs", |x| x.abs()),
        ("ln", |x| x.ln()),
        ("ln_1p", |x| x.ln_1p()),
        ("exp", |x| x.exp()),
        ("exp_m1", |x| x.exp_m1()),
        ("powf", |x| x.powf(-2.3)),
        ("recip", |x| x.recip()),
        ("cube", |x| {
            let mut cube = x.squared();
            cube *= x;
            cube
        }),
    ];
    for (name, f) in functions {
        for x in [0.3, 1.0, 2.7] {
            let h = 1e-5;
            let at = |x: f64| f(Dual::new(x, 0.0)).value;
            let slope = (at(x + h) - at(x - h)) / (2.0 * h);
            let found = f(Dual::new(x, 2.0)).derivative / 2.0;
            assert!(
                (found - slope).abs() < 1e-8 * (1.0 + slope.abs()),
                "{name} at {x}"
            );
        }
    }
    let (small, large) = (Dual::new(1.0, 5.0), Dual::new(2.0, 7.0));
    assert_eq!((small.min(large), small.max(large)), (small, large));
    assert_eq!((large.min(small), large.max(small)), (small, large));
    assert_eq!(Dual::new(-2.0, 3.0).abs(), Dual::new(2.0, -3.0));
}

/// dλ = vᵀ dA v and d(V Λ Vᵀ) = dA, of nine rows as projections of Hessians have them; also where A is
/// diagonal already and only dA is not.
#[test]
fn eigenvalues_of_dual_matrices_carry_their_derivatives() {
    fn hold<const N: usize>(A: [[f64; N]; N], dA: [[f64; N]; N]) {
        let dual: [[Dual<f64>; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| Dual::new(A[i][j], dA[i][j])));
        let (values, V) = jacobi_eigen(&dual);
        for k in 0..N {
            let v: [f64; N] = std::array::from_fn(|i| V[i][k].value);
            let product = |M: &[[f64; N]; N]| -> f64 {
                let pairs = (0..N * N).map(|n| (n / N, n % N));
                pairs.map(|(i, j)| v[i] * M[i][j] * v[j]).sum()
            };
            assert!((values[k].value - product(&A)).abs() < 1e-13, "{N}");
            assert!((values[k].derivative - product(&dA)).abs() < 1e-11, "{N}");
        }
        for (i, j) in (0..N * N).map(|n| (n / N, n % N)) {
            let mut sum = Dual::new(0.0, 0.0);
            (0..N).for_each(|k| sum += V[i][k] * values[k] * V[j][k]);
            assert!((sum.derivative - dA[i][j]).abs() < 1e-11, "{N}: {i} {j}");
        }
    }
    fn check<const N: usize>() {
        let mut random = Random(31);
        let mut symmetric = || {
            let raw: [[f64; N]; N] =
                std::array::from_fn(|_| std::array::from_fn(|_| random.unit()));
            let entry = |i: usize, j: usize| 0.5 * (raw[i][j] + raw[j][i]);
            std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
        };
        let (A, dA): ([[f64; N]; N], [[f64; N]; N]) = (symmetric(), symmetric());
        hold(A, dA);
        let diagonal = |i: usize, j: usize| if i == j { 1.0 + i as f64 } else { 0.0 };
        hold(
            std::array::from_fn(|i| std::array::from_fn(|j| diagonal(i, j))),
            dA,
        );
    }
    check::<3>();
    check::<4>();
    check::<9>();
}

fn projections<const D: usize, const N: usize>(
    block: &[(usize, usize); N],
    row_major: &[(usize, usize); N],
) {
    let mut random = Random(13);
    for scale in [1.0, 1e5, 1e-200, 1e120] {
        let T = Tensor4::<f64, D>::from_fn(|_, _, _, _| random.unit() * scale).symmetric_part();
        for order in [block, row_major] {
            assert_eq!(from_flat(&to_flat(&T, order), order), T);
        }
        let flat = to_flat(&T, row_major);
        for (r, &(i, j)) in row_major.iter().enumerate() {
            assert_eq!(r, D * i + j);
        }
        let m = nalgebra::DMatrix::<f64>::from_fn(N, N, |r, c| flat[r][c] / scale);
        let eigen = nalgebra::SymmetricEigen::new(m);
        let mut expected: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        expected.sort_by(f64::total_cmp);
        assert_eq!(T.eigenvalues().len(), N);
        for (a, b) in T.eigenvalues().iter().zip(&expected) {
            assert!((a / scale - b).abs() < 1e-14, "{a} {b}");
        }
        let clamped = eigen.eigenvalues.map(|x| x.max(0.0));
        let psd = &eigen.eigenvectors
            * nalgebra::DMatrix::from_diagonal(&clamped)
            * eigen.eigenvectors.transpose();
        let ours = to_flat(&T.project(|x| x.max(0.0)), row_major);
        for r in 0..N {
            for c in 0..N {
                assert!((ours[r][c] / scale - psd[(r, c)]).abs() < 1e-14);
            }
        }
        let same = to_flat(&T.project(|x| x), row_major);
        for r in 0..N {
            for c in 0..N {
                assert!(((same[r][c] - flat[r][c]) / scale).abs() < 1e-14);
            }
        }
    }
}

/// Q diag(d) Qᵀ with Q a product of random reflections: the truth for any d, repeated or not.
fn composed(Q: &[[f64; 9]; 9], d: [f64; 9]) -> [[f64; 9]; 9] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..9).map(|k| Q[i][k] * d[k] * Q[j][k]).sum()))
}

#[test]
fn numeric_projection_keeps_its_digits_where_eigenvalues_repeat() {
    let mut random = Random(29);
    for case in 0..400 {
        let mut Q: [[f64; 9]; 9] =
            std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
        for _ in 0..9 {
            let v: [f64; 9] = std::array::from_fn(|_| random.unit());
            let norm: f64 = v.iter().map(|x| x * x).sum();
            for row in &mut Q {
                let along: f64 = 2.0 * row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>() / norm;
                row.iter_mut().zip(v).for_each(|(a, b)| *a -= along * b);
            }
        }
        let kinds = [[1.0, -1.0, 3.0], [1e5, -2.0, 1e-7], [0.0, -1.0, 1.0]][case % 3];
        let d: [f64; 9] = std::array::from_fn(|k| kinds[k * (1 + case / 3) % 9 % 3]);
        let size = d.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let T = from_flat::<f64, 3, 9>(&composed(&Q, d), &ROW_MAJOR_3D);
        let projected = to_flat(&T.project(|x| x.max(0.0)), &ROW_MAJOR_3D);
        let truth = composed(&Q, d.map(|x| x.max(0.0)));
        let mut eigenvalues = d;
        eigenvalues.sort_by(f64::total_cmp);
        for (ours, exact) in T.eigenvalues().iter().zip(eigenvalues) {
            assert!(
                (ours - exact).abs() <= 1e-14 * size,
                "case {case}: {ours} {exact}"
            );
        }
        for (ours, exact) in projected.iter().flatten().zip(truth.iter().flatten()) {
            assert!(
                (ours - exact).abs() <= 1e-14 * size,
                "case {case}: {ours} {exact}"
            );
        }
    }
}

#[test]
fn a_lane_of_the_numeric_projection_does_not_feel_its_neighbors() {
    let mut random = Random(31);
    let all: [Tensor4<f64, 3>; 8] = std::array::from_fn(|k| {
        let scale = if k == 3 { 0.0 } else { 10_f64.powi(k as i32) };
        Tensor4::from_fn(|_, _, _, _| scale * random.unit()).symmetric_part()
    });
    let packed = Tensor4::<F64x8, 3>::from_fn(|i, j, k, l| {
        Lanes(std::array::from_fn(|n| all[n].get(i, j, k, l)))
    });
    let together = packed.project(|x| x.max(F64x8::from_f64(0.0)));
    for (n, T) in all.iter().enumerate() {
        let alone = T.project(|x| x.max(0.0));
        for (i, j, k, l) in (0..81).map(|m| (m / 27, m / 9 % 3, m / 3 % 3, m % 3)) {
            let (a, b) = (alone.get(i, j, k, l), together.get(i, j, k, l).0[n]);
            assert_eq!(a.to_bits(), b.to_bits(), "lane {n}");
        }
    }
}

#[test]
fn numeric_projection_against_an_independent_eigen_solver() {
    projections::<2, 4>(&BLOCK_ORDER_2D, &ROW_MAJOR_2D);
    projections::<3, 9>(&BLOCK_ORDER_3D, &ROW_MAJOR_3D);
}

#[test]
fn rest_shapes() {
    let mut random = Random(14);
    for _ in 0..50 {
        let X: [[f64; 3]; 4] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit()));
        let shape = RestShape::from_vertices(&X).unwrap();
        let Dm = shape_matrix(&X);
        assert!((shape.volume - Dm.determinant().abs() / 6.0).abs() < 1e-16);
        // ERRATUM: D_mᵀ B_m = −V I.
        let product = Dm.tr_mul(&shape.area_normals());
        close(product, Mat::identity().scale(-shape.volume), 1e-15);
        let mut sum = [0.0; 3];
        for a in 0..4 {
            // λ is 1 at its vertex and 0 at the others.
            let gradient = shape.barycentric_gradient(a);
            for (c, x) in X.iter().enumerate().filter(|(c, _)| *c != a) {
                let drop: f64 = (0..3).map(|i| gradient[i] * (X[a][i] - x[i])).sum();
                assert!((drop - 1.0).abs() < 1e-11, "{a} {c}: {drop}");
            }
            let b = shape.area_normal(a);
            for i in 0..3 {
                sum[i] += b[i];
                if a > 0 {
                    assert_eq!(b[i], shape.area_normals().0[i][a - 1]);
                }
            }
            // −1/3 of the sum of the outward area vectors at the node = 1/3 of the opposite one.
            let face: Vec<[f64; 3]> = (0..4).filter(|&c| c != a).map(|c| X[c]).collect();
            let e = |k: usize| -> [f64; 3] { std::array::from_fn(|i| face[k][i] - face[0][i]) };
            let (u, v) = (e(1), e(2));
            let mut area = [
                0.5 * (u[1] * v[2] - u[2] * v[1]),
                0.5 * (u[2] * v[0] - u[0] * v[2]),
                0.5 * (u[0] * v[1] - u[1] * v[0]),
            ];
            let inward: f64 = (0..3).map(|i| area[i] * (X[a][i] - face[0][i])).sum();
            if inward > 0.0 {
                area = area.map(|x| -x);
            }
            for i in 0..3 {
                assert!((b[i] - area[i] / 3.0).abs() < 1e-14, "{b:?} {area:?}");
            }
        }
        assert!(sum.iter().all(|s| s.abs() < 1e-14));
        // F of an affine map is its matrix.
        let A = random.matrix::<3>();
        let x = X.map(|x| A.mul_vec(x));
        let tolerance = 1e-14 * (1.0 + largest(&shape.inverse));
        close(
            deformation_gradient(&shape_matrix(&x), &shape.inverse),
            A,
            tolerance,
        );
    }
}

#[test]
fn bad_rest_shapes_are_refused() {
    type Shape = RestShape<f64, 2>;
    let flat = Shape::from_vertices(&[[0.0, 0.0], [0.1, 0.3], [0.2, 0.6]]);
    assert!(
        matches!(flat, Err(RestShapeError::ZeroVolume { .. })),
        "{flat:?}"
    );
    let nan = Shape::from_vertices(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]]);
    assert_eq!(nan, Err(RestShapeError::NotFinite { vertex: 1 }));
    let few = Shape::from_vertices(&[[0.0, 0.0], [1.0, 0.0]]);
    assert_eq!(
        few,
        Err(RestShapeError::VertexCount {
            dimension: 2,
            given: 2
        })
    );
    // Tiny and badly shaped is not flat.
    let (width, height) = (2f64.powi(-200), 2f64.powi(-230));
    let sliver = Shape::from_vertices(&[[0.0, 0.0], [width, 0.0], [0.0, height]]).unwrap();
    assert_eq!(sliver.volume, 2f64.powi(-431));
    let mirrored = Shape::from_vertices(&[[0.0, 0.0], [0.0, 1.0], [2.0, 0.0]]).unwrap();
    assert_eq!(mirrored.volume, 1.0);
}

#[test]
fn a_triangle_in_space_lies_flat_undeformed() {
    let mut random = Random(15);
    for _ in 0..20 {
        let x: [[f64; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit()));
        let flat = flatten_triangle(&x);
        for a in 0..3 {
            for b in 0..3 {
                let distance = |p: &[f64], q: &[f64]| -> f64 {
                    p.iter()
                        .zip(q)
                        .map(|(p, q)| (p - q).powi(2))
                        .sum::<f64>()
                        .sqrt()
                };
                assert!((distance(&x[a], &x[b]) - distance(&flat[a], &flat[b])).abs() < 1e-14);
            }
        }
        assert!(RestShape::from_vertices(&flat).is_ok());
        assert!(flat[2][1] > 0.0);
    }
}
