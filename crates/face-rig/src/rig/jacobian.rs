//! dx/dθ, exact: by columns, or by adjoints where fewer numbers are seen than parameters vary.

use super::control::Controls;
use super::equilibrium::{Equilibrium, Stiffness};
use super::error::RigError;
use super::loads::Loads;
use super::observation::Observation;
use super::parameters::Direction;
use fem_assembly::{Assembly, AssemblyError};
use fem_solvers::parallel;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How a Jacobian is computed: one linear solve for each direction, or one for each observed number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JacobianRoute {
    /// K dz = −∂²E/∂z∂θ dθ for each direction (document 000, 3).
    Columns,
    /// K λ = (∂g_k/∂z)ᵀ for each observed number.
    Adjoint,
}

impl JacobianRoute {
    /// The route with fewer linear solves.
    pub fn cheaper(observation: &dyn Observation, directions: &[Direction]) -> Self {
        let solves = |route: Self| route.right_hand_sides(observation, directions);
        if solves(Self::Adjoint) < solves(Self::Columns) {
            Self::Adjoint
        } else {
            Self::Columns
        }
    }

    /// How many linear solves it takes. Cranium directions need none on either.
    pub fn right_hand_sides(
        self,
        observation: &dyn Observation,
        directions: &[Direction],
    ) -> usize {
        let solve = |d: &&Direction| !matches!(d, Direction::Cranium(_));
        match self {
            Self::Columns => directions.iter().filter(solve).count(),
            Self::Adjoint => observation.dim(),
        }
    }
}

/// The implicit derivative at an equilibrium, with the stiffness K = ∂²E/∂z^U∂z^U factored or a multigrid
/// hierarchy made for it.
#[derive(Debug)]
pub struct Sensitivity<'a> {
    loads: Loads<'a>,
    equilibrium: &'a Equilibrium,
    positions: Vec<[f64; 3]>,
    solver: CountedSolver<'a>,
}

/// What K is solved with, and counts of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CountedSolver<'a> {
    pub stiffness: &'a Stiffness,
    pub tolerance: f64,
    pub right_hand_sides: &'a AtomicUsize,
    pub iterations: &'a AtomicUsize,
}

impl CountedSolver<'_> {
    fn solve_many(&self, block: &mut [f64], count: usize) -> Result<(), RigError> {
        self.right_hand_sides.fetch_add(count, Ordering::Relaxed);
        let solved = self.stiffness.solve_many(block, count, self.tolerance)?;
        let iterations = solved.iterations;
        self.iterations.fetch_add(iterations, Ordering::Relaxed);
        Ok(())
    }
}

impl<'a> Sensitivity<'a> {
    pub(super) fn new(
        assembly: &'a Assembly<3>,
        jaw: &'a [u32],
        controls: &'a Controls,
        equilibrium: &'a Equilibrium,
        energy: &'a [f64],
        solver: CountedSolver<'a>,
    ) -> Result<Self, AssemblyError> {
        Ok(Self {
            loads: Loads {
                assembly,
                at: assembly.configuration(&equilibrium.in_cranium_frame, energy)?,
                jaw,
                controls,
            },
            equilibrium,
            positions: equilibrium.positions(),
            solver,
        })
    }

    /// x(θ), where the derivative is taken.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// [`JacobianRoute::cheaper`].
    pub fn cheaper_route(
        &self,
        observation: &dyn Observation,
        directions: &[Direction],
    ) -> JacobianRoute {
        JacobianRoute::cheaper(observation, directions)
    }

    /// dx for each direction, at every node.
    ///
    /// # Errors
    /// When the assembly finds a list of another length than its own; by multigrid also
    /// [`RigError::Unstable`] and [`RigError::Derivative`].
    pub fn columns(&self, directions: &[Direction]) -> Result<Vec<Vec<[f64; 3]>>, RigError> {
        let n = self.loads.assembly.dofs().vector_len();
        let solving: Vec<usize> = (0..directions.len())
            .filter(|&k| !matches!(directions[k], Direction::Cranium(_)))
            .collect();
        let mut block = vec![0.0; n * solving.len()];
        if n > 0 {
            let tasks = block.chunks_exact_mut(n).zip(&solving).collect();
            parallel::map::<_, _, Result<(), _>>(tasks, |(rhs, &k)| {
                self.loads.load(&directions[k], rhs)
            })?;
            self.solver.solve_many(&mut block, solving.len())?;
        }
        let mut next = 0;
        directions
            .iter()
            .map(|direction| {
                let mut dz = self.loads.bone_motion(direction);
                Ok(match direction {
                    Direction::Cranium(d) => self
                        .equilibrium
                        .in_cranium_frame
                        .iter()
                        .map(|&z| d.apply(z))
                        .collect(),
                    Direction::Activation(_) | Direction::Jaw(_) | Direction::Control(_) => {
                        let column: Vec<f64> =
                            block[next * n..(next + 1) * n].iter().map(|v| -v).collect();
                        next += 1;
                        self.loads.assembly.dofs().scatter(&column, &mut dz)?;
                        let cranium = &self.equilibrium.parameters.cranium;
                        dz.iter().map(|&d| cranium.rotate(d)).collect()
                    }
                })
            })
            .collect()
    }

