//! Flesh against rigid solids: sampled distances, differences, a moving bone, Hertz, deep starts.

use crate::promise::Newton;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, ContactPoint, Dofs, NodalLoads, Quasistatic,
    RigidContact, RigidContactParams, RigidFrame, RigidSurface, SampledDistance,
};
use fem_kinematics::{HessianProjection, ImplicitSurface};
use fem_materials::NeoHookean;
use fem_solvers::{
    BlockSymmetric, LinearOperator, LinearSolver, NewtonInfo, NewtonParams, NonlinearProblem,
    ProjectionPolicy,
};
use std::sync::Arc;

type Point = [f64; 3];

fn length(v: Point) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// A ball of this radius as triangles: a cube of n³ cells, blown up.
fn ball(radius: f64, n: usize) -> SimplexMesh<3> {
    let cube = kuhn_grid(n, n, n, [2.0; 3]).unwrap();
    let place = |p: &Point| {
        let p = p.map(|c| c - 1.0);
        let widest = p.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let far = length(p);
        p.map(|c| {
            if far > 0.0 {
                radius * widest * c / far
            } else {
                0.0
            }
        })
    };
    let nodes = cube.nodes().iter().map(place).collect();
    SimplexMesh::new(nodes, cube.connectivity().to_vec()).unwrap()
}

fn sampled_ball(radius: f64) -> SampledDistance {
    let mesh = ball(radius, 24);
    SampledDistance::new(
        mesh.nodes(),
        &mesh.boundary().faces,
        0.05 * radius,
        0.5 * radius,
    )
    .unwrap()
}

#[test]
fn a_sampled_ball_has_the_distance_of_a_ball() {
    let phi = sampled_ball(1.0);
    for p in [
        [0.3, 0.8, 0.2],
        [-0.9, 0.4, 0.6],
        [0.1, -0.2, -1.3],
        [0.5, 0.45, -0.5],
    ] {
        let at = phi.jet(p).unwrap();
        let r = length(p);
        // The triangles themselves are off by 1 − cos(edge/2) and half an edge of slope.
        assert!((at.value - (r - 1.0)).abs() < 3e-3, "{p:?}: {}", at.value);
        for i in 0..3 {
            assert!((at.gradient[i] - p[i] / r).abs() < 0.05, "{p:?}");
        }
    }
}

/// φ, ∇φ and ∇²φ are each other's derivatives, within cells and across their sides.
#[test]
fn a_sampled_distance_is_twice_continuously_differentiable() {
    let phi = sampled_ball(1.0);
    let h = 1e-5;
    let mut worst = [0.0_f64; 2];
    for n in 0..400 {
        let wave = |p: f64| (12.9898 * f64::from(n) + p).sin();
        let d = [wave(0.1), wave(1.7), wave(2.9)];
        let x = d.map(|c| 0.9 * c / length(d));
        for axis in 0..3 {
            let at = |t: f64| {
                let mut y = x;
                y[axis] += t;
                phi.jet(y).unwrap()
            };
            let (here, high, low) = (at(0.0), at(h), at(-h));
            let slope = (high.value - low.value) / (2.0 * h);
            worst[0] = worst[0].max((slope - here.gradient[axis]).abs());
            for i in 0..3 {
                let slope = (high.gradient[i] - low.gradient[i]) / (2.0 * h);
                worst[1] = worst[1].max((slope - here.hessian.0[i][axis]).abs());
            }
        }
    }
    // A side of a cell in between costs h times the jump of the third derivative.
    assert!(worst[0] < 1e-7 && worst[1] < 1e-2, "{worst:?}");
    // The sides themselves: the second derivative from both of them.
    let side = 0.05 * 20.0 - (1.0 + 0.5 + 0.15);
    let at = |t: f64| phi.jet([side + t, 0.4, 0.3]).unwrap();
    let (a, b) = (at(-1e-9), at(1e-9));
    for i in 0..3 {
        for j in 0..3 {
            assert!((a.hessian.0[i][j] - b.hessian.0[i][j]).abs() < 1e-4);
        }
    }
}

