//! What is wrong can be told apart without reading the message.

use super::*;
use crate::defect::{
    Defect, EmbeddingDefect, FleshDefect, LandmarkDefect, Location, MaterialDefect, TableDefect,
    TargetDefect,
};

/// Where the scene is refused, and why.
fn refusal(files: &Files) -> (Location, Defect) {
    match files.load().expect_err("must be refused") {
        SceneError::Invalid {
            location, defect, ..
        } => (location, *defect),
        other => panic!("{other}"),
    }
}

fn field(path: &str, line: usize) -> Location {
    Location::Field {
        path: path.into(),
        line: Some(line),
    }
}

#[test]
fn a_field_is_told_with_its_line_and_the_names_that_were_meant() {
    let files = Files::new();
    files.edit("scene.json", "soft_tissue", "soft_tisue");
    let (location, defect) = refusal(&files);
    assert_eq!(location, field("material", 14));
    let Defect::Material(MaterialDefect::UnknownPreset {
        name,
        known,
        similar,
    }) = defect
    else {
        panic!("{defect:?}");
    };
    assert_eq!(
        (name.as_str(), similar.as_deref()),
        ("soft_tisue", Some("soft_tissue"))
    );
    assert!(known.contains(&"soft_tissue"));

    let files = Files::new();
    files.edit("scene.json", "\"name\"", "\"scale\": -2.5, \"name\"");
    let (location, defect) = refusal(&files);
    assert_eq!(location, field("scale", 2));
    let scale = -2.5;
    assert!(matches!(defect, Defect::Flesh(d) if d == FleshDefect::Scale { scale }));
}

#[test]
fn a_line_of_a_table_is_told_with_its_numbers() {
    let files = Files::new();
    files.edit("embedding.csv", "9,5,0.1", "9,99,0.1");
    let (location, defect) = refusal(&files);
    assert_eq!(location, Location::Line(3));
    let expected = EmbeddingDefect::NoTet { tet: 99, tets: 72 };
    assert!(matches!(defect, Defect::Embedding(d) if d == expected));

    let files = Files::new();
    files.edit("embedding.csv", "9,5,0.1", "9,5.5,0.1");
    let (location, defect) = refusal(&files);
    assert_eq!(location, Location::Line(3));
    let Defect::Table(TableDefect::NotAnIndex { column, found }) = defect else {
        panic!("{defect:?}");
    };
    assert_eq!((column.as_str(), found.as_str()), ("tet", "5.5"));

    let files = Files::new();
    files.edit("landmarks.csv", "rest,0,7,0,0,0", "rest,0,7,0.01,0,0");
    let (location, defect) = refusal(&files);
    assert_eq!(location, Location::Line(3));
    let Defect::Target(TargetDefect::Landmark { landmark, defect }) = defect else {
        panic!("{defect:?}");
    };
    assert_eq!(landmark, 0);
    let LandmarkDefect::Displaced { distance } = defect else {
        panic!("{defect:?}");
    };
    assert!((distance - 0.01).abs() < 1e-15, "{distance}");
}

#[test]
fn a_defect_of_the_mesh_is_told_with_its_array_and_point() {
    let files = Files::new();
    files.edit("scene.json", "\"jaw\": 2", "\"jaw\": 3");
    let (location, defect) = refusal(&files);
    let Location::PointArray {
        name,
        point: Some(_),
    } = location
    else {
        panic!("{location:?}");
    };
    assert_eq!(name, "bone");
    let expected = FleshDefect::UnknownBone {
        label: 2,
        free: 0,
        cranium: 1,
        jaw: 3,
    };
    assert!(matches!(defect, Defect::Flesh(d) if d == expected));
}

#[test]
fn a_field_of_the_wrong_kind_is_told_apart_from_its_reason() {
    let files = Files::new();
    files.edit("scene.json", "\"cranium\": 1", "\"cranium\": true");
    let error = files.load().expect_err("must be refused");
    let text = error.to_string();
    let SceneError::Syntax {
        line,
        field,
        source,
        ..
    } = error
    else {
        panic!("{text}");
    };
    assert_eq!(line, 5);
    let field = field.expect("a field");
    assert!(field.ends_with("bones.cranium"), "{field}");
    assert!(source.downcast_ref::<serde_json::Error>().is_some());
    // The place is said once.
    assert_eq!(text.matches("line").count(), 0, "{text}");
    expect(
        &text,
        &["scene.json:5:", &format!("{field}: invalid type: boolean")],
    );
}
