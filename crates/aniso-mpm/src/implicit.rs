//! Implicit steps: Newton's method with conjugate gradients for the velocities of the grid.
//!
//! The grid velocity v^{n+1} minimizes the incremental potential
//!
//! ```text
//! E(v) = ½ Σ_i m_i |v_i − v*_i|² + Σ_p V_p⁰ ψ((I + Δt ∇v(x_p)) F_p)
//! ```
//!
//! over the velocities that the obstacles allow; v* is the grid velocity without internal force.
//! Its Hessian is applied with the material's exact stress differential, or its projected one where
//! that is indefinite, and never assembled.

use crate::body::Body;
use crate::damage::DamageOutput;
use crate::error::{MpmError, NewtonEnd};
use crate::float::{Float, worse};
use crate::kernels::{Spline, locate};
use crate::particles::Particles;
use crate::simulation::Simulation;
use crate::transfer::{Scheme, read_gradient, spread_stress};
use crate::window::{Gather, Node, Scatter};
use fem_kinematics::{HessianProjection, Mat, Quad};
use fem_materials::DamageField;
use fem_solvers::{
    BlockSymmetric, LinearOperator, MatrixPreconditioner, Newton, NewtonError, NewtonFailure,
    NewtonParams, NonlinearProblem, PcgDirection, Preconditioner, PreconditionerError,
};
use std::cell::RefCell;
use std::marker::PhantomData;

/// Most iterations of conjugate gradients in one Newton step.
const PCG_LIMIT: usize = 500;

/// When an implicit step is accurate enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitStep {
    /// Largest change of velocity of the last, full Newton step, m/s.
    pub tolerance: f64,
    /// Give up after this many Newton steps.
    pub max_iterations: usize,
}

impl Default for ImplicitStep {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            max_iterations: 40,
        }
    }
}

/// The incremental potential of one step.
struct Potential<'a, T, M, S: Scheme, const D: usize> {
    simulation: &'a Simulation<T, S, M, D>,
    damage: &'a [T],
    dt: f64,
    /// Masses of the nodes.
    mass: Vec<f64>,
    /// v*.
    target: Vec<[f64; D]>,
    /// Directions in which a node may not move, orthonormal.
    blocked: Vec<Vec<[f64; D]>>,
    /// A velocity and F at the end of its step: products are taken where the gradient was.
    at: RefCell<(Vec<f64>, Vec<Mat<f64, D>>)>,
}

