//! Sums over a whole body and single terms against closed forms.
#![allow(non_snake_case)]

use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs, Fiber, ImplicitSurface, Penalty};
use fem_kinematics::Mat;
use fem_materials::curves::PhysBam;
use fem_materials::{FiberLaw, HessianProjection, Material, NeoHookean, Stretch};
use fem_solvers::{BlockSymmetric, LinearOperator};

const FLESH: NeoHookean = NeoHookean {
    mu: 1e3,
    lambda: 4e3,
};

#[test]
fn the_energy_of_everything_counts_elements_without_a_free_node() {
    let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).unwrap();
    let left: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| mesh.nodes()[n][0] <= 0.5)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &left).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let body = body.material(FLESH).unwrap().build().unwrap();
    let F = Mat([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]]);
    let moved: Vec<[f64; 3]> = mesh.nodes().iter().map(|&x| F.mul_vec(x)).collect();
    let at = body.configuration(&moved, &[]).unwrap();
    // Homogeneous: the energy density times the volume, of which the half without free nodes.
    let density = FLESH.energy(&F);
    assert!((body.energy(at) / density - 1.0).abs() < 1e-12);
    assert!((body.free_energy(at) / density - 0.5).abs() < 1e-12);
}

/// Past its peak an active fiber's tension falls with the stretch.
#[test]
fn a_fibers_falling_tension_is_projected_as_asked() {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let fiber = |element| Fiber {
        element,
        control: 0,
        direction: [1.0, 0.0, 0.0],
        max_isometric_stress: 2e5,
        optimal_stretch: 1.25,
    };
    let fibers: Vec<Fiber> = (0..mesh.num_elements()).map(fiber).collect();
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch: Stretch::Total,
    };
    let dofs = Dofs::all_free(mesh.nodes()).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let body = body.fibers(law, 1, &fibers).unwrap().build().unwrap();
    let stretched = mesh.nodes().iter().map(|p| [1.5 * p[0], p[1], p[2]]);
    let stretched: Vec<[f64; 3]> = stretched.collect();
    let at = body.configuration(&stretched, &[1.0]).unwrap();
    let direction: Vec<[f64; 3]> = mesh.nodes().iter().map(|p| [p[0], 0.0, 0.0]).collect();
    let direction = body.dofs().gather(&direction).unwrap();
    let curvature = |projection| {
        let mut matrix = BlockSymmetric::zeros(body.pattern().clone());
        body.hessian(at, projection, &mut matrix);
        let mut product = vec![0.0; direction.len()];
        matrix.apply(&direction, &mut product);
        let pairs = direction.iter().zip(&product);
        pairs.map(|(a, b)| a * b).sum::<f64>()
    };
    // σ/λ_ofl² (−25/3 e + P₁ P₂ (exp(P₂ e) − 1)) at e = 1.5/1.25 − 1, in a volume of 1.
    let slope = -25.0 / 3.0 * 0.2 + 0.05 * 6.6 * ((6.6_f64 * 0.2).exp() - 1.0);
    let exact = 2e5 / 1.25_f64.powi(2) * slope;
    assert!(exact < 0.0);
    assert!((curvature(HessianProjection::None) / exact - 1.0).abs() < 1e-12);
    assert!(curvature(HessianProjection::Clamp).abs() < 1e-12 * exact.abs());
    assert!((curvature(HessianProjection::Absolute) / exact + 1.0).abs() < 1e-12);
    // The fibers alone, stretched to 1.2 of their optimum: σ V (α ∫ f_a + ∫ f_p).
    let (e, x) = (0.2_f64, 6.6 * 0.2_f64);
    let passive = 0.05 / 6.6 * (x.exp() - 1.0 - x - x * x / 2.0);
    let energy = 2e5 * (e - 25.0 / 18.0 * e.powi(3) + passive);
    assert!((body.energy(at) / energy - 1.0).abs() < 1e-12);
}

#[test]
fn a_penalty_pushes_outwards_whoever_holds_the_node_and_never_pulls() {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let bottom: Vec<usize> = (0..8).filter(|&n| mesh.nodes()[n][2] == 0.0).collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &bottom[..2]).unwrap();
    let penalty = Penalty {
        nodes: (0..8).collect(),
        stiffness: 300.0,
        obstacle: ImplicitSurface::HalfSpace {
            point: [0.0, 0.0, 0.1],
            normal: [0.0, 0.0, 1.0],
        },
    };
    let body = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let body = body.penalty(penalty).unwrap().build().unwrap();
    let at = body.configuration(mesh.nodes(), &[]).unwrap();
    let forces = body.forces_everywhere(at);
    for (n, force) in forces.iter().enumerate() {
        // 0.1 m deep at the bottom, 0.9 m away at the top.
        let up = if bottom.contains(&n) { 30.0 } else { 0.0 };
        assert!((force[2] - up).abs() < 1e-12, "node {n}: {force:?}");
        assert_eq!([force[0].abs(), force[1].abs()], [0.0; 2]);
    }
    let stored = 4.0 * 0.5 * 300.0 * 0.01;
    assert!((body.energy(at) - stored).abs() < 1e-12);
}
