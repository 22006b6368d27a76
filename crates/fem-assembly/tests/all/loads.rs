//! Loads against closed forms, and prescribed motion that is too far for one step.

use crate::promise::{Newton, solve_walking};
use fem_assembly::mesh::{QuadraticMesh, SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Cavity, Dofs, NodalLoads, Quasistatic, Scaled,
    Springs, WalkError,
};
use fem_materials::models::Linear;
use fem_materials::{HessianProjection, Lame, NeoHookean, Space};
use fem_solvers::{
    BlockSymmetric, ContinuationError, ContinuationParams, LinearOperator, LinearSolver,
    NewtonFailure, NewtonParams,
};

const YOUNG: f64 = 3e4;
const POISSON: f64 = 0.3;

fn linear() -> Linear {
    Lame::from_young_poisson(YOUNG, POISSON, Space::Solid)
        .unwrap()
        .into()
}

/// Nodes on the planes where a coordinate is 0 may not leave them.
fn symmetric<const D: usize>(nodes: &[[f64; D]]) -> Dofs<D> {
    let on = |n: usize, k: usize| (nodes[n][k] == 0.0).then_some((n, k));
    let axes = (0..nodes.len()).flat_map(|n| (0..D).filter_map(move |k| on(n, k)));
    Dofs::new(nodes, &[], &axes.collect::<Vec<_>>()).unwrap()
}

fn solved<const D: usize>(body: &Assembly<D>, controls: &[f64]) -> Vec<[f64; D]> {
    let problem = Quasistatic::new(body, body.rest().to_vec(), controls.to_vec()).unwrap();
    let mut x = problem.unknowns();
    let params = NewtonParams {
        linear_solver: LinearSolver::Direct,
        ..NewtonParams::default()
    };
    Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    problem.positions(&x).unwrap()
}

/// ε = σ/E along the traction and −ν σ/E across it, on any mesh.
fn assert_uniaxial<const D: usize>(rest: &[[f64; D]], x: &[[f64; D]], along: f64, across: f64) {
    for (x, p) in x.iter().zip(rest) {
        for k in 0..D {
            let strain = if k == D - 1 { along } else { across };
            assert!((x[k] - p[k] * (1.0 + strain)).abs() < 1e-9, "{x:?} {p:?}");
        }
    }
}

#[test]
fn a_traction_stretches_a_block_by_sigma_over_young() {
    let mesh = kuhn_grid(2, 3, 4, [1.0, 1.5, 2.0]).unwrap();
    let end = mesh.boundary_faces(|n| mesh.node(n)[2] == 2.0);
    assert_eq!(end.len(), 12);
    let sigma = 300.0;
    let (along, across) = (sigma / YOUNG, -POISSON * sigma / YOUNG);
    let rest = mesh.nodes();
    let traction = NodalLoads::traction(rest, &end, [0.0, 0.0, sigma]).unwrap();
    let suction = NodalLoads::pressure(rest, &end, -sigma).unwrap();
    for load in [traction, suction] {
        let builder = AssemblyBuilder::new(&mesh, symmetric(rest)).unwrap();
        let builder = builder.material(linear()).unwrap();
        let body = builder.term(Scaled::new(load, 0).unwrap()).unwrap();
        let body = body.build().unwrap();
        assert_uniaxial(rest, &solved(&body, &[1.0]), along, across);
        assert_uniaxial(rest, &solved(&body, &[-2.0]), -2.0 * along, -2.0 * across);
    }
    let quadratic = QuadraticMesh::from_linear(&mesh).unwrap();
    let rest = quadratic.nodes();
    let traction = NodalLoads::quadratic_traction(&quadratic, &end, [0.0, 0.0, sigma]).unwrap();
    let suction = NodalLoads::quadratic_pressure(&quadratic, &end, -sigma).unwrap();
    for load in [traction, suction] {
        let builder = AssemblyBuilder::quadratic(&quadratic, symmetric(rest)).unwrap();
        let builder = builder.material(linear()).unwrap();
        let body = builder.term(load).unwrap().build().unwrap();
        assert_uniaxial(rest, &solved(&body, &[]), along, across);
    }
}

