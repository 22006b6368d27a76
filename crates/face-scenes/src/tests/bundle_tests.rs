//! Muscles that are divided into bundles.

use super::course_tests::{CURVES, FROM_FILE, drawn};
use super::*;
use crate::{InfluenceKind, parse_activations};
use std::collections::BTreeSet;

fn divided(bundles: &str, fields: &str) -> Files {
    let files = drawn(
        &format!(r#"{FROM_FILE}{fields}, "bundles": [{bundles}]"#),
        "",
    );
    files.text("curves.json", CURVES);
    // Finer, and without what rides on the coarse one.
    files.block_of([8, 12, 8], |_| {});
    let carried = r#",
    "embedding": "embedding.csv",
    "landmarks": { "file": "landmarks.csv" }"#;
    files.edit("scene.json", carried, "");
    let targets = r#""targets": { "landmarks": "landmarks.csv", "skip": ["rest"], "identities": ["identity"] }"#;
    files.edit("scene.json", targets, r#""volume": "elements""#);
    files
}

/// Elements, weights and directions of the muscles whose names begin like that.
fn parts(scene: &Scene, name: &str) -> Vec<(u32, u64, [u64; 3])> {
    let of = |m: u32| scene.muscles[m as usize].name.starts_with(name);
    let entries = scene.fiber_field.entries().iter();
    let own = entries.filter(|e| of(e.muscle));
    let bits = own.map(|e| (e.tet, e.weight.to_bits(), e.direction.map(f64::to_bits)));
    let mut bits: Vec<_> = bits.collect();
    bits.sort_unstable();
    bits
}

#[test]
fn bundles_are_their_muscle_in_parts_and_have_what_it_has() {
    let whole = divided("", "").load().expect("a scene");
    let own = r#", "own": [{ "muscles": ["sheet"], "optimal_stretch": 1.25 }]"#;
    let three = r#"{ "muscles": ["sheet", "ring"], "count": 3 }"#;
    let scene = divided(three, own).load().expect("a scene");
    let names: Vec<&str> = scene.muscles.iter().map(|m| m.name.as_str()).collect();
    let sheet = ["sheet.1_L", "sheet.2_L", "sheet.3_L"];
    let ring = ["ring.1_L", "ring.2_L", "ring.3_L"];
    assert_eq!(names, [&["cord_L"][..], &sheet, &ring].concat());
    for name in ["cord", "sheet", "ring"] {
        assert_eq!(parts(&scene, name), parts(&whole, name), "{name}");
        assert!(!parts(&scene, name).is_empty());
    }
    // The sheet runs along x between y = 0.05 and 0.09: its bundles lie above each other, without overlap.
    let middle = |entry: &&face_rig::anatomy::FiberEntry| {
        let corners = scene.mesh.tet(entry.tet as usize);
        corners
            .iter()
            .map(|&n| scene.mesh.nodes()[n as usize][1])
            .sum::<f64>()
            / 4.0
    };
    let mean = |muscle: u32| {
        let own = || {
            scene
                .fiber_field
                .entries()
                .iter()
                .filter(|e| e.muscle == muscle)
        };
        own().map(|e| middle(&e)).sum::<f64>() / own().count() as f64
    };
    let heights = [1, 2, 3].map(mean);
    assert!(
        heights[0] < heights[1] && heights[1] < heights[2],
        "{heights:?}"
    );
    let stretches: Vec<Option<f64>> = (0..7)
        .map(|m| scene.own_fibers.get(&m).and_then(|own| own.optimal_stretch))
        .collect();
    let long = Some(1.25);
    assert_eq!(stretches, [None, long, long, long, None, None, None]);
    // A muscle's name means all of its bundles, in a pose as in a strength.
    let pulled = parse_activations(&scene.muscles, ["sheet=0.5", "ring.2_L=1"]).expect("muscles");
    assert_eq!(pulled, [0.0, 0.5, 0.5, 0.5, 0.0, 1.0, 0.0]);
    let files = divided(three, own);
    let strength = r#""volume": "elements",
      "strengths": [{ "name": "sheets", "muscle": "sheet", "range": [-0.5, 2] }]"#;
    files.edit("scene.json", r#""volume": "elements""#, strength);
    let scene = files.load().expect("a scene");
    let InfluenceKind::Strength { muscles } = &scene.influences[0].kind else {
        panic!("{:?}", scene.influences);
    };
    assert_eq!(muscles, &[1, 2, 3]);
}

#[test]
fn few_elements_are_not_divided() {
    let many = r#"{ "muscles": ["cord_L"], "count": 1000 }"#;
    let scene = divided(many, "").load().expect("a scene");
    let elements = parts(&scene, "cord").len();
    let own: BTreeSet<u32> = scene
        .fiber_field
        .entries()
        .iter()
        .map(|e| e.muscle)
        .collect();
    let bundles = scene
        .muscles
        .iter()
        .filter(|m| m.name.starts_with("cord"))
        .count();
    assert!(
        bundles > 1 && bundles <= elements / 8,
        "{bundles} of {elements}"
    );
    assert_eq!(own.len(), scene.muscles.len(), "an empty muscle");
}

#[test]
fn a_division_that_cannot_be_names_its_field() {
    let place = "face.files.muscles.bundles";
    for (bundles, fields, parts) in [
        (
            r#"{ "muscles": ["sheat"], "count": 2 }"#,
            "",
            [
                "bundles[0]",
                "no muscle \"sheat\"; did you mean \"sheet_L\"?",
            ],
        ),
        (
            r#"{ "muscles": ["sheet"], "count": 0 }"#,
            "",
            ["bundles[0]", "sheet: \"count\" must be 1 or more"],
        ),
        (
            r#"{ "muscles": ["sheet"], "count": 2 }, { "muscles": ["sheet_L"], "count": 3 }"#,
            "",
            ["bundles[1]", "sheet_L is divided twice"],
        ),
        (
            r#"{ "muscles": ["sheet_L"], "count": 2 }"#,
            r#", "drawn": [{ "name": "sheet.2_L",
              "along": { "lines": [[[0.02, 0.1, 0.02], [0.08, 0.1, 0.02]]], "radius": 0.002 } }]"#,
            [
                "bundles",
                "\"sheet.2_L\" is the name of a bundle and of another muscle",
            ],
        ),
    ] {
        let error = divided(bundles, fields).error("scene.json");
        expect(&error, &[&[place][..], &parts].concat());
    }
}
