//! Reference scenes: whole problems whose solutions are known to 9 digits and more.

mod assembled;
mod compare;
mod fit;
mod input;
mod muscle;
mod particles;
mod recovery;
mod rig;

pub use assembled::{TwistBar, a0, a1, a2, tight, twist_bar};
pub use compare::{Record, apart};
pub use fit::b3;
pub use input::{Curve, FiberStretch, Mesh, NamedMaterial, SceneError};
pub use muscle::{Extent, a3, a5};
pub use particles::c;
pub use recovery::a4;
pub use rig::b1_b2;

use crate::ledger::Ledger;
use std::path::Path;

/// Runs every scene of `folder`; one that can't be run counts as failed and the others go on.
pub fn check(folder: &Path, extent: Extent, ledger: &mut Ledger) {
    let results = [
        ("scene a0", a0(folder, ledger)),
        ("scene a1", a1(folder, ledger)),
        ("scene a2", a2(folder, ledger)),
        ("scene a3", a3(folder, extent, ledger)),
        ("scene a4", a4(folder, extent, ledger)),
        ("scene a5", a5(folder, ledger)),
        ("scenes b1 and b2", b1_b2(folder, ledger)),
        ("scene b3", b3(folder, ledger)),
        ("scenes c1 to c4", c(folder, ledger)),
    ];
    for (scene, result) in results {
        if let Err(error) = result {
            ledger.broken(format!("{scene}: {error}"));
        }
    }
}
