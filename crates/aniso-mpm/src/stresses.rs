//! Kirchhoff stresses of the particles, eight side by side.

use crate::body::Body;
use crate::float::Float;
use crate::particles::Particles;
use fem_kinematics::{Mat, Pack, PackedKernel, dispatch_packed};
use fem_materials::DamageField;
use fem_solvers::parallel;

/// Particles handled by one task, a multiple of eight.
const CHUNK: usize = 1024;

/// τ = P(F, d) Fᵀ of every particle in a body that is `wanted`, Pa, and 0 for the others. `damage`
/// is d, or 0 everywhere. Always computed in `f64`: that is what lanes are made of.
pub(crate) fn kirchhoff_stresses<T: Float, M: DamageField<D>, const D: usize>(
    particles: &Particles<T, D>,
    bodies: &[Body<M, D>],
    damage: Option<&[T]>,
    wanted: impl Fn(&Body<M, D>) -> bool + Sync,
    tau: &mut Vec<Mat<T, D>>,
) {
    tau.resize(particles.len(), Mat::zeros());
    parallel::each(tau.chunks_mut(CHUNK).enumerate(), |(chunk, tau)| {
        let first = chunk * CHUNK;
        let last = first + tau.len();
        let of_particle = &particles.body[first..last];
        let mut present = vec![of_particle[0]];
        if of_particle.iter().any(|&body| body != present[0]) {
            present.extend_from_slice(of_particle);
            present.sort_unstable();
            present.dedup();
        }
        for &body in &present {
            let of_body = &bodies[usize::from(body)];
            if !wanted(of_body) {
                for (tau, _) in tau.iter_mut().zip(of_particle).filter(|(_, b)| **b == body) {
                    *tau = Mat::zeros();
                }
                continue;
            }
            dispatch_packed(OfBody {
                material: &of_body.material,
                body: (present.len() > 1).then_some(body),
                bodies: of_particle,
                F: &particles.F[first..last],
                damage: damage.map(|d| &d[first..last]),
                tau: &mut *tau,
            });
        }
    });
}

struct OfBody<'a, M, T, const D: usize> {
    material: &'a M,
    /// The body that has this material, if there are others in `bodies`.
    body: Option<u16>,
    bodies: &'a [u16],
    F: &'a [Mat<T, D>],
    damage: Option<&'a [T]>,
    tau: &'a mut [Mat<T, D>],
}
impl<M: DamageField<D>, T: Float, const D: usize> PackedKernel for OfBody<'_, M, T, D> {
    type Output = ();
    const WAITS: bool = true;
    #[inline(always)]
    fn run<V: Pack>(self) {
        let count = self.F.len();
        for first in (0..count).step_by(8) {
            let last = count.min(first + 8);
            let here = |p: usize| self.body.is_none_or(|b| b == self.bodies[p]);
            if self.body.is_some() && !(first..last).any(here) {
                continue;
            }
            // Lanes without a particle repeat the last one.
            let (some_F, some_d);
            let F = match self.F[first..last].first_chunk() {
                Some(eight) => eight,
                None => {
                    some_F = padded(&self.F[first..last], Mat::zeros());
                    &some_F
                }
            };
            let damage = self.damage.map_or(&[][..], |damage| &damage[first..last]);
            let d = match damage.first_chunk() {
                Some(eight) => eight,
                None => {
                    some_d = padded(damage, T::zero());
                    &some_d
                }
            };
            match self.tau[first..last].first_chunk_mut::<8>() {
                Some(tau) if self.body.is_none() => {
                    eight_stresses::<V, M, T, D>(self.material, F, d, tau);
                }
                _ => {
                    let mut tau = [Mat::zeros(); 8];
                    eight_stresses::<V, M, T, D>(self.material, F, d, &mut tau);
                    for (p, tau) in (first..last).zip(tau) {
                        if here(p) {
                            self.tau[p] = tau;
                        }
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn eight_stresses<V: Pack, M: DamageField<D>, T: Float, const D: usize>(
    material: &M,
    F: &[Mat<T, D>; 8],
    d: &[T; 8],
    tau: &mut [Mat<T, D>; 8],
) {
    let mut packed = [[[0.0; 8]; D]; D];
    let mut damage = [0.0; 8];
    for lane in 0..8 {
        for i in 0..D {
            for j in 0..D {
                packed[i][j][lane] = F[lane].0[i][j].to_f64();
            }
        }
        damage[lane] = d[lane].to_f64();
    }
    for part in 0..8 / V::WIDTH {
        let first = part * V::WIDTH;
        let mut F = Mat::<V, D>::zeros();
        for i in 0..D {
            for j in 0..D {
                F.0[i][j] = V::load(&packed[i][j], first);
            }
        }
        let local = M::at_damage(V::load(&damage, first));
        let stress = material.stress(&local, &F).mul_tr(&F);
        for i in 0..D {
            for j in 0..D {
                stress.0[i][j].store(&mut packed[i][j], first);
            }
        }
    }
    for lane in 0..8 {
        for i in 0..D {
            for j in 0..D {
                tau[lane].0[i][j] = T::from_f64(packed[i][j][lane]);
            }
        }
    }
}

/// Fewer than eight, and then the last of them again, or `none`.
#[inline(always)]
fn padded<R: Copy>(from: &[R], none: R) -> [R; 8] {
    let mut eight = [from.last().copied().unwrap_or(none); 8];
    for (to, from) in eight.iter_mut().zip(from) {
        *to = *from;
    }
    eight
}
