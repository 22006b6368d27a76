//! The stiffness of one element from dP/dF.

use crate::shape::ElementShape;
use crate::sink::pair;
use fem_kinematics::{Mat, Real, Tensor4};

/// Adds K_ab = w Σⱼₗ (∇Nₐ)ⱼ (∇N_b)ₗ T(j, l) for every pair a ≥ b; node 0 follows from Σₐ Nₐ = 1.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn element_stiffness<T: Real, S: ElementShape<D>, const D: usize>(
    derivative: &Tensor4<T, D>,
    gradients: &S::Rows<[T; D]>,
    weight: T,
    stiffness: &mut S::Pairs<Mat<T, D>>,
) {
    let (gradients, stiffness) = (gradients.as_ref(), stiffness.as_mut());
    let mut corner = Mat::zeros();
    let mut border = S::nodes(Mat::<T, D>::zeros());
    let border = border.as_mut();
    for b in 0..S::NODES - 1 {
        let mut half = [Mat::zeros(); D];
        for j in 0..D {
            half[j] = derivative.0[j][0].scale(gradients[b][0]);
            for l in 1..D {
                half[j] += derivative.0[j][l].scale(gradients[b][l]);
            }
        }
        for a in b..S::NODES - 1 {
            let mut block = half[0].scale(gradients[a][0]);
            for j in 1..D {
                block += half[j].scale(gradients[a][j]);
            }
            let block = block.scale(weight);
            stiffness[pair(a + 1, b + 1)] += block;
            border[a + 1] -= block;
            if a != b {
                border[b + 1] -= block.transpose();
            }
        }
    }
    for a in 1..S::NODES {
        stiffness[pair(a, 0)] += border[a];
        corner -= border[a];
    }
    stiffness[0] += corner.symmetric_part();
}
