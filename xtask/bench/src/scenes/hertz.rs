//! A rigid ball pressed on an elastic half-space (Hertz 1882; Johnson 1985, "Contact Mechanics", 4.2).

use super::Scene;
use super::elastic::{lame, named};
use crate::body::{Body, DIRECT, to};
use crate::curve::{Axis, Claim, Curve, Point};
use crate::failure::Failure;
use crate::settings::Settings;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    AssemblyBuilder, ContactPoint, Dofs, ImplicitSurface, RigidContact, RigidContactParams,
    RigidSurface,
};
use fem_solvers::{NewtonParams, ProjectionPolicy};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "hertz",
    about: "a rigid ball pressed on a half-space",
    measure: "of the force",
    truth: "F = 4/3 E/(1 - nu^2) sqrt(R) d^1.5; the block ends at 34 contact radii, where a half-space \
            goes on: about 2 %, and pressure begins 1 % of d before contact",
    run: curves,
    counted: Some(|| pressed(6, 1).map(|_| ())),
};

const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;
/// Of the ball, m.
const RADIUS: f64 = 1.0;
/// Radius of the contact, m.
const CONTACT: f64 = 0.02;
/// How deep the ball goes, m.
const DEPTH: f64 = CONTACT * CONTACT / RADIUS;
/// Edge of the block, in contact radii.
const REACH: f64 = 34.0;

/// A quarter of a half-space, x, y ≥ 0 ≥ z: the first of n cells is 2 a/n long, each longer than the
/// one before by the same ratio.
fn quarter(n: usize) -> Result<SimplexMesh<3>, Failure> {
    let grid = kuhn_grid(n, n, n, [n as f64; 3])?;
    let first = 2.0 / n as f64;
    let sum = |q: f64, i: f64| first * (q.powf(i) - 1.0) / (q - 1.0);
    let [mut low, mut high] = [1.0 + 1e-9, 10.0];
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        match sum(middle, n as f64) < REACH {
            true => low = middle,
            false => high = middle,
        }
    }
    let far = |i: f64| CONTACT * sum(low, i);
    let place = |p: &[f64; 3]| [far(p[0]), far(p[1]), -far(n as f64 - p[2])];
    let nodes = grid.nodes().iter().map(place).collect();
    Ok(SimplexMesh::new(nodes, grid.connectivity().to_vec())?)
}

/// The block, lifted by the depth, and the nodes of its bottom.
fn block(n: usize) -> Result<(Body, Vec<usize>), Failure> {
    let mesh = quarter(n)?;
    let rest = mesh.nodes();
    let bottom = rest.iter().fold(0.0_f64, |m, p| m.min(p[2]));
    let prescribed: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == bottom).collect();
    let planes = rest.iter().enumerate();
    let planes = planes.flat_map(|(n, p)| (0..2).filter(|&a| p[a] == 0.0).map(move |a| (n, a)));
    let dofs = Dofs::new(rest, &prescribed, &planes.collect::<Vec<_>>())?;
    let faces = mesh.boundary_faces(|n| mesh.node(n)[2] == 0.0);
    let params = RigidContactParams {
        activation: 0.01 * DEPTH,
        pressure: 0.1 * YOUNG,
        depth: f64::INFINITY,
    };
    let ball = RigidSurface::Implicit(ImplicitSurface::Sphere {
        center: [0.0, 0.0, RADIUS + params.activation],
        radius: RADIUS,
    });
    let points = ContactPoint::on_faces(&mesh, &faces);
    let contact = RigidContact::new(vec![ball], None, points, rest, params)?;
    let builder = AssemblyBuilder::new(&mesh, dofs)?;
    let builder = named(builder, &mesh, "neo_hookean", lame(YOUNG, POISSON))?;
    let body = Body {
        assembly: builder.term(contact)?.build()?,
        start: rest.iter().map(|p| [p[0], p[1], p[2] + DEPTH]).collect(),
        controls: vec![],
    };
    Ok((body, prescribed))
}

fn pressed(n: usize, repetitions: usize) -> Result<Point, Failure> {
    let stiffness = YOUNG / (1.0 - POISSON * POISSON);
    let exact = 4.0 / 3.0 * stiffness * RADIUS.sqrt() * DEPTH.powf(1.5);
    let (body, prescribed) = block(n)?;
    let params = NewtonParams {
        projection: ProjectionPolicy::ExactThenShifted,
        ..to(1e-8)
    };
    let solved = body.timed(repetitions, DIRECT, &params)?;
    let at = body.assembly.configuration(&solved.value.positions, &[])?;
    let forces = body.assembly.forces_everywhere(at);
    let force = 4.0 * prescribed.iter().map(|&n| forces[n][2]).sum::<f64>();
    let error = (force.abs() / exact - 1.0).abs();
    Ok(body.point(format!("n = {n}"), &solved, error))
}

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let mut curve = Curve::new("linear", Axis::Mesh, Claim::FallsTo(0.0));
    for n in settings.sizes(&[8, 12, 16], &[8, 12, 16, 20]) {
        curve.points.push(pressed(n, settings.repetitions)?);
    }
    Ok(vec![curve])
}