    /// ∂g/∂θ for the given directions, column-major: one column of `observation.dim()` numbers for
    /// each direction.
    ///
    /// # Errors
    /// When the observation is of other nodes, and as [`Sensitivity::columns`].
    pub fn jacobian(
        &self,
        observation: &dyn Observation,
        directions: &[Direction],
        route: JacobianRoute,
    ) -> Result<Vec<f64>, RigError> {
        observation.check(self.positions.len())?;
        let rows = observation.dim();
        let mut jacobian = vec![0.0; rows * directions.len()];
        match route {
            JacobianRoute::Columns => {
                let columns = self.columns(directions)?;
                if rows > 0 {
                    for (dx, out) in columns.iter().zip(jacobian.chunks_exact_mut(rows)) {
                        observation.differential(&self.positions, dx, out);
                    }
                }
            }
            JacobianRoute::Adjoint => {
                let seen: Vec<Vec<[f64; 3]>> = (0..rows)
                    .map(|k| {
                        let mut row = vec![[0.0; 3]; self.positions.len()];
                        observation.add_row(&self.positions, k, &mut row);
                        row
                    })
                    .collect();
                for (k, gradient) in self.pull_back(&seen, directions)?.into_iter().enumerate() {
                    for (c, value) in gradient.into_iter().enumerate() {
                        jacobian[c * rows + k] = value;
                    }
                }
            }
        }
        Ok(jacobian)
    }

    /// dL/dθ of a scalar loss from dL/dx, by one solve.
    ///
    /// # Errors
    /// When there is not one dL/dx for each node, and as [`Sensitivity::columns`].
    pub fn gradient(
        &self,
        by_position: &[[f64; 3]],
        directions: &[Direction],
    ) -> Result<Vec<f64>, RigError> {
        let seen = [by_position.to_vec()];
        let mut all = self.pull_back(&seen, directions)?;
        Ok(all.pop().unwrap_or_default())
    }

    /// For each covector over the nodes, its product with dx/dθ.
    fn pull_back(
        &self,
        seen: &[Vec<[f64; 3]>],
        directions: &[Direction],
    ) -> Result<Vec<Vec<f64>>, RigError> {
        let parameters = &self.equilibrium.parameters;
        let n = self.loads.assembly.dofs().vector_len();
        let in_frame: Vec<Vec<[f64; 3]>> = seen
            .iter()
            .map(|w| {
                w.iter()
                    .map(|&v| parameters.cranium.rotate_transposed(v))
                    .collect()
            })
            .collect();
        let mut multipliers = Vec::with_capacity(n * seen.len());
        for w in &in_frame {
            multipliers.extend(self.loads.assembly.dofs().gather(w)?);
        }
        self.solver.solve_many(&mut multipliers, seen.len())?;
        let force = |k: usize| {
            let mut force = vec![0.0; n];
            Ok(match self.loads.of_energy(&directions[k]) {
                Some(_) => {
                    self.loads.load(&directions[k], &mut force)?;
                    Some(force)
                }
                None => None,
            })
        };
        let forces: Result<Vec<Option<Vec<f64>>>, AssemblyError> =
            parallel::indexed(directions.len(), force);
        let forces = forces?;
        let moves = |d: &Direction| match d {
            Direction::Jaw(_) => true,
            Direction::Control(_) => self.loads.of_energy(d).is_none(),
            Direction::Activation(_) | Direction::Cranium(_) => false,
        };
        let moves_bones = directions.iter().any(moves);
        parallel::indexed(seen.len(), |k| {
            let multiplier = &multipliers[k * n..(k + 1) * n];
            let through_flesh = match moves_bones {
                true => self.through_flesh(multiplier)?,
                false => Vec::new(),
            };
            let pulled = Pulled {
                seen: &seen[k],
                in_frame: &in_frame[k],
                multiplier,
                through_flesh: &through_flesh,
            };
            let all = directions.iter().zip(&forces);
            let along =
                all.map(|(direction, force)| self.along(direction, force.as_deref(), &pulled));
            Ok(along.collect())
        })
    }

    /// What a field over the free nodes meets at every node, bones included.
    fn through_flesh(&self, multiplier: &[f64]) -> Result<Vec<[f64; 3]>, AssemblyError> {
        let assembly = self.loads.assembly;
        let mut field = vec![[0.0; 3]; self.equilibrium.in_cranium_frame.len()];
        assembly.dofs().scatter(multiplier, &mut field)?;
        assembly.hessian_vector_everywhere(self.loads.at, &field)
    }

    /// A covector's product with one column of dx/dθ.
    fn along(&self, direction: &Direction, force: Option<&[f64]>, pulled: &Pulled) -> f64 {
        match (direction, force) {
            (Direction::Cranium(d), _) => {
                let moved = self
                    .equilibrium
                    .in_cranium_frame
                    .iter()
                    .map(|&z| d.apply(z));
                let all = pulled.seen.iter().zip(moved);
                all.map(|(w, dx)| dot(*w, dx)).sum()
            }
            (Direction::Jaw(d), _) => {
                let bone = |&node: &u32| {
                    let node = node as usize;
                    let moved = d.apply(self.loads.assembly.rest()[node]);
                    dot(pulled.in_frame[node], moved) - dot(pulled.through_flesh[node], moved)
                };
                self.loads.jaw.iter().map(bone).sum()
            }
            (Direction::Control(c), None) => {
                let moved = self.loads.controls.motion(*c).iter();
                let felt = moved.map(|&(node, axis, meters)| {
                    let (own, back) = (pulled.in_frame[node], pulled.through_flesh[node]);
                    (own[axis] - back[axis]) * meters
                });
                felt.sum()
            }
            (Direction::Activation(_) | Direction::Control(_), force) => {
                let all = pulled.multiplier.iter().zip(force.unwrap_or_default());
                -all.map(|(m, f)| m * f).sum::<f64>()
            }
        }
    }
}

/// A covector over the nodes, and what it becomes at an equilibrium.
struct Pulled<'a> {
    seen: &'a [[f64; 3]],
    /// In the frame of the cranium.
    in_frame: &'a [[f64; 3]],
    /// K⁻¹ times it, over the unknowns.
    multiplier: &'a [f64],
    /// What the flesh passes on to the bones; empty where none moves.
    through_flesh: &'a [[f64; 3]],
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
