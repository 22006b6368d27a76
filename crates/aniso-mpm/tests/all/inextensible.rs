//! Inextensible fibers: the constraint against the deformation it stands for, the weak form against
//! sums over the particles, collisions in the same solve, and the host.
use crate::{Host, lattice};
use aniso_mpm::inextensibility::{CollisionRow, FiberGrid, Projection};
use aniso_mpm::{Apic, Body, Contact, Fiber, Obstacle, Quadratic, Settings, Simulation};
use fem_kinematics::{Dual, ImplicitSurface, Mat, dot};
use fem_materials::QrAnisotropic;
use fem_solvers::PcgParams;

const H: f64 = 0.1;

fn exact() -> PcgParams {
    PcgParams {
        relative_tolerance: 1e-12,
        max_iterations: 2000,
        stagnation_window: 400,
        ..PcgParams::default()
    }
}

/// The linear basis Γ_z of the cell with its center at h (z + ½), written independently.
fn hat(x: [f64; 2], z: [i32; 2]) -> f64 {
    (0..2)
        .map(|a| (1.0 - (x[a] / H - f64::from(z[a]) - 0.5).abs()).max(0.0))
        .product()
}

/// Places, volumes and one unit fiber per particle of a small block.
fn block() -> (Vec<[f64; 2]>, Vec<f64>, Vec<[f64; 2]>) {
    let x = lattice::<f64, 2>([0.0; 2], [0.4; 2], 0.04, |_| true).x;
    let volume = (0..x.len())
        .map(|p| 1e-3 * (1.0 + 0.1 * (p % 5) as f64))
        .collect();
    let a = (0..x.len())
        .map(|p| {
            let (sin, cos) = (0.3 + 0.01 * p as f64).sin_cos();
            [cos, sin]
        })
        .collect();
    (x, volume, a)
}

/// Values of a function of the place on all nodes of a grid.
fn on_nodes<R>(grid: &FiberGrid<2>, f: impl Fn([f64; 2]) -> R) -> Vec<R> {
    (0..grid.len())
        .map(|i| f(grid.node_blocks().node(i).map(|n| f64::from(n) * H)))
        .collect()
}

/// d/dt ln √tr(C M) along ∇v = L is (a aᵀ) : d, and Σ_z (B v)_z sums it over the volume: fibers keep
/// tr(C M) = 1 exactly where the constraint holds.
#[test]
fn constraint_is_the_rate_of_tr_cm() {
    let L = Mat([[0.3, -0.7], [0.4, 0.5]]);
    let a0 = [0.6, -0.8];
    for F in [
        Mat([[1.2, 0.3], [-0.2, 0.9]]),
        Mat([[0.4, -1.1], [0.9, 0.2]]),
        Mat([[-0.7, 0.1], [0.2, 1.4]]),
    ] {
        let rate = L * F;
        let moving = Mat::from_fn(|i, j| Dual::new(F.0[i][j], rate.0[i][j]));
        let stretched = moving.mul_vec(a0.map(|a| Dual::new(a, 0.0)));
        let tr_cm = dot(stretched, stretched);
        let a = F.mul_vec(a0);
        let (x, volume, _) = block();
        let grid = FiberGrid::new(H, &x, &volume, &vec![a; x.len()]).unwrap();
        let v = on_nodes(&grid, |x| L.mul_vec(x));
        let summed: f64 = grid.apply(&v).iter().sum();
        let expected = volume.iter().sum::<f64>() * 0.5 * tr_cm.derivative / tr_cm.value;
        assert!((summed - expected).abs() < 1e-13, "{summed} {expected}");
        // The spin of L does not count: only its symmetric part d.
        let v = on_nodes(&grid, |x| L.symmetric_part().mul_vec(x));
        let without_spin: f64 = grid.apply(&v).iter().sum();
        assert!((summed - without_spin).abs() < 1e-13);
    }
}