impl<T: Float, M: DamageField<D>, S: Scheme, const D: usize> Potential<'_, T, M, S, D> {
    fn particles(&self) -> &Particles<T, D> {
        &self.simulation.particles
    }
    fn bodies(&self) -> &[Body<M, D>] {
        &self.simulation.bodies
    }

    /// Δt ∇v F_p at every particle.
    fn strain(&self, v: &[f64]) -> Vec<Mat<f64, D>> {
        let field: Vec<Node<f64>> = v
            .chunks(D)
            .map(|v| core::array::from_fn(|c| if c < D { v[c] } else { 0.0 }))
            .collect();
        let read = ReadStrain::<T, S, D> {
            particles: self.particles(),
            h: self.simulation.settings.cell_size,
            dt: self.dt,
            scheme: PhantomData,
        };
        self.simulation.binning.gather(&field, &read)
    }

    /// Σ_p V_p⁰ Δt P_p F_pᵀ ∇N_i, for stresses given at every particle.
    fn spread(&self, stress: &[Mat<f64, D>]) -> Vec<f64> {
        let task = SpreadStress::<T, S, D> {
            particles: self.particles(),
            stress,
            h: self.simulation.settings.cell_size,
            dt: self.dt,
            scheme: PhantomData,
        };
        let (mut windows, mut field) = (Vec::new(), Vec::new());
        self.simulation
            .binning
            .scatter(&task, &mut windows, &mut field);
        field.iter().flat_map(|node| node[..D].to_vec()).collect()
    }

    fn state(&self, p: usize) -> (Mat<f64, D>, f64, f64) {
        let particles = self.particles();
        (
            wide(&particles.F[p]),
            self.damage[p].to_f64(),
            particles.volume[p].to_f64(),
        )
    }

    fn material(&self, p: usize) -> &M {
        &self.bodies()[self.particles().body[p] as usize].material
    }

    /// E(v), J.
    fn potential(&self, v: &[f64]) -> f64 {
        let mut e = 0.0;
        for (i, v) in v.chunks(D).enumerate() {
            for a in 0..D {
                e += 0.5 * self.mass[i] * (v[a] - self.target[i][a]).powi(2);
            }
        }
        for (p, dF) in self.strain(v).iter().enumerate() {
            let (F, d, volume) = self.state(p);
            e += volume * self.material(p).energy(&M::at_damage(d), &(F + *dF));
        }
        e
    }

    /// F at the end of the step.
    fn deformed(&self, v: &[f64]) -> Vec<Mat<f64, D>> {
        let mut F = self.strain(v);
        for (p, F) in F.iter_mut().enumerate() {
            *F += self.state(p).0;
        }
        F
    }

    /// ∂E/∂v at the end of the step without the blocked directions.
    fn force(&self, v: &[f64], F: &[Mat<f64, D>]) -> Vec<f64> {
        let stress: Vec<_> = F
            .iter()
            .enumerate()
            .map(|(p, F)| self.material(p).stress(&M::at_damage(self.state(p).1), F))
            .collect();
        let mut g = self.spread(&stress);
        for (i, v) in v.chunks(D).enumerate() {
            for a in 0..D {
                g[i * D + a] += self.mass[i] * (v[a] - self.target[i][a]);
            }
        }
        self.block(&mut g);
        g
    }

    /// Takes the blocked directions out of a node vector.
    fn block(&self, g: &mut [f64]) {
        for (g, blocked) in g.chunks_mut(D).zip(&self.blocked) {
            for n in blocked {
                let along: f64 = (0..D).map(|a| g[a] * n[a]).sum();
                for a in 0..D {
                    g[a] -= along * n[a];
                }
            }
        }
    }
}

/// Unknowns are the velocities of all nodes. Where nothing moves (no mass, or blocked) the Hessian
/// has a unit row, or the mass.
impl<T: Float, M: DamageField<D>, S: Scheme, const D: usize> NonlinearProblem<D>
    for Potential<'_, T, M, S, D>
{
    fn blocks(&self) -> usize {
        self.mass.len()
    }
    fn energy(&self, v: &[f64]) -> f64 {
        self.potential(v)
    }
    fn gradient(&self, v: &[f64], g: &mut [f64]) {
        let F = self.deformed(v);
        g.copy_from_slice(&self.force(v, &F));
        self.at.replace((v.to_vec(), F));
    }
    fn hessian_vector(&self, v: &[f64], projection: HessianProjection, x: &[f64], y: &mut [f64]) {
        if self.at.borrow().0 != v {
            self.at.replace((v.to_vec(), self.deformed(v)));
        }
        let mut free = x.to_vec();
        self.block(&mut free);
        let mut dP = self.strain(&free);
        for (p, dP) in dP.iter_mut().enumerate() {
            let F = &self.at.borrow().1[p];
            let (_, d, _) = self.state(p);
            let (material, local) = (self.material(p), M::at_damage(d));
            *dP = match projection {
                HessianProjection::None => material.stress_differential(&local, F, dP),
                projection => material
                    .projected_derivative(&local, F, projection)
                    .apply(dP),
            };
        }
        let mut product = self.spread(&dP);
        for (i, y) in product.chunks_mut(D).enumerate() {
            for a in 0..D {
                y[a] += self.mass[i] * free[i * D + a];
            }
        }
        self.block(&mut product);
        for i in 0..y.len() {
            let mass = self.mass[i / D];
            y[i] = if mass > 0.0 {
                product[i] + (x[i] - free[i]) * mass
            } else {
                x[i]
            };
        }
    }
    /// A few units in the last place of the largest momentum of a node and impulse of a particle.
    fn gradient_rounding(&self, v: &[f64]) -> Option<Vec<f64>> {
        let mut largest = 0.0;
        for (i, v) in v.chunks(D).enumerate() {
            for a in 0..D {
                let speeds = v[a].abs() + self.target[i][a].abs();
                largest = worse(largest, self.mass[i] * speeds);
            }
        }
        let per_length = self.dt / self.simulation.settings.cell_size;
        for (p, F) in self.deformed(v).iter().enumerate() {
            let (start, d, volume) = self.state(p);
            let P = self.material(p).stress(&M::at_damage(d), F);
            let impulse = volume * per_length * P.mul_tr(&start).norm_squared().sqrt();
            largest = worse(largest, impulse);
        }
        Some(vec![8.0 * f64::EPSILON * largest; v.len()])
    }
}

