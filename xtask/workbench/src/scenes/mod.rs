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

use crate::report::Report;
use std::path::Path;

/// Runs every scene of `folder`; one that can't be run counts as failed and the others go on.
pub fn check(folder: &Path, extent: Extent, report: &mut Report) {
    let results = [
        ("scene a0", a0(folder, report)),
        ("scene a1", a1(folder, report)),
        ("scene a2", a2(folder, report)),
        ("scene a3", a3(folder, extent, report)),
        ("scene a4", a4(folder, extent, report)),
        ("scene a5", a5(folder, report)),
        ("scenes b1 and b2", b1_b2(folder, report)),
        ("scene b3", b3(folder, report)),
        ("scenes c1 to c4", c(folder, report)),
    ];
    for (scene, result) in results {
        if let Err(error) = result {
            report.broken(format!("{scene}: {error}"));
        }
    }
}