fn sheet(columns: usize, rows: usize, size: [f64; 2]) -> SimplexMesh<2> {
    let node = |i: usize, j: usize| {
        let share = [i as f64 / columns as f64, j as f64 / rows as f64];
        [share[0] * size[0], share[1] * size[1]]
    };
    let at = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    let nodes = (0..=rows).flat_map(|j| (0..=columns).map(move |i| node(i, j)));
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [a, b, c, a, c, d]
    });
    SimplexMesh::new(nodes.collect(), triangles.collect()).unwrap()
}

/// Plane strain: E/(1 − ν²) along, −ν/(1 − ν) of that across.
#[test]
fn a_traction_stretches_a_sheet_in_plane_strain() {
    let mesh = sheet(3, 4, [1.0, 2.0]);
    let end = mesh.boundary_faces(|n| mesh.node(n)[1] == 2.0);
    let sigma = 300.0;
    let along = sigma * (1.0 - POISSON * POISSON) / YOUNG;
    let across = -along * POISSON / (1.0 - POISSON);
    let rest = mesh.nodes();
    for load in [
        NodalLoads::traction(rest, &end, [0.0, sigma]).unwrap(),
        NodalLoads::pressure(rest, &end, -sigma).unwrap(),
    ] {
        let builder = AssemblyBuilder::new(&mesh, symmetric(rest)).unwrap();
        let builder = builder.material(linear()).unwrap();
        let body = builder.term(load).unwrap().build().unwrap();
        assert_uniaxial(rest, &solved(&body, &[]), along, across);
    }
    let quadratic = QuadraticMesh::from_linear(&mesh).unwrap();
    let load = NodalLoads::quadratic_traction(&quadratic, &end, [0.0, sigma]).unwrap();
    let builder = AssemblyBuilder::quadratic(&quadratic, symmetric(quadratic.nodes())).unwrap();
    let builder = builder.material(linear()).unwrap();
    let body = builder.term(load).unwrap().build().unwrap();
    assert_uniaxial(quadratic.nodes(), &solved(&body, &[]), along, across);
}

/// A cube of cubes without its middle, blown up to a hollow ball: shells of the largest norm become
/// spheres. Radii 1/2 and 1 m.
fn hollow_ball(cells: usize) -> (SimplexMesh<3>, Vec<[u32; 3]>) {
    let grid = kuhn_grid(cells, cells, cells, [2.0; 3]).unwrap();
    let largest = |p: [f64; 3]| p.iter().fold(0.0_f64, |m, c| m.max((c - 1.0).abs()));
    let kept = grid.tets().filter(|tet| {
        let middle: [f64; 3] =
            std::array::from_fn(|i| tet.iter().map(|&n| grid.node(n)[i] / 4.0).sum());
        largest(middle) > 0.5
    });
    let kept: Vec<[u32; 4]> = kept.collect();
    let mut number = vec![u32::MAX; grid.num_nodes()];
    let mut nodes = Vec::new();
    for &n in kept.as_flattened() {
        if number[n as usize] == u32::MAX {
            number[n as usize] = nodes.len() as u32;
            let p = grid.node(n);
            let out = p.map(|c| c - 1.0);
            let length = out.iter().map(|c| c * c).sum::<f64>().sqrt();
            nodes.push(out.map(|c| c * largest(p) / length));
        }
    }
    let tets = kept.as_flattened().iter().map(|&n| number[n as usize]);
    let mesh = SimplexMesh::new(nodes, tets.collect()).unwrap();
    let radius = |n: u32| mesh.node(n).iter().map(|c| c * c).sum::<f64>().sqrt();
    let inner = mesh.boundary_faces(|n| radius(n) < 0.75);
    (mesh, Cavity::turned(inner))
}

