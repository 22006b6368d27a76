//! Volume without locking: the volumetric energy of patches of elements instead of single ones.

use crate::builder::AssemblyBuilder;
use crate::configuration::Configuration;
use crate::error::{AssemblyError, check_length};
use crate::patches::VolumePatches;
use crate::shape::Linear;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::{HessianProjection, Mat, Tensor4};
use std::collections::BTreeMap;
use std::ops::Range;

impl<const D: usize> AssemblyBuilder<D, Linear> {
    /// Adds E = Σ V_p κ/2 (J̄_p − 1)² over patches p of elements, J̄_p = Σ v_e/Σ V_e being the ratio of
    /// their current to their rest volume and `bulk` κ (pascals) of each element, averaged over the
    /// patch by volume.
    ///
    /// Give the elements a material that is compressible (Poisson's ratio about 0.4 stabilizes
    /// them) and the patches the rest of λ: linear simplices, which lock where each must keep its
    /// own volume, then have one constraint for each patch.
    ///
    /// # Errors
    /// When an element does not exist, or a number is negative or not finite.
    pub fn mean_volume(
        mut self,
        patches: &VolumePatches,
        bulk: &[f64],
    ) -> Result<Self, AssemblyError> {
        let count = self.elements().len();
        check_length("bulk moduli", bulk.len(), count)?;
        if let Some((index, &factor)) = (0..)
            .zip(bulk)
            .find(|(_, k)| !(**k >= 0.0 && k.is_finite()))
        {
            return Err(AssemblyError::NegativeStiffness { index, factor });
        }
        // A term has stencils of one size.
        let mut by_size: BTreeMap<usize, Vec<Patch<D>>> = BTreeMap::new();
        for members in patches.lists() {
            if let Some(&(element, _)) = members.iter().find(|(e, _)| *e >= count) {
                return Err(AssemblyError::NoSuchElement { element, count });
            }
            let patch = Patch::new(&self, members, bulk);
            if patch.bulk > 0.0 {
                by_size.entry(patch.nodes.len()).or_default().push(patch);
            }
        }
        for (size, patches) in by_size {
            self = self.term(MeanVolume { size, patches })?;
        }
        Ok(self)
    }
}

/// One patch.
struct Patch<const D: usize> {
    nodes: Vec<u32>,
    /// Vertices of each simplex (places in `nodes`), positively oriented at rest, and its share.
    simplices: Vec<([u32; 4], f64)>,
    /// Σ of the shares of rest volumes, m³.
    volume: f64,
    /// κ, Pa.
    bulk: f64,
    /// A mesh element to name.
    element: usize,
}

impl<const D: usize> Patch<D> {
    fn new(builder: &AssemblyBuilder<D>, members: &[(usize, f64)], bulk: &[f64]) -> Self {
        let elements = builder.elements();
        let mut nodes: Vec<u32> = members
            .iter()
            .flat_map(|&(e, _)| elements.nodes_of(e))
            .copied()
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        let (mut volume, mut stiffness) = (0.0, 0.0);
        let mut simplices = Vec::with_capacity(members.len());
        for &(e, share) in members {
            let of_element = share * elements.volume(e);
            volume += of_element;
            stiffness += of_element * bulk[e];
            let corners = elements.nodes_of(e);
            let mut places = [0; 4];
            for (place, node) in places.iter_mut().zip(corners) {
                *place = nodes.partition_point(|n| n < node) as u32;
            }
            let rest: Vec<[f64; D]> = corners
                .iter()
                .map(|&n| builder.rest()[n as usize])
                .collect();
            if fem_kinematics::shape_matrix(&rest).determinant() < 0.0 {
                places.swap(0, 1);
            }
            simplices.push((places, share));
        }
        Self {
            nodes,
            simplices,
            volume,
            bulk: if volume > 0.0 {
                stiffness / volume
            } else {
                0.0
            },
            element: members.first().map_or(0, |m| m.0),
        }
    }

    /// D_s of a simplex.
    fn shape(&self, vertices: &[u32; 4], field: &[[f64; D]]) -> Mat<f64, D> {
        let at = |a: usize| &field[self.nodes[vertices[a] as usize] as usize];
        let origin = at(0);
        Mat::from_fn(|i, j| at(j + 1)[i] - origin[i])
    }

    const FACTORIAL: f64 = if D == 2 { 2.0 } else { 6.0 };

    /// J̄ − 1.
    fn dilation(&self, x: &[[f64; D]]) -> f64 {
        let of = |(vertices, share): &([u32; 4], f64)| {
            share * self.shape(vertices, x).determinant() / Self::FACTORIAL
        };
        let current: f64 = self.simplices.iter().map(of).sum();
        (current - self.volume) / self.volume
    }

    /// V_p κ/2 (J̄ − 1)², joules.
    fn energy(&self, dilation: f64) -> f64 {
        0.5 * self.bulk * self.volume * dilation * dilation
    }

    /// ∂v/∂x, v = Σ share v_e, at each node.
    fn volume_gradient(&self, x: &[[f64; D]], gradient: &mut [[f64; D]]) {
        gradient.fill([0.0; D]);
        for (vertices, share) in &self.simplices {
            let cofactor = self.shape(vertices, x).cofactor();
            self.add_columns(vertices, &cofactor.scale(share / Self::FACTORIAL), gradient);
        }
    }

