//! What the host asks of a constitutive model: energy and stress, with damage.

use crate::float::worse;
use fem_kinematics::{Mat, Real};
use fem_materials::Material;

/// A hyperelastic law whose stiffness may fall with a damage variable d ∈ [0, 1].
///
/// `F` maps the particle's fiber frame to the world: a particle whose fibers lie along the unit
/// vector a starts with a rotation whose first column is a, and every direction in a law (e₁, e₂)
/// is then a fiber direction without any rotation at run time.
pub trait Law<const D: usize>: Copy + Send + Sync {
    /// ψ(F, d), J/m³ of rest volume.
    fn energy<T: Real>(&self, F: &Mat<T, D>, d: T) -> T;
    /// First Piola-Kirchhoff stress P = ∂ψ/∂F at damage d, Pa.
    fn stress<T: Real>(&self, F: &Mat<T, D>, d: T) -> Mat<T, D>;
    /// dP = ∂P/∂F : dF at damage d, Pa.
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>, d: T) -> Mat<T, D>;
}

/// Any [`Material`] as a law that ignores damage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic<M>(pub M);

impl<M: Material<D>, const D: usize> Law<D> for Elastic<M> {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>, _: T) -> T {
        self.0.energy(F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>, _: T) -> Mat<T, D> {
        self.0.stress(F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>, _: T) -> Mat<T, D> {
        self.0.stress_differential(F, dF)
    }
}

/// Speed of the fastest elastic wave in the directions of the axes at deformation F, m/s, for a
/// rest density `density` (kg/m³): √(a·A(n)a/ρ₀) with the acoustic tensor A of the current shape.
pub fn wave_speed<L: Law<D>, const D: usize>(
    law: &L,
    F: &Mat<f64, D>,
    d: f64,
    density: f64,
) -> f64 {
    let mut stiffest = 0.0f64;
    for n in 0..D {
        // Amplitude e_a, wave vector e_n in the world, Fᵀ e_n in the fiber frame.
        let pulled_back = F.0[n];
        for a in 0..D {
            let mut dF = Mat::<f64, D>::zeros();
            dF.0[a] = pulled_back;
            let dP = law.stress_differential(F, &dF, d);
            // The row sum bounds the largest eigenvalue of the acoustic tensor (Gershgorin).
            let row: f64 = (0..D)
                .map(|b| {
                    (0..D)
                        .map(|k| dP.0[b][k] * pulled_back[k])
                        .sum::<f64>()
                        .abs()
                })
                .sum();
            stiffest = worse(stiffest, row);
        }
    }
    (stiffest / density).sqrt()
}