#[test]
fn nothing_is_sampled_from_what_is_no_surface() {
    let cube = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let faces = cube.boundary().faces;
    let sample =
        |faces: &[[u32; 3]], spacing| SampledDistance::new(cube.nodes(), faces, spacing, 0.1);
    let unusable = |e| matches!(e, Err(AssemblyError::UnusableContact { .. }));
    assert!(unusable(sample(&[], 0.1)) && unusable(sample(&faces, f64::NAN)));
    assert!(unusable(sample(&faces, 1e-4)));
    assert!(matches!(
        sample(&[[0, 1, 99]], 0.1),
        Err(AssemblyError::NoSuchNode { node: 99, .. })
    ));
}

/// A block [0, 1]² × [0, 0.6] over a ball that touches its lower side from below and hangs on the
/// block's upper side, whose corners are the bone's frame.
struct Scene {
    mesh: SimplexMesh<3>,
    bone: Vec<usize>,
    assembly: Assembly<3>,
}

const RADIUS: f64 = 0.5;

fn scene(sampled: bool, moving: bool) -> Scene {
    let mesh = kuhn_grid(4, 4, 3, [1.0, 1.0, 0.6]).unwrap();
    let rest = mesh.nodes();
    let high: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] > 0.55).collect();
    let bone: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] > 0.35).collect();
    // 0.03 inside at rest.
    let center = [0.5, 0.5, 0.03 - RADIUS];
    let surface = if sampled {
        let mesh = ball(RADIUS, 12);
        let points: Vec<Point> = mesh
            .nodes()
            .iter()
            .map(|p| std::array::from_fn(|i| p[i] + center[i]))
            .collect();
        let phi = SampledDistance::new(&points, &mesh.boundary().faces, 0.04, 0.2).unwrap();
        RigidSurface::Sampled(Arc::new(phi))
    } else {
        RigidSurface::Implicit(ImplicitSurface::Sphere {
            center,
            radius: RADIUS,
        })
    };
    let low = |t: &[u32; 3]| t.iter().all(|&n| rest[n as usize][2] == 0.0);
    let faces: Vec<_> = mesh.boundary().faces.into_iter().filter(low).collect();
    let points = ContactPoint::on_faces(&mesh, &faces);
    let frame = moving.then(|| RigidFrame::new(rest, &bone).unwrap());
    let params = RigidContactParams {
        activation: 0.02,
        pressure: 1e4,
        depth: f64::INFINITY,
    };
    let contact = RigidContact::new(vec![surface], frame, points, rest, params).unwrap();
    let prescribed = if moving { &bone } else { &high };
    let dofs = Dofs::with_prescribed_nodes(rest, prescribed).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder.material(flesh).unwrap().term(contact).unwrap();
    let assembly = builder.build().unwrap();
    Scene {
        mesh,
        bone,
        assembly,
    }
}

fn wave(n: usize, i: usize, p: f64) -> f64 {
    (3.7 * n as f64 + 1.3 * i as f64 + p).sin()
}

fn dot(a: &[Point], b: &[Point]) -> f64 {
    a.as_flattened()
        .iter()
        .zip(b.as_flattened())
        .map(|(a, b)| a * b)
        .sum()
}