/// 1/m: the mass scaling takes the decades between border and inner nodes out of the system.
struct MassScaling<const D: usize>(Vec<f64>);
impl<const D: usize> Preconditioner for MassScaling<D> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for i in 0..r.len() {
            let mass = self.0[i / D];
            z[i] = if mass > 0.0 { r[i] / mass } else { r[i] };
        }
    }
}
impl<const D: usize> MatrixPreconditioner<D> for MassScaling<D> {
    fn update(&mut self, _: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        Ok(())
    }
    fn update_products(&mut self, _: &dyn LinearOperator) -> Result<(), PreconditionerError> {
        Ok(())
    }
}

impl<T: Float, S: Scheme, M: DamageField<D>, const D: usize> Simulation<T, S, M, D> {
    /// Replaces the grid velocity (mass and v* in the field) by the minimizer of the potential.
    pub(crate) fn implicit_velocity(
        &mut self,
        dt: f64,
        damage: Option<&DamageOutput<T>>,
        options: &ImplicitStep,
    ) -> Result<(), MpmError> {
        let potential = self.potential(dt, damage);
        let mut v: Vec<f64> = potential.target.as_flattened().to_vec();
        let scaling = MassScaling(potential.mass.clone());
        let params = NewtonParams {
            relative_gradient_tolerance: 0.0,
            step_tolerance: options.tolerance,
            max_iterations: options.max_iterations,
            ..NewtonParams::default()
        };
        let mut change = f64::INFINITY;
        let solved = Newton::with_direction(&potential, PcgDirection::new(scaling, PCG_LIMIT))
            .solve_observed(&potential, &mut v, &params, &mut |step| {
                if step.iteration > 0 {
                    change = step.step;
                }
            });
        solved.map_err(|error| failure(&error, change, options.tolerance, &v))?;
        for (node, v) in self.field.iter_mut().zip(v.chunks(D)) {
            for a in 0..D {
                node[a] = T::from_f64(v[a]);
            }
        }
        Ok(())
    }

    /// The potential of a step from the grid's mass and v*.
    fn potential<'a>(
        &'a self,
        dt: f64,
        damage: Option<&'a DamageOutput<T>>,
    ) -> Potential<'a, T, M, S, D> {
        let nodes = self.field.len();
        let mass: Vec<f64> = self.field.iter().map(|node| node[3].to_f64()).collect();
        let target: Vec<[f64; D]> = self
            .field
            .iter()
            .map(|node| core::array::from_fn(|a| node[a].to_f64()))
            .collect();
        let blocked = (0..nodes)
            .map(|i| self.blocked_directions(i, &target[i], mass[i], dt))
            .collect();
        Potential {
            simulation: self,
            damage: damage.map_or(&self.particles.damage, |damage| &damage.d),
            dt,
            mass,
            target,
            blocked,
            at: RefCell::default(),
        }
    }

    /// Directions that the obstacles take from a node whose velocity they have already changed.
    fn blocked_directions(&self, index: usize, v: &[f64; D], mass: f64, dt: f64) -> Vec<[f64; D]> {
        let mut blocked: Vec<[f64; D]> = Vec::new();
        if !(mass > 0.0) || self.obstacles.is_empty() {
            return blocked;
        }
        let h = self.settings.cell_size;
        let x = self.binning.nodes.node(index).map(|i| f64::from(i) * h);
        for obstacle in &self.obstacles {
            for n in obstacle
                .constraint(x, self.time + dt)
                .iter()
                .flat_map(|constraint| constraint.prescribed_directions(v))
            {
                // Gram-Schmidt against what is already blocked.
                let mut n: [f64; D] = n;
                for m in &blocked {
                    let along: f64 = (0..D).map(|a| n[a] * m[a]).sum();
                    n = core::array::from_fn(|a| n[a] - along * m[a]);
                }
                let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
                if length > 1e-6 {
                    blocked.push(n.map(|c| c / length));
                }
            }
        }
        blocked
    }
}

