//! Muscles, ligaments and regions that are drawn as lines.

use super::*;
use fem_assembly::Assembly;
use std::f64::consts::PI;

/// The block with these fields in the place of its muscles, and these before its material.
pub(super) fn drawn(muscles: &str, fields: &str) -> Files {
    let files = Files::new();
    let old = r#""names": { "list": ["smile_L", "smile_R"] },
      "fibers": { "table": "fibers.csv" }"#;
    files.edit("scene.json", old, muscles);
    let material = r#""material": { "preset": "soft_tissue" },"#;
    files.edit("scene.json", material, &format!("{material}\n  {fields}"));
    files
}

fn scene(muscles: &str, fields: &str) -> Scene {
    drawn(muscles, fields).load().expect("a scene")
}

/// Weights times volumes of a muscle, m³.
fn volume(scene: &Scene, name: &str) -> f64 {
    let muscle = scene.muscles.iter().position(|m| m.name == name);
    let muscle = muscle.expect("the muscle") as u32;
    let entries = scene.fiber_field.entries().iter();
    let of_muscle = entries.filter(|e| e.muscle == muscle);
    of_muscle
        .map(|e| e.weight * scene.mesh.volume(e.tet as usize))
        .sum()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{found} instead of {expected}"
    );
}

pub(super) const CURVES: &str = r#"[
  { "index": 0, "name": "cord_L", "half_thickness_m": 0.004, "closed_loop": false, "length_m": 0.1,
    "fibers": [[{ "kind": "skin", "point_m": [0.05, 0.02, 0.05] }, { "point_m": [0.05, 0.12, 0.05] }]] },
  { "index": 1, "name": "sheet_L", "half_thickness_m": 0.003, "closed_loop": false,
    "fibers": [[{ "point_m": [0.02, 0.05, 0.05] }, { "point_m": [0.08, 0.05, 0.05] }],
               [{ "point_m": [0.02, 0.09, 0.05] }, { "point_m": [0.08, 0.09, 0.05] }]] },
  { "index": 2, "name": "ring_L", "half_thickness_m": 0.002, "closed_loop": true,
    "fibres": [[{ "point_m": [0.02, 0.15, 0.05] }, { "point_m": [0.08, 0.15, 0.05] },
                { "point_m": [0.08, 0.19, 0.05] }, { "point_m": [0.02, 0.19, 0.05] }]] }
]"#;
pub(super) const FROM_FILE: &str =
    r#""names": { "file": "curves.json" }, "fibers": { "curves": "curves.json" }"#;

#[test]
fn a_file_of_curves_is_read_as_it_is_and_what_is_drawn_replaces_or_adds() {
    let files = drawn(FROM_FILE, "");
    files.text("curves.json", CURVES);
    let scene = files.load().expect("a scene");
    let names: Vec<&str> = scene.muscles.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["cord_L", "sheet_L", "ring_L"]);
    close(volume(&scene, "cord_L"), PI * 16e-6 * 0.1, 6e-3);
    let sheet = 0.06 * (0.04 * 0.006 + PI * 9e-6);
    close(volume(&scene, "sheet_L"), sheet, 6e-3);
    close(volume(&scene, "ring_L"), PI * 4e-6 * 0.2, 6e-3);
    for entry in scene.fiber_field.entries().iter().filter(|e| e.muscle == 0) {
        assert!(entry.direction[1].abs() > 1.0 - 1e-12);
    }

    let more = r#", "without": ["ring"], "drawn": [
        { "name": "cord_L", "along": { "lines": [[[0.02, 0.1, 0.02], [0.08, 0.1, 0.02]]], "radius": 0.002 } },
        { "name": "new", "along": { "lines": [[[0.02, 0.12, 0.08], [0.02, 0.18, 0.08]]],
          "thickness": 0.002, "width": 0.01, "normal": [0, 0, 1] } } ]"#;
    let files = drawn(&format!("{FROM_FILE}{more}"), "");
    files.text("curves.json", CURVES);
    let scene = files.load().expect("a scene");
    let names: Vec<&str> = scene.muscles.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["cord_L", "sheet_L", "new"]);
    close(volume(&scene, "cord_L"), PI * 4e-6 * 0.06, 6e-3);
    close(volume(&scene, "sheet_L"), sheet, 6e-3);
    close(volume(&scene, "new"), 2e-5 * 0.06, 6e-3);
}