/// Tested with q = c + Q x, which the quadratic basis holds exactly, the new velocity meets
/// Σ m q·(v − v⁰)/Δt + Σ_p V_p (σ + λ a aᵀ) : Q = Σ m q·g, and nothing acts on the boundary.
#[test]
fn weak_form_has_the_fiber_tension_gravity_and_no_traction() {
    let (x, volume, a) = block();
    let grid = FiberGrid::new(H, &x, &volume, &a).unwrap();
    let mass: Vec<f64> = volume.iter().map(|v| 1000.0 * v).collect();
    let node_mass = grid.node_mass(&mass).unwrap();
    let sigma: Vec<Mat<f64, 2>> = (0..x.len())
        .map(|p| Mat([[50.0, -20.0], [-20.0, 10.0 + p as f64]]))
        .collect();
    let (dt, g) = (1e-3, [0.0, -9.81]);
    let before = on_nodes(&grid, |x| [0.2 + x[1], x[0] * x[0]]);
    let pulled: Vec<[f64; 2]> = before
        .iter()
        .map(|v| [v[0] + dt * g[0], v[1] + dt * g[1]])
        .collect();
    let b = grid
        .right_hand_side(&node_mass, &pulled, &sigma, dt)
        .unwrap();
    let inverse_mass: Vec<f64> = node_mass
        .iter()
        .map(|&m| if m > 0.0 { dt / m } else { 0.0 })
        .collect();
    let projection = Projection::new(&grid, &inverse_mass, &[]).unwrap();
    let solution = projection.solve(&b, &inverse_mass, &exact()).unwrap();
    let cells: Vec<[i32; 2]> = projection
        .matrix()
        .cells()
        .iter()
        .map(|&cell| grid.node_blocks().node(cell as usize))
        .collect();
    let tension: Vec<f64> = x
        .iter()
        .map(|&x| {
            cells
                .iter()
                .zip(&solution.lambda)
                .map(|(&z, l)| l * hat(x, z))
                .sum()
        })
        .collect();
    let largest = tension.iter().fold(0.0f64, |m, t| m.max(t.abs()));
    assert!(largest > 1.0, "the fibers carry something: {largest} Pa");
    for (c, Q) in [
        ([1.0, 0.0], Mat::zeros()),
        ([0.0, 1.0], Mat::zeros()),
        ([0.0, 0.0], Mat([[1.0, 0.0], [0.0, 0.0]])),
        ([0.0, 0.0], Mat([[0.0, 2.0], [-0.5, 0.0]])),
        ([0.3, 0.0], Mat([[0.0, 0.0], [1.0, -3.0]])),
    ] {
        let q = on_nodes(&grid, |x| {
            let Qx = Q.mul_vec(x);
            [c[0] + Qx[0], c[1] + Qx[1]]
        });
        let (mut inertia, mut weight, mut power, mut size) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..q.len() {
            let change = [0, 1].map(|k| (solution.v[i][k] - before[i][k]) / dt);
            inertia += node_mass[i]
                * if node_mass[i] > 0.0 {
                    dot(q[i], change)
                } else {
                    0.0
                };
            weight += node_mass[i] * dot(q[i], g);
        }
        for p in 0..x.len() {
            let stress = sigma[p] + Mat::outer(a[p], a[p]).scale(tension[p]);
            power += volume[p] * stress.dot(&Q);
            size += volume[p] * stress.norm_squared().sqrt();
        }
        let residual = inertia + power - weight;
        assert!(
            residual.abs() < 1e-9 * (size + weight.abs()),
            "{residual:e}"
        );
    }
}

#[test]
fn collisions_and_fibers_are_met_by_one_velocity() {
    let (x, volume, a) = block();
    let grid = FiberGrid::new(H, &x, &volume, &a).unwrap();
    let node_mass = grid.node_mass(&volume).unwrap();
    let inverse_mass: Vec<f64> = node_mass
        .iter()
        .map(|&m| if m > 0.0 { 1e-3 / m } else { 0.0 })
        .collect();
    // The floor holds the lowest row of nodes at a speed of its own.
    let rows: Vec<CollisionRow<2>> = (0..grid.len())
        .filter(|&i| node_mass[i] > 0.0 && grid.node_blocks().node(i)[1] == 0)
        .map(|node| CollisionRow {
            node,
            normal: [0.0, 1.0],
            speed: 0.25,
        })
        .collect();
    assert!(rows.len() > 3);
    let free = on_nodes(&grid, |x| [0.5 * x[0], -1.0 - x[0]]);
    let projection = Projection::new(&grid, &inverse_mass, &rows).unwrap();
    let v = projection.project(free.clone(), &exact()).unwrap().v;
    for row in &rows {
        assert!((v[row.node][1] - 0.25).abs() < 1e-8, "{:?}", v[row.node]);
    }
    let rate = |v: &[[f64; 2]]| grid.apply(v).iter().fold(0.0f64, |m, r| m.max(r.abs()));
    assert!(
        rate(&v) < 1e-8 * rate(&free),
        "{:e} {:e}",
        rate(&v),
        rate(&free)
    );
}

