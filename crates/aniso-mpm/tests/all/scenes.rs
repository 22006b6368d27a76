//! Comparison with the reference solutions beside the repository.
use aniso_mpm::scenes;
use std::path::PathBuf;

#[test]
fn scenes_agree_with_the_reference() {
    let shared = std::env::var_os("FEM_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let directory = shared.join("reference/scenes");
    if !directory.is_dir() {
        println!("skipped: {} is not there", directory.display());
        return;
    }
    let mut bad = Vec::new();
    for name in scenes::NAMES {
        let text = std::fs::read_to_string(directory.join(format!("{name}.json"))).unwrap();
        let file = serde_json::from_str(&text).unwrap();
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
