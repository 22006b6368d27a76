//! The nearly incompressible block of SPP 1748 (Schröder et al. 2021), a quarter of it in SI units.

use super::Scene;
use super::elastic::{Kind, nodes};
use crate::body::{Body, DIRECT, to};
use crate::curve::{Axis, Claim, Curve, Point};
use crate::failure::Failure;
use crate::settings::Settings;
use fem_assembly::mesh::{QuadraticMesh, SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, NodalLoads, VolumePatches};
use fem_kinematics::{Mat, Real};
use fem_materials::Material;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "spp-block",
    about: "the nearly incompressible block of SPP 1748, pressed by 3 MPa on part of its top",
    measure: "of 20 mm",
    truth: "its corner sinks by 20.00 mm (Schroeder et al. 2021): known to 2.5e-4",
    run: curves,
    counted: Some(|| solved(4, Kind::Patches, 1).map(|_| ())),
};

/// μ and λ, Pa.
const MU: f64 = 1.61148e6;
const LAMBDA: f64 = 499.92568e6;
/// On [25, 50]² mm of the top, Pa.
const PRESSURE: f64 = 3e6;
/// Of the quarter, m.
const SIZE: f64 = 0.05;
/// How far its corner sinks, m.
const SINKS: f64 = 0.02;

/// ψ = μ/2 (I₁ − 3 − 2 ln J) + λ/2 (J − 1)².
#[derive(Clone, Copy)]
struct Rubber {
    mu: f64,
    lambda: f64,
}

impl Material<3> for Rubber {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let (mu, lambda) = (T::from_f64(0.5 * self.mu), T::from_f64(0.5 * self.lambda));
        let J = F.determinant();
        let shear = F.norm_squared() - T::from_f64(3.0) - T::from_f64(2.0) * J.ln();
        let energy = mu * shear + lambda * (J - T::one()) * (J - T::one());
        T::select(T::zero().lt(J), energy, T::from_f64(f64::INFINITY))
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let J = F.determinant();
        F.scale(mu) + F.cofactor().scale(lambda * (J - T::one()) - mu * J.recip())
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let (J, cof) = (F.determinant(), F.cofactor());
        let dJ = cof.dot(dF);
        let slope = lambda + mu * (J * J).recip();
        dF.scale(mu)
            + cof.scale(slope * dJ)
            + F.cofactor_differential(dF)
                .scale(lambda * (J - T::one()) - mu * J.recip())
    }
}

fn is(coordinate: f64, value: f64) -> bool {
    (coordinate - value).abs() < 1e-9 * SIZE
}

/// Bottom on rollers, top prescribed sideways, two planes of symmetry.
fn dofs(nodes: &[[f64; 3]]) -> Result<Dofs<3>, Failure> {
    let prescribed = |&[x, y, z]: &[f64; 3]| {
        let top = is(z, SIZE);
        [is(x, SIZE) || top, is(y, SIZE) || top, z == 0.0]
    };
    let axes = nodes.iter().enumerate().flat_map(|(n, p)| {
        let prescribed = prescribed(p);
        (0..3).filter(move |&a| prescribed[a]).map(move |a| (n, a))
    });
    Ok(Dofs::new(nodes, &[], &axes.collect::<Vec<_>>())?)
}

fn assembly(n: usize, kind: Kind) -> Result<Assembly<3>, Failure> {
    let mesh = kuhn_grid(n, n, n, [SIZE; 3])?;
    let faces = loaded(&mesh);
    let dofs = dofs(&nodes(&mesh, kind)?)?;
    let whole = Rubber {
        mu: MU,
        lambda: LAMBDA,
    };
    if kind == Kind::Quadratic {
        let mesh = QuadraticMesh::from_linear(&mesh)?;
        let load = NodalLoads::quadratic_pressure(&mesh, &faces, PRESSURE)?;
        let builder = AssemblyBuilder::quadratic(&mesh, dofs)?;
        return Ok(builder.term(load)?.material(whole)?.build()?);
    }
    let load = NodalLoads::pressure(mesh.nodes(), &faces, PRESSURE)?;
    let builder = AssemblyBuilder::new(&mesh, dofs)?.term(load)?;
    if kind == Kind::Linear {
        return Ok(builder.material(whole)?.build()?);
    }
    let soft = Rubber {
        lambda: 0.0,
        ..whole
    };
    let patches = VolumePatches::around_edges(&mesh);
    let bulk = vec![LAMBDA; mesh.num_elements()];
    let builder = builder.material(soft)?.mean_volume(&patches, &bulk)?;
    Ok(builder.build()?)
}

/// The faces of [25, 50]² mm of the top.
fn loaded(mesh: &SimplexMesh<3>) -> Vec<[u32; 3]> {
    mesh.boundary_faces(|n| {
        let [x, y, z] = mesh.node(n);
        let middle = 0.5 * SIZE * (1.0 - 1e-9);
        is(z, SIZE) && x >= middle && y >= middle
    })
}

fn solved(n: usize, kind: Kind, repetitions: usize) -> Result<Point, Failure> {
    let assembly = assembly(n, kind)?;
    let corner = assembly
        .rest()
        .iter()
        .position(|p| p.iter().all(|&c| is(c, SIZE)));
    let corner = corner.ok_or_else(|| Failure::Failed("no corner".into()))?;
    let start = assembly.rest().to_vec();
    let body = Body {
        assembly,
        start,
        controls: vec![],
    };
    let solved = body.timed(repetitions, DIRECT, &to(1e-8))?;
    let sunk = SIZE - solved.value.positions[corner][2];
    let error = (sunk / SINKS - 1.0).abs();
    Ok(body.point(format!("n = {n}"), &solved, error))
}

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let mut curves = Vec::new();
    for kind in Kind::ALL {
        let sizes = match kind {
            Kind::Linear => settings.sizes(&[4, 8, 12], &[4, 8, 16]),
            Kind::Patches => settings.sizes(&[4, 8, 12], &[4, 8, 12, 16]),
            Kind::Quadratic => settings.sizes(&[2, 4, 6], &[2, 4, 6, 8]),
        };
        let claim = match kind {
            Kind::Linear | Kind::Quadratic => Claim::FallsTo(0.0),
            // From the first mesh on within the influence of how its cells are cut.
            Kind::Patches => Claim::AtMost(0.06),
        };
        let mut curve = Curve::new(kind.name(), Axis::Mesh, claim);
        for n in sizes {
            curve.points.push(solved(n, kind, settings.repetitions)?);
        }
        curves.push(curve);
    }
    Ok(curves)
}
