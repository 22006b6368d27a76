//! The forces of a body by plain loops, and what a solve promised of them.

use crate::Failure;
use crate::body::Body;
use crate::row::Evidence;
use fem_assembly::Quasistatic;
use fem_assembly::mesh::SimplexMesh;
use fem_kinematics::Mat;
use fem_solvers::{NewtonParams, StopReason};

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

/// ∂E/∂x (N), V P ∇Nₐ summed element by element.
pub struct ElementForces<'a> {
    mesh: &'a SimplexMesh<3>,
    x: &'a [[f64; 3]],
    sums: Vec<[Exact; 3]>,
}

impl<'a> ElementForces<'a> {
    /// Of a mesh whose nodes are at x.
    pub fn new(mesh: &'a SimplexMesh<3>, x: &'a [[f64; 3]]) -> Self {
        let sums = vec![[Exact::default(); 3]; x.len()];
        Self { mesh, x, sums }
    }

    /// What an element adds with this P(F).
    pub fn add(&mut self, element: usize, stress: impl Fn(&Mat<f64, 3>) -> Mat<f64, 3>) {
        let nodes = self.mesh.tet(element);
        let (volume, of) = gradients(nodes.map(|n| self.mesh.node(n)));
        let F = gradient_of(nodes.map(|n| self.x[n as usize]), &of);
        let P = stress(&F);
        for (n, gradient) in nodes.into_iter().zip(of) {
            for i in 0..3 {
                for j in 0..3 {
                    self.sums[n as usize][i].add(volume * P[(i, j)] * gradient[j]);
                }
            }
        }
    }

    /// The sums at every node.
    pub fn sums(self) -> Vec<[f64; 3]> {
        let value = |sums: [Exact; 3]| sums.map(Exact::value);
        self.sums.into_iter().map(value).collect()
    }
}

/// ∂E/∂x of a body at every node, N: its elements, last to first, with their shares of the pressures
/// of patches of volume, and its other terms.
pub fn forces(body: &Body, x: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Failure> {
    let pressures = pressures(body, x);
    let mut elements = ElementForces::new(body.mesh(), x);
    for group in body.groups().iter().rev() {
        let stress = group.material.stress()?;
        for &e in group.elements.iter().rev() {
            elements.add(e, |F| match &pressures {
                Some(pressures) => stress(F) + F.cofactor().scale(pressures[e]),
                None => stress(F),
            });
        }
    }
    let mut sums = elements.sums();
    if let Some(others) = body.forces_of_terms(x)? {
        for (sum, force) in sums.iter_mut().zip(others) {
            (0..3).for_each(|i| sum[i] += force[i]);
        }
    }
    Ok(sums)
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

/// Compares the forces that are left at the free unknowns with what a stop says of them, and gives the
/// worst ([`workbench::promise::left`]).
pub fn kept(
    problem: &Quasistatic<'_, 3>,
    x: &[f64],
    everywhere: &[[f64; 3]],
    params: &NewtonParams,
    stop: StopReason,
) -> Result<Evidence, Failure> {
    let all = workbench::promise::left(problem, x, everywhere, params, stop)?;
    let evidence = all.into_iter().map(|(left, allowed)| Evidence {
        left,
        allowed,
        ..Evidence::default()
    });
    Ok(evidence.fold(Evidence::default(), Evidence::and))
}
