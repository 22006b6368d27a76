//! dx/dθ of the built-in face, a smile with the jaw opened by 8°: by a factor and by multigrid.
//!
//! `cargo run --release -p face-scenes --example derivatives -- 20000 100000` prints seconds, iterations
//! and how far columns are from those of the factor, in parts of each column's largest entry.
//! `without-factor` leaves the factor out, `without-columns` all but one gradient.

use face_rig::rig::{Direction, MultigridUse, Parameters, Rig, RigParams, Sensitivity};
use face_scenes::{Scene, parse_activations};
use fem_solvers::SymbolicCholesky;
use std::time::Instant;

fn seconds<R>(f: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = f();
    (result, start.elapsed().as_secs_f64())
}

fn pose(scene: &Scene) -> Parameters {
    let mut pose = scene.rest_pose();
    let pulled = ["zygomaticus_major=0.6"].into_iter();
    pose.activations = parse_activations(&scene.muscles, pulled).expect("a muscle of the face");
    let (jaw, _) = scene.joint.motion([8_f64.to_radians(), 0.0, 0.0, 0.0]);
    pose.jaw = jaw;
    pose
}

fn rig(scene: &Scene, multigrid: MultigridUse, derivative_tolerance: f64) -> Rig {
    let params = RigParams {
        multigrid,
        derivative_tolerance,
        ..RigParams::default()
    };
    scene.rig(params).expect("a rig")
}

type Columns = Vec<Vec<[f64; 3]>>;

/// One number's gradient, and all columns, with what they took.
fn derivatives(name: &str, rig: &mut Rig, all: &[Direction], columns: bool) -> Columns {
    let (made, setup) = seconds(|| rig.sensitivity().map(|_| ()));
    made.expect("a stable pose");
    let mut taken = |solve: &mut dyn FnMut(&Sensitivity<'_>)| {
        let before = rig.work().linear_iterations;
        let derivative = rig.sensitivity().expect("it is made");
        let (_, time) = seconds(|| solve(&derivative));
        (time, rig.work().linear_iterations - before)
    };
    let one = taken(&mut |derivative| {
        let mut loss = vec![[0.0; 3]; derivative.positions().len()];
        loss.iter_mut()
            .step_by(97)
            .for_each(|l| *l = [0.0, 1.0, 0.0]);
        derivative.gradient(&loss, all).expect("a gradient");
    });
    let mut found = Columns::new();
    let many = taken(&mut |derivative| {
        if columns {
            found = derivative.columns(all).expect("columns");
        }
    });
    println!(
        "  {name}: made in {setup:.2} s; a gradient {:.2} s, {} iterations; {} columns {:.2} s, {} iterations",
        one.0,
        one.1,
        found.len(),
        many.0,
        many.1
    );
    found
}

/// The largest difference of a column in parts of its largest entry.
fn off(found: &Columns, exact: &Columns) -> f64 {
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, v| m.max(v.abs()));
    let of = |(a, b): (&Vec<[f64; 3]>, &Vec<[f64; 3]>)| {
        let (a, b) = (a.as_flattened(), b.as_flattened());
        let difference = largest(&mut a.iter().zip(b).map(|(a, b)| a - b));
        difference / largest(&mut b.iter().copied())
    };
    found.iter().zip(exact).map(of).fold(0.0, f64::max)
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let says = |word: &str| words.iter().any(|w| w == word);
    for tets in words.iter().filter_map(|word| word.parse().ok()) {
        let scene = Scene::builtin(tets).expect("a face");
        let mut solved = rig(&scene, MultigridUse::WhereCheaper, 1e-10);
        let (_, time) = seconds(|| solved.solve(&pose(&scene)).map(|_| ()).expect("a pose"));
        let pattern = solved.assembly().pattern();
        let symbolic = SymbolicCholesky::<3>::new(pattern);
        println!(
            "{tets} tetrahedra: {} rows of blocks, a factor of {:.1} GF and {:.1} M numbers; equilibrium {time:.2} s",
            pattern.blocks(),
            symbolic.flops() / 1e9,
            symbolic.fill() as f64 / 1e6
        );
        let at = solved.equilibrium().clone();
        drop(solved);
        let all: Vec<Direction> = Direction::all(scene.muscles.len())
            .into_iter()
            .filter(|direction| !matches!(direction, Direction::Cranium(_)))
            .collect();
        let columns = !says("without-columns");
        let at_pose = |multigrid, tolerance| {
            let mut rig = rig(&scene, multigrid, tolerance);
            rig.start_from(at.clone()).expect("its own pose");
            rig
        };
        let exact = (!says("without-factor")).then(|| {
            let mut rig = at_pose(MultigridUse::Never, 0.0);
            derivatives("factor", &mut rig, &all, columns)
        });
        for tolerance in [1e-6, 1e-8, 1e-10] {
            let mut rig = at_pose(MultigridUse::Always, tolerance);
            let name = format!("multigrid to {tolerance:e}");
            let found = derivatives(&name, &mut rig, &all, columns);
            if let Some(exact) = &exact {
                println!("    off by {:.1e}", off(&found, exact));
            }
        }
    }
}
