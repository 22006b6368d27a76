//! What a fit or a pose is said to have ended as.

use super::*;

/// The landmarks of a target in the order of another numbering: no motion of the whole mends that.
#[test]
fn landmarks_in_another_order_are_no_end_of_a_fit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    files(at);
    let mesh = mesh();
    let free = free_nodes(&mesh);
    let mut table = String::from(HEADER);
    for (k, &n) in free.iter().enumerate() {
        let [x, y, z] = mesh.nodes()[free[(7 * k + 3) % free.len()]];
        table += &format!("shuffled,{k},{n},{x:e},{y:e},{z:e},1\n");
    }
    std::fs::write(at.join("shuffled.csv"), table).unwrap();
    let (code, report) = report(at, "fit", &["--targets", "shuffled.csv"]);
    let outcome = &report["results"]["fits"][0]["outcome"];
    assert_eq!(
        (code, &outcome["converged"]),
        (Some(1), &Value::Null),
        "{outcome}"
    );
    let missed = outcome["missed"]
        .as_str()
        .unwrap_or_else(|| panic!("{outcome}"));
    assert!(missed.contains("landmarks in another order"), "{missed}");
}

/// A jaw pushed through the flesh: as many tets are inside out as the shape has.
#[test]
fn a_pose_counts_the_tets_that_are_inside_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    files(at);
    let flesh = r#""inversion": "allowed",
        "material": { "stable_neo_hookean": { "young": 3e4, "poisson": 0.4 } }"#;
    let scene = SCENE.replace(r#""material": { "preset": "soft_tissue" }"#, flesh);
    std::fs::write(at.join("scene.json"), scene).unwrap();
    let mesh = mesh();
    for (shift, some) in [("0,0,-2", false), ("0,0,-120", true)] {
        let options = ["--jaw-shift", shift, "--write", "vtu"];
        let quiet = "simulate scene.json --json --force --pictures none";
        let output = Command::new(env!("CARGO_BIN_EXE_face-rig"))
            .args(quiet.split(' '))
            .args(options)
            .current_dir(at)
            .output()
            .unwrap();
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let x = MeshFile::read(at.join("out/pose.vtu")).unwrap().points;
        let turned = |tet: usize| {
            let [a, b, c, d] = mesh.tet(tet).map(|n| x[n as usize]);
            let edge = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| p[k] - a[k]) };
            let [u, v, w] = [b, c, d].map(edge);
            let normal = |i: usize, j: usize| u[i] * v[j] - u[j] * v[i];
            w[0] * normal(1, 2) + w[1] * normal(2, 0) + w[2] * normal(0, 1) <= 0.0
        };
        let count = (0..mesh.num_elements()).filter(|&tet| turned(tet)).count();
        assert_eq!(report["results"]["inverted_tets"], count, "{shift}");
        assert_eq!(count > 0, some, "{shift}");
    }
}
