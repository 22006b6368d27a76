//! Document 001's sums on a grid, written out once more: dense matrices and loops over all pairs of
//! nodes and particles, with splines by their pieces. No file beside the repository is needed.
use aniso_mpm::damage::{
    DamageGrid, DamageParameters, Director, Directors, Gradient, ImplicitOptions, ImplicitSystem,
    RightHandSide, crack_stress, driving_force, explicit_update, geometric_resistance,
    tensile_part,
};
use aniso_mpm::inextensibility::{FiberGrid, Projection};
use fem_kinematics::{Mat, dot};
use fem_solvers::PcgParams;

const H: f64 = 0.1;

/// Places away from nodes and from one another's symmetry.
const PLACES: [[f64; 2]; 7] = [
    [0.213, 0.117],
    [0.251, 0.189],
    [0.197, 0.223],
    [0.304, 0.142],
    [0.342, 0.261],
    [0.158, 0.171],
    [0.279, 0.246],
];

/// The cubic B-spline of one axis and its first two derivatives (1/m, 1/m²), node `i` seen from `x`.
fn cubic(x: f64, i: i32) -> [f64; 3] {
    let s = x / H - f64::from(i);
    let (r, side) = (s.abs(), s.signum());
    let [value, first, second] = match r {
        r if r < 1.0 => [
            r.powi(3) / 2.0 - r * r + 2.0 / 3.0,
            1.5 * r * r - 2.0 * r,
            3.0 * r - 2.0,
        ],
        r if r < 2.0 => {
            let q = 2.0 - r;
            [q.powi(3) / 6.0, -q * q / 2.0, q]
        }
        _ => [0.0; 3],
    };
    [value, side * first / H, second / (H * H)]
}

/// The quadratic B-spline and its derivative (1/m).
fn quadratic(x: f64, i: i32) -> [f64; 2] {
    let s = x / H - f64::from(i);
    let (r, side) = (s.abs(), s.signum());
    let [value, first] = match r {
        r if r < 0.5 => [0.75 - r * r, -2.0 * r],
        r if r < 1.5 => [(1.5 - r).powi(2) / 2.0, r - 1.5],
        _ => [0.0; 2],
    };
    [value, side * first / H]
}

/// N, ∇N and ΔN of a node at a place.
fn cubic_at(x: [f64; 2], node: [i32; 2]) -> (f64, [f64; 2], f64) {
    let [[a, da, dda], [b, db, ddb]] = [0, 1].map(|k| cubic(x[k], node[k]));
    (a * b, [da * b, a * db], dda * b + a * ddb)
}

fn near(found: f64, expected: f64, size: f64, what: &str) {
    let off = (found - expected).abs();
    assert!(off <= 1e-12 * size, "{what}: {found:e} for {expected:e}");
}

#[test]
fn damage_goes_to_nodes_by_weight_and_comes_back_with_its_laplacian() {
    let damage: Vec<f64> = (0..7).map(|p| 0.1 * (p * p % 7) as f64).collect();
    let mut grid = DamageGrid::new(H);
    grid.particles_to_grid(&PLACES, &damage).unwrap();
    let nodes: Vec<_> = grid.nodes().collect();
    assert!(nodes.len() > 20);
    for &(node, d, sum) in &nodes {
        let weights = PLACES.map(|x| cubic_at(x, node).0);
        let all: f64 = weights.iter().sum();
        let weighted: f64 = weights.iter().zip(&damage).map(|(w, d)| w * d).sum();
        near(sum, all, 1.0, "sum of weights");
        // Some nodes have weights of 1e-8, in which x/h loses digits.
        let off = (d - weighted / all).abs();
        assert!(off < 1e-8, "{node:?}: {d} for {}", weighted / all);
    }
    let (values, laplacians) = (grid.interpolate(), grid.laplacians());
    for (p, x) in PLACES.into_iter().enumerate() {
        let of = nodes.iter().map(|&(node, d, _)| (cubic_at(x, node), d));
        let sums = of.fold((0.0, 0.0), |(v, l), ((w, _, laplacian), d)| {
            (v + w * d, l + laplacian * d)
        });
        near(values[p], sums.0, 1.0, "value");
        near(laplacians[p], sums.1, 10.0 / (H * H), "laplacian");
    }
}

