//! Each option of the program, on and off, against what the libraries compute with it.

use face_rig::fit::{CraniumModel, FitParams, JawModel};
use face_rig::rig::{Direction, JacobianRoute, Parameters, RigParams};
use face_scenes::{ExpressionFit, Observed, Scene, fit_expression};
use fem_assembly::mesh::{DataArray, MeshFile, SimplexMesh, kuhn_grid};
use fem_solvers::{Loss, StepMethod};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

#[path = "options/at_once.rs"]
mod at_once;
#[path = "options/ends.rs"]
mod ends;
#[path = "options/of_scenes.rs"]
mod of_scenes;
#[path = "../../face-rig/tests/all/promise.rs"]
mod promise;
use promise::Rig;

/// A block whose back hangs on the cranium and whose lower front on the jaw, with two muscles.
const SCENE: &str = r#"{ "name": "block",
  "face": { "files": {
    "mesh": "block.vtu", "bones": { "array": "bone", "free": 0, "cranium": 1, "jaw": 2 },
    "hinge": { "line": { "point": [0, 0.1, 0], "axis": [1, 0, 0] } },
    "muscles": { "names": { "list": ["wide", "tall"] }, "fibers": { "table": "fibers.csv" } },
    "embedding": "embedding.csv", "landmarks": { "file": "rest.csv" } } },
  "material": { "preset": "soft_tissue" },
  "loads": [ { "gravity": { "name": "weight", "density": 1000, "acceleration": [0, -9.81, 0] } } ]
}"#;
const TARGETS: &str = r#""targets": { "landmarks": "targets.csv", "skip": ["rest"],
    "dense": { "file": "skin.vtu" } }, "material""#;
const HEADER: &str = "target,landmark,ict_vertex,x,y,z,weight\n";

fn mesh() -> SimplexMesh<3> {
    kuhn_grid(2, 3, 2, [0.1, 0.2, 0.1]).unwrap()
}

fn bone(x: &[f64; 3]) -> i64 {
    match x {
        x if x[2] == 0.0 => 1,
        x if x[1] == 0.0 => 2,
        _ => 0,
    }
}

fn free_nodes(mesh: &SimplexMesh<3>) -> Vec<usize> {
    let free = |&n: &usize| bone(&mesh.nodes()[n]) == 0;
    (0..mesh.num_nodes()).filter(free).collect()
}

/// The block in files, every free node a vertex of the skin by its own number.
fn files(at: &Path) {
    let mesh = mesh();
    MeshFile::from_tets(&mesh)
        .with_point_data(DataArray::integers("bone", mesh.nodes().iter().map(bone)))
        .write(at.join("block.vtu"))
        .unwrap();
    let mut fibers = String::from("tet,muscle,weight,fx,fy,fz\n");
    let mut embedding = String::from("ict_vertex,tet,w0,w1,w2,w3\n");
    let mut rest = String::from("target,landmark,ict_vertex,x,y,z\n");
    for tet in 0..mesh.num_elements() {
        let direction = ["1,0,0", "0,1,0"][tet % 2];
        fibers += &format!("{tet},{},0.5,{direction}\n", tet % 2);
    }
    for (k, n) in free_nodes(&mesh).into_iter().enumerate() {
        let of = |e: usize| mesh.tet(e).iter().position(|&m| m as usize == n);
        let (tet, corner) = (0..mesh.num_elements())
            .find_map(|e| Some((e, of(e)?)))
            .unwrap();
        let weights = [0, 1, 2, 3].map(|c| if c == corner { "1" } else { "0" });
        embedding += &format!("{n},{tet},{}\n", weights.join(","));
        let [x, y, z] = mesh.nodes()[n];
        rest += &format!("rest,{k},{n},{x:e},{y:e},{z:e}\n");
    }
    for (name, text) in [
        ("fibers.csv", &fibers),
        ("embedding.csv", &embedding),
        ("rest.csv", &rest),
        ("scene.json", &SCENE.to_owned()),
    ] {
        std::fs::write(at.join(name), text).unwrap();
    }
}