/// Along random directions of all nodes, the bone's too, and along the gradient.
#[test]
fn derivatives_hold_with_a_bone_that_moves() {
    for (sampled, moving) in [(false, false), (true, false), (false, true), (true, true)] {
        let Scene {
            mesh,
            bone,
            assembly,
        } = scene(sampled, moving);
        let rest = mesh.nodes();
        // Bent, and pressed upon the ball, which is turned and stretched a little with the bone.
        let x: Vec<Point> = (0..rest.len())
            .map(|n| {
                let [x, y, z] = rest[n];
                let down = if moving && bone.contains(&n) {
                    [0.03 * z, 0.02 * y, 0.04 * x + 0.02 * z]
                } else {
                    [0.0, 0.0, -0.05]
                };
                std::array::from_fn(|i| rest[n][i] + down[i] + 0.004 * wave(n, i, 0.0))
            })
            .collect();
        let forces =
            |x: &[Point]| assembly.forces_everywhere(assembly.configuration(x, &[]).unwrap());
        let g: Vec<Point> = forces(&x).iter().map(|f| f.map(|c| -c)).collect();
        let largest = g.as_flattened().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let random = |p: f64| {
            (0..x.len())
                .map(|n| std::array::from_fn(|i| wave(7 * n, i, p)))
                .collect()
        };
        let along: Vec<Point> = g.iter().map(|v| v.map(|c| c / largest)).collect();
        let directions: [Vec<Point>; 3] = [random(0.3), random(1.9), along];
        for d in directions {
            let at = |t: f64| -> Vec<Point> {
                (0..x.len())
                    .map(|n| std::array::from_fn(|i| x[n][i] + t * d[n][i]))
                    .collect()
            };
            let energy = |t: f64| assembly.energy(assembly.configuration(&at(t), &[]).unwrap());
            let h = 2e-6;
            let slope =
                (8.0 * (energy(h) - energy(-h)) - energy(2.0 * h) + energy(-2.0 * h)) / (12.0 * h);
            let scale = dot(&g, &g).sqrt() * dot(&d, &d).sqrt();
            assert!(
                (slope - dot(&g, &d)).abs() <= 1e-6 * scale,
                "{sampled} {moving}: {slope}"
            );
            let product = assembly
                .hessian_vector_everywhere(assembly.configuration(&x, &[]).unwrap(), &d)
                .unwrap();
            let top = product
                .as_flattened()
                .iter()
                .fold(0.0_f64, |m, v| m.max(v.abs()));
            let of = |t: f64| forces(&at(t));
            let (a, b, c, e) = (of(h), of(-h), of(2.0 * h), of(-2.0 * h));
            for n in 0..x.len() {
                for i in 0..3 {
                    let slope = -(8.0 * (a[n][i] - b[n][i]) - c[n][i] + e[n][i]) / (12.0 * h);
                    assert!(
                        (slope - product[n][i]).abs() <= 1e-6 * top,
                        "{sampled} {moving}: {slope} {}",
                        product[n][i]
                    );
                }
            }
        }
        // The assembled matrix is the same operator on the free nodes.
        let mut matrix = BlockSymmetric::zeros(assembly.pattern().clone());
        let at = assembly.configuration(&x, &[]).unwrap();
        assembly.hessian(at, HessianProjection::None, &mut matrix);
        let u: Vec<f64> = (0..assembly.dofs().vector_len())
            .map(|i| wave(i, 0, 0.5))
            .collect();
        let mut all = vec![[0.0; 3]; x.len()];
        assembly.dofs().scatter(&u, &mut all).unwrap();
        let (mut by_matrix, mut by_product) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        matrix.apply(&u, &mut by_matrix);
        assembly.hessian_vector(at, &all, &mut by_product).unwrap();
        let top = by_matrix.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in by_matrix.iter().zip(&by_product) {
            assert!((a - b).abs() < 1e-12 * top);
        }
    }
}

