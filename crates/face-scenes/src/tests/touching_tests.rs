//! With which surface the flesh of a scene touches itself.

use super::*;
use crate::Touching;

/// The built-in face, in millimeters, with this field `contact.flesh`.
fn builtin(name: &str, flesh: &str) -> Result<Scene, SceneError> {
    let folder = std::env::temp_dir().join(format!("touching_{}_{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("scene.json");
    let text = format!(
        r#"{{ "face": {{ "builtin": {{ "tets": 5000 }} }}, "scale": 0.001,
             "material": {{ "preset": "soft_tissue" }}, "contact": {{ "flesh": {flesh} }} }}"#
    );
    std::fs::write(&path, text).expect("a file");
    let scene = Scene::load(&path);
    std::fs::remove_dir_all(&folder).expect("the folder");
    scene
}

#[test]
fn what_flesh_touches_with_is_named_by_its_field() {
    for (name, flesh, place) in [
        ("number", "3", "true, false or"),
        ("depth", r#"{ "depth": -1 }"#, "contact.flesh.depth"),
        (
            "boundary",
            r#"{ "near": { "landmarks": [48], "within": 9 } }"#,
            "contact.flesh.near",
        ),
        (
            "landmark",
            r#"{ "surface": "skin", "near": { "landmarks": [99], "within": 9 } }"#,
            "no landmark 99",
        ),
        (
            "nothing",
            r#"{ "surface": "skin", "near": { "landmarks": [48], "within": 0.001 } }"#,
            "contact.flesh.near",
        ),
        (
            "empty",
            r#"{ "surface": "skin", "near": [] }"#,
            "a list of those",
        ),
        (
            "inside out",
            r#"{ "surface": "skin", "near": [{ "landmarks": [48], "within": 15 },
                 { "landmarks": [48], "within": -15 }] }"#,
            "contact.flesh.near[1]",
        ),
        (
            "elsewhere",
            r#"{ "surface": "skin", "near": [{ "landmarks": [48], "within": 15 },
                 { "landmarks": [48], "offset": [0, 500, 0], "within": 15 }] }"#,
            "contact.flesh.near[1]",
        ),
        (
            "of none",
            r#"{ "surface": "skin", "near": { "landmarks": [], "within": 9 } }"#,
            "contact.flesh.near[0]",
        ),
        ("unknown", r#"{ "surfaces": "skin" }"#, "surfaces"),
    ] {
        let error = builtin(name, flesh).expect_err(name).to_string();
        assert!(error.contains(place), "{name}: {error}");
    }
    let files = Files::new();
    files.edit(
        "scene.json",
        "\"name\": \"block\"",
        "\"name\": \"block\", \"contact\": { \"flesh\": { \"surface\": \"skin\" } }",
    );
    expect(
        &files.error("scene.json"),
        &["contact.flesh.surface", "no skin"],
    );
}

#[test]
fn a_part_of_the_skin_touches_itself_with_numbers_in_the_unit_of_the_scene() {
    let flesh = r#"{ "surface": "skin", "near": { "landmarks": [48, 54], "within": 15 },
        "activation": 0.3, "pressure": 2e4, "depth": 2, "margin": 1, "neighbors": 1 }"#;
    let scene = builtin("part", flesh).expect("a scene");
    let params = scene.contact.flesh.expect("flesh that touches");
    let lengths = [params.activation, params.depth, params.margin];
    assert!(
        lengths
            .iter()
            .zip([3e-4, 2e-3, 1e-3])
            .all(|(a, b)| (a - b).abs() < 1e-15)
    );
    assert_eq!((params.pressure, params.neighbors), (2e4, 1));
    let Touching::Carried { points, triangles } = &scene.contact.touching else {
        panic!("{:?}", scene.contact.touching);
    };
    let skin = scene.skin.as_ref().expect("a skin");
    assert_eq!(points, &skin.points);
    let corner = |index| {
        let landmark = scene.landmarks.iter().find(|l| l.index == index);
        landmark
            .expect("a corner")
            .point
            .position(scene.mesh.nodes())
    };
    let corners = [48, 54].map(corner);
    let near = |n: &u32| {
        let away = |c: &[f64; 3]| {
            (0..3)
                .map(|i| (skin.rest[*n as usize][i] - c[i]).powi(2))
                .sum::<f64>()
        };
        corners.iter().any(|c| away(c).sqrt() <= 0.015)
    };
    let wanted = skin.triangles.iter().filter(|t| t.iter().all(near)).count();
    assert!(wanted > 10 && wanted < skin.triangles.len());
    assert_eq!(triangles.len(), wanted);
    assert!(scene.assembly().expect("an assembly").changes());
    // The other corner as a place beside the first.
    let [x, y, z]: [f64; 3] = std::array::from_fn(|i| 1e3 * (corners[1][i] - corners[0][i]));
    let flesh = format!(
        r#"{{ "surface": "skin", "near": [{{ "landmarks": [48], "within": 15 }},
            {{ "landmarks": [48], "offset": [{x}, {y}, {z}], "within": 15 }}] }}"#
    );
    let scene = builtin("list", &flesh).expect("a scene");
    let Touching::Carried {
        triangles: same, ..
    } = &scene.contact.touching
    else {
        panic!("{:?}", scene.contact.touching);
    };
    assert_eq!(same, triangles);
}
