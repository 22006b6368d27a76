//! Energy, forces and Hessian of a whole mesh.

use crate::block::RestElement;
use crate::builder::Chunk;
use crate::dofs::Dofs;
use crate::part::{Part, State};
use crate::penalty::Penalty;
use fem_materials::HessianProjection;
use fem_solvers::{BlockPattern, BlockSymmetric};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// A mesh with its materials, fibers and obstacles, ready to be evaluated at any positions.
///
/// Positions and displacements are given for every node of the mesh, in its own numbering;
/// results are given for the free nodes (x^U), in the numbering of [`Dofs`]. All sums have a fixed
/// order: the same bits for any number of threads.
pub struct Assembly<const D: usize> {
    pub(crate) dofs: Dofs<D>,
    pub(crate) rest: Vec<[f64; D]>,
    pub(crate) elements: Vec<RestElement<D>>,
    pub(crate) pattern: Arc<BlockPattern>,
    pub(crate) chunks: Vec<Chunk<D>>,
    /// Elements whose vertices are all prescribed: they have energy but no force on x^U.
    pub(crate) prescribed: Vec<Box<dyn Part<D>>>,
    pub(crate) penalties: Vec<Penalty<D>>,
    pub(crate) channels: usize,
    pub(crate) force_scale: OnceLock<Option<f64>>,
}

impl<const D: usize> std::fmt::Debug for Assembly<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Assembly")
            .field("nodes", &self.rest.len())
            .field("elements", &self.elements.len())
            .field("free_nodes", &self.dofs.free_nodes())
            .field("activation_channels", &self.channels)
            .finish_non_exhaustive()
    }
}

impl<const D: usize> Assembly<D> {
    /// The split into prescribed and free coordinates.
    pub fn dofs(&self) -> &Dofs<D> {
        &self.dofs
    }
    /// Rest positions of all nodes, meters.
    pub fn rest(&self) -> &[[f64; D]] {
        &self.rest
    }
    /// Places of the Hessian's blocks, lower half.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }
    /// Number of activation channels.
    pub fn channels(&self) -> usize {
        self.channels
    }
    /// The force that strains by one at rest, newtons: the stiffness of a free node in the median
    /// times the mean size of an element. `None` where nothing is stiff at rest.
    pub fn force_scale(&self) -> Option<f64> {
        *self.force_scale.get_or_init(|| {
            let mut hessian = BlockSymmetric::zeros(self.pattern.clone());
            let activations = vec![0.0; self.channels];
            self.hessian(
                &self.rest,
                &activations,
                HessianProjection::None,
                &mut hessian,
            );
            let mut stiffness: Vec<f64> = (0..self.pattern.blocks())
                .map(|row| {
                    let block = hessian.values()[self.pattern.diagonal(row)];
                    (0..D).fold(0.0, |m, k| block[k][k].abs().max(m))
                })
                .collect();
            stiffness.sort_by(f64::total_cmp);
            let median = *stiffness.get(stiffness.len() / 2)?;
            let volume: f64 = self.volumes().sum::<f64>() / self.elements.len() as f64;
            let scale = median * volume.powf(1.0 / D as f64);
            (scale > 0.0 && scale.is_finite()).then_some(scale)
        })
    }
    /// Rest volume of each element, m³ (m² in 2D).
    pub fn volumes(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.elements.iter().map(|e| e.volume)
    }

    /// det F of every element at the given positions; no material is evaluated.
    pub fn volume_ratios(&self, positions: &[[f64; D]]) -> Vec<f64> {
        self.deformation_gradients(positions)
            .map(|F| F.determinant())
            .collect()
    }

