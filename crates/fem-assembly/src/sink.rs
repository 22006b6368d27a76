//! Where terms write: sums that keep what their owner sums and drop the rest.
//!
//! The methods are small and inlined into the terms' kernels; see `docs/kernels.md`.

use crate::element::LANES;
use fem_kinematics::F64x8;

/// "Not ours": a row or matrix block that another chunk owns, or a prescribed one.
pub(crate) const NONE: u32 = u32::MAX;
/// Marks the place of a block that is stored transposed.
pub(crate) const TRANSPOSED: u32 = 1 << 31;

/// Place of pair (a, b), a ≥ b, in lists of pairs.
#[inline(always)]
pub(crate) const fn pair(a: usize, b: usize) -> usize {
    a * (a + 1) / 2 + b
}

/// Takes the energies of a run of stencils.
#[derive(Debug)]
pub struct EnergySink<'a> {
    pub(crate) first: usize,
    pub(crate) scale: f64,
    pub(crate) energies: &'a mut [f64],
}

impl EnergySink<'_> {
    /// Sets the energy of a stencil, joules.
    ///
    /// # Panics
    /// When the stencil is not in the run.
    #[inline(always)]
    pub fn energy(&mut self, stencil: usize, energy: f64) {
        self.energies[stencil - self.first] = self.scale * energy;
    }
    /// The same sink for a multiple of what is written into it.
    #[must_use]
    pub fn scaled(&mut self, factor: f64) -> EnergySink<'_> {
        EnergySink {
            first: self.first,
            scale: self.scale * factor,
            energies: self.energies,
        }
    }
}

/// What becomes of the vectors that meet in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Summed {
    /// They add up.
    AsTheyAre,
    /// Their entries' absolute values add up: what a sum loses by rounding is `ε` times that.
    Absolutely,
}

/// Takes a vector at each vertex of a run of stencils: a gradient or the product with a Hessian.
#[derive(Debug)]
pub struct GradientSink<'a, const D: usize> {
    pub(crate) first: usize,
    pub(crate) vertices: usize,
    pub(crate) scale: f64,
    /// Row of each (stencil, vertex), [`NONE`] where it is not ours.
    pub(crate) rows: &'a [u32],
    /// Node of each (stencil, vertex) of the whole term.
    pub(crate) nodes: &'a [usize],
    pub(crate) sums: &'a mut [[f64; D]],
    /// Whose energy is ours; empty where no energies are wanted.
    pub(crate) owned: &'a [bool],
    pub(crate) first_energy: usize,
    pub(crate) energies: Option<&'a mut Vec<(u32, f64)>>,
    pub(crate) summed: Summed,
}

impl<const D: usize> GradientSink<'_, D> {
    /// Adds a vector to the row of a stencil's vertex.
    ///
    /// # Panics
    /// When the stencil is not in the run.
    #[inline(always)]
    pub fn add(&mut self, stencil: usize, vertex: usize, vector: [f64; D]) {
        debug_assert!(vertex < self.vertices);
        let row = self.rows[(stencil - self.first) * self.vertices + vertex];
        if row != NONE {
            let sum = &mut self.sums[row as usize];
            for i in 0..D {
                let value = self.scale * vector[i];
                sum[i] += match self.summed {
                    Summed::AsTheyAre => value,
                    Summed::Absolutely => value.abs(),
                };
            }
        }
    }

    /// Adds the vectors of a batch of eight stencils; lanes past the last stencil have no rows.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn add_lanes(&mut self, stencil: usize, vectors: &[[F64x8; D]]) {
        let vertices = vectors.len();
        let start = (stencil - self.first) * vertices;
        let rows = &self.rows[start..start + LANES * vertices];
        // Locals, which the stores into the sums cannot change.
        let (scale, sums) = (self.scale, &mut *self.sums);
        if self.summed == Summed::Absolutely {
            for lane in 0..LANES {
                for a in 0..vertices {
                    let row = rows[lane * vertices + a];
                    if row != NONE {
                        let sum = &mut sums[row as usize];
                        for i in 0..D {
                            sum[i] += (scale * vectors[a][i].0[lane]).abs();
                        }
                    }
                }
            }
            return;
        }
        // Element by element: where the batches of eight are cut must not change the order of a sum.
        if scale == 1.0 {
            for lane in 0..LANES {
                for a in 0..vertices {
                    let row = rows[lane * vertices + a];
                    if row != NONE {
                        let sum = &mut sums[row as usize];
                        for i in 0..D {
                            sum[i] += vectors[a][i].0[lane];
                        }
                    }
                }
            }
        } else {
            for lane in 0..LANES {
                for a in 0..vertices {
                    let row = rows[lane * vertices + a];
                    if row != NONE {
                        let sum = &mut sums[row as usize];
                        for i in 0..D {
                            sum[i] += scale * vectors[a][i].0[lane];
                        }
                    }
                }
            }
        }
    }

    /// Sets the energy of a stencil, joules.
    #[inline(always)]
    pub fn energy(&mut self, stencil: usize, energy: f64) {
        let local = stencil - self.first;
        if local < self.owned.len()
            && self.owned[local]
            && let Some(energies) = &mut self.energies
        {
            energies.push(((self.first_energy + stencil) as u32, self.scale * energy));
        }
    }

    /// Counts a stencil where no energies are asked for, in [`Term::control_gradient`](crate::Term::control_gradient).
    #[inline(always)]
    pub fn evaluated(&mut self, stencil: usize) {
        self.energy(stencil, 0.0);
    }

    /// The same sink for a multiple of what is written into it.
    #[must_use]
    pub fn scaled(&mut self, factor: f64) -> GradientSink<'_, D> {
        GradientSink {
            sums: self.sums,
            energies: self.energies.as_deref_mut(),
            scale: self.scale * factor,
            ..*self
        }
    }

    /// Takes the blocks of a Hessian and adds their product with a displacement of every node, such as
    /// [`Term::hessian_vector`](crate::Term::hessian_vector) is given.
    ///
    /// # Panics
    /// The blocks' sink does, where a node of a stencil has no displacement.
    #[must_use]
    pub fn product_with<'b>(&'b mut self, displacement: &'b [[f64; D]]) -> HessianSink<'b, D> {
        HessianSink {
            scale: 1.0,
            target: Target::Product {
                displacement,
                sums: self.scaled(1.0),
            },
        }
    }
}