/// Lamé: u(a) = p a³/(b³ − a³) ((1 − 2ν)/E a + (1 + ν)/(2E) b³/a²).
#[test]
fn a_pressure_blows_up_a_thick_ball_as_lame_says() {
    let (a, b, p) = (0.5_f64, 1.0_f64, 0.3);
    let share = a.powi(3) / (b.powi(3) - a.powi(3));
    let widened =
        (1.0 - 2.0 * POISSON) / YOUNG * a + (1.0 + POISSON) / (2.0 * YOUNG) * b.powi(3) / a.powi(2);
    let exact = p * share * widened;
    let error = |cells: usize| {
        let (mesh, inner) = hollow_ball(cells);
        let cavity = Cavity::closed(inner.clone(), 1.0).unwrap();
        let volume = cavity.volume(mesh.nodes()).unwrap();
        assert!(volume > 0.4 && volume < 4.0 / 3.0 * std::f64::consts::PI * a.powi(3));
        let builder = AssemblyBuilder::new(&mesh, symmetric(mesh.nodes())).unwrap();
        let builder = builder.material(linear()).unwrap();
        let body = builder.term(Scaled::new(cavity, 0).unwrap()).unwrap();
        let x = solved(&body.build().unwrap(), &[p]);
        let mut nodes = inner.concat();
        nodes.sort_unstable();
        nodes.dedup();
        let radius = |p: [f64; 3]| p.iter().map(|c| c * c).sum::<f64>().sqrt();
        let moved = nodes.iter().map(|&n| radius(x[n as usize]) - a);
        moved.sum::<f64>() / nodes.len() as f64 / exact - 1.0
    };
    let (coarse, fine) = (error(8), error(16));
    assert!(fine.abs() < 0.08, "{coarse} {fine}");
    assert!(fine.abs() < 0.4 * coarse.abs(), "{coarse} {fine}");
}

/// Lamé in plane strain: u(r) = p a²/(b² − a²) (1 + ν)/E ((1 − 2ν) r + b²/r). The mantle of the quarter
/// lies in the planes of symmetry, whose nodes cannot leave them.
#[test]
fn a_pressure_widens_a_thick_tube_as_lame_says() {
    let (a, b, p) = (0.5_f64, 1.0_f64, 0.3);
    let exact = |r: f64| {
        let share = p * a * a / (b * b - a * a) * (1.0 + POISSON) / YOUNG;
        share * ((1.0 - 2.0 * POISSON) * r + b * b / r)
    };
    let error = |cells: usize| {
        let flat = sheet(cells, 2 * cells, [b - a, 1.0]);
        let bend = |&[r, s]: &[f64; 2]| {
            let (sin, cos) = (s * std::f64::consts::FRAC_PI_2).sin_cos();
            [(a + r) * if s == 1.0 { 0.0 } else { cos }, (a + r) * sin]
        };
        let nodes = flat.nodes().iter().map(bend).collect();
        let mesh = SimplexMesh::<2>::new(nodes, flat.connectivity().to_vec()).unwrap();
        let inner = mesh.boundary_faces(|n| flat.node(n)[0] == 0.0);
        let cavity = Cavity::about(Cavity::turned(inner), [0.0; 2], 1.0).unwrap();
        let builder = AssemblyBuilder::new(&mesh, symmetric(mesh.nodes())).unwrap();
        let builder = builder.material(linear()).unwrap();
        let body = builder.term(Scaled::new(cavity, 0).unwrap()).unwrap();
        let x = solved(&body.build().unwrap(), &[p]);
        let off = x.iter().zip(mesh.nodes()).map(|(x, rest)| {
            let (now, r) = (x[0].hypot(x[1]), rest[0].hypot(rest[1]));
            ((now - r) / exact(r) - 1.0).abs()
        });
        off.fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(16), error(32));
    assert!(fine < 3e-3, "{coarse} {fine}");
    assert!(fine < 0.3 * coarse, "{coarse} {fine}");
}

