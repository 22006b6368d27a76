//! A thick sphere, blown up: outer radius twice the inner one.

use super::Scene;
use super::elastic::{Kind, flesh, lame, nodes};
use super::radial::Shell;
use super::shell::octant;
use crate::body::{Body, DIRECT, to};
use crate::curve::{Axis, Claim, Curve};
use crate::failure::Failure;
use crate::settings::Settings;
use fem_assembly::mesh::{QuadraticMesh, SimplexMesh};
use fem_assembly::{Cavity, Dofs};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "sphere",
    about: "a thick sphere of 1 and 2 m under a pressure from within that follows its wall",
    measure: "of the wall's way",
    truth: "r(R) of the same law as an ordinary differential equation, to 1e-10; averaged volumes have \
            another law, alike to 1e-4; straight edges leave the sphere with h^2 for every element",
    run: curves,
    counted: Some(|| {
        let (body, _) = sphere(3, Kind::Linear, lame(YOUNG, 0.3))?;
        body.solve_alone(DIRECT, &to(1e-8)).map(|_| ())
    }),
};

const INNER: f64 = 1.0;
const OUTER: f64 = 2.0;
const YOUNG: f64 = 1e5;
/// Of the shear modulus: the inner wall moves by a seventh. Above 0.8 there is no equilibrium.
const PRESSURE: f64 = 0.4;

/// An eighth of it, and what the pressure fills.
fn sphere(n: usize, kind: Kind, constants: [f64; 2]) -> Result<(Body, Cavity<3>), Failure> {
    let mesh = octant(n, INNER, OUTER)?;
    let rest = nodes(&mesh, kind)?;
    // The tangent of 0 is 0: the planes of symmetry are exact.
    let planes = rest.iter().enumerate();
    let planes = planes.flat_map(|(n, p)| (0..3).filter(|&a| p[a] == 0.0).map(move |a| (n, a)));
    let dofs = Dofs::new(&rest, &[], &planes.collect::<Vec<_>>())?;
    let faces = Cavity::turned(wall(&mesh, kind)?);
    let gas = Cavity::about(faces, [0.0; 3], PRESSURE * constants[0])?;
    let assembly = flesh(&mesh, kind, constants, dofs, Some(gas.clone()))?;
    let body = Body {
        assembly,
        start: rest,
        controls: vec![],
    };
    Ok((body, gas))
}

/// The inner faces; those of quadratic elements in four parts.
fn wall(mesh: &SimplexMesh<3>, kind: Kind) -> Result<Vec<[u32; 3]>, Failure> {
    let at_wall = |n: u32| workbench::numbers::norm(&mesh.node(n)) < INNER * (1.0 + 1e-9);
    let faces = mesh.boundary_faces(at_wall);
    if kind != Kind::Quadratic {
        return Ok(faces);
    }
    let edges = mesh.edges();
    let first = QuadraticMesh::from_linear(mesh)?.num_nodes() - edges.len();
    let middle = |a: u32, b: u32| {
        let at = edges.partition_point(|e| *e < [a.min(b), a.max(b)]);
        (first + at) as u32
    };
    let parts = |[a, b, c]: [u32; 3]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    Ok(faces.into_iter().flat_map(parts).collect())
}

/// How far a sphere of this cavity's volume would have gone, m. Places of single nodes would show how
/// the pressure is shared among the nodes of a face.
fn way(body: &Body, cavity: &Cavity<3>, positions: &[[f64; 3]]) -> Result<f64, Failure> {
    let ratio = cavity.volume(positions)? / cavity.volume(body.assembly.rest())?;
    Ok(INNER * (ratio.cbrt() - 1.0))
}

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let mut curves = Vec::new();
    for nu in [0.3, 0.4999] {
        let constants = lame(YOUNG, nu);
        let [mu, lambda] = constants;
        let shell = Shell {
            inner: INNER,
            outer: OUTER,
            mu,
            lambda,
        };
        let exact = shell.radii(PRESSURE * mu)[0] - INNER;
        let kinds = Kind::ALL.into_iter();
        for kind in kinds.filter(|&k| k != Kind::Patches || nu > 0.49) {
            let sizes = match kind {
                Kind::Linear | Kind::Patches => settings.sizes(&[2, 4, 8], &[2, 4, 8, 12]),
                Kind::Quadratic => settings.sizes(&[2, 4], &[2, 4, 6]),
            };
            let name = format!("{}, nu = {nu}", kind.name());
            let claim = match kind {
                Kind::Linear | Kind::Patches => Claim::FallsTo(0.0),
                // On coarse meshes errors of the edges and of the elements have opposite signs.
                Kind::Quadratic => Claim::AtMost(0.05),
            };
            let mut curve = Curve::new(name, Axis::Mesh, claim);
            for n in sizes {
                let (body, cavity) = sphere(n, kind, constants)?;
                let solved = body.timed(settings.repetitions, DIRECT, &to(1e-8))?;
                let error = (way(&body, &cavity, &solved.value.positions)? / exact - 1.0).abs();
                curve
                    .points
                    .push(body.point(format!("n = {n}"), &solved, error));
            }
            curves.push(curve);
        }
    }
    Ok(curves)
}