    /// Adds the columns of a derivative by D_s to the vertices.
    fn add_columns(&self, vertices: &[u32; 4], columns: &Mat<f64, D>, out: &mut [[f64; D]]) {
        for j in 0..D {
            for i in 0..D {
                out[vertices[j + 1] as usize][i] += columns.0[i][j];
                out[vertices[0] as usize][i] -= columns.0[i][j];
            }
        }
    }
}

/// Patches of one number of nodes.
struct MeanVolume<const D: usize> {
    size: usize,
    patches: Vec<Patch<D>>,
}

impl<const D: usize> MeanVolume<D> {
    /// The tensor p ∂²det/∂D_s² of a simplex, projected.
    fn curvature(
        shape: &Mat<f64, D>,
        factor: f64,
        projection: HessianProjection,
    ) -> Tensor4<f64, D> {
        let plain = Tensor4::from_linear_map(|d| shape.cofactor_differential(d).scale(factor));
        projection.apply(&plain)
    }
}

impl<const D: usize> Term<D> for MeanVolume<D> {
    fn stencils(&self) -> Stencils {
        let nodes = self.patches.iter().flat_map(|patch| &patch.nodes);
        Stencils {
            nodes: nodes.map(|&n| n as usize).collect(),
            vertices: self.size,
            batch: 1,
        }
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            let patch = &self.patches[s];
            sink.energy(s, patch.energy(patch.dilation(at.positions())));
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        let mut by_node = vec![[0.0; D]; self.size];
        for s in stencils {
            let patch = &self.patches[s];
            let dilation = patch.dilation(at.positions());
            sink.energy(s, patch.energy(dilation));
            patch.volume_gradient(at.positions(), &mut by_node);
            for (a, gradient) in by_node.iter().enumerate() {
                sink.add(s, a, gradient.map(|g| patch.bulk * dilation * g));
            }
        }
    }
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        let mut by_node = vec![[0.0; D]; self.size];
        let mut blocks = vec![Mat::<f64, D>::zeros(); self.size * self.size];
        for s in stencils {
            let patch = &self.patches[s];
            let pressure = patch.bulk * patch.dilation(at.positions());
            patch.volume_gradient(at.positions(), &mut by_node);
            let along = patch.bulk / patch.volume;
            for a in 0..self.size {
                for b in 0..=a {
                    blocks[a * self.size + b] =
                        Mat::outer(by_node[a].map(|g| along * g), by_node[b]);
                }
            }
            for (vertices, share) in &patch.simplices {
                let factor = pressure * share / Patch::<D>::FACTORIAL;
                let shape = patch.shape(vertices, at.positions());
                let tensor = Self::curvature(&shape, factor, projection);
                add_simplex(&tensor, vertices, self.size, &mut blocks);
            }
            for a in 0..self.size {
                for b in 0..=a {
                    sink.add(s, a, b, blocks[a * self.size + b].0);
                }
            }
        }
    }
    fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        let mut gradient = vec![[0.0; D]; self.size];
        let mut product = vec![[0.0; D]; self.size];
        for s in stencils {
            let patch = &self.patches[s];
            let pressure = patch.bulk * patch.dilation(at.positions());
            patch.volume_gradient(at.positions(), &mut gradient);
            product.fill([0.0; D]);
            for (vertices, share) in &patch.simplices {
                let shape = patch.shape(vertices, at.positions());
                let d = patch.shape(vertices, displacement);
                let factor = pressure * share / Patch::<D>::FACTORIAL;
                let columns = shape.cofactor_differential(&d).scale(factor);
                patch.add_columns(vertices, &columns, &mut product);
            }
            let moved: f64 = (gradient.iter().zip(&patch.nodes))
                .map(|(g, &n)| fem_kinematics::dot(*g, displacement[n as usize]))
                .sum();
            let along = patch.bulk / patch.volume * moved;
            for (a, (product, gradient)) in product.iter().zip(&gradient).enumerate() {
                sink.add(
                    s,
                    a,
                    std::array::from_fn(|i| product[i] + along * gradient[i]),
                );
            }
        }
    }
    fn element(&self, stencil: usize) -> Option<usize> {
        Some(self.patches[stencil].element)
    }
}

/// Adds a second derivative by D_s to the lower half of a patch's blocks.
fn add_simplex<const D: usize>(
    tensor: &Tensor4<f64, D>,
    vertices: &[u32; 4],
    size: usize,
    blocks: &mut [Mat<f64, D>],
) {
    // Block (j, l) couples columns j and l of D_s, which are vertices j + 1 and l + 1 less vertex 0.
    let mut of_pair = [[Mat::<f64, D>::zeros(); 4]; 4];
    for j in 0..D {
        for l in 0..D {
            let block = tensor.0[j][l];
            of_pair[j + 1][l + 1] += block;
            of_pair[j + 1][0] -= block;
            of_pair[0][l + 1] -= block;
            of_pair[0][0] += block;
        }
    }
    for a in 0..=D {
        for b in 0..=D {
            let (row, column) = (vertices[a] as usize, vertices[b] as usize);
            if row >= column {
                blocks[row * size + column] += of_pair[a][b];
            }
        }
    }
}
