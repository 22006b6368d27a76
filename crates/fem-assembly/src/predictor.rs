//! Where the flesh goes, to first order, when prescribed coordinates move.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use fem_materials::HessianProjection;
use fem_solvers::{BlockPattern, BlockSymmetric, Newton, NewtonParams, NonlinearProblem};
use std::sync::Arc;

/// ½ dᵀ K d + dᵀ (g + K_c c): the energy to second order around a state, with displacements d of the
/// free and c of the prescribed nodes. Its minimum is Newton's step and the tangent of the path in one.
struct Linearized<'a, const D: usize> {
    assembly: &'a Assembly<D>,
    at: Configuration<'a, D>,
    /// g + K_c c.
    load: Vec<f64>,
}

impl<const D: usize> Linearized<'_, D> {
    fn product(&self, d: &[f64]) -> Vec<f64> {
        let mut moved = vec![[0.0; D]; self.at.positions().len()];
        self.assembly.dofs().scatter(d, &mut moved);
        let mut product = vec![0.0; d.len()];
        self.assembly.hessian_vector(self.at, &moved, &mut product);
        product
    }
}

impl<const D: usize> NonlinearProblem<D> for Linearized<'_, D> {
    fn blocks(&self) -> usize {
        self.assembly.dofs().free_nodes()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.assembly.pattern().clone())
    }
    fn energy(&self, d: &[f64]) -> f64 {
        let product = self.product(d);
        let terms = d.iter().zip(product.iter().zip(&self.load));
        terms.map(|(d, (k, f))| d * (0.5 * k + f)).sum()
    }
    fn gradient(&self, d: &[f64], g: &mut [f64]) {
        let product = self.product(d);
        let sums = product.iter().zip(&self.load).map(|(k, f)| k + f);
        g.iter_mut().zip(sums).for_each(|(g, sum)| *g = sum);
    }
    fn hessian(&self, _: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<D>) {
        self.assembly.hessian(self.at, projection, out);
    }
    fn coordinates(&self) -> Option<Vec<[f64; D]>> {
        let rest = self.assembly.rest();
        let rows = self.assembly.dofs().node_of_row().iter();
        Some(rows.map(|&n| rest[n as usize]).collect())
    }
}

/// The state whose prescribed coordinates are those of `goal`, its free ones moved along the tangent
/// of the state `at`; `None` where the tangent does not exist or no share of it has a lower energy
/// than free nodes that stay.
pub(crate) fn predicted<const D: usize>(
    assembly: &Assembly<D>,
    newton: &mut Newton<'_, D>,
    at: Configuration<'_, D>,
    goal: &[[f64; D]],
    params: &NewtonParams,
) -> Option<Vec<[f64; D]>> {
    let moved: Vec<[f64; D]> = goal
        .iter()
        .zip(at.positions())
        .map(|(to, from)| std::array::from_fn(|k| to[k] - from[k]))
        .collect();
    if moved.iter().flatten().all(|d| *d == 0.0) {
        return None;
    }
    let mut load = vec![0.0; assembly.dofs().unknowns()];
    assembly.hessian_vector(at, &moved, &mut load);
    let mut forces = vec![0.0; load.len()];
    assembly.gradient(at, &mut forces);
    load.iter_mut().zip(forces).for_each(|(l, f)| *l += f);
    let problem = Linearized { assembly, at, load };
    let mut d = vec![0.0; problem.load.len()];
    let params = NewtonParams {
        relative_gradient_tolerance: ENOUGH,
        gradient_tolerance: 0.0,
        max_iterations: 3,
        ..*params
    };
    newton.solve(&problem, &mut d, &params).ok()?;
    let mut guess = goal.to_vec();
    let mut free = vec![[0.0; D]; guess.len()];
    assembly.dofs().scatter(&d, &mut free);
    for (x, d) in guess.iter_mut().zip(free) {
        (0..D).for_each(|k| x[k] += d[k]);
    }
    let energy = |x: &[[f64; D]]| assembly.free_energy(Configuration::trusted(x, at.controls()));
    (energy(&guess) < energy(goal)).then_some(guess)
}

/// Share of the load that a guess may leave.
const ENOUGH: f64 = 1e-3;
