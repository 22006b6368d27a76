//! The twisted bar: E = 100 kPa, ν = 0.45, turned by 60° and stretched by a tenth.

use crate::ledger::Style;
use crate::scenes::{SceneError, apart, twist_bar};
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::NeoHookean;
use fem_solvers::{Newton, NewtonParams};
use std::time::Instant;

/// Options of the benchmark.
#[derive(Clone, Debug, clap::Args)]
pub struct Twist {
    /// Cubes along the short side, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "8")]
    pub n: Vec<usize>,
    /// Threads; 0 takes all processors
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Relative tolerances of the gradient for the table of time against error
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1e-2,1e-4,1e-6,1e-8,1e-10"
    )]
    pub tolerances: Vec<f64>,
}

/// Energies at equilibrium, from a separate implementation.
const ENERGIES: [(usize, f64); 2] = [(8, 2693.99566058807), (16, 2629.14082144976)];

/// Runs it; false if an energy is not the known one.
///
/// # Errors
/// If a solve fails.
pub fn run(options: &Twist) -> Result<bool, SceneError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build();
    match pool {
        Ok(pool) => pool.install(|| all(options)),
        Err(_) => all(options),
    }
}

fn all(options: &Twist) -> Result<bool, SceneError> {
    let style = Style::of_stdout();
    println!("{} threads", rayon::current_num_threads());
    let mut right = true;
    for &n in &options.n {
        right &= bar(n, &options.tolerances, style)?;
    }
    Ok(right)
}

fn bar(n: usize, tolerances: &[f64], style: Style) -> Result<bool, SceneError> {
    let (E, nu) = (1e5, 0.45);
    let flesh = NeoHookean {
        mu: E / (2.0 * (1.0 + nu)),
        lambda: E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
    };
    let begin = Instant::now();
    let bar = twist_bar(n, 4, 60.0, 4.4)?;
    let dofs = Dofs::with_fixed_nodes(bar.mesh.nodes(), &bar.held)?;
    let unknowns = dofs.unknowns();
    let assembly = AssemblyBuilder::new(&bar.mesh, dofs)?
        .material(flesh)?
        .build()?;
    let problem = Quasistatic::new(&assembly, bar.start, vec![])?;
    let setup = begin.elapsed().as_secs_f64();
    let solve = |tolerance: f64| -> Result<_, SceneError> {
        let params = NewtonParams {
            relative_gradient_tolerance: tolerance,
            ..NewtonParams::default()
        };
        let begin = Instant::now();
        let mut x = problem.unknowns();
        let info = Newton::new(&problem).solve(&problem, &mut x, &params)?;
        Ok((problem.positions(&x), info, begin.elapsed().as_secs_f64()))
    };
    let (exact, info, seconds) = solve(1e-12)?;
    println!(
        "{}",
        style.bold(&format!(
            "n = {n}: {} tets, {unknowns} unknowns",
            bar.mesh.num_elements()
        ))
    );
    println!(
        "  setup {setup:.3} s, solve to 1e-12 {seconds:.3} s, {} steps, {} factorisations, \
         {} linear iterations, peak memory {}",
        info.iterations,
        info.factorizations,
        info.linear_iterations,
        peak_memory().map_or("unknown".to_owned(), |mib| format!("{mib:.0} MiB")),
    );
    let known = ENERGIES.iter().find(|(m, _)| *m == n);
    let right = known.is_none_or(|(_, e)| (info.energy - e).abs() <= 1e-11 * e);
    let verdict = match (known, right) {
        (None, _) => "no known value".to_owned(),
        (Some(_), true) => style.green("as known"),
        (Some((_, e)), false) => style.red(&format!("WRONG, should be {e}")),
    };
    println!("  energy {:.14} ({verdict})", info.energy);
    println!("  tolerance   seconds  steps  |x - x*|, m   relative error of the energy");
    for &tolerance in tolerances {
        let (x, run, seconds) = solve(tolerance)?;
        println!(
            "  {tolerance:>9.0e}  {seconds:>8.3}  {:>5}  {:>11.1e}   {:.1e}",
            run.iterations,
            apart(&x, &exact),
            (run.energy - info.energy).abs() / info.energy,
        );
    }
    Ok(right)
}

/// The most memory this process has held, MiB, where the system tells.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}