/// A cube 1 m wide above a half-space or in it at rest, moved down: the pressure over p̂.
#[test]
fn flesh_with_less_room_than_the_activation_is_pushed_over_a_shorter_way() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let rest = mesh.nodes();
    let floor = mesh.boundary().faces.into_iter();
    let floor: Vec<_> = floor
        .filter(|f| f.iter().all(|&n| rest[n as usize][2] == 0.0))
        .collect();
    let points = ContactPoint::on_faces(&mesh, &floor);
    let params = RigidContactParams {
        activation: 0.03,
        pressure: 1e4,
        depth: f64::INFINITY,
    };
    for (gap, down, pressure) in [
        (0.03, 0.03, 1.0),
        (0.015, 0.015, 1.0),
        (0.0, 0.01, 1.0),
        (-0.2, 0.01, 1.0),
        (0.03, 0.06, 4.0),
        (0.006, 0.006, 0.36),
        (0.0, 0.0, 0.0),
    ] {
        let below = ImplicitSurface::HalfSpace {
            point: [0.0, 0.0, -gap],
            normal: [0.0, 0.0, 1.0],
        };
        let solids = vec![RigidSurface::Implicit(below)];
        let contact = RigidContact::new(solids, None, points.clone(), rest, params).unwrap();
        let dofs = Dofs::with_prescribed_nodes(rest, &[0]).unwrap();
        let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
        let assembly = builder.term(contact).unwrap().build().unwrap();
        let moved: Vec<Point> = rest.iter().map(|p| [p[0], p[1], p[2] - down]).collect();
        let forces = assembly.forces_everywhere(assembly.configuration(&moved, &[]).unwrap());
        let push: f64 = forces.iter().map(|f| f[2]).sum();
        assert!((push - 1e4 * pressure).abs() < 1e-8, "{gap} {down}: {push}");
    }
}

#[test]
fn nothing_pushes_at_rest_or_where_bone_and_flesh_move_together() {
    for (sampled, moving) in [(false, false), (true, true)] {
        let Scene { mesh, assembly, .. } = scene(sampled, moving);
        let (s, c) = 0.4_f64.sin_cos();
        let turned = |p: &Point| [c * p[0] - s * p[1] + 0.1, s * p[0] + c * p[1], p[2] - 0.2];
        let moved: Vec<Point> = mesh.nodes().iter().map(turned).collect();
        let places = if moving {
            vec![mesh.nodes().to_vec(), moved]
        } else {
            vec![mesh.nodes().to_vec()]
        };
        for x in places {
            let forces = assembly.forces_everywhere(assembly.configuration(&x, &[]).unwrap());
            assert!(forces.iter().flatten().all(|f| f.abs() < 1e-8));
        }
    }
}

fn solve(assembly: &Assembly<3>, start: Vec<Point>) -> (Vec<Point>, NewtonInfo) {
    let problem = Quasistatic::new(assembly, start, vec![]).unwrap();
    let mut x = problem.unknowns();
    let params = NewtonParams {
        projection: ProjectionPolicy::ExactThenShifted,
        linear_solver: LinearSolver::Direct,
        max_iterations: 200,
        ..NewtonParams::default()
    };
    let info = Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    (problem.positions(&x).unwrap(), info)
}

/// A ball pressed 0.16 into a block, the start 0.16 deep: it leaves, on any number of threads, with
/// the same bits.
#[test]
fn a_start_from_deep_inside_leaves() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let Scene { mesh, assembly, .. } = scene(true, false);
            let low = mesh.nodes().iter().map(|p| [p[0], p[1], p[2] - 0.16]);
            solve(&assembly, low.collect()).0
        })
    };
    let x = run(1);
    let gap = |p: &Point| length([p[0] - 0.5, p[1] - 0.5, p[2] + RADIUS - 0.03]) - RADIUS;
    let deepest = |x: &[Point]| x.iter().map(gap).fold(f64::INFINITY, f64::min);
    // 0.03 deep at rest is allowed.
    assert!(deepest(&x) > -0.06, "{}", deepest(&x));
    for threads in [2, 3] {
        assert!(run(threads) == x, "{threads} threads");
    }
}

