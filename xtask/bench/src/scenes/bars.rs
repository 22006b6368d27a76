//! Curves of the twisted and the bent bar: every axis that a body without a face has.

use super::Scene;
use super::bar::{Bar, Load, truth};
use super::elastic::Kind;
use crate::body::{AUTO, LINEAR, Linear, apart, to};
use crate::curve::{Axis, Claim, Curve};
use crate::failure::Failure;
use crate::settings::{Settings, on_threads};
use fem_solvers::{NewtonParams, ProjectionPolicy};

/// 60° and a tenth.
pub const TWIST: Scene = Scene {
    name: "twist",
    about: "a bar of n x n x 4n cubes, turned by 60 degrees and stretched by a tenth",
    measure: "apart, m",
    truth: "mesh curves: quadratic elements on the finest grid, at the corners of cubes of 1 m; others: \
            the same body to 1e-12; a bar is 1 m wide",
    run: |settings| curves(Load::Twist, settings),
    counted: Some(|| counted(Load::Twist)),
};

/// 30 % of its length.
pub const BEND: Scene = Scene {
    name: "bend",
    about: "the same bar clamped at one end, the other pushed aside by 30 % of the length",
    measure: "apart, m",
    truth: TWIST.truth,
    run: |settings| curves(Load::Bend, settings),
    counted: Some(|| counted(Load::Bend)),
};

/// What flesh is, where nothing else is said.
const POISSON: f64 = 0.45;

fn counted(load: Load) -> Result<(), Failure> {
    let bar = Bar::new(load, 4, Kind::Linear, POISSON)?;
    bar.body.solve_alone(AUTO, &to(1e-8)).map(|_| ())
}

fn curves(load: Load, settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let mut curves = Vec::new();
    let asked = settings.sizes.as_ref().and_then(|sizes| sizes.last());
    let reference = asked.map_or(settings.pick(6, 8), |n| n + 2);
    let truth = |poisson| truth(load, reference, poisson, AUTO);
    let flesh = truth(POISSON)?;
    if settings.large {
        for (solver, sizes) in [(LINEAR[5], &[16, 24][..]), (LINEAR[4], &[16, 24, 35])] {
            curves.push(large(load, POISSON, &flesh, (solver, sizes), settings)?);
        }
        let (stiff, by) = (truth(0.49)?, (LINEAR[4], &[16, 24, 35][..]));
        curves.push(large(load, 0.49, &stiff, by, settings)?);
    }
    for (poisson, exact) in [(POISSON, flesh), (0.499, truth(0.499)?)] {
        let kinds = Kind::ALL.into_iter();
        // Patches have another law: the same only where J is 1.
        for kind in kinds.filter(|&k| k != Kind::Patches || poisson > POISSON) {
            curves.push(meshes(load, kind, poisson, &exact, settings)?);
        }
    }
    if load == Load::Twist {
        let energies = energies(settings)?;
        curves.extend((!energies.points.is_empty()).then_some(energies));
    }
    let n = *settings.sizes(&[4, 8], &[8, 16]).last().unwrap_or(&8);
    let bar = Bar::new(load, n, Kind::Linear, POISSON)?;
    let exact = bar.body.solve(AUTO, &to(1e-12))?.positions;
    curves.push(tolerances(&bar, n, &exact, settings)?);
    curves.push(solvers(&bar, n, &exact, settings)?);
    curves.push(threads(&bar, n, &exact, settings)?);
    let small = settings.pick(4, 8).min(n);
    curves.push(models(load, small, settings)?);
    curves.push(projections(load, small, settings)?);
    Ok(curves)
}

fn meshes(
    load: Load,
    kind: Kind,
    poisson: f64,
    exact: &[[f64; 3]],
    settings: &Settings,
) -> Result<Curve, Failure> {
    let name = format!("{}, nu = {poisson}", kind.name());
    let mut curve = Curve::new(name, Axis::Mesh, Claim::FallsTo(0.0));
    let sizes = match kind {
        Kind::Linear => settings.sizes(&[2, 4, 8], &[2, 4, 8, 16]),
        Kind::Patches => settings.sizes(&[2, 4], &[2, 4, 8]),
        Kind::Quadratic => settings.sizes(&[2, 4], &[2, 4, 6]),
    };
    for n in sizes {
        let bar = Bar::new(load, n, kind, poisson)?;
        let solved = bar.body.timed(settings.repetitions, AUTO, &to(1e-8))?;
        let error = apart(&bar.probes(&solved.value.positions), exact);
        curve
            .points
            .push(bar.body.point(format!("n = {n}"), &solved, error));
    }
    Ok(curve)
}

/// Up to a million tetrahedra, where one factorization takes longer than a whole solve by multigrid.
fn large(
    load: Load,
    poisson: f64,
    exact: &[[f64; 3]],
    ((solver, linear), sizes): ((&str, Linear), &[usize]),
    settings: &Settings,
) -> Result<Curve, Failure> {
    let name = format!("linear, nu = {poisson}, to 1e-8, {solver}");
    let mut curve = Curve::new(name, Axis::Mesh, Claim::FallsTo(0.0)).undrawn();
    for n in settings.sizes(&[8, 16], sizes) {
        let bar = Bar::new(load, n, Kind::Linear, poisson)?;
        let solved = bar.body.timed(settings.repetitions, linear, &to(1e-8))?;
        let error = apart(&bar.probes(&solved.value.positions), exact);
        let point = bar.body.point(format!("n = {n}"), &solved, error);
        curve.points.push(point);
    }
    Ok(curve)
}

