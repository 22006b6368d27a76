//! The forces of a body by plain loops, and what a solve promised of them.

use crate::Failure;
use crate::body::Body;
use crate::row::Evidence;
use fem_assembly::Quasistatic;
use fem_kinematics::Mat;
use fem_solvers::{
    BlockSymmetric, HessianProjection, NewtonInfo, NewtonParams, NonlinearProblem, StopReason,
};

/// A sum that keeps what its additions lose (Neumaier 1974).
#[derive(Clone, Copy, Default)]
struct Exact {
    sum: f64,
    lost: f64,
}

impl Exact {
    fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() {
            (self.sum - sum) + x
        } else {
            (x - sum) + self.sum
        };
        self.sum = sum;
    }
    fn value(self) -> f64 {
        self.sum + self.lost
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let [a0, a1, a2] = a;
    let [b0, b1, b2] = b;
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

/// Volume and ∇N of the corners of a tetrahedron at rest.
fn gradients(corners: [[f64; 3]; 4]) -> (f64, [[f64; 3]; 4]) {
    let [e1, e2, e3] = [1, 2, 3]
        .map(|a: usize| -> [f64; 3] { std::array::from_fn(|i| corners[a][i] - corners[0][i]) });
    let normals = [cross(e2, e3), cross(e3, e1), cross(e1, e2)];
    let det: f64 = (0..3).map(|i| e1[i] * normals[0][i]).sum();
    let of = normals.map(|n| n.map(|c| c / det));
    let first = std::array::from_fn(|i| -(of[0][i] + of[1][i] + of[2][i]));
    (det / 6.0, [first, of[0], of[1], of[2]])
}

/// F = Σ xₐ ⊗ ∇Nₐ.
fn gradient_of(x: [[f64; 3]; 4], gradients: &[[f64; 3]; 4]) -> Mat<f64, 3> {
    Mat::from_fn(|i, j| (0..4).map(|a| x[a][i] * gradients[a][j]).sum())
}

/// ∂E/∂x at every node (N): V P ∇Nₐ over the elements, last to first, with their shares of the
/// pressures of patches of volume.
pub fn forces(body: &Body, x: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Failure> {
    let mesh = body.mesh();
    let corners = |e: usize, of: &[[f64; 3]]| mesh.tet(e).map(|n| of[n as usize]);
    let mut sums = vec![[Exact::default(); 3]; x.len()];
    let pressures = pressures(body, x);
    for part in body.parts().iter().rev() {
        let law = part.material.law()?;
        for &e in part.elements.iter().rev() {
            let (volume, of) = gradients(corners(e, mesh.nodes()));
            let F = gradient_of(corners(e, x), &of);
            let mut P = law(&F);
            if let Some(pressures) = &pressures {
                P = P + F.cofactor().scale(pressures[e]);
            }
            for (n, gradient) in mesh.tet(e).into_iter().zip(of) {
                for i in 0..3 {
                    for j in 0..3 {
                        sums[n as usize][i].add(volume * P[(i, j)] * gradient[j]);
                    }
                }
            }
        }
    }
    if let Some(others) = body.forces_of_terms(x)? {
        for (sum, force) in sums.iter_mut().zip(others) {
            (0..3).for_each(|i| sum[i].add(force[i]));
        }
    }
    Ok(sums.into_iter().map(|s| s.map(Exact::value)).collect())
}

/// Σ κ (J̄ − 1) over the patches of each element, Pa.
fn pressures(body: &Body, x: &[[f64; 3]]) -> Option<Vec<f64>> {
    let (patches, bulk) = body.patches()?;
    let mesh = body.mesh();
    let mut of_element = vec![0.0; mesh.num_elements()];
    for patch in patches.lists() {
        let (mut rest, mut now, mut stiffness) = (0.0, 0.0, 0.0);
        for &(e, share) in patch {
            let (volume, of) = gradients(mesh.tet(e).map(|n| mesh.node(n)));
            let F = gradient_of(mesh.tet(e).map(|n| x[n as usize]), &of);
            rest += share * volume;
            now += share * volume * F.determinant();
            stiffness += share * volume * bulk[e];
        }
        for &(e, share) in patch {
            of_element[e] += share * (stiffness / rest) * (now / rest - 1.0);
        }
    }
    Some(of_element)
}

/// Compares the forces that are left at the free unknowns with what [`NewtonInfo::stop`] says of them,
/// and gives the worst.
pub fn kept(
    problem: &Quasistatic<'_, 3>,
    x: &[f64],
    everywhere: &[[f64; 3]],
    params: &NewtonParams,
    info: &NewtonInfo,
) -> Evidence {
    let dofs = problem.assembly().dofs();
    let left = dofs.gather(everywhere);
    let scales = problem.gradient_scales(x);
    let floor = rounding(problem, x);
    let mut worst = Evidence::default();
    for (i, force) in left.iter().enumerate() {
        let node = dofs.node_of_row()[i / 3] as usize;
        if dofs.is_prescribed(node, i % 3) {
            continue;
        }
        let scale = params.reference.or_else(|| Some(scales.as_ref()?[i]));
        let share = params.relative_gradient_tolerance * scale.unwrap_or(0.0);
        let share = params.gradient_tolerance.max(share);
        let promised = match info.stop {
            StopReason::Gradient => params.gradient_tolerance,
            StopReason::RelativeGradient => share,
            StopReason::Rounding => share.max(floor[i]),
            // A step tolerance promises no force.
            _ => f64::NAN,
        };
        worst = worst.and(Evidence {
            left: force.abs(),
            // Another order of the sums has another rounding.
            allowed: promised + floor[i],
            ..Evidence::default()
        });
    }
    Evidence {
        steps: info.iterations,
        ..worst
    }
}

/// 4 ε times Σⱼ |Kᵢⱼ| |xⱼ|, and what the problem says of its own sums, whichever is larger (N).
fn rounding(problem: &Quasistatic<'_, 3>, x: &[f64]) -> Vec<f64> {
    let pattern = problem.assembly().pattern();
    let mut matrix = BlockSymmetric::<3>::zeros(pattern.clone());
    problem.hessian(x, HessianProjection::None, &mut matrix);
    let mut sums = vec![0.0; x.len()];
    for row in 0..pattern.blocks() {
        for (k, &column) in (pattern.row_start()[row]..).zip(pattern.row(row)) {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let (r, c) = (3 * row + i, 3 * column as usize + j);
                let entry = matrix.values()[k][i][j].abs();
                sums[r] += entry * x[c].abs();
                if row != column as usize {
                    sums[c] += entry * x[r].abs();
                }
            }
        }
    }
    let own = problem.gradient_rounding(x);
    let own = own.unwrap_or_else(|| vec![0.0; x.len()]);
    let floor = |(own, sum): (f64, f64)| own.max(4.0 * f64::EPSILON * sum);
    own.into_iter().zip(sums).map(floor).collect()
}
