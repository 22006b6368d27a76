//! Curves are right: errors fall along their axis, closed forms hold. No test looks at a time.
//!
//! What is not run here: faces, their derivatives, and cracks take too long without optimization.

use bench::scenes::{Scene, all};
use bench::{Axis, Curve, Settings};

fn scene(name: &str) -> Scene {
    let found = all().into_iter().find(|scene| scene.name == name);
    found.unwrap_or_else(|| panic!("no scene {name}"))
}

/// The curves of a small run with all that a large one has, whose claims hold.
fn curves(name: &str, sizes: &[usize]) -> Vec<Curve> {
    let settings = Settings {
        large: true,
        sizes: Some(sizes.to_vec()),
        ..Settings::smallest()
    };
    let curves = (scene(name).run)(&settings).unwrap_or_else(|e| panic!("{name}: {e}"));
    for curve in &curves {
        let broken = curve.broken();
        assert!(broken.is_none(), "{name}, {}: {broken:?}", curve.name);
        assert!(
            !curve.points.is_empty(),
            "{name}, {}: no points",
            curve.name
        );
    }
    curves
}

fn errors(curves: &[Curve], name: &str) -> Vec<f64> {
    let found = curves.iter().find(|c| c.name == name);
    let curve = found.unwrap_or_else(|| panic!("no curve {name}"));
    curve.points.iter().map(|p| p.error).collect()
}

/// The bars of a large run, and the linear curve that every run has.
fn by_multigrid_as_well(curves: &[Curve], linear: &[f64]) {
    for solver in ["multigrid f32 in f64", "by itself (auto)"] {
        let found = errors(curves, &format!("linear, nu = 0.45, to 1e-8, {solver}"));
        let same = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
        assert!(found.iter().zip(linear).all(same), "{found:?} {linear:?}");
    }
    errors(curves, "linear, nu = 0.49, to 1e-8, multigrid f32 in f64");
}

#[test]
fn names_are_different_and_every_scene_has_a_truth() {
    let all = all();
    for (k, scene) in all.iter().enumerate() {
        assert!(!scene.truth.is_empty() && !scene.measure.is_empty());
        assert!(all[..k].iter().all(|other| other.name != scene.name));
    }
    let uncounted = all.iter().filter(|scene| scene.counted.is_none());
    let uncounted: Vec<_> = uncounted.map(|scene| scene.name).collect();
    assert_eq!(uncounted, ["head-medium"]);
}

#[test]
fn a_twisted_bar_comes_nearer_with_every_mesh_tolerance_and_element() {
    let curves = curves("twist", &[1, 2]);
    let linear = errors(&curves, "linear, nu = 0.45");
    let quadratic = errors(&curves, "quadratic, nu = 0.45");
    assert!(quadratic[1] < 0.3 * linear[1], "{linear:?} {quadratic:?}");
    by_multigrid_as_well(&curves, &linear);
    let tolerances = errors(&curves, "linear, n = 2, by itself");
    assert!(
        tolerances[0] > 1e-5 && tolerances[6] < 1e-9,
        "{tolerances:?}"
    );
    let axes = [
        Axis::Mesh,
        Axis::Tolerance,
        Axis::Solver,
        Axis::Threads,
        Axis::Model,
        Axis::Projection,
    ];
    for axis in axes {
        assert!(curves.iter().any(|c| c.axis == axis), "{axis:?}");
    }
}

#[test]
fn a_bent_bar_comes_nearer_with_every_mesh_and_element() {
    let curves = curves("bend", &[1, 2]);
    let linear = errors(&curves, "linear, nu = 0.45");
    let quadratic = errors(&curves, "quadratic, nu = 0.45");
    assert!(quadratic[1] < 0.1 * linear[1], "{linear:?} {quadratic:?}");
    by_multigrid_as_well(&curves, &linear);
    // Far stiffer than it is, where volumes are kept element by element.
    let locked = errors(&curves, "linear, nu = 0.499");
    let free = errors(&curves, "averaged volume, nu = 0.499");
    assert!(free[1] < 0.5 * locked[1], "{locked:?} {free:?}");
}

#[test]
fn averaged_volumes_unlock_the_block() {
    let block = curves("spp-block", &[4]);
    let (locked, free) = (errors(&block, "linear"), errors(&block, "averaged volume"));
    assert!(free[0] < 0.5 * locked[0], "{locked:?} {free:?}");
}

/// Order 2 in h, on coarse meshes nearly.
#[test]
fn a_blown_up_sphere_converges_to_its_differential_equation() {
    let curves = curves("sphere", &[2, 4]);
    let found = errors(&curves, "linear, nu = 0.3");
    let order = (found[0] / found[1]).log2();
    assert!((1.2..2.6).contains(&order), "{found:?}, order {order}");
    let locked = errors(&curves, "linear, nu = 0.4999");
    let free = errors(&curves, "averaged volume, nu = 0.4999");
    assert!(free[1] < 0.5 * locked[1], "{locked:?} {free:?}");
}

#[test]
fn a_muscle_shortens_as_its_two_stretches_say() {
    let curves = curves("muscle", &[1, 3]);
    assert!(
        errors(&curves, "linear, to 1e-10")
            .iter()
            .all(|e| *e < 1e-10)
    );
}

#[test]
fn a_ball_needs_less_force_on_a_finer_half_space() {
    let found = errors(&curves("hertz", &[5, 8]), "linear");
    assert!(found[1] < 0.8 * found[0], "{found:?}");
}

#[test]
fn a_swinging_block_keeps_more_energy_on_a_finer_grid_and_its_momentum_on_any() {
    let curves = curves("mpm", &[8, 16]);
    let energy = errors(&curves, "energy, f64");
    assert!(energy[1] < 0.4 * energy[0], "{energy:?}");
    assert!(errors(&curves, "momentum, f64").iter().all(|e| *e < 1e-12));
}