/// Energies at equilibrium, J, from a separate implementation.
const ENERGIES: [(usize, f64); 2] = [(8, 2693.99566058807), (16, 2629.14082144976)];

/// The same bar in another program: what is left is rounding.
fn energies(settings: &Settings) -> Result<Curve, Failure> {
    let name = "energy to 1e-12, against that of a separate implementation (relative)";
    let mut curve = Curve::new(name, Axis::Mesh, Claim::AtMost(1e-11)).undrawn();
    let sizes = settings.sizes(&[8], &[8, 16]);
    for (n, energy) in ENERGIES.into_iter().filter(|(n, _)| sizes.contains(n)) {
        let bar = Bar::new(Load::Twist, n, Kind::Linear, POISSON)?;
        let solved = bar.body.timed(settings.repetitions, AUTO, &to(1e-12))?;
        let error = (solved.value.info.energy / energy - 1.0).abs();
        curve
            .points
            .push(bar.body.point(format!("n = {n}"), &solved, error));
    }
    Ok(curve)
}

fn tolerances(
    bar: &Bar,
    n: usize,
    exact: &[[f64; 3]],
    settings: &Settings,
) -> Result<Curve, Failure> {
    let name = format!("linear, n = {n}, by itself");
    let mut curve = Curve::new(name, Axis::Tolerance, Claim::PerTolerance(10.0, 1e-9));
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10] {
        let solved = bar.body.timed(settings.repetitions, AUTO, &to(tolerance))?;
        let error = apart(&solved.value.positions, exact);
        let setting = format!("{tolerance:.0e}");
        curve.points.push(bar.body.point(setting, &solved, error));
    }
    Ok(curve)
}

fn solvers(bar: &Bar, n: usize, exact: &[[f64; 3]], settings: &Settings) -> Result<Curve, Failure> {
    let name = format!("linear, n = {n}, to 1e-8");
    let mut curve = Curve::new(name, Axis::Solver, Claim::AtMost(1e-6));
    for (name, linear) in LINEAR {
        let solved = bar.body.timed(settings.repetitions, linear, &to(1e-8))?;
        let error = apart(&solved.value.positions, exact);
        curve.points.push(bar.body.point(name, &solved, error));
    }
    Ok(curve)
}

fn threads(bar: &Bar, n: usize, exact: &[[f64; 3]], settings: &Settings) -> Result<Curve, Failure> {
    let name = format!("linear, n = {n}, to 1e-8, direct and multigrid");
    let mut curve = Curve::new(name, Axis::Threads, Claim::AtMost(1e-6));
    for (name, linear) in [LINEAR[0], LINEAR[4]] {
        for count in doubled_up_to(rayon::current_num_threads()) {
            let timed = || bar.body.timed(settings.repetitions, linear, &to(1e-8));
            let solved = on_threads(count, timed)?;
            let error = apart(&solved.value.positions, exact);
            let setting = format!("{name}, {count}");
            curve.points.push(bar.body.point(setting, &solved, error));
        }
    }
    Ok(curve)
}

/// 1, 2, 4, … below `all`, and `all`.
fn doubled_up_to(all: usize) -> Vec<usize> {
    let doubled = std::iter::successors(Some(1), |count| Some(2 * count));
    doubled
        .take_while(|&count| count < all)
        .chain([all])
        .collect()
}

/// Models that the constants determine and that a bar of them can be bent and twisted in one solve.
const MODELS: [&str; 5] = [
    "neo_hookean",
    "stable_neo_hookean",
    "corotated",
    "stvk",
    "linear",
];

fn models(load: Load, n: usize, settings: &Settings) -> Result<Curve, Failure> {
    let name = format!("linear, n = {n}, to 1e-8, each against its own solution");
    let mut curve = Curve::new(name, Axis::Model, Claim::AtMost(1e-6));
    for model in MODELS {
        let bar = Bar::of_model(load, n, model, POISSON)?;
        let blended = |tolerance| NewtonParams {
            projection: ProjectionPolicy::ExactThenBlended,
            ..to(tolerance)
        };
        let exact = bar.body.solve(AUTO, &blended(1e-12))?.positions;
        let solved = bar.body.timed(settings.repetitions, AUTO, &blended(1e-8))?;
        let error = apart(&solved.value.positions, &exact);
        curve.points.push(bar.body.point(model, &solved, error));
    }
    Ok(curve)
}

/// What is done about indefinite matrices, by name.
pub const PROJECTIONS: [(&str, ProjectionPolicy); 5] = [
    ("exact first", ProjectionPolicy::ExactFirst),
    ("exact, then absolute", ProjectionPolicy::ExactThenAbsolute),
    ("exact, then shifted", ProjectionPolicy::ExactThenShifted),
    ("exact, then blended", ProjectionPolicy::ExactThenBlended),
    ("always projected", ProjectionPolicy::AlwaysProjected),
];

fn projections(load: Load, n: usize, settings: &Settings) -> Result<Curve, Failure> {
    let name = format!("linear, n = {n}, to 1e-8, direct");
    let mut curve = Curve::new(name, Axis::Projection, Claim::AtMost(1e-6));
    let bar = Bar::new(load, n, Kind::Linear, POISSON)?;
    let exact = bar.body.solve(AUTO, &to(1e-12))?.positions;
    for (name, projection) in PROJECTIONS {
        let params = NewtonParams {
            projection,
            ..to(1e-8)
        };
        let direct: Linear = LINEAR[0].1;
        let solved = bar.body.timed(settings.repetitions, direct, &params)?;
        let error = apart(&solved.value.positions, &exact);
        curve.points.push(bar.body.point(name, &solved, error));
    }
    Ok(curve)
}
