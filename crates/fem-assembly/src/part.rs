//! The passes over elements of one law: energies, nodal gradient, Hessian, differential.
//!
//! A part belongs to a chunk, which owns a run of consecutive matrix rows and evaluates every
//! element that touches them; elements on the border are evaluated by both neighbors. Each row is
//! thus summed by one owner, in the order of the elements, and has the same bits however many
//! chunks or threads there are.

use crate::block::{Block, LANES, PAIRS, RestElement, VERTICES, pair};
use crate::builder::{Entry, Packing};
use crate::dofs::FIXED;
use crate::law::Law;
use fem_kinematics::{F64x8, Mat, Pack, PackedKernel, Real, Tensor4, dispatch_packed};
use fem_materials::HessianProjection;

/// "Not ours": a row or matrix block that another chunk owns, or a prescribed one.
const NONE: u32 = u32::MAX;

/// What the energy depends on.
#[derive(Clone, Copy)]
pub(crate) struct State<'a, const D: usize> {
    /// Position of every node.
    pub positions: &'a [[f64; D]],
    /// Activation of every channel.
    pub activations: &'a [f64],
}

/// The elements of one law in one chunk.
pub(crate) trait Part<const D: usize>: Send + Sync {
    /// (element, energy) of the elements that this chunk owns.
    fn energies(&self, state: State<D>, out: &mut Vec<(u32, f64)>);
    /// Adds ∂E/∂x^U of the chunk's rows; also the energies.
    fn gradient(&self, state: State<D>, rows: &mut [[f64; D]], energies: &mut Vec<(u32, f64)>);
    /// Adds ∂²E/∂x^U∂x^U of the chunk's rows.
    fn hessian(&self, state: State<D>, filter: HessianProjection, values: &mut [[[f64; D]; D]]);
    /// Adds (∂²E/∂x^U∂x) δx of the chunk's rows, δx given at every node.
    fn differential(&self, state: State<D>, displacement: &[[f64; D]], rows: &mut [[f64; D]]);
    /// Adds ∂E/∂x at every vertex of the elements that this chunk owns.
    fn gradient_everywhere(&self, state: State<D>, nodes: &mut [[f64; D]]);
    /// Adds (∂²E/∂x²) δx at every vertex of the elements that this chunk owns.
    fn differential_everywhere(
        &self,
        state: State<D>,
        displacement: &[[f64; D]],
        nodes: &mut [[f64; D]],
    );
    /// Adds ∂²E/∂x^U∂α_c of the chunk's rows for one activation channel.
    fn activation_gradient(&self, state: State<D>, channel: usize, rows: &mut [[f64; D]]);
}

/// Blocks of elements with their places in the chunk's rows and matrix values.
pub(crate) struct Elements<const D: usize, L> {
    law: L,
    blocks: Vec<Block<D>>,
    rows: Vec<[[u32; LANES]; VERTICES]>,
    places: Vec<[[u32; LANES]; PAIRS]>,
    owned: Vec<[u32; LANES]>,
}

