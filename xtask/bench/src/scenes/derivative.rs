//! dx/dθ of the built-in face: exact columns and adjoints against differences of equilibria.

use super::Scene;
use super::faces::{came_to_rest, posed, rig_to};
use crate::curve::{Axis, Claim, Curve, Point};
use crate::failure::Failure;
use crate::settings::Settings;
use crate::timing::{Timed, fastest, fastest_with};
use face_rig::anatomy::EmbeddedPoint;
use face_rig::rig::{
    AffineMap, Direction, EmbeddedPoints, JacobianRoute, Parameters, Rig, RigParams, Work,
};
use face_scenes::Scene as Face;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "dx-dtheta",
    about: "derivatives of the built-in face's shape by its parameters",
    measure: "of the column",
    truth: "central differences of equilibria to 1e-12, steps of 1e-5: about 1e-7 left; routes: one another",
    run: curves,
    counted: Some(counted),
};

/// Muscles by which is differentiated, and the first columns of the jaw's motion.
const MUSCLES: usize = 4;

/// Of the differences that are taken for true. The curves of muscles are continuous with one
/// derivative only: there is no gain in higher orders, and longer steps meet their kinks.
const TRUE_STEP: f64 = 1e-5;

fn directions() -> Vec<Direction> {
    (0..MUSCLES).map(Direction::Activation).collect()
}

fn moved(pose: &Parameters, muscle: usize, by: f64) -> Parameters {
    let mut moved = pose.clone();
    moved.activations[muscle] += by;
    moved
}

/// A sum of shapes around a pose, each a step of one muscle: differences of any order.
fn difference(
    rig: &mut Rig,
    pose: &Parameters,
    muscle: usize,
    weights: &[(f64, f64)],
) -> Result<Vec<[f64; 3]>, Failure> {
    let mut sum = vec![[0.0; 3]; rig.equilibrium().in_cranium_frame.len()];
    for &(step, weight) in weights {
        let shape = rig.solve(&moved(pose, muscle, step))?.positions();
        for (s, x) in sum.iter_mut().zip(shape) {
            (0..3).for_each(|k| s[k] += weight * x[k]);
        }
    }
    Ok(sum)
}

type Columns = Vec<Vec<[f64; 3]>>;

/// The largest difference of entries over the largest entry, of all columns.
fn off(found: &Columns, exact: &Columns) -> f64 {
    let one = |(a, b): (&Vec<[f64; 3]>, &Vec<[f64; 3]>)| {
        let (a, b) = (a.as_flattened(), b.as_flattened());
        let size = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, workbench::numbers::worse) / size
    };
    let all = found.iter().zip(exact).map(one);
    all.fold(0.0, workbench::numbers::worse)
}

fn counted() -> Result<(), Failure> {
    let face = Face::builtin(2_000)?;
    let mut rig = face.rig(rig_to(1e-9))?;
    rig.solve(&posed(&face)?)?;
    rig.sensitivity()?.columns(&directions())?;
    Ok(())
}

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let face = Face::builtin(settings.pick(4_000, 20_000))?;
    let pose = posed(&face)?;
    let mut rig = face.rig(rig_to(1e-12))?;
    let weights = [(-TRUE_STEP, -0.5 / TRUE_STEP), (TRUE_STEP, 0.5 / TRUE_STEP)];
    let z = rig.solve(&pose)?.in_cranium_frame.clone();
    came_to_rest(&face, &pose, z, &rig_to(1e-12))?;
    let columns = (0..MUSCLES).map(|m| difference(&mut rig, &pose, m, &weights));
    let exact: Columns = columns.collect::<Result<_, Failure>>()?;
    Ok(vec![
        tolerances(&face, &pose, &exact, settings)?,
        steps(&face, &pose, &exact, settings)?,
        routes(&face, &pose, settings)?,
    ])
}