/// −p/(3K) of strain all around, whatever the mesh.
#[test]
fn a_pressure_on_all_sides_shrinks_a_block_as_its_bulk_modulus_says() {
    let mesh = kuhn_grid(2, 3, 2, [1.0, 1.5, 2.0]).unwrap();
    let rest = mesh.nodes();
    let around = mesh.boundary_faces(|_| true);
    let open: Vec<[u32; 3]> = around
        .into_iter()
        .filter(|f| (0..3).all(|k| f.iter().any(|&n| mesh.node(n)[k] > 0.0)))
        .collect();
    let pressure = 1e-3;
    let cavity = Cavity::about(open, [0.0; 3], -pressure).unwrap();
    let builder = AssemblyBuilder::new(&mesh, symmetric(rest)).unwrap();
    let builder = builder.material(linear()).unwrap();
    let body = builder.term(cavity).unwrap().build().unwrap();
    let strain = -pressure * (1.0 - 2.0 * POISSON) / YOUNG;
    for (x, p) in solved(&body, &[]).iter().zip(rest) {
        for k in 0..3 {
            assert!(
                (x[k] - p[k] * (1.0 + strain)).abs() < 1e-6 * strain.abs(),
                "{x:?} {p:?}"
            );
        }
    }
}

#[test]
fn a_cavity_has_the_volume_that_it_encloses() {
    let mesh = kuhn_grid(2, 3, 2, [0.5, 2.0, 1.5]).unwrap();
    let shifted = |mesh: &SimplexMesh<3>| -> Vec<[f64; 3]> {
        let shift = |&[x, y, z]: &[f64; 3]| [x + 3.0, y - 2.0, z + 0.7 * x];
        mesh.nodes().iter().map(shift).collect()
    };
    let cavity = Cavity::closed(mesh.boundary().faces, 1.0).unwrap();
    assert!((cavity.volume(&shifted(&mesh)).unwrap() - 1.5).abs() < 1e-13);
    let turned = Cavity::closed(Cavity::turned(mesh.boundary().faces), 1.0).unwrap();
    assert!((turned.volume(mesh.nodes()).unwrap() + 1.5).abs() < 1e-13);
    // Without its top: a cap in the same plane, and a mantle from the middle of the top.
    let mut open = mesh.boundary().faces;
    open.retain(|face| face.iter().any(|&n| mesh.node(n)[2] < 1.5));
    let refused = Cavity::closed(open.clone(), 1.0);
    let Err(AssemblyError::OpenSurface { nodes, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert!(nodes.iter().all(|&n| mesh.node(n)[2] == 1.5));
    let capped = Cavity::capped(open.clone(), 1.0, |_| false).unwrap();
    assert!((capped.volume(mesh.nodes()).unwrap() - 1.5).abs() < 1e-13);
    let mantle = Cavity::about(open, [0.25, 1.0, 1.5], 1.0).unwrap();
    assert!((mantle.volume(mesh.nodes()).unwrap() - 1.5).abs() < 1e-13);
    let sheet = sheet(3, 2, [0.5, 3.0]);
    let area = Cavity::closed(sheet.boundary().faces, 1.0).unwrap();
    assert!((area.volume(sheet.nodes()).unwrap() - 1.5).abs() < 1e-13);
    assert!(Cavity::about(vec![[0, 1, 2]], [f64::NAN, 0.0, 0.0], 1.0).is_err());
}

fn bent(p: &[f64; 3]) -> [f64; 3] {
    let [x, y, z] = *p;
    [x + 0.2 * z * z, y - 0.1 * x * z, z + 0.3 * x * y]
}

/// p times the area vectors of the moved faces, a third at each node: what a follower pressure is.
#[test]
fn a_cavity_presses_along_the_current_normals_and_leaves_no_force_or_torque() {
    let mesh = kuhn_grid(2, 2, 3, [1.0, 1.0, 1.5]).unwrap();
    let faces = mesh.boundary().faces;
    let pressure = 250.0;
    let x: Vec<[f64; 3]> = mesh.nodes().iter().map(bent).collect();
    let forces = |cavity: Cavity<3>| {
        let builder = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes()).unwrap()).unwrap();
        let body = builder.term(cavity).unwrap().build().unwrap();
        body.forces_everywhere(body.configuration(&x, &[]).unwrap())
    };
    let sub = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| a[i] - b[i]) };
    let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let mut expected = vec![[0.0; 3]; x.len()];
    for face in &faces {
        let [a, b, c] = face.map(|n| x[n as usize]);
        let area = cross(sub(b, a), sub(c, a)).map(|v| 0.5 * v);
        for &n in face {
            (0..3).for_each(|i| expected[n as usize][i] += pressure * area[i] / 3.0);
        }
    }
    let found = forces(Cavity::closed(faces.clone(), pressure).unwrap());
    for (f, e) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((f - e).abs() < 1e-11 * pressure, "{f} against {e}");
    }
    let mut open = faces;
    open.retain(|face| face.iter().any(|&n| mesh.node(n)[0] > 0.0));
    let capped = forces(Cavity::capped(open.clone(), pressure, |n| n == 9).unwrap());
    for forces in [&found, &capped] {
        let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
        for (f, x) in forces.iter().zip(&x) {
            let turn = cross(*x, *f);
            for i in 0..3 {
                force[i] += f[i];
                torque[i] += turn[i];
            }
        }
        let left = force.iter().chain(&torque);
        assert!(
            left.clone().all(|v| v.abs() < 1e-11 * pressure),
            "{force:?} {torque:?}"
        );
    }
    // Away from the rim a mantle presses as the faces do.
    let mantle = forces(Cavity::about(open, [0.1, 0.2, 0.3], pressure).unwrap());
    for n in (0..x.len()).filter(|&n| mesh.nodes()[n][0] > 0.0) {
        for i in 0..3 {
            assert!((mantle[n][i] - expected[n][i]).abs() < 1e-11 * pressure);
        }
    }
}