#[test]
fn a_table_keeps_its_fibers_beside_what_is_drawn() {
    let muscles = r#""names": { "list": ["smile_L", "smile_R"] }, "fibers": { "table": "fibers.csv" },
        "drawn": [{ "name": "new", "along": { "lines": [[[0.02, 0.12, 0.08], [0.02, 0.18, 0.08]]], "radius": 0.001 } }]"#;
    let (with, without) = (scene(muscles, ""), Files::new().load().expect("a scene"));
    let kept = with.fiber_field.entries().iter().filter(|e| e.muscle < 2);
    assert!(kept.eq(without.fiber_field.entries()));
    assert_eq!(with.muscles.len(), 3);
}

/// Where muscles interlace, they share the element.
#[test]
fn no_element_holds_more_muscle_than_itself() {
    let line = r#"{ "lines": [[[0.02, 0.1, 0.04], [0.08, 0.1, 0.04]]], "radius": 0.03 }"#;
    let muscles = format!(
        r#""drawn": [{{ "name": "a", "along": {line} }}, {{ "name": "b", "along": {line} }}]"#
    );
    let scene = scene(&muscles, "");
    let mut sums = vec![0.0; scene.mesh.num_elements()];
    for entry in scene.fiber_field.entries() {
        sums[entry.tet as usize] += entry.weight;
    }
    let most = sums.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.99 && most < 1.0 + 1e-12, "{most}");
}

fn forces(assembly: &Assembly<3>, activations: &[f64]) -> Vec<f64> {
    let at = assembly.configuration(assembly.rest(), activations);
    assembly.forces_everywhere(at.expect("finite")).concat()
}