/// Φ = Σ (1 + α)² ⟨σ⟩²/σ_c² for stresses along the directors, turned with the body.
#[test]
fn directors_weigh_the_tension_along_them() {
    let (sin, cos) = 0.4_f64.sin_cos();
    let turned = Mat([[cos, -sin], [sin, cos]]);
    let F = turned * Mat::from_diagonal([1.3, 0.8]);
    let (a, b) = ([cos, sin], [-sin, cos]);
    let along = |s: f64, t: f64| Mat::outer(a, a).scale(s) + Mat::outer(b, b).scale(t);
    let director = |direction, weight| Director { direction, weight };
    let parameters = DamageParameters {
        zeta: 1.5,
        ..DamageParameters::new(H, 2.0, 0.05)
    };
    for (alpha, beta) in [(0.0, 0.0), (-1.0, 0.5), (2.0, -0.25), (-0.5, -1.0)] {
        let both = Directors::Orthotropic(director([1.0, 0.0], alpha), director([0.0, 1.0], beta));
        let one = Directors::TransverselyIsotropic(director([1.0, 0.0], alpha));
        for (directors, beta) in [(both, beta), (one, 0.0)] {
            for (s, t) in [(4.0, 3.0), (5.0, -6.0), (-1.0, 7.0), (1.0, 1.0)] {
                let sigma = along(s, t);
                let plus = along(f64::max(s, 0.0), f64::max(t, 0.0));
                assert!((tensile_part(&sigma) - plus).norm_squared() < 1e-26);
                let share = |weight: f64, s: f64| ((1.0 + weight) * s.max(0.0) / 2.0).powi(2);
                let phi = share(alpha, s) + share(beta, t);
                let A = directors.structural_tensor(&F);
                near(crack_stress(&A, &plus, 2.0), phi, 50.0, "Φ");
                let expected = 1.5 * (phi - 1.0).max(0.0);
                for history in [0.0, 9.0] {
                    let found = driving_force(&parameters, &directors, &F, &sigma, history);
                    near(found, expected.max(history), 100.0, "D̃");
                }
            }
        }
    }
}

/// d + Δt/η ((1 − d) D̃ − (d − l₀² Δd)), and nothing where that is no growth.
#[test]
fn an_explicit_step_is_that_of_the_formula() {
    let parameters = DamageParameters {
        length_scale: 0.04,
        ..DamageParameters::new(H, 1.0, 0.05)
    };
    for (d, laplacian, force) in [(0.2, 30.0, 0.0), (0.1, -20.0, 0.9), (0.4, 5.0, 2.0)] {
        let resistance = d - 0.0016 * laplacian;
        near(
            geometric_resistance(d, laplacian, 0.04),
            resistance,
            1.0,
            "D_c",
        );
        let growth = (1.0 - d) * force - resistance;
        let expected = d + 1e-3 / 0.05 * f64::max(growth, 0.0);
        near(
            explicit_update(&parameters, d, force, laplacian, 1e-3),
            expected,
            1.0,
            "d",
        );
    }
}

/// Gaussian elimination with partial pivoting.
fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let best = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()));
        let best = best.unwrap();
        a.swap(k, best);
        b.swap(k, best);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

