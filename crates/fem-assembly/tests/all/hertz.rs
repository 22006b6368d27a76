//! A rigid ball on an elastic half-space (Hertz 1882; Johnson 1985, "Contact Mechanics", 4.2):
//! F = 4/3 E* √R δ^(3/2), contact radius a = √(R δ), E* = E/(1 − ν²).

use crate::promise::Newton;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    AssemblyBuilder, ContactPoint, Dofs, Quasistatic, RigidContact, RigidContactParams,
    RigidSurface,
};
use fem_kinematics::ImplicitSurface;
use fem_materials::NeoHookean;
use fem_solvers::{LinearSolver, NewtonParams, ProjectionPolicy};
use std::f64::consts::PI;

const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;
const RADIUS: f64 = 1.0;
const CONTACT: f64 = 0.02;
const DEPTH: f64 = CONTACT * CONTACT / RADIUS;

/// A quarter of a half-space, x, y ≥ 0 ≥ z: cells of 0.1 a at the origin, each 1.25 times as long as
/// the one before, 34 a in all.
fn quarter() -> SimplexMesh<3> {
    let cells = 20;
    let grid = kuhn_grid(cells, cells, cells, [cells as f64; 3]).unwrap();
    let far = |i: f64| 0.1 * CONTACT * (1.25_f64.powf(i) - 1.0) / 0.25;
    let place = |p: &[f64; 3]| [far(p[0]), far(p[1]), -far(cells as f64 - p[2])];
    let nodes = grid.nodes().iter().map(place).collect();
    SimplexMesh::new(nodes, grid.connectivity().to_vec()).unwrap()
}

#[test]
fn a_ball_presses_as_hertz_says() {
    let mesh = quarter();
    let rest = mesh.nodes();
    let bottom = rest.iter().fold(0.0_f64, |m, p| m.min(p[2]));
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == bottom).collect();
    let on_plane = |(n, axis): &(usize, usize)| rest[*n][*axis] == 0.0;
    let planes = (0..rest.len())
        .flat_map(|n| [(n, 0), (n, 1)])
        .filter(on_plane);
    let planes: Vec<(usize, usize)> = planes.collect();
    let top = |t: &[u32; 3]| t.iter().all(|&n| rest[n as usize][2] == 0.0);
    let faces: Vec<[u32; 3]> = mesh.boundary().faces.into_iter().filter(top).collect();
    let points = ContactPoint::on_faces(&mesh, &faces);
    let area: f64 = points.iter().map(|p| p.area).sum();
    assert!((area / bottom / bottom - 1.0).abs() < 1e-12);
    let params = RigidContactParams {
        activation: 0.01 * DEPTH,
        pressure: 0.1 * YOUNG,
        depth: f64::INFINITY,
    };
    // At rest its gap is the activation: it pushes from the first lift on.
    let center = [0.0, 0.0, RADIUS + params.activation];
    let ball = RigidSurface::Implicit(ImplicitSurface::Sphere {
        center,
        radius: RADIUS,
    });
    let contact =
        RigidContact::new(vec![ball.clone()], None, points.clone(), rest, params).unwrap();
    let flesh = NeoHookean {
        mu: YOUNG / (2.0 * (1.0 + POISSON)),
        lambda: YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)),
    };
    let dofs = Dofs::new(rest, &prescribed, &planes).unwrap();
    let assembly = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(flesh)
        .unwrap()
        .term(contact)
        .unwrap()
        .build()
        .unwrap();
    let lifted: Vec<[f64; 3]> = rest.iter().map(|p| [p[0], p[1], p[2] + DEPTH]).collect();
    let problem = Quasistatic::new(&assembly, lifted, vec![]).unwrap();
    let mut x = problem.unknowns();
    let newton = NewtonParams {
        projection: ProjectionPolicy::ExactThenShifted,
        linear_solver: LinearSolver::Direct,
        ..NewtonParams::default()
    };
    Newton::new(&problem)
        .solve(&problem, &mut x, &newton)
        .unwrap();
    let positions = problem.positions(&x).unwrap();
    let forces = assembly.forces_everywhere(assembly.configuration(&positions, &[]).unwrap());
    let force = 4.0 * prescribed.iter().map(|&n| forces[n][2]).sum::<f64>();
    let stiffness = YOUNG / (1.0 - POISSON * POISSON);
    let expected = 4.0 / 3.0 * stiffness * RADIUS.sqrt() * DEPTH.powf(1.5);
    let off = force.abs() / expected - 1.0;
    // The mean distance of the pressure from the axis: 3 π a/16.
    let (mut total, mut moment) = (0.0, 0.0);
    for point in &points {
        let [x, y, z] = point.position(&positions);
        let away = (x * x + y * y + (z - center[2]) * (z - center[2])).sqrt();
        let lack = (1.0 - (away - RADIUS) / params.activation).max(0.0);
        total += point.area * lack * lack;
        moment += point.area * lack * lack * x.hypot(y);
    }
    let reach = moment / total / (3.0 * PI / 16.0 * CONTACT) - 1.0;
    // Linear elements at fixed displacements are too stiff, never too soft: 14 % with cells of 0.15 a,
    // 8.5 % here.
    assert!(
        off > 0.0 && off < 0.09 && reach.abs() < 0.01,
        "force {off:+.4}, radius {reach:+.4}"
    );
}