fn rig(scene: &Scene) -> Rig {
    let params = RigParams::for_fits();
    Rig::of(scene.rig(params).unwrap(), params)
}

/// Two poses that nothing reaches exactly, by landmarks of unequal weight and by a denser skin that
/// lies elsewhere again: what is left depends on every option.
fn with_targets(at: &Path) -> Scene {
    files(at);
    let scene = Scene::load(at.join("scene.json")).unwrap();
    let mut table = String::from(HEADER);
    let mut skin = skin_of(&scene);
    for (name, activation, degrees) in [("first", 0.5, 3.0), ("second", 0.3, 6.0)] {
        let mut pose = scene.rest_pose();
        pose.activations = vec![activation, 0.1];
        pose.jaw = jaw(&scene, degrees, [1e-3, 0.0, 0.0]).jaw;
        let x = rig(&scene).solve(&pose).unwrap().positions();
        for (k, l) in scene.landmarks.iter().enumerate() {
            let [mut x, y, z] = l.point.position(&x);
            x += 1e-3 * (k % 4) as f64;
            table += &format!(
                "{name},{},{},{x:e},{y:e},{z:e},{}\n",
                l.index,
                l.vertex,
                1 + k % 3
            );
        }
        let moved = |l: &face_scenes::Landmark| {
            let (now, rest) = (l.point.position(&x), l.point.position(scene.mesh.nodes()));
            [now[0] - rest[0], now[1] - rest[1] + 2e-3, now[2] - rest[2]]
        };
        let moved: Vec<[f64; 3]> = scene.landmarks.iter().map(moved).collect();
        skin = skin.with_point_data(DataArray::vectors(format!("disp_{name}"), &moved));
    }
    std::fs::write(at.join("targets.csv"), table).unwrap();
    skin.write(at.join("skin.vtu")).unwrap();
    let text = SCENE.replace("\"material\"", TARGETS);
    std::fs::write(at.join("scene.json"), text).unwrap();
    Scene::load(at.join("scene.json")).unwrap()
}

/// The landmarks as a surface whose triangles nobody looks at.
fn skin_of(scene: &Scene) -> MeshFile {
    let at_rest = |l: &face_scenes::Landmark| l.point.position(scene.mesh.nodes());
    let points: Vec<[f64; 3]> = scene.landmarks.iter().map(at_rest).collect();
    let count = points.len() as u32;
    let triangles: Vec<[u32; 3]> = (2..count).map(|k| [0, k - 1, k]).collect();
    let ids = scene.landmarks.iter().map(|l| i64::from(l.vertex));
    MeshFile::from_triangles(points, &triangles)
        .with_point_data(DataArray::integers("ict_vertex", ids))
}

/// The rest pose with the jaw opened and shifted (m).
fn jaw(scene: &Scene, degrees: f64, shift: [f64; 3]) -> Parameters {
    let mut pose = scene.rest_pose();
    pose.jaw = scene.joint.motion([degrees.to_radians(), 0.0, 0.0, 0.0]).0;
    (0..3).for_each(|k| pose.jaw.translation[k] += shift[k]);
    pose
}

fn report(at: &Path, command: &str, options: &[&str]) -> (Option<i32>, Value) {
    let quiet = ["--json", "--force", "--pictures", "none", "--write", "none"];
    let output = Command::new(env!("CARGO_BIN_EXE_face-rig"))
        .args([command, "scene.json"])
        .args(quiet)
        .args(options)
        .current_dir(at)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    let report = serde_json::from_slice(&output.stdout);
    let report: Value = report.unwrap_or_else(|_| panic!("{options:?}: {message}"));
    (output.status.code(), report)
}

/// What a fit found, without what clocks and counters say.
fn found(fit: &Value) -> Value {
    let mut fit = fit.clone();
    let fields = fit.as_object_mut().unwrap();
    fields.remove("seconds");
    fields.remove("work");
    for step in fields["history"].as_array_mut().unwrap() {
        step.as_object_mut().unwrap().remove("seconds");
    }
    fit
}