impl<const D: usize, L: Law<D>> Elements<D, L> {
    /// Packs the entries of a chunk, eight to a block.
    pub fn pack(law: L, entries: &[Entry], packing: &Packing<D>) -> Self {
        let Packing {
            elements,
            rows: range,
            pattern,
        } = packing;
        let range = range.clone().unwrap_or(0..0);
        let first_value = pattern.row_start()[range.start];
        let local = |row: u32| {
            if row != FIXED && range.contains(&(row as usize)) {
                row - range.start as u32
            } else {
                NONE
            }
        };
        let mut packed = Self {
            law,
            blocks: vec![],
            rows: vec![],
            places: vec![],
            owned: vec![],
        };
        for group in entries.chunks(LANES) {
            let rest: Vec<RestElement<D>> = group
                .iter()
                .map(|entry| elements[entry.element as usize])
                .collect();
            let mut rows = [[NONE; LANES]; VERTICES];
            let mut places = [[NONE; LANES]; PAIRS];
            let mut owned = [NONE; LANES];
            for (lane, (entry, element)) in group.iter().zip(&rest).enumerate() {
                if element.is_prescribed() || local(element.rows[0]) != NONE {
                    owned[lane] = entry.element;
                }
                for a in 0..=D {
                    rows[a][lane] = local(element.rows[a]);
                    for b in 0..=a {
                        if rows[a][lane] == NONE || element.rows[b] == FIXED {
                            continue;
                        }
                        let place =
                            pattern.find(element.rows[a] as usize, element.rows[b] as usize);
                        places[pair(a, b)][lane] = place.map_or(NONE, |p| (p - first_value) as u32);
                    }
                }
            }
            packed.blocks.push(Block::pack(&rest));
            packed.rows.push(rows);
            packed.places.push(places);
            packed.owned.push(owned);
        }
        packed
    }

    #[inline(always)]
    fn record(&self, k: usize, density: F64x8, out: &mut Vec<(u32, f64)>) {
        for lane in 0..self.blocks[k].used {
            if self.owned[k][lane] != NONE {
                out.push((
                    self.owned[k][lane],
                    density.0[lane] * self.blocks[k].volume.0[lane],
                ));
            }
        }
    }

    #[inline(always)]
    fn scatter(&self, k: usize, nodal: &[[F64x8; D]; VERTICES], rows: &mut [[f64; D]]) {
        // Element by element: where the blocks of eight are cut must not change the order of a sum.
        for lane in 0..LANES {
            for a in 0..=D {
                let row = self.rows[k][a][lane];
                if row != NONE {
                    let target = &mut rows[row as usize];
                    for i in 0..D {
                        target[i] += nodal[a][i].0[lane];
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_stiffness(
        &self,
        k: usize,
        stiffness: &[[[[f64; LANES]; VERTICES]; VERTICES]; PAIRS],
        values: &mut [[[f64; D]; D]],
    ) {
        for lane in 0..LANES {
            for p in 0..(D + 1) * (D + 2) / 2 {
                let place = self.places[k][p][lane];
                if place != NONE {
                    let target = &mut values[place as usize];
                    for i in 0..D {
                        for j in 0..D {
                            target[i][j] += stiffness[p][i][j][lane];
                        }
                    }
                }
            }
        }
    }
}

struct EnergyPass<'a, const D: usize, L>(&'a Elements<D, L>, State<'a, D>, &'a mut Vec<(u32, f64)>);
impl<const D: usize, L: Law<D>> PackedKernel for EnergyPass<'_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let Self(part, state, out) = self;
        for (k, block) in part.blocks.iter().enumerate() {
            let F = block.deformation_gradient::<V>(state.positions);
            part.record(k, part.law.energy(k, state.activations, &F).to_lanes(), out);
        }
    }
}

struct GradientPass<'a, const D: usize, L> {
    part: &'a Elements<D, L>,
    state: State<'a, D>,
    rows: &'a mut [[f64; D]],
    energies: &'a mut Vec<(u32, f64)>,
}
impl<const D: usize, L: Law<D>> PackedKernel for GradientPass<'_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        for (k, block) in self.part.blocks.iter().enumerate() {
            let F = block.deformation_gradient::<V>(self.state.positions);
            let (psi, P) = self
                .part
                .law
                .energy_and_stress(k, self.state.activations, &F);
            self.part.record(k, psi.to_lanes(), self.energies);
            self.part.scatter(k, &block.nodal_gradient(&P), self.rows);
        }
    }
}

