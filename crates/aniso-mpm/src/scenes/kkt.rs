use super::Deviation;
use super::read::{Report, list, number, numbers, of_length, relative};
use crate::float::worse;
use crate::kkt::{ConstrainedProblem, Constraints, Kkt};
use serde_json::Value;

/// E = xᵀHx/2 − g·x + κ/4 Σ x_i⁴ with c = G x − h₀.
struct Quartic {
    H: Vec<f64>,
    g: Vec<f64>,
    kappa: f64,
    G: Vec<f64>,
    h0: Vec<f64>,
}

fn multiply(m: &[f64], x: &[f64], y: &mut [f64]) {
    for (y, row) in y.iter_mut().zip(m.chunks(x.len())) {
        *y = row.iter().zip(x).map(|(m, x)| m * x).sum();
    }
}

impl ConstrainedProblem for Quartic {
    fn unknowns(&self) -> usize {
        self.g.len()
    }
    fn constraints(&self) -> usize {
        self.h0.len()
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let mut Hx = vec![0.0; x.len()];
        multiply(&self.H, x, &mut Hx);
        (0..x.len())
            .map(|i| (0.5 * Hx[i] - self.g[i]) * x[i] + 0.25 * self.kappa * x[i].powi(4))
            .sum()
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        multiply(&self.H, x, g);
        for i in 0..x.len() {
            g[i] += self.kappa * x[i].powi(3) - self.g[i];
        }
    }
    fn hessian(&self, x: &[f64], d: &[f64], y: &mut [f64]) {
        multiply(&self.H, d, y);
        for i in 0..x.len() {
            y[i] += 3.0 * self.kappa * x[i] * x[i] * d[i];
        }
    }
    fn diagonal(&self, x: &[f64], stiffness: f64, diagonal: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            let squares: f64 = self.G.chunks(n).map(|row| row[i] * row[i]).sum();
            diagonal[i] = self.H[i * n + i] + 3.0 * self.kappa * x[i] * x[i] + stiffness * squares;
        }
    }
    fn constraint(&self, x: &[f64], c: &mut [f64]) {
        multiply(&self.G, x, c);
        for (c, h) in c.iter_mut().zip(&self.h0) {
            *c -= h;
        }
    }
    fn jacobian(&self, d: &[f64], y: &mut [f64]) {
        multiply(&self.G, d, y);
    }
    fn jacobian_transpose(&self, lambda: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (row, l) in self.G.chunks(y.len()).zip(lambda) {
            for (y, g) in y.iter_mut().zip(row) {
                *y += l * g;
            }
        }
    }
}

pub fn compare(file: &Value) -> Result<Vec<Deviation>, String> {
    let problem = Quartic {
        H: numbers(file, "H")?,
        g: numbers(file, "g")?,
        kappa: number(file, "kappa")?,
        G: numbers(file, "G")?,
        h0: numbers(file, "h0")?,
    };
    let (n, constraints) = (problem.g.len(), problem.h0.len());
    if n == 0 {
        return Err("`g` is empty".to_owned());
    }
    of_length("H", problem.H.len(), n * n)?;
    of_length("G", problem.G.len(), n * constraints)?;
    let exact = numbers(&file["exact"], "x")?;
    let mut report = Report {
        prefix: "relaxed".into(),
        deviations: Vec::new(),
    };
    let start = vec![0.0; problem.g.len()];
    let constrained = Kkt {
        constraints: Constraints::Exact,
        tolerance: 1e-10,
        max_iterations: 30,
    };
    let solution = constrained.solve(&problem, &start);
    let solution = solution.map_err(|e| e.to_string())?;
    report.prefix = "exact".into();
    report.push("x", relative(&solution.x, &exact), 1e-12);
    let lambda = numbers(&file["exact"], "lambda")?;
    report.push("lambda", relative(&solution.lambda, &lambda), 1e-12);
    for case in list(file, "relaxed")? {
        relaxed(&mut report, &problem, case, &exact)?;
    }
    Ok(report.deviations)
}

/// The constraints as a penalty of stiffness −η.
fn relaxed(
    report: &mut Report,
    problem: &Quartic,
    case: &Value,
    exact: &[f64],
) -> Result<(), String> {
    let eta = number(case, "eta")?;
    let solver = Kkt {
        constraints: Constraints::Relaxed { stiffness: -eta },
        tolerance: 1e-10,
        max_iterations: 30,
    };
    let n = problem.g.len();
    let solution = solver.solve(problem, &vec![0.0; n]);
    let solution = solution.map_err(|e| e.to_string())?;
    let (x, lambda) = (numbers(case, "x")?, numbers(case, "lambda")?);
    of_length("x", x.len(), n)?;
    report.prefix = format!("eta={eta:e}");
    report.push("x", relative(&solution.x, &x), 1e-9);
    report.push("lambda", relative(&solution.lambda, &lambda), 1e-8);
    // The file lists what each full Newton step started from; `x` is where the last one ended.
    let mut path = numbers(case, "x_iterates")?;
    path.extend(x);
    let mut ours = Vec::new();
    for x in path[..path.len() - n].chunks(n) {
        let step = solver.step(problem, x).map_err(|e| e.to_string())?;
        ours.extend(x.iter().zip(&step.dx).map(|(x, dx)| x + dx));
    }
    let error = relative(&ours, &path[n..]);
    report.push("Newton's steps, all of them", error, 1e-9);
    let apart = solution.x.iter().zip(exact).map(|(a, b)| (a - b).abs());
    let expected = number(&case["checks"], "distance_to_exact")?;
    let error = (apart.fold(0.0, worse) - expected).abs();
    report.push("distance to the constrained optimum", error, 1e-9);
    Ok(())
}