fn fits(at: &Path, options: &[&str]) -> Vec<Value> {
    let fits = report(at, "fit", options).1["results"]["fits"].clone();
    fits.as_array().unwrap().iter().map(found).collect()
}

/// A fit by the library.
struct Fit {
    cranium: CraniumModel,
    jaw: JawModel,
    seen: Observed,
    params: FitParams,
}

impl Fit {
    fn default_of(scene: &Scene) -> Self {
        Self {
            cranium: CraniumModel::Fixed,
            jaw: scene.jointed_jaw(),
            seen: Observed::Landmarks,
            params: FitParams {
                jaw_angle_bounds: Some(scene.joint.limits().opening),
                ..FitParams::default()
            },
        }
    }

    fn run(
        &self,
        scene: &Scene,
        rig: &mut Rig,
        name: &str,
        start: Option<&[f64]>,
    ) -> ExpressionFit {
        let map = scene.parametrization(self.cranium, self.jaw);
        let start = start.map_or_else(|| map.rest(), <[f64]>::to_vec);
        let target = scene.target(name).unwrap();
        let params = &self.params;
        let seen = self.seen;
        rig.lent(|rig| fit_expression(scene, rig, target, seen, &map, params, &start, &mut |_| {}))
            .unwrap()
    }

    fn of_first(&self, scene: &Scene) -> Value {
        told(&self.run(scene, &mut rig(scene), "first", None))
    }
}

/// As a report tells it.
fn told(fit: &ExpressionFit) -> Value {
    let text = serde_json::to_string(fit).unwrap();
    found(&serde_json::from_str(&text).unwrap())
}

type Change = fn(&Scene, &mut Fit);

/// Options that change a fit, and what they mean.
const CHANGES: [(&[&str], Change); 16] = [
    (&["--relax", "50"], |_, fit| {
        fit.params.activation_weight = 5e-5
    }),
    (&["--robust", "0.5"], |_, fit| {
        fit.params.loss = Loss::Huber { scale: 5e-4 }
    }),
    (&["--stop", "1"], |_, fit| fit.params.rms_change = 1e-3),
    (&["--max-iterations", "1"], |_, fit| {
        fit.params.max_iterations = 1
    }),
    (&["--jaw-weight", "0"], |_, fit| {
        fit.params.joint_weight = 0.0
    }),
    (&["--method", "normal-equations"], |_, fit| {
        fit.params.method = StepMethod::NormalEquations
    }),
    (&["--head", "rigid"], |_, fit| {
        fit.cranium = CraniumModel::Rigid
    }),
    (&["--head", "affine"], |_, fit| {
        fit.cranium = CraniumModel::Affine
    }),
    (&["--jaw", "fixed"], |_, fit| fit.jaw = JawModel::Fixed),
    (&["--jaw", "hinge"], |scene, fit| {
        fit.jaw = JawModel::Hinge(*scene.joint.hinge())
    }),
    (&["--jaw", "rigid"], |scene, fit| {
        fit.jaw = JawModel::Rigid {
            point: scene.joint.hinge().point(),
        };
    }),
    (&["--jaw", "affine"], |_, fit| fit.jaw = JawModel::Affine),
    (&["--jaw", "affine", "--orthogonality", "0"], |_, fit| {
        fit.jaw = JawModel::Affine;
        fit.params.orthogonality.jaw = 0.0;
    }),
    (&["--head", "affine", "--orthogonality", "1"], |_, fit| {
        fit.cranium = CraniumModel::Affine;
        fit.params.orthogonality.cranium = 1e-6;
    }),
    (&["--points", "dense"], |_, fit| fit.seen = Observed::Dense),
    (&["--points", "both", "--landmark-weight", "9"], |_, fit| {
        fit.seen = Observed::Both {
            landmark_weight: 9.0,
        };
    }),
];

/// What holds without them, said aloud.
const DEFAULTS: &str = "--relax 0.1 --stop 0.002 --max-iterations 40 --jaw-weight 300 --method qr --head fixed \
     --jaw joint --orthogonality 10000 --points landmarks --landmark-weight 1";