/// Which field a pass over all nodes adds: the gradient, or the Hessian's product with a field.
struct EverywherePass<'a, const D: usize, L> {
    part: &'a Elements<D, L>,
    state: State<'a, D>,
    displacement: Option<&'a [[f64; D]]>,
    nodes: &'a mut [[f64; D]],
}
impl<const D: usize, L: Law<D>> PackedKernel for EverywherePass<'_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let Self {
            part,
            state,
            displacement,
            nodes,
        } = self;
        for (k, block) in part.blocks.iter().enumerate() {
            let F = block.deformation_gradient::<V>(state.positions);
            let P = match displacement {
                None => part.law.energy_and_stress(k, state.activations, &F).1,
                Some(field) => {
                    let dF = block.deformation_gradient::<V>(field);
                    part.law.stress_differential(k, state.activations, &F, &dF)
                }
            };
            let nodal = block.nodal_gradient(&P);
            for lane in (0..block.used).filter(|&lane| part.owned[k][lane] != NONE) {
                for a in 0..=D {
                    for i in 0..D {
                        nodes[block.nodes[a][lane] as usize][i] += nodal[a][i].0[lane];
                    }
                }
            }
        }
    }
}

struct HessianPass<'a, const D: usize, L> {
    part: &'a Elements<D, L>,
    state: State<'a, D>,
    values: &'a mut [[[f64; D]; D]],
}
impl<const D: usize, L: Law<D>> PackedKernel for HessianPass<'_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let mut pairs = [[[[0.0; LANES]; VERTICES]; VERTICES]; PAIRS];
        for (k, block) in self.part.blocks.iter().enumerate() {
            let F = block.deformation_gradient::<V>(self.state.positions);
            let T = self.part.law.derivative(k, self.state.activations, &F);
            let volume = V::from_lanes(block.volume);
            let stiffness = element_stiffness(&T, &block.inverse_shape::<V>(), volume);
            for (pair, lanes) in stiffness.iter().zip(&mut pairs) {
                for i in 0..D {
                    for j in 0..D {
                        lanes[i][j] = pair.0[i][j].to_lanes().0;
                    }
                }
            }
            self.part.add_stiffness(k, &pairs, self.values);
        }
    }
}

/// The Hessian of filtered elements, one at a time: the filters decompose F, which in registers for
/// three instruction sets would multiply the size of the program for a path that few steps take.
fn filtered_hessian<const D: usize, L: Law<D>>(
    part: &Elements<D, L>,
    state: State<D>,
    filter: HessianProjection,
    values: &mut [[[f64; D]; D]],
) {
    let mut pairs = [[[[0.0; LANES]; VERTICES]; VERTICES]; PAIRS];
    for (k, block) in part.blocks.iter().enumerate() {
        let F = block.deformation_gradient::<F64x8>(state.positions);
        for lane in 0..block.used {
            let of_lane = |m: &Mat<F64x8, D>| Mat::<f64, D>::from_fn(|i, j| m.0[i][j].0[lane]);
            let place = (k, lane);
            let T = part
                .law
                .filtered_derivative(place, state.activations, &of_lane(&F), filter);
            let gradients = of_lane(&block.inverse_shape);
            let stiffness = element_stiffness(&T, &gradients, block.volume.0[lane]);
            for (pair, lanes) in stiffness.iter().zip(&mut pairs) {
                for i in 0..D {
                    for j in 0..D {
                        lanes[i][j][lane] = pair.0[i][j];
                    }
                }
            }
        }
        part.add_stiffness(k, &pairs, values);
    }
}