/// At rest the tension is σ_max/λ_ofl f(1/λ_ofl), with f = 1 − 25/6 (l − 1)².
#[test]
fn each_muscle_has_its_own_strength_and_optimal_stretch() {
    let line = r#"{ "lines": [[[0.02, 0.1, 0.04], [0.08, 0.1, 0.04]]], "radius": 0.003 }"#;
    let muscle = |own: &str| format!(r#""drawn": [{{ "name": "a_L", "along": {line}{own} }}]"#);
    let force = |muscles: &str| {
        let scene = scene(muscles, "");
        let assembly = scene.assembly().expect("an assembly");
        let largest = |a: f64| {
            forces(&assembly, &[a])
                .iter()
                .fold(0.0_f64, |m, f| m.max(f.abs()))
        };
        // Less what is passive.
        let (active, passive) = (forces(&assembly, &[1.0]), forces(&assembly, &[0.0]));
        let difference = active.iter().zip(&passive).map(|(a, p)| (a - p).abs());
        assert!(largest(1.0) > 0.0);
        difference.fold(0.0, f64::max)
    };
    let common = force(&muscle(""));
    let strong = force(&muscle(r#", "max_isometric_stress": 500e3"#));
    close(strong, 2.5 * common, 1e-12);
    let short = force(&muscle(r#", "optimal_stretch": 0.8"#));
    close(short, common / 0.8 * (1.0 - 25.0 / 6.0 * 0.0625), 1e-12);
    let both = format!(
        r#"{}, "own": [{{ "muscles": ["a"], "optimal_stretch": 1.25 }}]"#,
        muscle(r#", "max_isometric_stress": 100e3"#)
    );
    close(
        force(&both),
        0.5 * common / 1.25 * (1.0 - 25.0 / 6.0 * 0.04),
        1e-12,
    );
}

/// Stretched by a tenth along a ligament of toe 0.02, each cubic meter of it holds
/// E (toe²/6 + toe (e − toe)/2 + (e − toe)²/2); pressed together, nothing. No activation changes that.
#[test]
fn a_ligament_holds_what_it_is_stretched_by_and_no_more() {
    let ligament = r#""ligaments": [{ "name": "tendon", "stiffness": 2e6, "toe": 0.02,
        "along": { "lines": [[[0.02, 0.1, 0.04], [0.08, 0.1, 0.04]]], "radius": 0.003 } }],"#;
    let table =
        r#""names": { "list": ["smile_L", "smile_R"] }, "fibers": { "table": "fibers.csv" }"#;
    let with = scene(table, ligament).assembly().expect("an assembly");
    let without = scene(table, "").assembly().expect("an assembly");
    assert_eq!(with.controls(), without.controls());
    let stored = |stretch: f64, activation: f64| {
        let moved: Vec<[f64; 3]> = with
            .rest()
            .iter()
            .map(|x| [stretch * x[0], x[1], x[2]])
            .collect();
        let energy = |a: &Assembly<3>| {
            let activations = [activation; 2];
            let at = a.configuration(&moved, &activations);
            a.energy(at.expect("finite"))
        };
        energy(&with) - energy(&without)
    };
    let volume = PI * 9e-6 * 0.06;
    let each = 2e6 * (0.0004 / 6.0 + 0.01 * 0.08 + 0.5 * 0.0064);
    close(stored(1.1, 0.0), volume * each, 6e-3);
    close(stored(1.1, 0.7), stored(1.1, 0.0), 1e-9);
    assert!(stored(0.9, 0.0).abs() < 1e-9 * volume * each);
    assert!(stored(1.0, 0.5).abs() < 1e-12);
}

#[test]
fn a_region_along_lines_is_made_of_its_own_material() {
    let region = |share: &str| {
        format!(
            r#""regions": {{ "drawn": [{{ "name": "cartilage"{share},
              "along": {{ "lines": [[[0.0, 0.1, 0.05], [0.1, 0.1, 0.05]]], "thickness": 0.05, "width": 0.0667,
                         "normal": [0, 0, 1] }},
              "material": {{ "neo_hookean": {{ "young": 1e6, "poisson": 0.4 }} }} }}] }},"#
        )
    };
    let scene = scene("", &region(""));
    let in_region = scene.region_of_tet.iter().filter(|&&r| r == 1).count();
    // 24 elements fill the middle third of the height; those nearer to the middle of the depth are
    // filled by half or more.
    assert_eq!(
        (scene.regions[1].name.as_str(), scene.regions.len()),
        ("cartilage", 2)
    );
    assert!((8..=20).contains(&in_region), "{in_region}");
    for (tet, region) in scene.mesh.tets().zip(&scene.region_of_tet) {
        let heights = tet.map(|n| scene.mesh.node(n)[1]);
        let inside = heights.iter().all(|y| (0.06..0.14).contains(y));
        assert!(*region == 0 || inside, "{heights:?}");
    }
    let error = drawn("", &region(r#", "share": 1.5"#)).error("scene.json");
    expect(
        &error,
        &[
            "regions.drawn[0]",
            "cartilage",
            "fills no tetrahedron to 1.5",
        ],
    );
}

/// A line at 5 mm from the middle of a ball of 20 mm follows it along an arc.
#[test]
fn a_muscle_is_laid_over_a_solid() {
    let muscle = r#""drawn": [{ "name": "wrap", "along": { "lines": [[[0.01, 0.1, 0.055], [0.09, 0.1, 0.055]]],
        "radius": 0.002, "over": [{ "shape": { "sphere": { "center": [0.05, 0.1, 0.05], "radius": 0.018 } },
                                    "clearance": 0.002 }] } }]"#;
    let scene = scene(muscle, "");
    let (r, d) = (0.02_f64, 0.005_f64);
    let length = 0.08 - 2.0 * (r * r - d * d).sqrt() + 2.0 * r * (d / r).acos();
    close(volume(&scene, "wrap"), length * PI * 4e-6, 1e-2);
}