#[test]
fn every_option_of_a_fit_does_what_the_library_does_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = with_targets(at);
    let one = ["--target", "first"];
    let plain = fits(at, &one);
    assert_eq!(plain, [Fit::default_of(&scene).of_first(&scene)]);
    let defaults: Vec<&str> = DEFAULTS.split_whitespace().collect();
    assert_eq!(fits(at, &[&one[..], &defaults].concat()), plain);
    let mut seen = vec![plain[0].clone()];
    for (options, change) in CHANGES {
        let mut fit = Fit::default_of(&scene);
        change(&scene, &mut fit);
        let expected = fit.of_first(&scene);
        let results = fits(at, &[&one[..], options].concat());
        assert_eq!(results, std::slice::from_ref(&expected), "{options:?}");
        assert!(!seen.contains(&expected), "{options:?} change nothing");
        seen.push(expected);
    }
    // Landmarks count among the points of the skin as much as is said.
    let both = |weight| {
        fits(
            at,
            &[&one[..], &["--points", "both", "--landmark-weight", weight]].concat(),
        )
    };
    assert_ne!(both("1"), both("9"));
    let (code, stopped) = report(at, "fit", &[&one[..], &["--max-iterations", "1"]].concat());
    assert_eq!(
        (code, &stopped["results"]["fits"][0]["iterations"]),
        (Some(1), &Value::from(1))
    );
    // Weights of orthogonality stand in the scene, and the option replaces them.
    let text = std::fs::read_to_string(at.join("scene.json")).unwrap();
    let weights = r#""fit": { "orthogonality": { "jaw_mm2": 0 } }, "material""#;
    let weighed = text.replacen("\"material\"", weights, 1);
    std::fs::write(at.join("scene.json"), weighed).unwrap();
    for (mm2, option) in [(0.0, &[][..]), (1e4, &["--orthogonality", "1e4"])] {
        let mut fit = Fit::default_of(&scene);
        fit.jaw = JawModel::Affine;
        fit.params.orthogonality.jaw = 1e-6 * mm2;
        let options = [&one[..], &["--jaw", "affine"], option].concat();
        assert_eq!(fits(at, &options), [fit.of_first(&scene)], "{option:?}");
    }
}

#[test]
fn targets_are_those_named_each_from_rest_or_from_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = with_targets(at);
    let fit = Fit::default_of(&scene);
    let mut one = rig(&scene);
    let first = fit.run(&scene, &mut one, "first", None);
    let after = fit.run(&scene, &mut one, "second", Some(&first.q));
    let alone = fit.run(&scene, &mut rig(&scene), "second", None);
    let [first, after, alone] = [first, after, alone].map(|fit| told(&fit));
    assert_ne!(after, alone);
    assert_eq!(fits(at, &[]), [first.clone(), alone.clone()]);
    assert_eq!(fits(at, &["--warm-start"]), [first, after]);
    assert_eq!(
        fits(at, &["--target", "second"]),
        std::slice::from_ref(&alone)
    );
    let twice = ["--target", "second", "--target", "second"];
    assert_eq!(fits(at, &twice), [alone]);
}

