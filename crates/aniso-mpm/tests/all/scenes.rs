//! Comparison with the reference solutions beside the repository.
use aniso_mpm::scenes;
use serde_json::Value;
use std::path::PathBuf;

/// The scene's file; nothing where the files are absent.
fn reference(name: &str) -> Option<Value> {
    let shared = std::env::var_os("FEM_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let directory = shared.join("reference/scenes");
    if !directory.is_dir() {
        println!("skipped: {} is not there", directory.display());
        return None;
    }
    let text = std::fs::read_to_string(directory.join(format!("{name}.json"))).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

#[test]
fn scenes_agree_with_the_reference() {
    let mut bad = Vec::new();
    for name in scenes::NAMES {
        let Some(file) = reference(name) else { return };
        let deviations = scenes::compare(name, &file).unwrap();
        assert!(!deviations.is_empty());
        for deviation in deviations {
            println!("{name} {}: {:.1e}", deviation.name, deviation.error);
            if !deviation.is_good() {
                bad.push((name, deviation));
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

/// Multiplies every number of this name, however deep.
fn scale(value: &mut Value, key: &str, factor: f64) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|v| scale(v, key, factor)),
        Value::Object(fields) => {
            for (name, field) in fields {
                match field.as_f64() {
                    Some(number) if name == key => *field = (factor * number).into(),
                    _ => scale(field, key, factor),
                }
            }
        }
        _ => {}
    }
}

/// A constant of one file in the code would serve this file alone: with another number in it what is
/// computed from it no longer agrees, and everything else does.
#[test]
fn the_steps_of_the_damage_scenes_come_from_the_file() {
    for name in ["c2_damage_2d", "c2_damage_3d"] {
        for (key, results) in [
            ("dt_explicit", &["d_explicit", "explicit_d_new"][..]),
            ("l0", &["D_c", "d_explicit"][..]),
        ] {
            let Some(mut file) = reference(name) else {
                return;
            };
            scale(&mut file, key, 0.5);
            let deviations = scenes::compare(name, &file).unwrap();
            for result in results {
                let wrong = |d: &scenes::Deviation| d.name.ends_with(result) && !d.is_good();
                assert!(deviations.iter().any(wrong), "{name}: {key}, {result}");
            }
            let independent = |d: &&scenes::Deviation| d.name.ends_with("laplacian");
            assert!(deviations.iter().filter(independent).all(|d| d.is_good()));
        }
    }
}