/// 𝒜, ℬ, c and the solution of alg. 9, particle by particle, and alg. 10.
#[test]
fn the_implicit_system_is_that_of_the_sums() {
    let damage: Vec<f64> = (0..7).map(|p| 0.12 * (p * 3 % 7) as f64).collect();
    let force: Vec<f64> = (0..7).map(|p| 2.0 * (p * 5 % 7) as f64).collect();
    let volume: Vec<f64> = (0..7).map(|p| 1e-3 * (1.0 + 0.2 * p as f64)).collect();
    let (dt, eta, length) = (0.02, 0.05, 0.07);
    let constants = |_| DamageParameters {
        length_scale: length,
        ..DamageParameters::new(H, 1.0, eta)
    };
    let mut grid = DamageGrid::new(H);
    grid.particles_to_grid(&PLACES, &damage).unwrap();
    let nodes: Vec<_> = grid.nodes().collect();
    let place = |node: [i32; 2]| grid.node_blocks().node_index(node).unwrap();
    for gradient in [Gradient::BSpline, Gradient::MlsMpm] {
        let theta = |x: [f64; 2], node: [i32; 2]| {
            let (w, by_x, _) = cubic_at(x, node);
            match gradient {
                Gradient::BSpline => by_x,
                Gradient::MlsMpm => {
                    [0, 1].map(|k| w * 3.0 / (H * H) * (H * f64::from(node[k]) - x[k]))
                }
            }
        };
        for right_hand_side in [RightHandSide::GridDamage, RightHandSide::ParticleDamage] {
            let options = ImplicitOptions {
                right_hand_side,
                gradient,
                tolerance: 1e-12,
            };
            let system =
                ImplicitSystem::new(&grid, &volume, &force, &damage, dt, &constants, &options);
            let system = system.unwrap();
            let (mut lumped, mut c, mut laplace) = (Vec::new(), Vec::new(), Vec::new());
            for &(node, d_node, _) in &nodes {
                let (mut a, mut source) = (0.0, 0.0);
                let mut row = vec![0.0; nodes.len()];
                for p in 0..7 {
                    let share = volume[p] * cubic_at(PLACES[p], node).0;
                    a += share * (1.0 + dt / eta * (force[p] + 1.0));
                    let old = match right_hand_side {
                        RightHandSide::GridDamage => d_node,
                        RightHandSide::ParticleDamage => damage[p],
                    };
                    source += share * (dt / eta * force[p] + old);
                    let by_x = theta(PLACES[p], node);
                    for (entry, &(other, ..)) in row.iter_mut().zip(&nodes) {
                        let both = dot(by_x, theta(PLACES[p], other));
                        *entry += volume[p] * dt / eta * length * length * both;
                    }
                }
                near(system.lumped()[place(node)], a, 1e-2, "A");
                near(system.right_hand_side()[place(node)], source, 1e-2, "c");
                lumped.push(a);
                c.push(source);
                laplace.push(row);
            }
            let u: Vec<f64> = (0..nodes.len())
                .map(|i| (i * 7 % 11) as f64 - 5.0)
                .collect();
            let mut spread = vec![0.0; system.lumped().len()];
            for (&(node, ..), u) in nodes.iter().zip(&u) {
                spread[place(node)] = *u;
            }
            let mut product = vec![0.0; spread.len()];
            system.apply_laplace(&spread, &mut product);
            for (&(node, ..), row) in nodes.iter().zip(&laplace) {
                let expected = row.iter().zip(&u).map(|(a, u)| a * u).sum::<f64>();
                near(product[place(node)], expected, 1e-1, "B u");
            }
            let mut whole = laplace;
            for (i, a) in lumped.iter().enumerate() {
                whole[i][i] += a;
                near(
                    system.diagonal()[place(nodes[i].0)],
                    whole[i][i],
                    1e-1,
                    "diagonal",
                );
            }
            let expected = solved(whole, c);
            let found = system.solve(1e-12).unwrap();
            for (&(node, ..), d) in nodes.iter().zip(&expected) {
                let off = (found[place(node)] - d).abs();
                assert!(off < 1e-7, "{node:?}: {} for {d}", found[place(node)]);
            }
            let carried = system.grid_to_particles(&found);
            for (p, carried) in carried.iter().enumerate() {
                let of = nodes.iter().zip(&expected);
                let sum: f64 = of.map(|(n, d)| cubic_at(PLACES[p], n.0).0 * d).sum();
                let off = (carried - sum.min(1.0).max(damage[p])).abs();
                assert!(off < 1e-9, "{p}: {carried} for {sum}");
            }
        }
    }
}

