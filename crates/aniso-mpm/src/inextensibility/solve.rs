//! The projection of grid velocities onto those that stretch no fiber (alg. 11, lines 9-13).

use super::matrix::ConstraintMatrix;
use super::matrix_free::FiberGrid;
use crate::error::{MpmError, SolveError};
use crate::float::worse;
use fem_kinematics::dot;
use fem_solvers::{LinearOperator, PcgError, PcgParams, Structure, pcg_semidefinite};

/// One more row of the constraint: the node's velocity along `normal` is `speed`.
///
/// Collisions are part of the same solve, so that the fibers cannot push the material back into
/// an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionRow<const D: usize> {
    /// Place of the node in a node vector of the grid.
    pub node: usize,
    /// Unit normal of the obstacle.
    pub normal: [f64; D],
    /// Normal velocity of the obstacle, m/s.
    pub speed: f64,
}

/// The velocities found and the multipliers that hold them.
#[derive(Clone, Debug, PartialEq)]
pub struct InextensibleSolution<const D: usize> {
    /// Velocities on all nodes of the grid, m/s.
    pub v: Vec<[f64; D]>,
    /// Multipliers of [`ConstraintMatrix::cells`], then of the collision rows; not unique.
    pub lambda: Vec<f64>,
    /// Products with L.
    pub iterations: usize,
    /// max_z |(B v)_z| / √L_zz over the same for M⁻¹ b (or 1e-6 of the mass norm of v, if that is
    /// more): what is left of the stretch rate.
    pub violation: f64,
}

/// B, M⁻¹ and the collision rows of one step.
#[derive(Clone, Debug)]
pub struct Projection<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
    matrix: ConstraintMatrix<D>,
    /// Δt/m of the matrix's nodes.
    inverse_mass: Vec<f64>,
    collisions: Vec<(u32, CollisionRow<D>)>,
    /// 1/√L_zz, 0 for an empty row.
    scale: Vec<f64>,
}

