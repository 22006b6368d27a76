//! What a landmark's weight is worth.

use super::derivatives::{MUSCLES, largest, rig};
use super::promise::Rig;
use face_rig::anatomy::{EmbeddedPoint, JawHinge};
use face_rig::fit::{CraniumModel, FitParams, Fitter, JawModel, Parametrization};
use face_rig::rig::{AllNodes, EmbeddedPoints, Parameters, RigParams};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs};
use fem_materials::NeoHookean;
use fem_solvers::Damping;

/// One point that two targets pull at, and a head that moves freely: the least sum of weighted squares
/// has it at the mean by weight.
#[test]
fn a_point_comes_to_rest_at_the_mean_of_its_targets_by_weight() {
    let mesh = kuhn_grid(1, 1, 2, [0.02, 0.02, 0.04]).unwrap();
    let prescribed: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| mesh.nodes()[n][2] == 0.0)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 4e4,
    };
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let body = builder.material(flesh).unwrap().build().unwrap();
    let node = mesh.num_nodes() - 1;
    let rest = mesh.nodes()[node];
    let observation = EmbeddedPoints(vec![EmbeddedPoint::node(node as u32); 2]);
    let target = [
        [rest[0] + 0.01, rest[1], rest[2]],
        [rest[0] - 0.01, rest[1], rest[2]],
    ];
    let parametrization = Parametrization::of_all(0, CraniumModel::Rigid, JawModel::Fixed);
    let params = FitParams {
        rms_change: 0.0,
        step_tolerance: 1e-10,
        ..FitParams::default()
    };
    let mut rig = Rig::new(body, &[], RigParams::default()).unwrap();
    for (weights, mean) in [([9.0, 1.0], 0.8), ([1.0, 3.0], -0.5), ([2.0, 2.0], 0.0)] {
        let fitter = Fitter {
            observation: &observation,
            target: target.as_flattened(),
            weights: &weights,
            parametrization: &parametrization,
            params: &params,
        };
        let fit = rig.fit(&fitter, &[0.0; 6], &mut |_| {}).unwrap();
        let moved = fit.positions[node][0] - rest[0];
        assert!((moved - 0.01 * mean).abs() < 1e-7, "{weights:?}: {moved}");
    }
}

#[test]
fn neither_a_common_factor_of_weights_nor_the_first_damping_changes_a_fit() {
    let map = Parametrization {
        muscles: MUSCLES,
        active: vec![0, 1, 2],
        cranium: CraniumModel::Fixed,
        jaw: JawModel::Hinge(JawHinge::sideways([0.02, 0.0, 0.05])),
        controls: Vec::new(),
    };
    let mut rig = rig();
    let mut target = rig
        .solve(&map.parameters(&[0.6, 0.1, 0.3, 0.15]).unwrap())
        .unwrap()
        .positions();
    // No pose reaches it: what is left is decided by weights and priors.
    for (k, x) in target.iter_mut().enumerate() {
        x[k % 3] += 1e-3 * f64::from(k as u32 % 7);
    }
    let mut fit = |factor: f64, initial: f64| {
        let params = FitParams {
            damping: Damping::Marquardt { initial },
            rms_change: 1e-9,
            ..FitParams::default()
        };
        let weights: Vec<f64> = (0..target.len())
            .map(|k| factor * f64::from(1 + k as u32 % 3))
            .collect();
        let fitter = Fitter {
            observation: &AllNodes {
                nodes: target.len(),
            },
            target: target.as_flattened(),
            weights: &weights,
            parametrization: &map,
            params: &params,
        };
        rig.solve(&Parameters::rest(MUSCLES)).unwrap();
        rig.fit(&fitter, &map.rest(), &mut |_| {}).unwrap().q
    };
    let expected = fit(1.0, 1e-3);
    for (factor, initial) in [(1e-9, 1e-3), (1e12, 1e-3), (1.0, 1e9)] {
        let found = fit(factor, initial);
        let apart = largest(found.iter().zip(&expected).map(|(a, b)| a - b));
        assert!(
            apart < 1e-4,
            "{factor:e}, {initial:e}: {found:?}, {expected:?}"
        );
    }
}