#[test]
fn the_projected_hessian_of_a_cavity_pulls_nothing() {
    let mesh = kuhn_grid(1, 2, 1, [1.0; 3]).unwrap();
    let cavity = Cavity::closed(mesh.boundary().faces, 40.0).unwrap();
    let builder = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes()).unwrap()).unwrap();
    let body = builder.term(cavity).unwrap().build().unwrap();
    let x: Vec<[f64; 3]> = mesh.nodes().iter().map(bent).collect();
    let at = body.configuration(&x, &[]).unwrap();
    let curvature = |projection, v: &[f64]| {
        let mut hessian = BlockSymmetric::zeros(body.pattern().clone());
        body.hessian(at, projection, &mut hessian);
        let mut product = vec![0.0; v.len()];
        hessian.apply(v, &mut product);
        product.iter().zip(v).map(|(a, b)| a * b).sum::<f64>()
    };
    let waves = (0..40_usize).map(|k| {
        let wave = |i: usize| (12.9898 * (i * (k + 2)) as f64 + 3.7).sin();
        (0..3 * x.len()).map(wave).collect::<Vec<f64>>()
    });
    let mut negative = 0;
    for v in waves {
        let plain = curvature(HessianProjection::None, &v);
        negative += usize::from(plain < 0.0);
        let clamped = curvature(HessianProjection::Clamp, &v);
        assert!(clamped >= 0.0 && clamped >= plain, "{clamped} {plain}");
    }
    assert!(negative > 5, "{negative}");
}

