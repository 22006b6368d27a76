//! Eight elements side by side, as the kernels read them.

use crate::rest::RestElements;
use crate::shape::ElementShape;
use fem_kinematics::{F64x8, Mat, Pack, deformation_gradient_at};

/// Elements in one batch: the lanes of [`F64x8`].
pub(crate) const LANES: usize = 8;

/// Eight elements. Unused lanes repeat the last element with weight 0.
#[derive(Clone, Copy)]
pub(crate) struct ElementBatch<const D: usize, S: ElementShape<D>> {
    pub nodes: S::Nodes<[u32; LANES]>,
    pub points: S::Points<QuadraturePoint<D, S>>,
    /// How many lanes are in use.
    pub used: usize,
}

/// The same quadrature point of eight elements.
#[derive(Clone, Copy)]
pub(crate) struct QuadraturePoint<const D: usize, S: ElementShape<D>> {
    /// ∇N of every node but the first, 1/m.
    gradients: S::Rows<[F64x8; D]>,
    /// Its share of the element's volume, m³ (m² in 2D).
    pub weight: F64x8,
}

impl<const D: usize, S: ElementShape<D>> ElementBatch<D, S> {
    /// Packs one to eight elements.
    pub fn pack(chosen: &[u32], elements: &RestElements<D>) -> Self {
        let empty = QuadraturePoint {
            gradients: S::rows([F64x8::default(); D]),
            weight: F64x8::default(),
        };
        let mut batch = Self {
            nodes: S::nodes([0; LANES]),
            points: S::points(empty),
            used: chosen.len(),
        };
        for lane in 0..LANES {
            let element = chosen[lane.min(chosen.len() - 1)] as usize;
            let nodes = batch.nodes.as_mut();
            for (place, &node) in nodes.iter_mut().zip(elements.nodes_of(element)) {
                place[lane] = node;
            }
            for (k, point) in batch.points.as_mut().iter_mut().enumerate() {
                let rows = point.gradients.as_mut();
                for (row, gradient) in rows.iter_mut().zip(elements.gradients_of(element, k)) {
                    for j in 0..D {
                        row[j].0[lane] = gradient[j];
                    }
                }
                if lane < chosen.len() {
                    point.weight.0[lane] = elements.weights_of(element)[k];
                }
            }
        }
        batch
    }

    /// A nodal field at every node but the first, less that at the first: the columns of D_s. The same for
    /// every material and every kind of register, so compiled once for each shape.
    #[inline(never)]
    pub fn edges(&self, field: &[[f64; D]]) -> S::Rows<[F64x8; D]> {
        let mut edges = S::rows([F64x8::default(); D]);
        let (rows, nodes) = (edges.as_mut(), self.nodes.as_ref());
        for lane in 0..LANES {
            let origin = field[nodes[0][lane] as usize];
            for a in 0..S::NODES - 1 {
                let vertex = field[nodes[a + 1][lane] as usize];
                for i in 0..D {
                    rows[a][i].0[lane] = vertex[i] - origin[i];
                }
            }
        }
        edges
    }
}

/// The lanes of each row that `V` holds, from `first` on.
#[inline(always)]
fn load<const D: usize, S: ElementShape<D>, V: Pack>(
    rows: &S::Rows<[F64x8; D]>,
    first: usize,
) -> S::Rows<[V; D]> {
    let mut packed = S::rows([V::zero(); D]);
    let (to, from) = (packed.as_mut(), rows.as_ref());
    for a in 0..S::NODES - 1 {
        for j in 0..D {
            to[a][j] = V::load(&from[a][j].0, first);
        }
    }
    packed
}

/// `first` is the first of the lanes that `V` holds.
impl<const D: usize, S: ElementShape<D>> QuadraturePoint<D, S> {
    /// F = Σₐ xₐ ∇Nₐᵀ of positions; dF of displacements. For a linear simplex it is D_s D_m⁻¹
    /// (document 000, 4.1).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn deformation_gradient<V: Pack>(
        &self,
        edges: &S::Rows<[F64x8; D]>,
        first: usize,
    ) -> Mat<V, D> {
        let edges = load::<D, S, V>(edges, first);
        deformation_gradient_at(edges.as_ref(), self.gradients(first).as_ref())
    }

    /// ∇N of the nodes but the first, in registers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn gradients<V: Pack>(&self, first: usize) -> S::Rows<[V; D]> {
        load::<D, S, V>(&self.gradients, first)
    }

    /// Adds ∂E/∂x at each node, w P ∇Nₐ: minus the finite-volume force g = P B_m of document 000,
    /// 4.4.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn add_nodal_gradient<V: Pack>(
        &self,
        P: &Mat<V, D>,
        first: usize,
        sums: &mut S::Nodes<[V; D]>,
    ) {
        let weight = V::load(&self.weight.0, first);
        let (gradients, sums) = (self.gradients.as_ref(), sums.as_mut());
        for a in 0..S::NODES - 1 {
            let mut gradient = [V::zero(); D];
            for j in 0..D {
                gradient[j] = V::load(&gradients[a][j].0, first);
            }
            let column = P.mul_vec(gradient);
            for i in 0..D {
                let force = column[i] * weight;
                sums[0][i] -= force;
                sums[a + 1][i] += force;
            }
        }
    }
}
