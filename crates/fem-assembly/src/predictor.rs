//! Where the flesh goes, to first order, when prescribed coordinates move.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::quasistatic::Quasistatic;
use fem_solvers::{Newton, NewtonParams};

/// Share of the load that a guess may leave.
const ENOUGH: f64 = 1e-3;

/// The state whose prescribed coordinates are those of `goal` and whose free ones are those of the
/// state `at`, moved by K d = −(g + K_c c): Newton's step and the tangent of the path in one, with the
/// displacements c of the prescribed coordinates. `None` where that does not lower the energy.
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
    let mut load = vec![0.0; assembly.dofs().vector_len()];
    assembly.trusted_hessian_vector(at, &moved, &mut load);
    let mut forces = vec![0.0; load.len()];
    assembly.trusted_gradient(at, &mut forces);
    for (load, force) in load.iter_mut().zip(forces) {
        *load = -(*load + force);
    }
    let (positions, controls) = (at.positions().to_vec(), at.controls().to_vec());
    let problem = Quasistatic::new(assembly, positions, controls).ok()?;
    let x = problem.unknowns();
    let d = newton
        .linearized(&problem, &x, &load, ENOUGH, params)
        .ok()?;
    let mut guess = goal.to_vec();
    let mut free = vec![[0.0; D]; guess.len()];
    assembly.dofs().trusted_scatter(&d, &mut free);
    for (x, d) in guess.iter_mut().zip(free) {
        (0..D).for_each(|k| x[k] += d[k]);
    }
    let energy = |x: &[[f64; D]]| assembly.free_energy(Configuration::trusted(x, at.controls()));
    (energy(&guess) < energy(goal)).then_some(guess)
}
