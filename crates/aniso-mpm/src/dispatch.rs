//! The instruction set that driving forces run with; transfers and stresses choose theirs by
//! `dispatch_quads` and `dispatch_packed`.

use fem_kinematics::Kernel;

/// Runs a kernel with the widest instructions of this processor; the bits are the same with all.
///
/// Debug builds compile the kernel once, for the baseline, instead of once per instruction set.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(debug_assertions)]
    return kernel.run();
    #[cfg(not(debug_assertions))]
    fem_kinematics::dispatch(kernel)
}