/// A slab thinner than a step: no step leads through it, and behind its middle nothing is.
#[test]
fn no_step_leads_through_a_thin_solid() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let rest = mesh.nodes();
    let slab = ImplicitSurface::Box {
        min: [-1.0, -1.0, -0.5],
        max: [2.0, 2.0, -0.4],
    };
    let points = ContactPoint::on_faces(&mesh, &mesh.boundary().faces);
    let params = RigidContactParams {
        activation: 0.02,
        pressure: 1e4,
        depth: 0.04,
    };
    let contact = RigidContact::new(
        vec![RigidSurface::Implicit(slab)],
        None,
        points,
        rest,
        params,
    )
    .unwrap();
    let dofs = Dofs::all_free(rest).unwrap();
    let assembly = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .term(contact)
        .unwrap()
        .build()
        .unwrap();
    let down = vec![[0.0, 0.0, -2.0]; rest.len()];
    let at = assembly.configuration(rest, &[]).unwrap();
    let t = assembly.largest_step(at, &down).unwrap();
    // The lower side reaches z = −0.44 at t = 0.22.
    assert!(t > 0.2 && t < 0.22, "{t}");
    let up = vec![[0.0, 0.0, 2.0]; rest.len()];
    assert_eq!(assembly.largest_step(at, &up).unwrap(), f64::INFINITY);
    let energy = |z: f64| {
        let x: Vec<Point> = rest.iter().map(|p| [p[0], p[1], p[2] + z]).collect();
        assembly.energy(assembly.configuration(&x, &[]).unwrap())
    };
    assert!(energy(-0.37) == 0.0 && energy(-0.43) > 0.0 && energy(-0.43).is_finite());
    assert_eq!(energy(-0.445), f64::INFINITY);
}

/// The same slab under a soft block, pulled so that the first Newton step leads past it.
#[test]
fn a_solve_does_not_pass_a_thin_solid() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let rest = mesh.nodes();
    let slab = ImplicitSurface::Box {
        min: [-1.0, -1.0, -0.5],
        max: [2.0, 2.0, -0.4],
    };
    let faces = mesh.boundary().faces;
    let of_nodes = |z: f64| (0..rest.len()).filter(move |&n| rest[n][2] == z);
    let params = RigidContactParams {
        activation: 0.02,
        pressure: 1e4,
        depth: 0.04,
    };
    let points = ContactPoint::on_faces(&mesh, &faces);
    let contact = RigidContact::new(
        vec![RigidSurface::Implicit(slab)],
        None,
        points,
        rest,
        params,
    )
    .unwrap();
    let mut forces = vec![[0.0_f64; 3]; rest.len()];
    of_nodes(0.0).for_each(|n| forces[n][2] = -400.0);
    let top: Vec<usize> = of_nodes(1.0).collect();
    let assembly = AssemblyBuilder::new(&mesh, Dofs::with_prescribed_nodes(rest, &top).unwrap())
        .unwrap()
        .material(NeoHookean {
            mu: 1e3,
            lambda: 1e3,
        })
        .unwrap()
        .term(contact)
        .unwrap()
        .term(NodalLoads::new(forces.into_iter().enumerate().collect()).unwrap())
        .unwrap()
        .build()
        .unwrap();
    let problem = Quasistatic::new(&assembly, rest.to_vec(), vec![]).unwrap();
    let mut x = problem.unknowns();
    let mut dx = vec![0.0; x.len()];
    dx.iter_mut().skip(2).step_by(3).for_each(|z| *z = -2.0);
    assert!(problem.largest_step(&x, &dx) < 0.22);
    let mut newton = Newton::new(&problem);
    let params = NewtonParams::default();
    newton.solve(&problem, &mut x, &params).unwrap();
    let lowest = problem
        .positions(&x)
        .unwrap()
        .iter()
        .map(|p| p[2])
        .fold(0.0, f64::min);
    assert!(lowest > -0.44 && lowest < -0.38, "{lowest}");
}

/// A pillar that stands in a cube, its triangles partly inside: what is left out leaves no gap through
/// which inside and outside run together.
#[test]
fn parts_that_overlap_are_one_solid() {
    let cube = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let pillar = kuhn_grid(1, 1, 1, [0.4, 0.4, 1.4]).unwrap();
    let stands = pillar
        .nodes()
        .iter()
        .map(|p| [0.3 + p[0], 0.3 + p[1], 0.1 + p[2]]);
    let points: Vec<Point> = cube.nodes().iter().copied().chain(stands).collect();
    let first = cube.num_nodes() as u32;
    let above = pillar
        .boundary()
        .faces
        .into_iter()
        .map(|t| t.map(|n| n + first));
    let triangles: Vec<_> = cube.boundary().faces.into_iter().chain(above).collect();
    let phi = SampledDistance::new(&points, &triangles, 0.05, 0.3).unwrap();
    for (p, distance) in [
        ([0.5, 0.5, 1.3], -0.2),
        ([0.5, 0.5, 1.6], 0.1),
        ([0.9, 0.5, 1.15], 0.15),
        ([0.6, 0.5, 1.2], -0.1),
        ([0.9, 0.5, 0.5], -0.1),
    ] {
        let found = phi.value(p).unwrap();
        assert!((found - distance).abs() < 0.02, "{p:?}: {found}");
    }
}