impl<'a, const D: usize> Projection<'a, D> {
    /// Assembles B and M⁻¹ (alg. 11, lines 5-8). `inverse_mass` is Δt/m_i on all nodes of the
    /// grid, 0 where there is no mass.
    ///
    /// Collision rows at nodes that no fiber reaches are left out: nothing couples to them.
    ///
    /// # Errors
    /// A length that differs.
    pub fn new(
        grid: &'a FiberGrid<D>,
        inverse_mass: &[f64],
        collisions: &[CollisionRow<D>],
    ) -> Result<Self, MpmError> {
        crate::error::same_length("inverse mass", inverse_mass.len(), grid.len())?;
        let matrix = ConstraintMatrix::assemble(grid);
        let mut number = vec![u32::MAX; grid.len()];
        for (n, &place) in matrix.nodes().iter().enumerate() {
            number[place as usize] = n as u32;
        }
        let inverse_mass: Vec<f64> = matrix
            .nodes()
            .iter()
            .map(|&place| inverse_mass[place as usize])
            .collect();
        let collisions: Vec<_> = collisions
            .iter()
            .filter(|row| number[row.node] != u32::MAX)
            .map(|row| (number[row.node], *row))
            .collect();
        let mut diagonal = matrix.schur_diagonal(&inverse_mass);
        diagonal.extend(
            collisions
                .iter()
                .map(|(n, row)| inverse_mass[*n as usize] * dot(row.normal, row.normal)),
        );
        let scale = diagonal
            .iter()
            .map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 })
            .collect();
        Ok(Self {
            grid,
            matrix,
            inverse_mass,
            collisions,
            scale,
        })
    }

    /// B as a sparse matrix.
    pub fn matrix(&self) -> &ConstraintMatrix<D> {
        &self.matrix
    }

    /// From alg. 11's b (N, on all nodes of the grid): L λ = B M⁻¹ b, v = M⁻¹ (b − Bᵀ λ).
    ///
    /// # Errors
    /// See [`Projection::project`].
    pub fn solve(
        &self,
        b: &[[f64; D]],
        inverse_mass: &[f64],
        params: &PcgParams,
    ) -> Result<InextensibleSolution<D>, MpmError> {
        let free = b
            .iter()
            .zip(inverse_mass)
            .map(|(b, &m)| b.map(|b| b * m))
            .collect();
        self.project(free, params)
    }

    /// The mass-orthogonal projection of the velocities `free` = M⁻¹ b (m/s, on all nodes of the
    /// grid) onto those that meet every row.
    ///
    /// # Errors
    /// A solve that ended far from its tolerance.
    pub fn project(
        &self,
        mut free: Vec<[f64; D]>,
        params: &PcgParams,
    ) -> Result<InextensibleSolution<D>, MpmError> {
        let nodes = self.matrix.nodes();
        let rows = self.scale.len();
        let mut v: Vec<[f64; D]> = nodes.iter().map(|&n| free[n as usize]).collect();
        let start = v.clone();
        let before_max = self.size_of_violation(&v);
        let mut total = vec![0.0; rows];
        let mut iterations = 0;
        let mut left = before_max;
        // L is singular and badly conditioned: a second solve for what rounding left of B v.
        for _ in 0..3 {
            let r = self.violation(&v);
            left = r.iter().fold(0.0, |m, r| worse(m, r.abs()));
            if !(left > params.relative_tolerance * before_max) {
                break;
            }
            let (y, taken) = self.impulses(&r, params)?;
            iterations += taken;
            for (total, (y, scale)) in total.iter_mut().zip(y.iter().zip(&self.scale)) {
                *total += y * scale;
            }
            let impulse = self.transpose(&total);
            for i in 0..v.len() {
                v[i] = core::array::from_fn(|a| start[i][a] - self.inverse_mass[i] * impulse[i][a]);
            }
        }
        let violation = if before_max == 0.0 {
            0.0
        } else {
            left / before_max
        };
        if !(violation <= 1e-4) {
            return Err(MpmError::Solve {
                system: "inextensible fibers",
                source: SolveError::StretchLeft {
                    violation,
                    iterations,
                },
            });
        }
        for (&place, v) in nodes.iter().zip(v) {
            free[place as usize] = v;
        }
        Ok(InextensibleSolution {
            v: free,
            lambda: total,
            iterations,
            violation,
        })
    }

    /// The largest violation, or what of it could be rounding.
    fn size_of_violation(&self, v: &[[f64; D]]) -> f64 {
        // |(B v)_z|/√L_zz is at most the mass norm of v: what is 1e-6 of that is rounding of a
        // motion that stretches nothing.
        let size: f64 = v
            .iter()
            .zip(&self.inverse_mass)
            .map(|(v, &m)| if m > 0.0 { dot(*v, *v) / m } else { 0.0 })
            .sum::<f64>()
            .sqrt();
        let violation = self.violation(v);
        violation.iter().fold(1e-6 * size, |m, r| worse(m, r.abs()))
    }

    /// The scaled impulses that take back a violation as far as rounding lets them, and the iterations
    /// that it took to find them.
    fn impulses(&self, r: &[f64], params: &PcgParams) -> Result<(Vec<f64>, usize), MpmError> {
        let mut y = vec![0.0; r.len()];
        let ones: Vec<f64> = self
            .scale
            .iter()
            .map(|&s| if s > 0.0 { 1.0 } else { 0.0 })
            .collect();
        match pcg_semidefinite(self, &ones, r, &mut y, params) {
            Ok(info) => Ok((y, info.iterations)),
            // What rounding puts outside the range of L cannot be solved for; the iterate is
            // still the best there is, and what it leaves decides.
            Err(
                PcgError::Inconsistent { .. }
                | PcgError::Stagnated { .. }
                | PcgError::NotConverged { .. }
                | PcgError::NegativeCurvature { .. },
            ) => Ok((y, params.max_iterations)),
            Err(error) => Err(MpmError::Solve {
                system: "inextensible fibers",
                source: error.into(),
            }),
        }
    }

    /// (B v − right-hand side)/√L_zz for every row, collisions last.
    fn violation(&self, v: &[[f64; D]]) -> Vec<f64> {
        let cells = self.matrix.cells().len();
        let mut r = vec![0.0; self.scale.len()];
        self.matrix.apply(v, &mut r[..cells]);
        for (r, (n, row)) in r[cells..].iter_mut().zip(&self.collisions) {
            *r = dot(row.normal, v[*n as usize]) - row.speed;
        }
        for (r, scale) in r.iter_mut().zip(&self.scale) {
            *r *= scale;
        }
        r
    }

    /// Bᵀ λ on the matrix's nodes, collisions included.
    fn transpose(&self, lambda: &[f64]) -> Vec<[f64; D]> {
        let cells = self.matrix.cells().len();
        let mut f = vec![[0.0; D]; self.matrix.nodes().len()];
        self.matrix.apply_transpose(&lambda[..cells], &mut f);
        for (l, (n, row)) in lambda[cells..].iter().zip(&self.collisions) {
            for a in 0..D {
                f[*n as usize][a] += l * row.normal[a];
            }
        }
        f
    }

    /// The grid that the node vectors live on.
    pub fn grid(&self) -> &FiberGrid<D> {
        self.grid
    }
}

/// L with a unit diagonal: D^{-1/2} B M⁻¹ Bᵀ D^{-1/2}.
impl<const D: usize> LinearOperator for Projection<'_, D> {
    fn dim(&self) -> usize {
        self.scale.len()
    }
    fn structure(&self) -> Structure {
        Structure::SymmetricPositiveSemidefinite
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let lambda: Vec<f64> = x.iter().zip(&self.scale).map(|(x, s)| x * s).collect();
        let mut v = self.transpose(&lambda);
        for (v, &m) in v.iter_mut().zip(&self.inverse_mass) {
            *v = v.map(|f| f * m);
        }
        let cells = self.matrix.cells().len();
        self.matrix.apply(&v, &mut y[..cells]);
        for (y, (n, row)) in y[cells..].iter_mut().zip(&self.collisions) {
            *y = dot(row.normal, v[*n as usize]);
        }
        for (y, scale) in y.iter_mut().zip(&self.scale) {
            *y *= scale;
        }
    }
}