    /// F = D_s D_m⁻¹ of every element.
    pub fn deformation_gradients<'a>(
        &'a self,
        positions: &'a [[f64; D]],
    ) -> impl ExactSizeIterator<Item = fem_kinematics::Mat<f64, D>> + 'a {
        self.elements.iter().map(|e| {
            let origin = positions[e.nodes[0] as usize];
            fem_kinematics::Mat::from_fn(|i, j| positions[e.nodes[j + 1] as usize][i] - origin[i])
                * e.inverse_shape
        })
    }

    /// Energy of everything, prescribed elements included, joules; +∞ outside a material's domain.
    pub fn energy(&self, positions: &[[f64; D]], activations: &[f64]) -> f64 {
        let mut energies = Vec::new();
        for part in &self.prescribed {
            part.energies(
                State {
                    positions,
                    activations,
                },
                &mut energies,
            );
        }
        self.free_energy(positions, activations) + self.sum(energies)
    }

    /// Energy of the elements and penalties that free nodes feel: what an equilibrium minimizes.
    pub fn free_energy(&self, positions: &[[f64; D]], activations: &[f64]) -> f64 {
        let state = State {
            positions,
            activations,
        };
        let energies: Vec<Vec<(u32, f64)>> = self
            .chunks
            .par_iter()
            .map(|chunk| {
                let mut out = Vec::new();
                chunk
                    .parts
                    .iter()
                    .for_each(|part| part.energies(state, &mut out));
                out
            })
            .collect();
        self.sum(energies.into_iter().flatten()) + self.penalty_energy(positions)
    }

    /// The first element (in mesh order) whose energy is not finite.
    pub fn element_outside_domain(
        &self,
        positions: &[[f64; D]],
        activations: &[f64],
    ) -> Option<usize> {
        let mut energies = Vec::new();
        let parts = self
            .chunks
            .iter()
            .flat_map(|c| &c.parts)
            .chain(&self.prescribed);
        for part in parts {
            part.energies(
                State {
                    positions,
                    activations,
                },
                &mut energies,
            );
        }
        energies
            .iter()
            .filter(|(_, e)| !e.is_finite())
            .map(|&(k, _)| k as usize)
            .min()
    }

    /// ∂E/∂x^U (minus the nodal forces, newtons); returns [`Assembly::free_energy`].
    pub fn gradient(
        &self,
        positions: &[[f64; D]],
        activations: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let state = State {
            positions,
            activations,
        };
        let energies = self.by_rows(gradient, |chunk, rows| {
            let mut out = Vec::new();
            chunk
                .parts
                .iter()
                .for_each(|part| part.gradient(state, rows, &mut out));
            out
        });
        for penalty in &self.penalties {
            penalty.add_gradient(positions, &self.dofs, gradient);
        }
        self.clear_clamped_axes(gradient);
        self.sum(energies.into_iter().flatten()) + self.penalty_energy(positions)
    }

    /// Nodal forces f = −∂E/∂x at every node, prescribed ones included, newtons: at equilibrium the
    /// reaction that a prescribed node exerts on the body is −f.
    pub fn forces_everywhere(&self, positions: &[[f64; D]], activations: &[f64]) -> Vec<[f64; D]> {
        let mut everywhere = vec![[0.0; D]; self.rest.len()];
        let state = State {
            positions,
            activations,
        };
        for part in self.every_part() {
            part.gradient_everywhere(state, &mut everywhere);
        }
        everywhere
            .as_flattened_mut()
            .iter_mut()
            .for_each(|f| *f = -*f);
        for penalty in &self.penalties {
            penalty.add_forces_everywhere(positions, &mut everywhere);
        }
        everywhere
    }

    /// (∂²E/∂x²) δx at every node, prescribed ones included: the adjoint of a load needs the rows
    /// that [`Assembly::hessian_vector`] leaves out.
    pub fn hessian_vector_everywhere(
        &self,
        positions: &[[f64; D]],
        activations: &[f64],
        displacement: &[[f64; D]],
    ) -> Vec<[f64; D]> {
        let mut everywhere = vec![[0.0; D]; self.rest.len()];
        let state = State {
            positions,
            activations,
        };
        for part in self.every_part() {
            part.differential_everywhere(state, displacement, &mut everywhere);
        }
        for penalty in &self.penalties {
            penalty.add_product_everywhere(positions, displacement, &mut everywhere);
        }
        everywhere
    }

    fn every_part(&self) -> impl Iterator<Item = &dyn Part<D>> {
        self.chunks
            .iter()
            .flat_map(|c| &c.parts)
            .chain(&self.prescribed)
            .map(|p| &**p)
    }

    /// ∂²E/∂x^U∂x^U, symmetric. Elements are filtered one by one as asked.
    pub fn hessian(
        &self,
        positions: &[[f64; D]],
        activations: &[f64],
        filter: HessianProjection,
        hessian: &mut BlockSymmetric<D>,
    ) {
        let state = State {
            positions,
            activations,
        };
        let mut pieces = Vec::with_capacity(self.chunks.len());
        let mut rest = hessian.values_mut();
        let starts = self.pattern.row_start();
        for chunk in &self.chunks {
            let size = starts[chunk.rows.end] - starts[chunk.rows.start];
            let (piece, tail) = std::mem::take(&mut rest).split_at_mut(size);
            pieces.push((chunk, piece));
            rest = tail;
        }
        pieces.into_par_iter().for_each(|(chunk, values)| {
            values.fill([[0.0; D]; D]);
            chunk
                .parts
                .iter()
                .for_each(|part| part.hessian(state, filter, values));
        });
        for penalty in &self.penalties {
            penalty.add_hessian(positions, &self.dofs, filter, hessian);
        }
        self.decouple_clamped_axes(hessian);
    }

    /// (∂²E/∂x^U∂x) δx without a matrix; δx is given at every node, so that it serves both the
    /// operator of a conjugate-gradient solve (δx = 0 at prescribed nodes) and the right-hand side
    /// of document 000, eq. 9 (δx ≠ 0 only there).
    pub fn hessian_vector(
        &self,
        positions: &[[f64; D]],
        activations: &[f64],
        displacement: &[[f64; D]],
        product: &mut [f64],
    ) {
        let state = State {
            positions,
            activations,
        };
        self.by_rows(product, |chunk, rows| {
            chunk
                .parts
                .iter()
                .for_each(|part| part.differential(state, displacement, rows));
        });
        for penalty in &self.penalties {
            penalty.add_product(positions, displacement, &self.dofs, product);
        }
        self.clear_clamped_axes(product);
    }

    /// ∂²E/∂x^U∂α_c: minus the force of channel c at unit activation (document 000, eq. 4).
    pub fn activation_gradient(
        &self,
        positions: &[[f64; D]],
        channel: usize,
        gradient: &mut [f64],
    ) {
        let state = State {
            positions,
            activations: &[],
        };
        self.by_rows(gradient, |chunk, rows| {
            chunk
                .parts
                .iter()
                .for_each(|part| part.activation_gradient(state, channel, rows));
        });
        self.clear_clamped_axes(gradient);
    }

    /// Runs `work` on every chunk with its own zeroed run of rows.
    fn by_rows<R: Send>(
        &self,
        rows: &mut [f64],
        work: impl Fn(&Chunk<D>, &mut [[f64; D]]) -> R + Sync,
    ) -> Vec<R> {
        let mut pieces = Vec::with_capacity(self.chunks.len());
        let (mut rest, _) = rows.as_chunks_mut::<D>();
        for chunk in &self.chunks {
            let (piece, tail) = std::mem::take(&mut rest).split_at_mut(chunk.rows.len());
            pieces.push((chunk, piece));
            rest = tail;
        }
        pieces
            .into_par_iter()
            .map(|(chunk, rows)| {
                rows.fill([0.0; D]);
                work(chunk, rows)
            })
            .collect()
    }

    fn clear_clamped_axes(&self, rows: &mut [f64]) {
        for &(row, axis) in self.dofs.clamped_axes() {
            rows[D * row as usize + axis] = 0.0;
        }
    }

    /// Rows and columns of clamped axes of partly free nodes become multiples of unit vectors.
    /// Their right-hand side is 0 and nothing couples to them, so they stay exactly 0 in any solve.
    fn decouple_clamped_axes(&self, hessian: &mut BlockSymmetric<D>) {
        if self.dofs.clamped_axes().is_empty() {
            return;
        }
        let mut clamped = vec![[false; D]; self.dofs.free_nodes()];
        for &(row, axis) in self.dofs.clamped_axes() {
            clamped[row as usize][axis] = true;
        }
        let values = hessian.values_mut();
        for row in 0..self.pattern.blocks() {
            let start = self.pattern.row_start()[row];
            for (offset, &column) in self.pattern.row(row).iter().enumerate() {
                let block = &mut values[start + offset];
                let trace: f64 = (0..D).map(|i| block[i][i].abs()).sum();
                for i in 0..D {
                    for j in 0..D {
                        if clamped[row][i] || clamped[column as usize][j] {
                            let diagonal = column as usize == row && i == j;
                            block[i][j] = if diagonal { trace } else { 0.0 };
                        }
                    }
                }
            }
        }
    }

    fn penalty_energy(&self, positions: &[[f64; D]]) -> f64 {
        self.penalties.iter().map(|p| p.energy(positions)).sum()
    }

    /// Σ over elements in mesh order, compensated: what a line search compares must not depend on
    /// the chunks and should not lose digits.
    fn sum(&self, energies: impl IntoIterator<Item = (u32, f64)>) -> f64 {
        let mut by_element = vec![0.0; self.elements.len()];
        for (element, energy) in energies {
            by_element[element as usize] += energy;
        }
        let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
        for energy in by_element {
            let next = sum + energy;
            lost += if sum.abs() >= energy.abs() {
                (sum - next) + energy
            } else {
                (energy - next) + sum
            };
            sum = next;
        }
        if sum.is_finite() {
            sum + lost
        } else {
            f64::INFINITY
        }
    }
}