/// Two landmarks on one vertex that pull apart, and a head that moves freely: the vertex comes to rest
/// at their mean by weight.
#[test]
fn a_table_of_targets_has_the_weights_of_its_landmarks() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    files(at);
    let mesh = mesh();
    let vertex = *free_nodes(&mesh).last().unwrap();
    let [x, y, z] = mesh.nodes()[vertex];
    let rest: String = (0..2)
        .map(|k| format!("rest,{k},{vertex},{x:e},{y:e},{z:e}\n"))
        .collect();
    std::fs::write(
        at.join("rest.csv"),
        format!("target,landmark,ict_vertex,x,y,z\n{rest}"),
    )
    .unwrap();
    for (weights, mean) in [([9.0, 1.0], 0.8), ([1.0, 3.0], -0.5), ([1.0, 0.0], 1.0)] {
        let row = |k: usize, off: f64| {
            format!(
                "apart,{k},{vertex},{:e},{y:e},{z:e},{}\n",
                x + off,
                weights[k]
            )
        };
        let table = format!("{HEADER}{}{}", row(0, 0.01), row(1, -0.01));
        std::fs::write(at.join("apart.csv"), table).unwrap();
        let options = ["--targets", "apart.csv", "--head", "rigid", "--stop", "0"];
        let fit = report(at, "fit", &options).1["results"]["fits"][0].clone();
        let counted: Vec<f64> = [0.01, -0.01]
            .into_iter()
            .zip(weights)
            .filter(|(_, w)| *w > 0.0)
            .map(|(off, _)| 10.0 * (off / 0.01 - mean))
            .collect();
        let squares: f64 = counted.iter().map(|d| d * d).sum();
        let left = fit["rms_after_mm"].as_f64().unwrap();
        let expected = (squares / counted.len() as f64).sqrt();
        assert!(
            (left - expected).abs() < 1e-2,
            "{weights:?}: {left} for {expected} mm"
        );
    }
}

/// The largest way of a node (mm) and the energy (J).
fn posed(scene: &Scene, pose: &Parameters) -> [f64; 2] {
    let params = RigParams::default();
    let mut rig = Rig::of(scene.rig(params).unwrap(), params);
    let x = rig.solve(pose).unwrap().positions();
    let z = rig.equilibrium().in_cranium_frame.clone();
    let controls = rig.energy_controls(pose);
    let at = rig.assembly().configuration(&z, &controls).unwrap();
    let way =
        |(x, r): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (x[k] - r[k]).powi(2)).sum::<f64>().sqrt();
    let ways = x.iter().zip(scene.mesh.nodes()).map(way);
    [1e3 * ways.fold(0.0, f64::max), rig.assembly().energy(at)]
}

#[test]
fn every_option_of_a_pose_does_what_the_library_does_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    files(at);
    let scene = Scene::load(at.join("scene.json")).unwrap();
    let mut muscle = scene.rest_pose();
    muscle.activations = vec![0.6, 0.0];
    let mut light = scene.rest_pose();
    light.controls = vec![0.25];
    let cases: [(&[&str], Parameters); 5] = [
        (&[], scene.rest_pose()),
        (&["--set", "wide=0.6"], muscle),
        (&["--jaw", "-3deg"], jaw(&scene, -3.0, [0.0; 3])),
        (
            &["--jaw-shift", "1,2,0.5"],
            jaw(&scene, 0.0, [1e-3, 2e-3, 5e-4]),
        ),
        (&["--control", "weight=0.25"], light),
    ];
    let mut seen: Vec<[f64; 2]> = Vec::new();
    for (options, pose) in &cases {
        let results = report(at, "simulate", options).1["results"].clone();
        let expected = posed(&scene, pose);
        for (field, expected) in ["largest_displacement_mm", "energy_joules"]
            .iter()
            .zip(expected)
        {
            let result = results[field].as_f64().unwrap();
            let off = (result - expected).abs();
            assert!(
                off <= 1e-12 * expected.abs(),
                "{options:?}: {field} {result} {expected}"
            );
        }
        assert!(
            seen.iter()
                .all(|other| (other[1] / expected[1] - 1.0).abs() > 1e-3),
            "{options:?}"
        );
        seen.push(expected);
        // The derivative is that of the same pose.
        report(at, "jacobian", options);
        let table = std::fs::read_to_string(at.join("out/jacobian.csv")).unwrap();
        let numbers: Vec<Vec<f64>> = table
            .lines()
            .skip(1)
            .map(|line| {
                line.split(',')
                    .skip(2)
                    .map(|v| v.parse().unwrap())
                    .collect()
            })
            .collect();
        assert_eq!(numbers, jacobian(&scene, pose), "{options:?}");
    }
}