/// Four springs of k at the free end of a bar of stiffness E A/ℓ: u = 4k d/(4k + E A/ℓ).
#[test]
fn springs_share_their_pull_with_the_body() {
    let mesh = kuhn_grid(1, 1, 3, [1.0, 1.0, 3.0]).unwrap();
    let rest = mesh.nodes();
    let end = (0..rest.len()).filter(|&n| rest[n][2] == 3.0);
    let ends: Vec<usize> = end.collect();
    assert_eq!(ends.len(), 4);
    let (k, pulled) = (400.0, 0.02);
    let bar = Linear {
        mu: YOUNG / 2.0,
        lambda: 0.0,
    };
    // With ν = 0 and the load of a uniform traction the state is uniform; corners of the grid carry it
    // unevenly, so the end moves as a plate.
    let springs = Springs::at_nodes(
        ends.iter()
            .map(|&n| (n, [rest[n][0], rest[n][1], 3.0 + pulled])),
        k,
    );
    let axes = (0..rest.len()).flat_map(|n| [(n, 0), (n, 1)]);
    let bottom: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let dofs = Dofs::new(rest, &bottom, &axes.collect::<Vec<_>>()).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let builder = builder.material(bar).unwrap();
    let body = builder.term(springs.unwrap()).unwrap().build().unwrap();
    let x = solved(&body, &[]);
    let mean = ends.iter().map(|&n| x[n][2] - 3.0).sum::<f64>() / 4.0;
    let total: f64 = ends.iter().map(|&n| k * (3.0 + pulled - x[n][2])).sum();
    let reaction: f64 = {
        let forces = body.forces_everywhere(body.configuration(&x, &[]).unwrap());
        bottom.iter().map(|&n| forces[n][2]).sum()
    };
    assert!(
        (total - reaction).abs() < 1e-6 * total,
        "{total} {reaction}"
    );
    let exact = 4.0 * k * pulled / (4.0 * k + YOUNG / 3.0);
    assert!((mean / exact - 1.0).abs() < 0.05, "{mean} {exact}");
    assert!(Springs::at_nodes([(0, [f64::NAN, 0.0, 0.0])], k).is_err());
    assert!(Springs::at_nodes([(0, [0.0; 3])], -k).is_err());
}

#[test]
fn faces_that_make_no_sense_are_refused() {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let load = |face| NodalLoads::traction(mesh.nodes(), &[[0, 1, 2], face], [1.0; 3]).err();
    let missing = AssemblyError::NoSuchNode { node: 8, count: 8 };
    assert_eq!(load([0, 1, 8]), Some(missing));
    let twice = AssemblyError::DegenerateFace { face: 1, node: 1 };
    assert_eq!(load([0, 1, 1]), Some(twice));
    let quadratic = QuadraticMesh::from_linear(&mesh).unwrap();
    let missing = NodalLoads::quadratic_pressure(&quadratic, &[[1, 6, 0]], 1.0).err();
    let nodes = [1, 6];
    assert_eq!(missing, Some(AssemblyError::NoSuchEdge { nodes, face: 0 }));
}

/// A block of four layers, its top pushed in by one and a half of them.
#[test]
fn a_face_pushed_in_by_more_than_a_layer_is_walked_to() {
    let mesh = kuhn_grid(3, 3, 4, [1.0; 3]).unwrap();
    let rest = mesh.nodes().to_vec();
    let held = |n: &usize| rest[*n][2] == 0.0 || rest[*n][2] == 1.0;
    let ends: Vec<usize> = (0..rest.len()).filter(held).collect();
    // One node at the side stays in its plane.
    let roller = (0..rest.len())
        .find(|&n| rest[n] == [0.0, 0.0, 0.5])
        .unwrap();
    let dofs = Dofs::new(&rest, &ends, &[(roller, 0)]).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 2e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let mut body = builder.material(flesh).unwrap().build().unwrap();
    let pushed = |depth: f64| -> Vec<[f64; 3]> {
        let push = |&[x, y, z]: &[f64; 3]| [x, y, if z == 1.0 { 1.0 - depth } else { z }];
        let mut pushed: Vec<[f64; 3]> = rest.iter().map(push).collect();
        pushed[roller][0] = -0.05;
        pushed
    };
    let target = pushed(1.5 * 0.25);
    let problem = Quasistatic::new(&body, target.clone(), vec![]).unwrap();
    let mut newton = Newton::new(&problem);
    let params = NewtonParams::default();
    let jump = newton.solve(&problem, &mut problem.unknowns(), &params);
    let jump = jump.expect_err("outside the domain").reason;
    assert!(
        matches!(jump, NewtonFailure::OutsideDomain { .. }),
        "{jump}"
    );
    let walk = ContinuationParams::default();
    let there = solve_walking(
        &mut body,
        &mut newton,
        rest.clone(),
        &target,
        &[],
        &params,
        &walk,
    );
    let there = there.unwrap();
    // The tangent leads there at once.
    assert_eq!((there.walk.steps, there.walk.failures), (1, 0));
    for &n in &ends {
        assert_eq!(there.positions[n], target[n]);
    }
    assert_eq!(there.positions[roller][0], -0.05);
    let at = body.configuration(&there.positions, &[]).unwrap();
    let mut gradient = vec![0.0; body.dofs().vector_len()];
    body.gradient(at, &mut gradient).unwrap();
    let force = body.forces_everywhere(at)[ends[0]][2].abs();
    assert!(gradient.iter().all(|g| g.abs() < 1e-5 * force), "{force}");
    assert!(body.volume_ratios(at).unwrap().iter().all(|j| *j > 0.2));
}

