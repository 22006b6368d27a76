//! What stands in for a hierarchy that cannot be made.

use super::{Equilibrium, MultigridUse, Rig, RigError, Stiffness};
use crate::rig::RigParams;
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Dofs};
use fem_materials::StableNeoHookean;
use fem_solvers::{LinearOperator, MatrixPreconditioner, NewtonFailure};

/// A block that hangs on a layer of this share of its stiffness.
fn rig(layer: f64, multigrid: MultigridUse) -> Rig {
    let mesh = kuhn_grid(2, 2, 4, [0.04, 0.04, 0.08]).unwrap();
    let rest = mesh.nodes().to_vec();
    let cranium: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let factors: Vec<f64> = (0..mesh.elements().len())
        .map(|e| mesh.tet(e).iter().any(|&n| rest[n as usize][2] == 0.0))
        .map(|below| if below { layer } else { 1.0 })
        .collect();
    let dofs = Dofs::with_prescribed_nodes(&rest, &cranium).unwrap();
    let flesh = StableNeoHookean {
        mu: 1e4,
        lambda: 9e4,
    };
    let assembly = AssemblyBuilder::new(&mesh, dofs).unwrap();
    let assembly = assembly.scaled_material(flesh, &factors).unwrap();
    let params = RigParams {
        multigrid,
        ..RigParams::default()
    };
    Rig::new(assembly.build().unwrap(), &[], params).unwrap()
}

fn made(rig: &mut Rig, at: &Equilibrium) -> Result<Stiffness, RigError> {
    let energy = rig.controls.of_energy(&at.parameters);
    rig.stiffness_at(at, energy, true)
}

#[test]
fn a_factor_stands_in_for_a_hierarchy_that_cannot_be_made_unless_always_one_is_asked_for() {
    for multigrid in [MultigridUse::WhereCheaper, MultigridUse::WhereFarCheaper] {
        let mut sound = rig(1.0, multigrid);
        let at = sound.equilibrium.clone();
        let stiffness = made(&mut sound, &at).unwrap();
        assert!(matches!(stiffness, Stiffness::Multilevel(_)));
        assert_eq!(sound.work().factorizations, 0);
        // What holds the block is below what a hierarchy's last pivots may be, and above rounding.
        let mut held = rig(7e-13, multigrid);
        let stiffness = made(&mut held, &at).unwrap();
        assert!(matches!(stiffness, Stiffness::Factored(_)));
        assert_eq!(held.work().factorizations, 1);
    }
    let mut always = rig(7e-13, MultigridUse::Always);
    let at = always.equilibrium.clone();
    let error = made(&mut always, &at).unwrap_err();
    assert!(
        matches!(error, RigError::Hierarchy(_))
            && error.to_string().contains("`MultigridUse::Never`"),
        "{error}"
    );
    assert_eq!(always.work().factorizations, 0);
}

#[test]
fn a_factor_is_sure_that_a_pose_is_not_stable() {
    for (multigrid, surely) in [
        (MultigridUse::WhereCheaper, true),
        (MultigridUse::Always, false),
    ] {
        let mut rig = rig(1.0, multigrid);
        let mut at = rig.equilibrium.clone();
        // No equilibrium, but flesh so flat that every level of a hierarchy sees it.
        at.in_cranium_frame.iter_mut().for_each(|z| z[2] *= 0.2);
        let error = made(&mut rig, &at).unwrap_err();
        let by_factor = matches!(error, RigError::Unstable(NewtonFailure::Cholesky(_)));
        let by_levels = matches!(error, RigError::Hierarchy(_));
        assert_eq!((by_factor, by_levels), (surely, !surely), "{error}");
    }
}

#[test]
fn errors_of_conjugate_gradients_say_what_to_do() {
    let mut rig = rig(1.0, MultigridUse::Always);
    let at = rig.equilibrium.clone();
    let Stiffness::Multilevel(parts) = made(&mut rig, &at).unwrap() else {
        panic!("a factor");
    };
    let (matrix, mut hierarchy) = *parts;
    let n = matrix.dim();
    let solve = |stiffness: &Stiffness, tolerance| {
        let mut block = vec![1.0; n];
        stiffness.solve_many(&mut block, 1, tolerance).unwrap_err()
    };
    // A hierarchy that is none.
    let mut bad = matrix.clone();
    let values = bad.values_mut().as_flattened_mut().as_flattened_mut();
    values.fill(f64::NAN);
    hierarchy.update(&bad).unwrap_err();
    let unusable = Stiffness::Multilevel(Box::new((matrix, hierarchy)));
    let error = solve(&unusable, 1e-10);
    assert!(matches!(error, RigError::Preconditioner(_)), "{error}");
    assert!(error.to_string().contains("`MultigridUse::Never`"));
    let error = solve(&made(&mut rig, &at).unwrap(), 1e-18);
    assert!(matches!(error, RigError::Derivative(_)), "{error}");
    assert!(error.to_string().contains("`MultigridUse::Never`"));
}
