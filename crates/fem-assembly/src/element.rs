//! Eight elements side by side, as the kernels read them.

use crate::error::AssemblyError;
use fem_kinematics::{F64x8, Lanes, Mat, Pack};

/// Elements in one batch: the lanes of [`F64x8`].
pub(crate) const LANES: usize = 8;
/// Most vertices that a simplex has here; triangles use three of the four places.
pub(crate) const VERTICES: usize = 4;
/// Most pairs (a ≥ b) of vertices: the lower half of the element stiffness.
pub(crate) const PAIRS: usize = VERTICES * (VERTICES + 1) / 2;

/// The rest state of one simplex. Vertices are sorted by their row among the unknowns, prescribed
/// ones last, so that the lower half of its stiffness lands in the lower half of the Hessian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RestElement<const D: usize> {
    pub nodes: [u32; VERTICES],
    /// Its first row, `u32::MAX` where all its vertices are prescribed.
    pub first_row: u32,
    /// D_m⁻¹: row a − 1 is the gradient of the shape function of vertex a.
    pub inverse_shape: Mat<f64, D>,
    /// |det D_m|/D!
    pub volume: f64,
}

impl<const D: usize> RestElement<D> {
    pub fn new(
        element: usize,
        nodes: &[u32],
        rest: &[[f64; D]],
        rank: &[u32],
    ) -> Result<Self, AssemblyError> {
        let mut sorted = [0; VERTICES];
        for (place, &node) in sorted.iter_mut().zip(nodes) {
            if node as usize >= rest.len() {
                let (node, count) = (node as usize, rest.len());
                return Err(AssemblyError::NoSuchNode { node, count });
            }
            *place = node;
        }
        sorted[..=D].sort_by_key(|&n| (rank[n as usize], n));
        let origin = rest[sorted[0] as usize];
        let shape = Mat::<f64, D>::from_fn(|i, j| rest[sorted[j + 1] as usize][i] - origin[i]);
        let factorial = if D == 2 { 2.0 } else { 6.0 };
        let volume = shape.determinant().abs() / factorial;
        let inverse_shape = shape.inverse();
        let usable = volume > 0.0
            && volume.is_finite()
            && inverse_shape.0.iter().flatten().all(|v| v.is_finite());
        if !usable {
            let nodes = nodes.to_vec();
            return Err(AssemblyError::DegenerateElement {
                element,
                volume,
                nodes,
            });
        }
        Ok(Self {
            nodes: sorted,
            first_row: rank[sorted[0] as usize],
            inverse_shape,
            volume,
        })
    }
}

/// Eight elements. Unused lanes repeat the last element with volume 0.
#[derive(Clone, Debug)]
pub(crate) struct ElementBatch<const D: usize> {
    pub nodes: [[u32; LANES]; VERTICES],
    pub inverse_shape: Mat<F64x8, D>,
    pub volume: F64x8,
    /// How many lanes are in use.
    pub used: usize,
}

impl<const D: usize> ElementBatch<D> {
    /// Packs one to eight elements.
    pub fn pack(elements: &[RestElement<D>]) -> Self {
        let at = |lane: usize| &elements[lane.min(elements.len() - 1)];
        Self {
            nodes: core::array::from_fn(|a| core::array::from_fn(|lane| at(lane).nodes[a])),
            inverse_shape: Mat::from_fn(|i, j| {
                Lanes(core::array::from_fn(|lane| at(lane).inverse_shape.0[i][j]))
            }),
            volume: Lanes(core::array::from_fn(|lane| {
                if lane < elements.len() {
                    elements[lane].volume
                } else {
                    0.0
                }
            })),
            used: elements.len(),
        }
    }

    /// D_s of a nodal field: column a − 1 is the field at vertex a less that at vertex 0.
    #[inline(always)]
    fn shape_matrix(&self, field: &[[f64; D]]) -> Mat<F64x8, D> {
        let mut shape = Mat::<F64x8, D>::zeros();
        for lane in 0..LANES {
            let origin = field[self.nodes[0][lane] as usize];
            for a in 0..D {
                let vertex = field[self.nodes[a + 1][lane] as usize];
                for i in 0..D {
                    shape.0[i][a].0[lane] = vertex[i] - origin[i];
                }
            }
        }
        shape
    }

    /// F = D_s D_m⁻¹ of positions; dF of displacements (document 000, 4.1).
    #[inline(always)]
    pub fn deformation_gradient<V: Pack>(&self, field: &[[f64; D]]) -> Mat<V, D> {
        let shape = self.shape_matrix(field);
        Mat::from_fn(|i, j| V::from_lanes(shape.0[i][j])) * self.inverse_shape()
    }

    /// D_m⁻¹ in registers.
    #[inline(always)]
    pub fn inverse_shape<V: Pack>(&self) -> Mat<V, D> {
        Mat::from_fn(|i, j| V::from_lanes(self.inverse_shape.0[i][j]))
    }

    /// ∂E/∂x at each vertex, V P ∇Nₐ: minus the finite-volume force g = P B_m of document 000, 4.4.
    #[inline(always)]
    pub fn nodal_gradient<V: Pack>(&self, P: &Mat<V, D>) -> [[F64x8; D]; VERTICES] {
        let volume = V::from_lanes(self.volume);
        let inverse_shape = self.inverse_shape::<V>();
        let mut first = [V::zero(); D];
        let mut gradient = [[F64x8::default(); D]; VERTICES];
        for a in 0..D {
            let column = P.mul_vec(inverse_shape.0[a]);
            for i in 0..D {
                let force = column[i] * volume;
                first[i] -= force;
                gradient[a + 1][i] = force.to_lanes();
            }
        }
        gradient[0] = first.map(V::to_lanes);
        gradient
    }
}