/// The error of a step whose Newton iteration failed.
fn failure(error: &NewtonError, change: f64, tolerance: f64, last: &[f64]) -> MpmError {
    let reason = match error.reason {
        NewtonFailure::NotConverged => NewtonEnd::NotConverged,
        NewtonFailure::LineSearchFailed { .. } => NewtonEnd::NoDecrease,
        _ => {
            return MpmError::Solve {
                system: "implicit step",
                source: error.clone().into(),
            };
        }
    };
    MpmError::Newton {
        system: "implicit step",
        reason,
        iterations: error.iteration,
        change,
        tolerance,
        last: last.to_vec(),
    }
}

fn wide<T: Float, const D: usize>(F: &Mat<T, D>) -> Mat<f64, D> {
    Mat::from_fn(|i, j| F.0[i][j].to_f64())
}

struct ReadStrain<'a, T, S, const D: usize> {
    particles: &'a Particles<T, D>,
    h: f64,
    dt: f64,
    scheme: PhantomData<S>,
}
impl<T: Float, S: Scheme, const D: usize> Gather<f64, D> for ReadStrain<'_, T, S, D> {
    type Output = Mat<f64, D>;
    #[inline(always)]
    fn gather<Q: Quad<f64>>(
        &self,
        p: usize,
        origin: [i32; D],
        window: &[Node<f64>],
    ) -> Mat<f64, D> {
        let x = same_cell::<T, S, D>(&self.particles.x[p], self.h);
        let gradient = read_gradient::<f64, Q, S, D>(&x, self.h, origin, window);
        gradient.scale(self.dt) * wide(&self.particles.F[p])
    }
}

struct SpreadStress<'a, T, S, const D: usize> {
    particles: &'a Particles<T, D>,
    stress: &'a [Mat<f64, D>],
    h: f64,
    dt: f64,
    scheme: PhantomData<S>,
}
impl<T: Float, S: Scheme, const D: usize> Scatter<f64, D> for SpreadStress<'_, T, S, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let x = same_cell::<T, S, D>(&self.particles.x[p], self.h);
        let impulse = self.stress[p]
            .mul_tr(&wide(&self.particles.F[p]))
            .scale(self.dt * self.particles.volume[p].to_f64());
        spread_stress::<f64, Q, S, D>(&x, self.h, &impulse, origin, window);
    }
}

/// A particle's place in `f64`, in the same cell as in `T`: rounding must not move it across a
/// cell's face, out of the window of its block.
#[inline(always)]
fn same_cell<T: Float, S: Scheme, const D: usize>(x: &[T; D], h: f64) -> [f64; D] {
    let (base, f) = locate::<S::Kernel, T, D>(x, T::from_f64(h));
    core::array::from_fn(|a| {
        let shift = <S::Kernel as Spline>::SHIFT;
        let inside = f[a].to_f64().clamp(shift + 1e-9, shift + 1.0 - 1e-9);
        (f64::from(base[a]) + inside) * h
    })
}

#[cfg(test)]
mod tests;
