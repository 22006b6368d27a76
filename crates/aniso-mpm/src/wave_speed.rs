//! The fastest elastic wave of a material.

use crate::float::worse;
use fem_kinematics::Mat;
use fem_materials::DamageField;

/// Speed of the fastest elastic wave in the directions of the axes at deformation F, m/s, for a
/// rest density `density` (kg/m³): √(a·A(n)a/ρ₀) with the acoustic tensor A of the current shape.
pub fn wave_speed<M: DamageField<D>, const D: usize>(
    material: &M,
    F: &Mat<f64, D>,
    d: f64,
    density: f64,
) -> f64 {
    let local = M::at_damage(d);
    let mut stiffest = 0.0f64;
    for n in 0..D {
        // Amplitude e_a, wave vector e_n in the world, Fᵀ e_n in the fiber frame.
        let pulled_back = F.0[n];
        for a in 0..D {
            let mut dF = Mat::<f64, D>::zeros();
            dF.0[a] = pulled_back;
            let dP = material.stress_differential(&local, F, &dF);
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
