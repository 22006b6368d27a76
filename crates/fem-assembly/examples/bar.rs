//! A bar of n × n × 4n cubes, twisted or bent, solved to 1e-8: seconds, steps and memory of a solver.
//!
//! `cargo run --release -p fem-assembly --example bar -- [n] [auto|multigrid|direct] [ν] [twist|bend]`

use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::{Lame, NeoHookean, Space};
use fem_solvers::{LinearSolver, MultigridDirection, MultigridParams, Newton, NewtonParams};
use std::error::Error;
use std::time::Instant;

/// Meters; the width is 1 m.
const LENGTH: f64 = 4.0;
/// Pascals.
const YOUNG: f64 = 1e5;

/// The upper end turned by 60° and lifted by a tenth, or pushed aside by 30 % of the length.
fn place(twist: bool, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let share = z / LENGTH;
    if !twist {
        return [x + 0.3 * LENGTH * share * share, y, z];
    }
    let (sin, cos) = (60.0 * share).to_radians().sin_cos();
    let (x, y) = (x - 0.5, y - 0.5);
    [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y, 1.1 * z]
}

/// Twisted, both ends are prescribed; bent, the upper one is free to sink and to turn.
fn dofs(twist: bool, nodes: &[[f64; 3]]) -> Result<Dofs<3>, Box<dyn Error>> {
    let at = |z: f64| (0..nodes.len()).filter(move |&n| nodes[n][2] == z);
    if twist {
        let ends: Vec<usize> = at(0.0).chain(at(LENGTH)).collect();
        return Ok(Dofs::with_prescribed_nodes(nodes, &ends)?);
    }
    let below: Vec<usize> = at(0.0).collect();
    let pushed: Vec<(usize, usize)> = at(LENGTH).map(|n| (n, 0)).collect();
    Ok(Dofs::new(nodes, &below, &pushed)?)
}

/// The most memory that was in use, as Linux tells it.
fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.map_or("unknown".into(), |l| l.trim().into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize, default: &str| words.get(k).map_or(default.to_string(), String::clone);
    let n: usize = word(0, "16").parse()?;
    let (solver, load) = (word(1, "auto"), word(3, "twist"));
    let (poisson, twist): (f64, bool) = (word(2, "0.45").parse()?, load == "twist");
    let mesh = kuhn_grid(n, n, 4 * n, [1.0, 1.0, LENGTH])?;
    let Lame { mu, lambda } = Lame::from_young_poisson(YOUNG, poisson, Space::Solid)?;
    let flesh = NeoHookean { mu, lambda };
    let builder = AssemblyBuilder::new(&mesh, dofs(twist, mesh.nodes())?)?;
    let body = builder.material(flesh)?.build()?;
    let begin = Instant::now();
    let start = mesh.nodes().iter().map(|&p| place(twist, p)).collect();
    let problem = Quasistatic::new(&body, start, vec![])?;
    let mut newton = Newton::new(&problem);
    let mut params = NewtonParams {
        relative_gradient_tolerance: 1e-8,
        ..NewtonParams::default()
    };
    match solver.as_str() {
        "auto" => {}
        "direct" => params.linear_solver = LinearSolver::Direct,
        "multigrid" => {
            let multigrid = MultigridDirection::<3, 6>::new(MultigridParams::default());
            newton = newton.directed_by(multigrid);
        }
        other => return Err(format!("no solver {other}: auto, direct or multigrid").into()),
    }
    let mut x = problem.unknowns();
    let info = newton.solve(&problem, &mut x, &params)?;
    println!(
        "{load} n = {n}, nu = {poisson}, {solver}: {} tets, {} s, {} steps, {} factorizations, {} iterations, energy {:.9} J, {}",
        mesh.num_elements(),
        (begin.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        info.iterations,
        info.factorizations,
        info.linear_iterations,
        info.energy,
        peak(),
    );
    Ok(())
}
