//! The reference scenes at the tolerances that their notes suggest.
#![allow(missing_docs)]

use std::path::Path;
use verification::report::{Report, Style};
use verification::scenes::{self, Extent, SceneError};
use verification::shared::folder_or_skip;

fn run(scene: impl Fn(&Path, &mut Report) -> Result<(), SceneError>) {
    let Some(folder) = folder_or_skip(None, "reference/scenes") else {
        return;
    };
    let mut report = Report::default();
    scene(&folder, &mut report).expect("the scene can be run");
    println!("{}", report.tables(Style::Plain));
    report.assert();
}

#[test]
fn a0_energy_forces_and_stiffness_of_given_states() {
    run(scenes::a0);
}

#[test]
fn a1_patch_test() {
    run(scenes::a1);
}

#[test]
fn a2_twisted_bar() {
    run(scenes::a2);
}

#[test]
fn a3_muscle() {
    run(|folder, report| scenes::a3(folder, Extent::Some, report));
}

#[test]
fn a4_recovery_from_inverted_and_collapsed_starts() {
    run(|folder, report| scenes::a4(folder, Extent::All, report));
}

#[test]
fn a5_penalty_collisions() {
    run(scenes::a5);
}

#[test]
fn b1_b2_poses_and_their_derivatives() {
    run(scenes::b1_b2);
}

#[test]
fn b3_paths_of_gauss_newton() {
    run(scenes::b3);
}
