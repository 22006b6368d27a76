//! Inertia as a term of one's own: implicit Euler minimizes E(x) + Σ m/(2h²) |x − x̂|², with x̂ where a
//! node would be by its velocity alone. A free block falls as the method's closed form says.
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Configuration, Dofs, EnergySink, GradientSink, HessianSink};
use fem_assembly::{Gravity, Quasistatic, Stencils, Term};
use fem_materials::{HessianProjection, NeoHookean};
use fem_solvers::NewtonParams;
use promise::Newton;
use std::ops::Range;
use std::sync::{Arc, RwLock};

#[path = "../tests/all/promise.rs"]
mod promise;

const STEP: f64 = 0.01; // h, seconds
const DENSITY: f64 = 1000.0;

/// Mass of each node, kg, and x̂, which the loop below moves on.
struct Inertia(Vec<f64>, Arc<RwLock<Vec<[f64; 3]>>>);

impl Inertia {
    /// m/h² (x − x̂), newtons, of the nodes that can be read.
    fn forces(&self, at: Configuration<3>, nodes: Range<usize>) -> Vec<[f64; 3]> {
        let predicted = self.1.read().map(|p| p.clone()).unwrap_or_default();
        let force = |n: usize| {
            let (x, p, k) = (at.positions()[n], predicted[n], self.0[n] / (STEP * STEP));
            [0, 1, 2].map(|i| k * (x[i] - p[i]))
        };
        nodes.map(force).collect()
    }
}

#[rustfmt::skip]
impl Term<3> for Inertia {
    fn stencils(&self) -> Stencils { Stencils::new((0..self.0.len()).map(|n| [n])) }
    fn energy(&self, at: Configuration<3>, nodes: Range<usize>, sink: &mut EnergySink) {
        for (n, f) in nodes.clone().zip(self.forces(at, nodes)) {
            let squared: f64 = f.iter().map(|f| f * f).sum();
            sink.energy(n, 0.5 * squared * STEP * STEP / self.0[n]);
        }
    }
    fn gradient(&self, at: Configuration<3>, nodes: Range<usize>, sink: &mut GradientSink<3>) {
        for (n, f) in nodes.clone().zip(self.forces(at, nodes)) {
            let squared: f64 = f.iter().map(|f| f * f).sum();
            sink.energy(n, 0.5 * squared * STEP * STEP / self.0[n]);
            sink.add(n, 0, f);
        }
    }
    fn hessian(&self, _: Configuration<3>, _: HessianProjection, nodes: Range<usize>, sink: &mut HessianSink<3>) {
        for n in nodes {
            let k = self.0[n] / (STEP * STEP);
            sink.add(n, 0, 0, [[k, 0.0, 0.0], [0.0, k, 0.0], [0.0, 0.0, k]]);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = kuhn_grid(2, 2, 2, [0.1; 3])?;
    let builder = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes())?)?;
    let mut masses = vec![0.0; mesh.num_nodes()];
    for (element, nodes) in mesh.elements().enumerate() {
        nodes
            .iter()
            .for_each(|&n| masses[n as usize] += DENSITY * mesh.volume(element) / 4.0);
    }
    let predicted = Arc::new(RwLock::new(mesh.nodes().to_vec()));
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let assembly = builder
        .material(flesh)?
        .term(Gravity::new(&mesh, DENSITY, [0.0, 0.0, -9.81])?)?
        .term(Inertia(masses, predicted.clone()))?
        .build()?;
    let (mut before, mut now) = (mesh.nodes().to_vec(), mesh.nodes().to_vec());
    let mut newton = Newton::new(&Quasistatic::new(&assembly, now.clone(), vec![])?);
    for step in 1..=20 {
        let coast = now
            .iter()
            .zip(&before)
            .map(|(x, b)| [0, 1, 2].map(|i| 2.0 * x[i] - b[i]));
        *predicted.write().map_err(|_| "a thread panicked")? = coast.collect();
        let problem = Quasistatic::new(&assembly, now.clone(), vec![])?;
        let mut x = problem.unknowns();
        newton.solve(&problem, &mut x, &NewtonParams::default())?;
        before = std::mem::replace(&mut now, problem.positions(&x)?);
        // z₀ − g h² n (n + 1)/2
        let fallen = 0.5 * 9.81 * STEP * STEP * f64::from(step * (step + 1));
        let off = now
            .iter()
            .zip(mesh.nodes())
            .map(|(x, r)| (x[2] - r[2] + fallen).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "step {step}");
    }
    Ok(())
}
