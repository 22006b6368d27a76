//! Triangles and tetrahedra: rest shape, area normals, deformation gradient.

use crate::mat::{Mat, dot, vector};
use crate::scalar::Real;
use thiserror::Error;

/// What a linear simplex keeps of its rest positions X₀ … X_D.
///
/// D_m has the columns X₁ − X₀ … X_D − X₀ (document 000, section 4.4).
///
/// ```
/// use fem_kinematics::{RestShape, deformation_gradient, shape_matrix};
/// let rest = RestShape::from_vertices(&[[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]])?;
/// let Ds = shape_matrix(&[[0.0, 0.0], [2.0, 0.0], [0.0, 3.0]]);
/// let F = deformation_gradient(&Ds, &rest.inverse);
/// assert_eq!((rest.volume, F.determinant()), (1.0, 3.0));
/// # Ok::<(), fem_kinematics::RestShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestShape<T, const D: usize> {
    /// D_m⁻¹, 1/m.
    pub inverse: Mat<T, D>,
    /// |det D_m|/D!: volume in m³, or area in m² for triangles. Positive for either orientation.
    pub volume: T,
}

/// Why a simplex has no rest shape.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RestShapeError {
    /// The number of vertices is not D + 1.
    #[error("a simplex in {dimension}D has {} vertices, {given} were given", dimension + 1)]
    VertexCount {
        /// D.
        dimension: usize,
        /// How many were given.
        given: usize,
    },
    /// A rest position is NaN or infinite.
    #[error("rest position {vertex} of the simplex is not finite: check the mesh's coordinates")]
    NotFinite {
        /// Which vertex, 0 … D.
        vertex: usize,
    },
    /// The vertices lie in one plane (on one line for a triangle), or so nearly that the volume
    /// is rounding error.
    #[error(
        "the rest volume is zero (det D_m = {determinant:e}): remove or repair the flat element"
    )]
    ZeroVolume {
        /// det D_m.
        determinant: f64,
    },
}

impl<T: Real, const D: usize> RestShape<T, D> {
    /// From the rest shape matrix D_m, unchecked: not finite where det D_m = 0.
    #[inline(always)]
    pub fn from_shape_matrix(Dm: &Mat<T, D>) -> Self {
        Self {
            inverse: Dm.inverse(),
            volume: simplex_volume(Dm).abs(),
        }
    }
    /// ∇λ of the barycentric coordinate of vertex `a` = 0 … D, 1/m: row a − 1 of D_m⁻¹, and minus the sum
    /// of the others for a = 0.
    #[inline(always)]
    pub fn barycentric_gradient(&self, a: usize) -> [T; D] {
        if a > 0 {
            return self.inverse.0[a - 1];
        }
        vector(|j| {
            let mut sum = self.inverse.0[0][j];
            for row in &self.inverse.0[1..] {
                sum += row[j];
            }
            -sum
        })
    }
    /// The area normals b₁ … b_D, columns of B_m = −V D_m⁻ᵀ, m² (m for triangles).
    ///
    /// A stress P pulls node a with the force P b_a; b₀ = −Σ b_a.
    // ERRATUM: document 000, section 4.4 prints D_mᵀ B_m = V I; the sign is −.
    #[inline(always)]
    pub fn area_normals(&self) -> Mat<T, D> {
        self.inverse.transpose().scale(-self.volume)
    }
    /// The area normal of vertex `a` = 0 … D.
    #[inline(always)]
    pub fn area_normal(&self, a: usize) -> [T; D] {
        let B = self.area_normals();
        if a > 0 {
            return B.column(a - 1);
        }
        vector(|i| {
            let mut sum = -B.0[i][0];
            for j in 1..D {
                sum -= B.0[i][j];
            }
            sum
        })
    }
}