/// One step of the host stretches no fiber a = F a₀, in the average over any cell, read off the
/// particles before and after. The fibers start turned and stretched.
#[test]
fn host_constrains_the_transported_fiber() {
    let (sin, cos) = 1.1f64.sin_cos();
    let mut particles = lattice::<f64, 2>([0.0; 2], [0.4; 2], 0.04, |_| true);
    for p in 0..particles.len() {
        let x = particles.x[p];
        particles.F[p] = Mat([[cos, -sin], [sin, cos]]) * Mat([[1.2, 0.1 * x[0]], [0.0, 0.9]]);
        particles.v[p] = [0.5 * x[0] + 0.2 * x[1], -0.8 * x[1] + 0.3];
    }
    let material = QrAnisotropic::from_young_poisson(1e3, 0.3, 0.0, 0.0)
        .unwrap()
        .degradable(1e-3);
    // Largest average of a·∇v a over a cell, in one step of the host.
    let stretch_rate = |fiber: Fiber| {
        let body = Body {
            fiber,
            ..Body::elastic(material)
        };
        let mut s = Simulation::<f64, Apic<Quadratic>, _, 2>::new(
            Settings::new(H),
            vec![body],
            vec![],
            particles.clone(),
        )
        .unwrap();
        let dt = 1e-3;
        s.step(dt).unwrap();
        let after = s.particles();
        let mut new_F = vec![Mat::zeros(); after.len()];
        for (id, F) in after.id.iter().zip(&after.F) {
            new_F[*id as usize] = *F;
        }
        let mut largest = 0.0f64;
        for z in (-1..5).flat_map(|i| (-1..5).map(move |j| [i, j])) {
            let (mut rate, mut volume) = (0.0, 0.0);
            for p in 0..new_F.len() {
                let weight =
                    particles.volume[p] * particles.F[p].determinant() * hat(particles.x[p], z);
                let (a, b) = (particles.F[p].column(0), new_F[p].column(0));
                rate += weight * (dot(a, b) / dot(a, a) - 1.0) / dt;
                volume += weight;
            }
            if volume > 0.0 {
                largest = largest.max((rate / volume).abs());
            }
        }
        largest
    };
    let (free, held) = (
        stretch_rate(Fiber::Extensible),
        stretch_rate(Fiber::Inextensible),
    );
    println!("mean stretch rate in a cell: {free:.3} 1/s free, {held:.1e} 1/s held");
    assert!(free > 0.3 && held < 1e-5 * free);
}

/// Fibers turn with a spinning body: a = R a₀ after a third of a turn, as long as before.
#[test]
fn fibers_turn_with_the_body() {
    let mut particles = lattice::<f64, 2>([-0.2; 2], [0.2; 2], 0.05, |_| true);
    let omega = 2.0;
    let (sin, cos) = 0.4f64.sin_cos();
    for p in 0..particles.len() {
        let x = particles.x[p];
        particles.v[p] = [-omega * x[1], omega * x[0]];
        particles.C[p] = Mat([[0.0, -omega], [omega, 0.0]]);
        particles.F[p] = Mat([[cos, -sin], [sin, cos]]);
    }
    let mut settings = Settings::new(H);
    settings.gravity = [0.0; 2];
    let body = Body {
        fiber: Fiber::Inextensible,
        ..Body::elastic(
            QrAnisotropic::from_young_poisson(1e5, 0.3, 0.0, 0.0)
                .unwrap()
                .degradable(1e-3),
        )
    };
    let mut s = Host::<2>::new(settings, vec![body], vec![], particles).unwrap();
    let dt = 2e-3;
    while omega * s.time() < 2.0 {
        s.step(dt).unwrap();
    }
    let angle = 0.4 + omega * s.time();
    for F in &s.particles().F {
        let a = F.column(0);
        // Symplectic Euler turns by atan(ω Δt) and lengthens by 1 + (ω Δt)²/2 in every step.
        assert!(
            (a[0] - angle.cos()).hypot(a[1] - angle.sin()) < 1e-2,
            "{a:?}"
        );
        assert!((dot(a, a).sqrt() - 1.0).abs() < 1e-2, "{a:?}");
    }
}

/// A column hangs from a clamp: without its fibers it stretches by ρ g L/E and more, with them not.
/// The clamp is a set of collision rows in the fibers' own solve.
#[test]
fn a_hanging_column_does_not_stretch() {
    let lowest = |fiber: Fiber| {
        let mut particles = lattice::<f64, 2>([0.0, -1.0], [0.3, 0.0], 0.05, |_| true);
        for F in &mut particles.F {
            // e₁ of the fiber frame points down.
            *F = Mat([[0.0, 1.0], [-1.0, 0.0]]);
        }
        let clamp = Obstacle::fixed(
            ImplicitSurface::HalfSpace {
                point: [0.0, -0.2],
                normal: [0.0, -1.0],
            },
            Contact::Sticky,
        );
        let body = Body {
            fiber,
            ..Body::elastic(
                QrAnisotropic::from_young_poisson(5e4, 0.3, 0.0, 0.0)
                    .unwrap()
                    .degradable(1e-3),
            )
        };
        let mut s = Host::<2>::new(Settings::new(H), vec![body], vec![clamp], particles).unwrap();
        s.advance(0.15).unwrap();
        let p = s.particles();
        assert!((0..p.len()).all(|i| p.x[i][1] < -0.05 || p.v[i][1].abs() < 1e-8));
        p.x.iter().map(|x| x[1]).fold(0.0, f64::min)
    };
    let (free, held) = (lowest(Fiber::Extensible), lowest(Fiber::Inextensible));
    println!("lowest particle, at -0.975 m at rest: {free:.4} m free, {held:.4} m held");
    assert!(free < -1.05 && (held + 0.975).abs() < 5e-3);
}