/// The built-in face has the 68 landmarks and is its own mirror image.
#[test]
fn a_mirrored_drawing_has_a_right_half() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.json");
    let ligament = r#""ligaments": [{ "name": "canthal_L", "mirrored": true, "stiffness": 1e6, "along": {
        "radius": 0.003, "lines": [[{ "landmark": 45, "offset": [0, 0, -0.004] },
          { "between": [{ "landmark": 45 }, { "landmark": 16 }], "at": 0.4, "offset": [-0.002, 0, -0.004] }]] } }]"#;
    let text = format!(
        r#"{{ "face": {{ "builtin": {{ "tets": 20000 }} }}, "material": {{ "preset": "soft_tissue" }}, {ligament} }}"#
    );
    fs::write(&path, text).expect("writable");
    let scene = Scene::load(&path).expect("a scene");
    let names: Vec<&str> = scene.ligaments.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["canthal_L", "canthal_R"]);
    let middle = |l: &crate::Ligament| -> [f64; 4] {
        l.shares.iter().fold([0.0; 4], |sum, share| {
            let tet = scene
                .mesh
                .tet(share.tet as usize)
                .map(|n| scene.mesh.node(n));
            let v = share.weight * scene.mesh.volume(share.tet as usize);
            let at = |i: usize| v * 0.25 * tet.iter().map(|x| x[i]).sum::<f64>();
            [sum[0] + at(0), sum[1] + at(1), sum[2] + at(2), sum[3] + v]
        })
    };
    let [left, right] = [&scene.ligaments[0], &scene.ligaments[1]].map(middle);
    assert!(left[0] > 0.01 * left[3], "{left:?}");
    close(right[3], left[3], 0.05);
    close(-right[0], left[0], 0.1);
    close(right[1], left[1], 0.1);
}

