//! A block that is one muscle, shortened by itself: one stretch along it and one across, everywhere.

use super::Scene;
use super::elastic::lame;
use crate::body::{AUTO, Body, LINEAR, apart, to};
use crate::curve::{Axis, Claim, Curve};
use crate::failure::Failure;
use crate::settings::Settings;
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs, Fiber};
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, NeoHookean, Stretch};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "muscle",
    about: "a block of muscle, fibers along it, activated by a half, nothing holds it from shortening",
    measure: "apart, m",
    truth: "the two stretches that leave no stress, by bisection, to rounding; the block is 0.1 m long",
    run: curves,
    counted: Some(|| block(4)?.solve_alone(AUTO, &to(1e-8)).map(|_| ())),
};

const YOUNG: f64 = 3e4;
const POISSON: f64 = 0.45;
const STRENGTH: f64 = 2e4;
const ACTIVATION: f64 = 0.5;
/// Edges, m.
const SIZE: [f64; 3] = [0.04, 0.04, 0.1];

/// Where an increasing function is 0.
fn zero(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        match f(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// The stretches along and across: μ l + (λ ln J − μ)/l + σ_max α f_a(l) = 0 and
/// μ t + (λ ln J − μ)/t = 0 with J = l t², f_a = 1 − 25/6 (l − 1)². A slack fiber pulls back nothing.
fn stretches() -> [f64; 2] {
    let [mu, lambda] = lame(YOUNG, POISSON);
    let elastic = |own: f64, J: f64| mu * own + (lambda * J.ln() - mu) / own;
    let across = |l: f64| zero(|t| elastic(t, l * t * t), [0.5, 3.0]);
    let along = |l: f64| {
        let t = across(l);
        let active = 1.0 - 25.0 / 6.0 * (l - 1.0) * (l - 1.0);
        elastic(l, l * t * t) + STRENGTH * ACTIVATION * active
    };
    let l = zero(along, [0.61, 1.0]);
    [l, across(l)]
}

fn block(n: usize) -> Result<Body, Failure> {
    let mesh = kuhn_grid(n, n, 2 * n, SIZE)?;
    let [mu, lambda] = lame(YOUNG, POISSON);
    let rest = mesh.nodes();
    let planes = rest.iter().enumerate();
    let planes = planes.flat_map(|(n, p)| (0..3).filter(|&a| p[a] == 0.0).map(move |a| (n, a)));
    let dofs = Dofs::new(rest, &[], &planes.collect::<Vec<_>>())?;
    let fiber = |element| Fiber {
        element,
        control: 0,
        direction: [0.0, 0.0, 1.0],
        max_isometric_stress: STRENGTH,
        optimal_stretch: 1.0,
    };
    let fibers: Vec<Fiber> = (0..mesh.num_elements()).map(fiber).collect();
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs)?.material(NeoHookean { mu, lambda })?;
    Ok(Body {
        assembly: builder.fibers(law, 1, &fibers)?.build()?,
        start: rest.to_vec(),
        controls: vec![ACTIVATION],
    })
}

fn exact(body: &Body) -> Vec<[f64; 3]> {
    let [l, t] = stretches();
    let rest = body.assembly.rest().iter();
    rest.map(|&[x, y, z]| [t * x, t * y, l * z]).collect()
}

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let sizes = settings.sizes(&[2, 4, 8], &[4, 8, 16]);
    let mut meshes = Curve::new("linear, to 1e-10", Axis::Mesh, Claim::AtMost(1e-9)).undrawn();
    for &n in &sizes {
        let body = block(n)?;
        let solved = body.timed(settings.repetitions, AUTO, &to(1e-10))?;
        let error = apart(&solved.value.positions, &exact(&body));
        let setting = format!("n = {n}");
        meshes.points.push(body.point(setting, &solved, error));
    }
    let n = *sizes.last().unwrap_or(&4);
    let body = block(n)?;
    let exact = exact(&body);
    let name = format!("linear, n = {n}, by itself");
    let mut tolerances = Curve::new(name, Axis::Tolerance, Claim::PerTolerance(0.1, 1e-11));
    for tolerance in [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        let solved = body.timed(settings.repetitions, AUTO, &to(tolerance))?;
        let error = apart(&solved.value.positions, &exact);
        let setting = format!("{tolerance:.0e}");
        tolerances.points.push(body.point(setting, &solved, error));
    }
    let name = format!("linear, n = {n}, to 1e-8");
    let mut solvers = Curve::new(name, Axis::Solver, Claim::AtMost(1e-7));
    for (name, linear) in LINEAR {
        let solved = body.timed(settings.repetitions, linear, &to(1e-8))?;
        let error = apart(&solved.value.positions, &exact);
        solvers.points.push(body.point(name, &solved, error));
    }
    Ok(vec![meshes, tolerances, solvers])
}
