//! What a landmark's weight is worth.

use face_rig::anatomy::EmbeddedPoint;
use face_rig::fit::{CraniumModel, FitParams, Fitter, JawModel, Parametrization};
use face_rig::rig::{EmbeddedPoints, Rig, RigParams};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs};
use fem_materials::NeoHookean;

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
        let fit = fitter.fit(&mut rig, &[0.0; 6], &mut |_| {}).unwrap();
        let moved = fit.positions[node][0] - rest[0];
        assert!((moved - 0.01 * mean).abs() < 1e-7, "{weights:?}: {moved}");
    }
}