/// B_(z,iα) = Σ_p V_p Γ_z a_α (a · ∇N_i), L = B M⁻¹ Bᵀ, and v = M⁻¹ (b − Bᵀ λ) with B v = 0.
#[test]
fn the_constraint_of_fibers_is_that_of_the_sums() {
    let volume: Vec<f64> = (0..7).map(|p| 1e-3 * (1.0 + 0.1 * p as f64)).collect();
    let fibers: Vec<[f64; 2]> = (0..7)
        .map(|p| {
            let (sin, cos) = (0.3 + 0.4 * p as f64).sin_cos();
            [cos, sin]
        })
        .collect();
    let grid = FiberGrid::new(H, &PLACES, &volume, &fibers).unwrap();
    let at = |place: u32| grid.node_blocks().node(place as usize);
    let mut inverse_mass = vec![0.0; grid.len()];
    for (i, inverse) in inverse_mass.iter_mut().enumerate() {
        *inverse = 1e-3 * (1.0 + (i % 5) as f64);
    }
    let projection = Projection::new(&grid, &inverse_mass, &[]).unwrap();
    let matrix = projection.matrix();
    let (cells, nodes) = (matrix.cells(), matrix.nodes());
    let hat = |x: [f64; 2], z: [i32; 2]| -> f64 {
        let one = |k: usize| (1.0 - (x[k] / H - f64::from(z[k]) - 0.5).abs()).max(0.0);
        one(0) * one(1)
    };
    let entry = |z: [i32; 2], i: [i32; 2]| {
        let mut sum = [0.0; 2];
        for p in 0..7 {
            let [[a, da], [b, db]] = [0, 1].map(|k| quadratic(PLACES[p][k], i[k]));
            let along = dot(fibers[p], [da * b, a * db]);
            let factor = volume[p] * hat(PLACES[p], z) * along;
            (0..2).for_each(|k| sum[k] += factor * fibers[p][k]);
        }
        sum
    };
    let B: Vec<Vec<[f64; 2]>> = (cells.iter())
        .map(|&z| nodes.iter().map(|&i| entry(at(z), at(i))).collect())
        .collect();
    let size = 0.1;
    let v: Vec<[f64; 2]> = (0..nodes.len())
        .map(|i| [(i % 7) as f64 - 3.0, (i % 5) as f64 - 2.0])
        .collect();
    let mut product = vec![0.0; cells.len()];
    matrix.apply(&v, &mut product);
    for (found, row) in product.iter().zip(&B) {
        let expected: f64 = row.iter().zip(&v).map(|(b, v)| dot(*b, *v)).sum();
        near(*found, expected, size, "B v");
    }
    let lambda: Vec<f64> = (0..cells.len()).map(|z| (z % 3) as f64 - 1.0).collect();
    let mut forces = vec![[0.0; 2]; nodes.len()];
    matrix.apply_transpose(&lambda, &mut forces);
    for (i, force) in forces.iter().enumerate() {
        for k in 0..2 {
            let expected: f64 = B.iter().zip(&lambda).map(|(row, l)| row[i][k] * l).sum();
            near(force[k], expected, size, "Bᵀ λ");
        }
    }
    let own: Vec<f64> = nodes.iter().map(|&n| inverse_mass[n as usize]).collect();
    let schur = matrix.assemble_schur(&own);
    let diagonal = matrix.schur_diagonal(&own);
    for (z, row) in schur.iter().enumerate() {
        for &(w, found) in row {
            let pairs = B[z].iter().zip(&B[w as usize]).zip(&own);
            let expected: f64 = pairs.map(|((a, b), m)| dot(*a, *b) * m).sum();
            near(found, expected, size, "L");
            if w as usize == z {
                near(diagonal[z], expected, size, "diagonal of L");
            }
        }
    }
    let b: Vec<[f64; 2]> = (0..grid.len())
        .map(|i| [1.0 + (i % 3) as f64, -((i % 4) as f64)])
        .collect();
    let params = PcgParams {
        relative_tolerance: 1e-12,
        max_iterations: 2000,
        stagnation_window: 400,
        ..PcgParams::default()
    };
    let solution = projection.solve(&b, &inverse_mass, &params).unwrap();
    for (k, row) in B.iter().enumerate() {
        let left: f64 = (row.iter().zip(nodes))
            .map(|(b, &n)| dot(*b, solution.v[n as usize]))
            .sum();
        let before: f64 = (row.iter().zip(nodes))
            .map(|(e, &n)| inverse_mass[n as usize] * dot(*e, b[n as usize]))
            .sum();
        assert!(
            left.abs() < 1e-9 * (1e-3 + before.abs()),
            "{k}: {left:e} of {before:e}"
        );
    }
    for (i, &n) in nodes.iter().enumerate() {
        let n = n as usize;
        for k in 0..2 {
            let pull: f64 = B
                .iter()
                .zip(&solution.lambda)
                .map(|(row, l)| row[i][k] * l)
                .sum();
            let expected = inverse_mass[n] * (b[n][k] - pull);
            assert!((solution.v[n][k] - expected).abs() < 1e-9, "{n}");
        }
    }
}