#[test]
fn what_cannot_be_drawn_is_named_with_its_cure() {
    let one = |name: &str, along: &str, more: &str| {
        format!(r#""drawn": [{{ "name": "{name}", "along": {along}{more} }}]"#)
    };
    let line = r#"[[0.02, 0.1, 0.04], [0.08, 0.1, 0.04]]"#;
    let good = format!(r#"{{ "lines": [{line}], "radius": 0.003 }}"#);
    let place = "face.files.muscles.drawn[0]";
    for (muscles, parts) in [
        (
            one(
                "far",
                r#"{ "lines": [[[2, 0, 0], [3, 0, 0]]], "radius": 0.003 }"#,
                "",
            ),
            &[place, "far: it meets no tetrahedron", "check units"][..],
        ),
        (
            one(
                "dot",
                r#"{ "lines": [[[0.02, 0.1, 0.04]]], "radius": 0.003 }"#,
                "",
            ),
            &[place, "dot: line 0 has 1 point(s), at least 2"],
        ),
        (
            one(
                "thin",
                &format!(r#"{{ "lines": [{line}], "radius": 0 }}"#),
                "",
            ),
            &[place, "thin: radius = 0 m must be above 0"],
        ),
        (
            one(
                "odd",
                &format!(r#"{{ "lines": [{line}], "radius": 1, "width": 1 }}"#),
                "",
            ),
            &[place, "odd: give a \"radius\" (bundles)"],
        ),
        (
            one(
                "lost",
                r#"{ "lines": [[[0, 0, 0], { "landmark": 30 }]], "radius": 0.003 }"#,
                "",
            ),
            &[place, "lost: the face has no landmark 30"],
        ),
        (
            one(
                "lost",
                r#"{ "lines": [[[0, 0, 0], { "vertex": 8 }]], "radius": 0.003 }"#,
                "",
            ),
            &[place, "lost: the embedding has no vertex 8"],
        ),
        (
            one(
                "both",
                r#"{ "lines": [[[0, 0, 0], { "vertex": 7, "landmark": 0 }]], "radius": 1 }"#,
                "",
            ),
            &[place, "both, point 1 of line 0: give one of"],
        ),
        (
            one("m", &good, r#", "mirrored": true"#),
            &[place, "\"m\" is mirrored and must end in _L"],
        ),
        (
            one("m", &good, r#", "optimal_stretch": -1"#),
            &[place, "m: optimal_stretch = -1 must be a number above 0"],
        ),
        (
            format!(
                r#"{}, "own": [{{ "muscles": ["smilee"] }}]"#,
                one("smile", &good, "")
            ),
            &[
                "face.files.muscles.own[0]",
                "no muscle \"smilee\"; did you mean \"smile\"?",
            ],
        ),
        (
            r#""without": ["smile"]"#.to_owned(),
            &["face.files.muscles.without[0]", "no muscle \"smile\""],
        ),
        (
            one("p", r#"{ "lines": [[7, [0, 0, 0]]], "radius": 1 }"#, ""),
            &["drawn[0].along.lines[0][0]", "expected [x, y, z]"],
        ),
    ] {
        let error = drawn(&muscles, "").error("scene.json");
        expect(&error, parts);
    }
    let ligament =
        format!(r#""ligaments": [{{ "name": "t", "stiffness": 1e6, "along": {good} }}],"#);
    let error = drawn("", &ligament).error("scene.json");
    expect(
        &error,
        &["ligaments", "t: a face with ligaments needs a muscle"],
    );
}

/// The muscles of the shared head, against the table that was made from the same curves by another
/// program, where it is there.
#[test]
fn the_curves_of_the_shared_head_fill_what_its_table_says() {
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/head_coarse.json");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/head/muscles.json");
    if !data.exists() {
        return;
    }
    let text = fs::read_to_string(&head).expect("readable");
    let mut file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let muscles = |fibers: &str| {
        serde_json::json!({ "names": { "file": "muscles.json" }, "fibers": { fibers: match fibers {
            "table" => "muscle_tets_coarse.csv",
            _ => "muscles.json",
        } } })
    };
    let folder = data
        .parent()
        .expect("a folder")
        .to_string_lossy()
        .into_owned();
    let mut load = |fibers: &str| {
        let mut scene = file.take();
        for key in ["targets", "contact", "ligaments", "regions", "cavities"] {
            scene.as_object_mut().expect("an object").remove(key);
        }
        scene["face"]["files"]["muscles"] = muscles(fibers);
        let text = scene
            .to_string()
            .replace("../../../../shared/data/head", &folder);
        file = scene;
        let text = text
            .replace("\"muscles.json\"", &format!("\"{folder}/muscles.json\""))
            .replace("\"muscle_tets", &format!("\"{folder}/muscle_tets"));
        let place = tempfile::tempdir().expect("a temporary folder");
        fs::write(place.path().join("scene.json"), text).expect("writable");
        Scene::load(place.path().join("scene.json")).expect("a scene")
    };
    let [table, curves] = [load("table"), load("curves")];
    let (mut alike, mut all, mut along) = (0.0, 0.0, 0.0);
    for muscle in &table.muscles {
        let [a, b] = [volume(&table, &muscle.name), volume(&curves, &muscle.name)];
        assert!((a / b - 1.0).abs() < 0.35, "{}: {a} and {b}", muscle.name);
    }
    for entry in table.fiber_field.entries() {
        let others = curves.fiber_field.of_tet(entry.tet);
        let other = others.iter().find(|e| e.muscle == entry.muscle);
        let volume = table.mesh.volume(entry.tet as usize);
        all += entry.weight * volume;
        let Some(other) = other else { continue };
        let shared = entry.weight.min(other.weight) * volume;
        let dot: f64 = (0..3)
            .map(|i| entry.direction[i] * other.direction[i])
            .sum();
        alike += shared;
        along += shared * dot.abs();
    }
    // The other program takes 60 points an element, leaves shares under 0.04 out and smooths lines.
    assert!(alike > 0.8 * all, "{alike} of {all}");
    assert!(along > 0.95 * alike, "{along} of {alike}");
}
