//! Goes into a copy of the workspace, beside a model that no other file of it names: a scene reaches
//! the model by its name.
#![allow(missing_docs, non_snake_case)]

use face_rig::rig::{Parameters, RigParams};
use face_scenes::{Contact, Scene};
use fem_kinematics::Mat;

#[path = "../../face-rig/tests/all/promise.rs"]
mod promise;

const SCENE: &str = r#"{
  "face": { "builtin": { "tets": 4000 } },
  "material": { "exponential_neo_hookean": { "mu": 1e4, "lambda": 1e5, "b": 2 } },
  "fibers": { "max_isometric_stress": 1e-9 },
  "inversion": "allowed"
}"#;

/// ψ by the formula alone.
fn energy_density(F: &Mat<f64, 3>) -> f64 {
    let (mu, lambda, b) = (1e4, 1e5, 2.0);
    let (I, log_J) = (F.dot(F), F.determinant().ln());
    mu / (2.0 * b) * ((b * (I - 3.0)).exp() - 1.0) - mu * log_J + lambda / 2.0 * log_J * log_J
}

#[test]
fn a_scene_reaches_the_added_model() {
    let file = std::env::temp_dir().join(format!("added-{}.json", std::process::id()));
    std::fs::write(&file, SCENE).expect("writable");
    let scene = Scene::load(&file);
    std::fs::remove_file(&file).expect("there");
    let mut scene = scene.expect("a sound scene");
    // All of the added model, and nothing else that has an energy.
    scene.region_of_tet.fill(0);
    scene.contact = Contact::default();
    let params = RigParams::default();
    let mut rig = promise::Rig::of(scene.rig(params).expect("a rig"), params);
    let mut pose = Parameters::rest(scene.muscles.len());
    pose.jaw.translation[1] = -0.002;
    let solved = rig.solve(&pose).expect("an equilibrium").clone();
    let found = {
        let assembly = rig.assembly();
        assembly.energy(assembly.configuration(&solved.in_cranium_frame, &pose.activations).expect("its own"))
    };
    let mesh = &scene.mesh;
    let edges = |tet: [[f64; 3]; 4]| {
        Mat::<f64, 3>::from_fn(|i, k| tet[k + 1][i] - tet[0][i])
    };
    let wanted: f64 = (0..mesh.num_elements())
        .map(|e| {
            let nodes = mesh.tet(e).map(|n| n as usize);
            let rest = edges(nodes.map(|n| mesh.nodes()[n]));
            let F = edges(nodes.map(|n| solved.in_cranium_frame[n])) * rest.inverse();
            rest.determinant() / 6.0 * energy_density(&F)
        })
        .sum();
    assert!((found / wanted - 1.0).abs() < 1e-12, "{found} J, {wanted} J by hand");
    assert!(wanted > 1e-3, "{wanted} J");
}