/// A point is looked at only where it may be pushed: wherever it goes, solid by solid, the energy is that
/// of the formula, which looks at every point.
#[test]
fn no_point_that_a_solid_reaches_is_skipped_and_solids_add_up() {
    let mesh = kuhn_grid(4, 4, 3, [1.0, 1.0, 0.6]).unwrap();
    let rest = mesh.nodes();
    let points = ContactPoint::on_faces(&mesh, &mesh.boundary().faces);
    let params = RigidContactParams {
        activation: 0.05,
        pressure: 1e4,
        depth: f64::INFINITY,
    };
    let cube = kuhn_grid(4, 4, 4, [0.5; 3]).unwrap();
    let corners: Vec<Point> = cube.nodes().iter().map(|p| p.map(|c| c + 1.1)).collect();
    let phi = SampledDistance::new(&corners, &cube.boundary().faces, 0.04, 0.1).unwrap();
    let phi = Arc::new(phi);
    let sphere = ImplicitSurface::Sphere {
        center: [0.5, 0.5, -0.6],
        radius: 0.58,
    };
    let solids = [
        RigidSurface::Implicit(sphere),
        RigidSurface::Sampled(phi.clone()),
    ];
    let distance = |solid: usize, x: Point| match solid {
        0 => sphere.distance(&x),
        _ => phi.value(x).unwrap_or(f64::INFINITY),
    };
    let of = |surfaces: &[RigidSurface]| {
        let contact =
            RigidContact::new(surfaces.to_vec(), None, points.clone(), rest, params).unwrap();
        let dofs = Dofs::with_prescribed_nodes(rest, &[0]).unwrap();
        let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
        builder.term(contact).unwrap().build().unwrap()
    };
    let both = of(&solids);
    let each = [of(&solids[..1]), of(&solids[1..])];
    let mut pushed = [0; 2];
    for k in 0..40 {
        let far = 0.05 * f64::from(k);
        let toward = if k % 2 == 0 { 0.9 } else { -0.3 };
        let way: Point = std::array::from_fn(|i| far * (toward + 0.4 * wave(k as usize, i, 0.2)));
        let moved: Vec<Point> = (0..rest.len())
            .map(|n| std::array::from_fn(|i| rest[n][i] + way[i] + 0.02 * wave(n, i, far)))
            .collect();
        let energy =
            |assembly: &Assembly<3>| assembly.energy(assembly.configuration(&moved, &[]).unwrap());
        let mut sum = 0.0;
        for solid in 0..2 {
            let formula = |point: &ContactPoint| {
                let d = params.activation.min(distance(solid, point.position(rest)));
                let length = d.max(params.activation / 3.0);
                let lack = (d - distance(solid, point.position(&moved))) / length;
                params.pressure * point.area * length / 3.0 * lack.max(0.0).powi(3)
            };
            let expected: f64 = points.iter().map(formula).sum();
            let found = energy(&each[solid]);
            assert!(
                (found - expected).abs() <= 1e-12 * expected,
                "{k}, solid {solid}: {found} {expected}"
            );
            pushed[solid] += usize::from(expected > 0.0);
            sum += expected;
        }
        assert!((energy(&both) - sum).abs() <= 1e-12 * sum, "{k}");
    }
    assert!(pushed.iter().all(|&n| (3..40).contains(&n)), "{pushed:?}");
}