/// Rows of landmarks and axes, a column for each direction.
fn jacobian(scene: &Scene, pose: &Parameters) -> Vec<Vec<f64>> {
    let params = RigParams::default();
    let mut rig = Rig::of(scene.rig(params).unwrap(), params);
    rig.solve(pose).unwrap();
    let mut directions = Direction::all(scene.muscles.len());
    directions.extend((0..scene.influences.len()).map(Direction::Control));
    let points = scene.landmark_points(0..scene.landmarks.len());
    let columns = rig
        .sensitivity()
        .map(|s| s.jacobian(&points, &directions, JacobianRoute::Columns));
    let columns = columns.unwrap().unwrap();
    let rows = 3 * scene.landmarks.len();
    (0..rows)
        .map(|row| columns.iter().skip(row).step_by(rows).copied().collect())
        .collect()
}

#[test]
fn multigrid_is_used_when_asked_for_and_never_when_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    let pose = ["--set", "wide=0.4", "--jaw", "2deg"];
    let with = |multigrid: &[&str]| {
        let results = report(at, "simulate", &[&pose[..], multigrid].concat()).1["results"].clone();
        let iterations = results["linear_iterations"].as_u64().unwrap();
        (iterations, results["energy_joules"].as_f64().unwrap())
    };
    let (always, never) = (
        with(&["--multigrid", "always"]),
        with(&["--multigrid", "never"]),
    );
    // A block this small is factored unless something else is asked for.
    assert_eq!(
        (never.0, with(&[]), with(&["--multigrid", "auto"])),
        (0, never, never)
    );
    assert!(
        always.0 > 0 && (always.1 / never.1 - 1.0).abs() < 1e-9,
        "{always:?} {never:?}"
    );
    for (word, iterates) in [("always", true), ("never", false), ("auto", false)] {
        for (command, work) in [("jacobian", "work"), ("fit", "fits/0/work")] {
            let done = report(at, command, &["--multigrid", word]).1;
            let work = done.pointer(&format!("/results/{work}")).unwrap();
            let counts = (work["linear_iterations"] != 0, work["factorizations"] == 0);
            assert_eq!(counts, (iterates, iterates), "{command} {word}");
            assert_eq!(done["settings"]["multigrid"], word, "{command}");
        }
    }
}

#[test]
fn a_scene_solved_by_qr_takes_no_multigrid_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    let text = std::fs::read_to_string(at.join("scene.json")).unwrap();
    let by_qr = text.replacen('{', r#"{ "linear_solver": "qr","#, 1);
    std::fs::write(at.join("scene.json"), by_qr).unwrap();
    for command in ["simulate", "jacobian", "fit"] {
        for word in ["auto", "never"] {
            let done = report(at, command, &["--multigrid", word]).1;
            assert_eq!(done["settings"]["multigrid"], "never", "{command} {word}");
        }
        let output = Command::new(env!("CARGO_BIN_EXE_face-rig"))
            .args([
                command,
                "scene.json",
                "--multigrid",
                "always",
                "--out",
                "none",
            ])
            .current_dir(at)
            .output()
            .unwrap();
        assert_ne!(output.status.code(), Some(0), "{command}");
        let message = String::from_utf8_lossy(&output.stderr);
        for part in ["linear_solver", "qr", "--multigrid always"] {
            assert!(message.contains(part), "{command}: {message}");
        }
    }
}

#[test]
fn threads_are_as_many_as_asked_for_and_change_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    files(at);
    let mut shapes = Vec::new();
    for (threads, count) in [("1", 1), ("3", 3)] {
        let options = ["--set", "tall=0.5", "--write", "vtu", "--threads", threads];
        let quiet = ["--json", "--force", "--pictures", "none", "--out", threads];
        let output = Command::new(env!("CARGO_BIN_EXE_face-rig"))
            .args(["simulate", "scene.json"])
            .args(options)
            .args(quiet)
            .current_dir(at)
            .output()
            .unwrap();
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["threads"], count);
        shapes.push(std::fs::read(at.join(threads).join("pose.vtu")).unwrap());
    }
    assert!(shapes[0] == shapes[1]);
}
