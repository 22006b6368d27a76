//! Flesh without any stiffness has no equilibrium to find.

use super::promise::Rig;
use face_rig::rig::{RigError, RigParams};
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs};
use fem_materials::NeoHookean;

#[test]
fn flesh_whose_moduli_are_all_zero_is_refused_by_a_rig() {
    let mesh = kuhn_grid(2, 2, 4, [0.04, 0.04, 0.08]).unwrap();
    let prescribed: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| mesh.nodes()[n][2] == 0.0)
        .collect();
    let rig = |lambda: f64| {
        let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed).unwrap();
        let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
        let flesh = NeoHookean { mu: 0.0, lambda };
        let assembly = builder.material(flesh).unwrap().build().unwrap();
        Rig::new(assembly, &[], RigParams::default())
    };
    let error = rig(0.0).unwrap_err();
    assert!(
        matches!(&error, RigError::Free(part) if part.limp),
        "{error}"
    );
    rig(1.0).expect("any stiffness will do");
}