/// K_ab = V Σⱼₗ (∇Nₐ)ⱼ (∇N_b)ₗ T(j, l) for every pair a ≥ b; vertex 0 follows from Σₐ Nₐ = 1.
#[inline(always)]
fn element_stiffness<T: Real, const D: usize>(
    derivative: &Tensor4<T, D>,
    gradients: &Mat<T, D>,
    volume: T,
) -> [Mat<T, D>; PAIRS] {
    let mut stiffness = [Mat::zeros(); PAIRS];
    let mut corner = Mat::zeros();
    let mut border = [Mat::zeros(); VERTICES];
    for b in 0..D {
        let mut half = [Mat::zeros(); D];
        for j in 0..D {
            half[j] = derivative.0[j][0].scale(gradients.0[b][0]);
            for l in 1..D {
                half[j] += derivative.0[j][l].scale(gradients.0[b][l]);
            }
        }
        for a in b..D {
            let mut block = half[0].scale(gradients.0[a][0]);
            for j in 1..D {
                block += half[j].scale(gradients.0[a][j]);
            }
            let block = block.scale(volume);
            stiffness[pair(a + 1, b + 1)] = block;
            border[a + 1] -= block;
            if a != b {
                border[b + 1] -= block.transpose();
            }
        }
    }
    for a in 1..=D {
        stiffness[pair(a, 0)] = border[a];
        corner -= border[a];
    }
    stiffness[0] = corner.symmetric_part();
    stiffness
}

struct DifferentialPass<'a, const D: usize, L> {
    part: &'a Elements<D, L>,
    state: State<'a, D>,
    displacement: &'a [[f64; D]],
    rows: &'a mut [[f64; D]],
}
impl<const D: usize, L: Law<D>> PackedKernel for DifferentialPass<'_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        for (k, block) in self.part.blocks.iter().enumerate() {
            let F = block.deformation_gradient::<V>(self.state.positions);
            let dF = block.deformation_gradient::<V>(self.displacement);
            let dP = self
                .part
                .law
                .stress_differential(k, self.state.activations, &F, &dF);
            self.part.scatter(k, &block.nodal_gradient(&dP), self.rows);
        }
    }
}

struct ActivationPass<'a, const D: usize, L> {
    part: &'a Elements<D, L>,
    state: State<'a, D>,
    channel: usize,
    rows: &'a mut [[f64; D]],
}
impl<const D: usize, L: Law<D>> PackedKernel for ActivationPass<'_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        for (k, block) in self.part.blocks.iter().enumerate() {
            if !self.part.law.has_channel(k, self.channel) {
                continue;
            }
            let F = block.deformation_gradient::<V>(self.state.positions);
            let P = self.part.law.stress_by_activation(k, self.channel, &F);
            self.part.scatter(k, &block.nodal_gradient(&P), self.rows);
        }
    }
}

impl<const D: usize, L: Law<D>> Part<D> for Elements<D, L> {
    fn energies(&self, state: State<D>, out: &mut Vec<(u32, f64)>) {
        dispatch_packed(EnergyPass(self, state, out));
    }
    fn gradient(&self, state: State<D>, rows: &mut [[f64; D]], energies: &mut Vec<(u32, f64)>) {
        dispatch_packed(GradientPass {
            part: self,
            state,
            rows,
            energies,
        });
    }
    fn hessian(&self, state: State<D>, filter: HessianProjection, values: &mut [[[f64; D]; D]]) {
        match filter {
            HessianProjection::None => dispatch_packed(HessianPass {
                part: self,
                state,
                values,
            }),
            _ => filtered_hessian(self, state, filter, values),
        }
    }
    fn differential(&self, state: State<D>, displacement: &[[f64; D]], rows: &mut [[f64; D]]) {
        dispatch_packed(DifferentialPass {
            part: self,
            state,
            displacement,
            rows,
        });
    }
    fn gradient_everywhere(&self, state: State<D>, nodes: &mut [[f64; D]]) {
        dispatch_packed(EverywherePass {
            part: self,
            state,
            displacement: None,
            nodes,
        });
    }
    fn differential_everywhere(
        &self,
        state: State<D>,
        displacement: &[[f64; D]],
        nodes: &mut [[f64; D]],
    ) {
        dispatch_packed(EverywherePass {
            part: self,
            state,
            displacement: Some(displacement),
            nodes,
        });
    }
    fn activation_gradient(&self, state: State<D>, channel: usize, rows: &mut [[f64; D]]) {
        dispatch_packed(ActivationPass {
            part: self,
            state,
            channel,
            rows,
        });
    }
}
