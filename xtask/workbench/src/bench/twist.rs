//! The twisted bar: E = 100 kPa, ν = 0.45, turned by 60° and stretched by a tenth.

use crate::report::Style;
use crate::scenes::{SceneError, apart, twist_bar};
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::NeoHookean;
use fem_solvers::{Newton, NewtonInfo, NewtonParams};
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
        right &= report(n, &options.tolerances, style)?;
    }
    Ok(right)
}

/// One solve to a tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Relative tolerance of the gradient.
    pub tolerance: f64,
    /// Seconds.
    pub seconds: f64,
    /// Newton steps.
    pub steps: usize,
    /// Largest distance of a node from the solution to 1e-12, meters.
    pub apart: f64,
    /// Error of the energy, relative to that of the solution to 1e-12.
    pub energy_error: f64,
}

/// What was measured on one bar.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Elements.
    pub tets: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Seconds for the mesh and the assembly.
    pub setup: f64,
    /// Seconds for the solve to 1e-12.
    pub seconds: f64,
    /// That solve.
    pub info: NewtonInfo,
    /// Time against error.
    pub rows: Vec<Row>,
}

/// Builds and solves the bar of n×n×4n cubes.
///
/// # Errors
/// If a solve fails.
pub fn measure(n: usize, tolerances: &[f64]) -> Result<Measured, SceneError> {
    let (E, nu) = (1e5, 0.45);
    let flesh = NeoHookean {
        mu: E / (2.0 * (1.0 + nu)),
        lambda: E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
    };
    let begin = Instant::now();
    let bar = twist_bar(n, 4, 60.0, 4.4)?;
    let dofs = Dofs::with_prescribed_nodes(bar.mesh.nodes(), &bar.prescribed)?;
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
    let row = |&tolerance: &f64| {
        let (x, run, seconds) = solve(tolerance)?;
        Ok(Row {
            tolerance,
            seconds,
            steps: run.iterations,
            apart: apart(&x, &exact),
            energy_error: (run.energy - info.energy).abs() / info.energy,
        })
    };
    Ok(Measured {
        tets: bar.mesh.num_elements(),
        unknowns,
        setup,
        seconds,
        info,
        rows: tolerances
            .iter()
            .map(row)
            .collect::<Result<_, SceneError>>()?,
    })
}

fn report(n: usize, tolerances: &[f64], style: Style) -> Result<bool, SceneError> {
    let bar = measure(n, tolerances)?;
    let title = format!("n = {n}: {} tets, {} unknowns", bar.tets, bar.unknowns);
    println!("{}", style.bold(&title));
    println!(
        "  setup {:.3} s, solve to 1e-12 {:.3} s, {} steps, {} factorizations, \
         {} linear iterations, peak memory {}",
        bar.setup,
        bar.seconds,
        bar.info.iterations,
        bar.info.factorizations,
        bar.info.linear_iterations,
        peak_memory().map_or("unknown".to_owned(), |mib| format!("{mib:.0} MiB")),
    );
    let energy = bar.info.energy;
    let known = ENERGIES.iter().find(|(m, _)| *m == n);
    let right = known.is_none_or(|(_, e)| (energy - e).abs() <= 1e-11 * e);
    let verdict = match (known, right) {
        (None, _) => "no known value".to_owned(),
        (Some(_), true) => style.green("as known"),
        (Some((_, e)), false) => style.red(&format!("WRONG, should be {e}")),
    };
    println!("  energy {energy:.14} ({verdict})");
    println!("  tolerance   seconds  steps  |x - x*|, m   relative error of the energy");
    for row in &bar.rows {
        println!(
            "  {:>9.0e}  {:>8.3}  {:>5}  {:>11.1e}   {:.1e}",
            row.tolerance, row.seconds, row.steps, row.apart, row.energy_error,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tighter_tolerance_never_costs_accuracy() {
        let bar = measure(3, &[1e-1, 1e-4, 1e-10]).expect("a bar that can be solved");
        assert_eq!((bar.tets, bar.unknowns), (648, 3 * 16 * 11));
        let errors: Vec<f64> = bar.rows.iter().map(|r| r.apart).collect();
        assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
        assert!(errors[2] < 1e-9 && bar.rows[2].energy_error < 1e-14);
        // At a minimum the energy's error is the square of the shape's.
        let share = |r: &Row| r.energy_error / r.apart.powi(2);
        assert!(share(&bar.rows[0]) < 1e3 && bar.rows[0].energy_error > 0.0);
    }
}