/// Exact columns at equilibria that are not exact: their solve is part of the time.
fn tolerances(
    face: &Face,
    pose: &Parameters,
    exact: &Columns,
    settings: &Settings,
) -> Result<Curve, Failure> {
    let name = "pose and exact columns of 4 muscles";
    let mut curve = Curve::new(name, Axis::Tolerance, Claim::PerTolerance(1.0, 1e-5));
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9] {
        let timed = fastest_with(
            settings.repetitions,
            || Ok(face.rig(rig_to(tolerance))?),
            |rig| {
                rig.solve(pose)?;
                let columns = rig.sensitivity()?.columns(&directions())?;
                Ok((columns, rig.work(), unknowns(rig)))
            },
        )?;
        curve
            .points
            .push(point(format!("{tolerance:.0e}"), &timed, exact));
    }
    Ok(curve)
}

/// Free coordinates of the face, those of its linear systems.
fn unknowns(rig: &Rig) -> usize {
    rig.assembly().dofs().unknowns()
}

/// Columns that took so long and so many steps, against the exact ones.
fn point(setting: String, timed: &Timed<(Columns, Work, usize)>, exact: &Columns) -> Point {
    let (columns, work, unknowns) = &timed.value;
    Point {
        setting,
        error: off(columns, exact),
        seconds: timed.seconds,
        unknowns: *unknowns,
        steps: work.newton_steps,
        factorizations: work.factorizations,
        iterations: work.linear_iterations,
        memory: timed.memory,
    }
}

/// Central differences with steps of several lengths, from the pose: two equilibria for a column.
fn steps(
    face: &Face,
    pose: &Parameters,
    exact: &Columns,
    settings: &Settings,
) -> Result<Curve, Failure> {
    let name = "pose and central differences by 4 muscles";
    let mut curve = Curve::new(name, Axis::Derivative, Claim::Nothing);
    for h in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8] {
        let weights = [(-h, -0.5 / h), (h, 0.5 / h)];
        let timed = fastest_with(
            settings.repetitions,
            || Ok(face.rig(RigParams::default())?),
            |rig| {
                rig.solve(pose)?;
                let columns = (0..MUSCLES).map(|m| difference(rig, pose, m, &weights));
                let columns = columns.collect::<Result<Columns, Failure>>()?;
                Ok((columns, rig.work(), unknowns(rig)))
            },
        )?;
        curve
            .points
            .push(point(format!("step {h:.0e}"), &timed, exact));
    }
    Ok(curve)
}

/// All muscles and the jaw, seen at ever more landmarks: by columns, and by adjoints.
fn routes(face: &Face, pose: &Parameters, settings: &Settings) -> Result<Curve, Failure> {
    let name = "Jacobian by all muscles and the jaw, pose and factor given";
    let mut curve = Curve::new(name, Axis::Route, Claim::AtMost(1e-9));
    let mut rig = face.rig(rig_to(1e-10))?;
    let z = rig.solve(pose)?.in_cranium_frame.clone();
    came_to_rest(face, pose, z, &rig_to(1e-10))?;
    let mut directions: Vec<Direction> = (0..rig.muscles()).map(Direction::Activation).collect();
    directions.extend((0..AffineMap::PARAMETERS).map(|k| Direction::Jaw(AffineMap::unit(k))));
    let unknowns = unknowns(&rig);
    let sensitivity = rig.sensitivity()?;
    for count in [1, 3, 10, 30] {
        let points: Vec<EmbeddedPoint> =
            face.landmarks.iter().take(count).map(|l| l.point).collect();
        let seen = EmbeddedPoints(points);
        let by = |route| sensitivity.jacobian(&seen, &directions, route);
        let exact = by(JacobianRoute::Columns)?;
        let size = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let routes = [
            ("columns", JacobianRoute::Columns),
            ("adjoint", JacobianRoute::Adjoint),
        ];
        for (name, route) in routes {
            let timed = fastest(settings.repetitions, || Ok(by(route)?))?;
            let apart = timed.value.iter().zip(&exact).map(|(a, b)| (a - b).abs());
            curve.points.push(Point {
                setting: format!("{name}, {count} points"),
                error: apart.fold(0.0, workbench::numbers::worse) / size,
                seconds: timed.seconds,
                unknowns,
                memory: timed.memory,
                ..Point::default()
            });
        }
    }
    Ok(curve)
}