/// Takes the blocks ∂²e/∂xₐ∂x_b of a run of stencils.
#[derive(Debug)]
pub struct HessianSink<'a, const D: usize> {
    pub(crate) scale: f64,
    pub(crate) target: Target<'a, D>,
}

#[derive(Debug)]
pub(crate) enum Target<'a, const D: usize> {
    /// The lower half of a matrix.
    Matrix {
        first: usize,
        /// Pairs of vertices of a stencil.
        pairs: usize,
        /// Place of each (stencil, pair) among the values.
        places: &'a [u32],
        values: &'a mut [[[f64; D]; D]],
    },
    /// The product with a displacement.
    Product {
        displacement: &'a [[f64; D]],
        sums: GradientSink<'a, D>,
    },
}

impl<const D: usize> HessianSink<'_, D> {
    /// Adds the blocks of a batch of eight elements, of which the first `used` exist, pair by pair.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn add_lanes(
        &mut self,
        stencil: usize,
        used: usize,
        nodes: usize,
        blocks: &[[[[f64; LANES]; D]; D]],
    ) {
        let all_pairs = pair(nodes, 0);
        if self.scale == 1.0
            && let Target::Matrix {
                first,
                places,
                values,
                ..
            } = &mut self.target
        {
            let start = (stencil - *first) * all_pairs;
            let places = &places[start..start + LANES * all_pairs];
            let values = &mut **values;
            for lane in 0..LANES {
                for p in 0..all_pairs {
                    let place = places[lane * all_pairs + p];
                    // The vertices of an element are sorted: no block is stored transposed.
                    if place != NONE {
                        let value = &mut values[place as usize];
                        for i in 0..D {
                            for j in 0..D {
                                value[i][j] += blocks[p][i][j][lane];
                            }
                        }
                    }
                }
            }
            return;
        }
        for lane in 0..used {
            for a in 0..nodes {
                for b in 0..=a {
                    let mut block = [[0.0; D]; D];
                    for i in 0..D {
                        for j in 0..D {
                            block[i][j] = blocks[pair(a, b)][i][j][lane];
                        }
                    }
                    self.add(stencil + lane, a, b, block);
                }
            }
        }
    }

    /// Adds the block ∂²e/∂xₐ∂x_b; its transpose stands for (b, a) and must not be added too.
    ///
    /// # Panics
    /// When the stencil is not in the run.
    #[inline(always)]
    pub fn add(&mut self, stencil: usize, a: usize, b: usize, block: [[f64; D]; D]) {
        match &mut self.target {
            Target::Matrix {
                first,
                pairs,
                places,
                values,
            } => {
                let p = if a >= b { pair(a, b) } else { pair(b, a) };
                debug_assert!(p < *pairs);
                let place = places[(stencil - *first) * *pairs + p];
                if place == NONE {
                    return;
                }
                let value = &mut values[(place & !TRANSPOSED) as usize];
                if (place & TRANSPOSED != 0) != (a < b) {
                    for i in 0..D {
                        for j in 0..D {
                            value[i][j] += self.scale * block[j][i];
                        }
                    }
                } else {
                    for i in 0..D {
                        for j in 0..D {
                            value[i][j] += self.scale * block[i][j];
                        }
                    }
                }
            }
            Target::Product { displacement, sums } => {
                let start = stencil * sums.vertices;
                let at_a = displacement[sums.nodes[start + a]];
                let at_b = displacement[sums.nodes[start + b]];
                let (mut to_a, mut to_b) = ([0.0; D], [0.0; D]);
                for i in 0..D {
                    for j in 0..D {
                        to_a[i] += self.scale * block[i][j] * at_b[j];
                        to_b[j] += self.scale * block[i][j] * at_a[i];
                    }
                }
                sums.add(stencil, a, to_a);
                if a != b {
                    sums.add(stencil, b, to_b);
                }
            }
        }
    }

    /// The same sink for a multiple of what is written into it.
    #[must_use]
    pub fn scaled(&mut self, factor: f64) -> HessianSink<'_, D> {
        let target = match &mut self.target {
            Target::Matrix {
                first,
                pairs,
                places,
                values,
            } => Target::Matrix {
                first: *first,
                pairs: *pairs,
                places,
                values,
            },
            Target::Product { displacement, sums } => Target::Product {
                displacement,
                sums: sums.scaled(1.0),
            },
        };
        HessianSink {
            scale: self.scale * factor,
            target,
        }
    }
}