impl<const D: usize> RestShape<f64, D> {
    /// From the D + 1 rest positions, in meters.
    ///
    /// # Errors
    /// A wrong number of vertices, a position that is not finite, or a volume that is zero to
    /// rounding: |det D_m| ≤ 4ε Π |X_a − X₀|.
    pub fn from_vertices(X: &[[f64; D]]) -> Result<Self, RestShapeError> {
        if X.len() != D + 1 {
            return Err(RestShapeError::VertexCount {
                dimension: D,
                given: X.len(),
            });
        }
        if let Some(vertex) = X.iter().position(|x| !x.iter().all(|c| c.is_finite())) {
            return Err(RestShapeError::NotFinite { vertex });
        }
        let Dm = shape_matrix(X);
        let shape = Self::from_shape_matrix(&Dm);
        let determinant = Dm.determinant();
        let mut bound = 4.0 * f64::EPSILON;
        for j in 0..D {
            let edge = Dm.column(j);
            bound *= dot(edge, edge).sqrt();
        }
        let finite = shape.inverse.0.iter().flatten().all(|x| x.is_finite());
        if determinant.abs() > bound && finite && shape.volume.is_finite() {
            Ok(shape)
        } else {
            Err(RestShapeError::ZeroVolume { determinant })
        }
    }
}

/// D_s (or D_m): the columns x₁ − x₀ … x_D − x₀ of a simplex with D + 1 vertices.
///
/// # Panics
/// If fewer than D + 1 positions are given.
#[inline(always)]
pub fn shape_matrix<T: Real, const D: usize>(x: &[[T; D]]) -> Mat<T, D> {
    Mat::from_fn(|i, j| x[j + 1][i] - x[0][i])
}

/// det D_s/D!, m³ (m² in 2D) of edges in meters: the volume of a simplex with this shape matrix,
/// negative where it is inverted.
#[inline(always)]
pub fn simplex_volume<T: Real, const D: usize>(Ds: &Mat<T, D>) -> T {
    let factorial = if D == 2 { 2.0 } else { 6.0 };
    Ds.determinant() / T::from_f64(factorial)
}

/// F = D_s D_m⁻¹ of a linear simplex: [`deformation_gradient_at`] any of its points.
#[inline(always)]
pub fn deformation_gradient<T: Real, const D: usize>(
    Ds: &Mat<T, D>,
    Dm_inverse: &Mat<T, D>,
) -> Mat<T, D> {
    deformation_gradient_at(&Ds.transpose().0, &Dm_inverse.0)
}

/// F = Σₐ (xₐ − x₀) ∇Nₐᵀ at a point of any element, the sum over all nodes but the first, whose
/// gradient is minus the sum of the others' (document 000, 4.1, for shape functions of any order).
///
/// `edges` are xₐ − x₀ in meters, `gradients` ∇Nₐ in 1/m, in the same order; the longer list is
/// read as far as the shorter one goes, and without any the result is 0.
///
/// ```
/// use fem_kinematics::{deformation_gradient_at, RestShape, Mat};
/// let rest = RestShape::from_vertices(&[[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]])?;
/// let edges = [[2.0, 0.0], [0.0, 3.0]];
/// let F = deformation_gradient_at(&edges, &rest.inverse.0);
/// assert_eq!(F, Mat([[1.0, 0.0], [0.0, 3.0]]));
/// # Ok::<(), fem_kinematics::RestShapeError>(())
/// ```
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn deformation_gradient_at<T: Real, const D: usize>(
    edges: &[[T; D]],
    gradients: &[[T; D]],
) -> Mat<T, D> {
    let count = if edges.len() < gradients.len() {
        edges.len()
    } else {
        gradients.len()
    };
    let mut F = Mat::zeros();
    for i in 0..D {
        for j in 0..D {
            // The first product begins the sum: 0 + x is not x where x is −0.
            let mut entry = T::zero();
            for a in 0..count {
                let product = edges[a][i] * gradients[a][j];
                if a == 0 {
                    entry = product;
                } else {
                    entry += product;
                }
            }
            F.0[i][j] = entry;
        }
    }
    F
}

/// A triangle in space laid into the plane without deforming it: vertex 0 at the origin, the
/// first edge along +x, the triangle on the side of +y.
///
/// With rest and deformed triangle laid flat, a 2D material serves as a membrane. Not finite
/// where the first edge has no length.
#[inline(always)]
pub fn flatten_triangle<T: Real>(x: &[[T; 3]; 3]) -> [[T; 2]; 3] {
    let edge = |a: usize| -> [T; 3] { vector(|i| x[a][i] - x[0][i]) };
    let (e1, e2) = (edge(1), edge(2));
    let length = dot(e1, e1).sqrt();
    let along = vector(|i| e1[i] / length);
    let s = dot(along, e2);
    let across: [T; 3] = vector(|i| e2[i] - s * along[i]);
    let height = dot(across, across).sqrt();
    [[T::zero(); 2], [length, T::zero()], [s, height]]
}