/// A column that cannot give way sideways is pushed through its own bottom.
#[test]
fn a_walk_that_leads_nowhere_says_how_far_it_came() {
    let mesh = kuhn_grid(1, 1, 4, [1.0; 3]).unwrap();
    let rest = mesh.nodes().to_vec();
    let end = |n: &usize| rest[*n][2] == 0.0 || rest[*n][2] == 1.0;
    let ends: Vec<usize> = (0..rest.len()).filter(end).collect();
    let sides = (0..rest.len()).flat_map(|n| [(n, 0), (n, 1)]);
    let dofs = Dofs::new(&rest, &ends, &sides.collect::<Vec<_>>()).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 2e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let mut body = builder.material(flesh).unwrap().build().unwrap();
    let through = |&[x, y, z]: &[f64; 3]| [x, y, if z == 1.0 { -0.25 } else { z }];
    let target: Vec<[f64; 3]> = rest.iter().map(through).collect();
    let problem = Quasistatic::new(&body, rest.clone(), vec![]).unwrap();
    let mut newton = Newton::new(&problem);
    let (params, walk) = (NewtonParams::default(), ContinuationParams::default());
    let stuck = solve_walking(
        &mut body,
        &mut newton,
        rest.clone(),
        &target,
        &[],
        &params,
        &walk,
    );
    let Err(WalkError::Stuck {
        percent,
        element,
        last,
        ..
    }) = stuck
    else {
        panic!("{stuck:?}");
    };
    assert!(percent > 70.0 && percent < 80.0, "{percent}");
    assert!(element.is_some());
    let top = last[rest.len() - 1][2];
    assert!(
        top > 0.0 && (1.0 - 1.25 * percent / 100.0 - top).abs() < 1e-9,
        "{top}"
    );
    let wrong = solve_walking(
        &mut body,
        &mut newton,
        rest.clone(),
        &target[1..],
        &[],
        &params,
        &walk,
    );
    assert!(matches!(wrong, Err(WalkError::Assembly(_))));
}

#[test]
fn a_setting_of_a_walk_that_makes_no_sense_is_named() {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let rest = mesh.nodes().to_vec();
    let dofs = Dofs::with_prescribed_nodes(&rest, &[0, 1, 2, 3]).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 2e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let mut body = builder.material(flesh).unwrap().build().unwrap();
    let mut newton = Newton::new(&Quasistatic::new(&body, rest.clone(), vec![]).unwrap());
    let params = NewtonParams::default();
    let walk = ContinuationParams {
        shrink: 1.5,
        ..ContinuationParams::default()
    };
    let end = rest.clone();
    let wrong = solve_walking(&mut body, &mut newton, rest, &end, &[], &params, &walk);
    let Err(WalkError::Walk(source)) = wrong else {
        panic!("{wrong:?}");
    };
    let ContinuationError::Params { what, value, .. } = *source else {
        panic!("{source:?}");
    };
    assert_eq!((what, value), ("shrink", 1.5));
}
