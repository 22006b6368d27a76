//! How many fits run at once, and on how many threads each.

use super::args::FitArgs;
use super::error::Failure;
use face_rig::rig::{MultigridUse, Rig, RigError};
use fem_assembly::Quasistatic;
use fem_solvers::Newton;

/// What the factors of all rigs together may take where nobody says how many fits run at once, bytes.
const MEMORY: u64 = 4 << 30;
/// A rig holds two factors in `f64`: that of its last derivative, and that of Newton's steps.
const BYTES_PER_NONZERO: u64 = 2 * 8;

/// How many fits run at once: as many as were asked for or as there are threads, but not more than there
/// are targets.
///
/// # Errors
/// As [`Quasistatic::new`], of a rig that is none.
pub fn count(args: &FitArgs, targets: usize, rig: &Rig) -> Result<usize, RigError> {
    let threads = rayon::current_num_threads();
    match args.at_once {
        _ if args.warm_start => Ok(1),
        Some(asked) => Ok(usize::from(asked).min(targets)),
        None if threads.min(targets) <= 1 => Ok(1),
        None => Ok(threads.min(targets).min(within_memory(factor_bytes(rig)?))),
    }
}

/// Whether what was asked for can be.
///
/// # Errors
/// [`Failure::AtOnce`] where fits that follow each other are to run side by side.
pub fn check(args: &FitArgs) -> Result<(), Failure> {
    match args.at_once {
        Some(asked) if asked > 1 && args.warm_start => Err(Failure::AtOnce { asked }),
        _ => Ok(()),
    }
}

/// What the factors of a rig take, by the nonzeros of the stiffness at rest.
fn factor_bytes(rig: &Rig) -> Result<u64, RigError> {
    if rig.params().multigrid == MultigridUse::Always {
        return Ok(0);
    }
    let assembly = rig.assembly();
    let controls = rig.energy_controls(&rig.equilibrium().parameters);
    let problem = Quasistatic::new(assembly, assembly.rest().to_vec(), controls)?;
    let mut newton = Newton::new(&problem);
    let nonzeros = newton.symbolic().map_or(0, |symbolic| symbolic.fill());
    Ok(BYTES_PER_NONZERO * nonzeros as u64)
}

/// Rigs of this size whose factors fit into [`MEMORY`]; one in any case.
fn within_memory(bytes: u64) -> usize {
    let rigs = MEMORY.checked_div(bytes).unwrap_or(u64::MAX);
    usize::try_from(rigs).unwrap_or(usize::MAX).max(1)
}

/// Threads of one of `workers`: all get as many, the first ones one more where some are left over.
pub fn share(threads: usize, workers: usize, worker: usize) -> usize {
    let more = usize::from(worker < threads % workers);
    (threads / workers + more).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use face_rig::rig::RigParams;
    use face_scenes::Scene;

    #[test]
    fn threads_are_shared_out_whole_and_nobody_goes_without() {
        let shares = |threads, workers| -> Vec<usize> {
            (0..workers)
                .map(|worker| share(threads, workers, worker))
                .collect()
        };
        assert_eq!(shares(2, 2), [1, 1]);
        assert_eq!(shares(8, 3), [3, 3, 2]);
        assert_eq!(shares(5, 1), [5]);
        assert_eq!(shares(2, 4), [1, 1, 1, 1]);
    }

    #[test]
    fn as_many_rigs_as_memory_has_room_for_and_one_in_any_case() {
        assert_eq!(within_memory(MEMORY / 3), 3);
        assert_eq!(within_memory(MEMORY / 3 + 1), 2);
        assert_eq!(within_memory(MEMORY + 1), 1);
        assert_eq!(within_memory(0), usize::MAX);
    }

    #[test]
    fn the_factors_of_a_rig_are_two_of_the_size_of_its_stiffness() {
        let scene = Scene::builtin(4_000).expect("a face");
        let rig = scene.rig(RigParams::for_fits()).expect("a rig");
        let bytes = factor_bytes(&rig).expect("a count");
        let unknowns = 3 * rig.assembly().dofs().free_nodes() as u64;
        // More than the diagonal, less than a dense triangle.
        assert!(bytes > 16 * 10 * unknowns && bytes < 8 * unknowns * unknowns);
        let always = RigParams {
            multigrid: MultigridUse::Always,
            ..RigParams::for_fits()
        };
        let rig = scene.rig(always).expect("a rig");
        assert_eq!(factor_bytes(&rig).expect("a count"), 0);
    }
}
