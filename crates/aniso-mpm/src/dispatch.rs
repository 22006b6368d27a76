//! The instruction set that a transfer runs with.

use fem_kinematics::Kernel;

/// Runs a kernel with the widest instructions of this processor; the bits are the same with all.
///
/// Debug builds compile each transfer once, for the baseline, instead of once per instruction set.
#[inline]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(debug_assertions)]
    return kernel.run();
    #[cfg(not(debug_assertions))]
    fem_kinematics::dispatch(kernel)
}
