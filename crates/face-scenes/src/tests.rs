//! A small face in files, and every way to break it.

use super::*;
use face_rig::anatomy::{Bone, Side};
use fem_assembly::mesh::{DataArray, MeshFile, kuhn_grid};
use std::{fs, path::Path};

mod bundle_tests;
mod course_tests;
mod defect_tests;
mod document_tests;
mod hostile_tests;
mod influence_tests;
mod joint_tests;
mod meaning_tests;
mod skin_tests;
mod touching_tests;
mod uncrossed_tests;

/// A block of 2×3×2 boxes, 0.2 m tall: the back hangs on the cranium, the lower front on the jaw.
struct Files {
    folder: tempfile::TempDir,
}

const SCENE: &str = r#"{
  "name": "block",
  "face": { "files": {
    "mesh": "block.vtu",
    "bones": { "array": "bone", "free": 0, "cranium": 1, "jaw": 2 },
    "hinge": { "line": { "point": [0, 0.1, 0], "axis": [2, 0, 0] } },
    "muscles": {
      "names": { "list": ["smile_L", "smile_R"] },
      "fibers": { "table": "fibers.csv" }
    },
    "embedding": "embedding.csv",
    "landmarks": { "file": "landmarks.csv" }
  } },
  "material": { "preset": "soft_tissue" },
  "targets": { "landmarks": "landmarks.csv", "skip": ["rest"], "identities": ["identity"] }
}"#;
const FIBERS: &str =
    "tet,muscle,weight,fx,fy,fz\n3,0,0.5,0,1,0\n3,1,0.25,1,0,0\n0,1,1.0,0,0.6,0.8\n";
const EMBEDDING: &str = "ict_vertex,tet,w0,w1,w2,w3\n7,0,1,0,0,0\n9,5,0.1,0.2,0.3,0.4\n";

impl Files {
    fn new() -> Self {
        let files = Self {
            folder: tempfile::tempdir().expect("a temporary folder"),
        };
        files.block(|_| {});
        files.text("scene.json", SCENE);
        files.text("fibers.csv", FIBERS);
        files.text("embedding.csv", EMBEDDING);
        let mesh = kuhn_grid(2, 3, 2, [0.1, 0.2, 0.1]).expect("a grid");
        let tet = mesh.tet(5).map(|n| mesh.node(n));
        let [x, y, z]: [f64; 3] = std::array::from_fn(|i| {
            0.1 * tet[0][i] + 0.2 * tet[1][i] + 0.3 * tet[2][i] + 0.4 * tet[3][i]
        });
        files.text(
            "landmarks.csv",
            &format!(
                "target,landmark,ict_vertex,x,y,z\nrest,1,9,{x},{y},{z}\nrest,0,7,0,0,0\n\
                 smile,0,7,0.01,0,0\nsmile,1,9,0.02,0.02,0.02\nidentity_a,0,7,0,0.01,0\n"
            ),
        );
        files
    }
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
    fn text(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("writable");
    }
    fn edit(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.path(name)).expect("readable");
        assert!(text.contains(from), "{from} is not in {name}");
        self.text(name, &text.replacen(from, to, 1));
    }
    fn block(&self, change: impl FnOnce(&mut MeshFile)) {
        self.block_of([2, 3, 2], change);
    }
    fn block_of(&self, [x, y, z]: [usize; 3], change: impl FnOnce(&mut MeshFile)) {
        let mesh = kuhn_grid(x, y, z, [0.1, 0.2, 0.1]).expect("a grid");
        let bone = mesh.nodes().iter().map(|x| match x {
            x if x[2] == 0.0 => 1,
            x if x[1] == 0.0 => 2,
            _ => 0,
        });
        let tets = mesh.num_elements() as i64;
        let mut file = MeshFile::from_tets(&mesh)
            .with_point_data(DataArray::integers("bone", bone))
            .with_cell_data(DataArray::integers("layer", (0..tets).map(|e| e % 3)));
        change(&mut file);
        file.write(self.path("block.vtu")).expect("writable");
    }
    fn load(&self) -> Result<Scene, SceneError> {
        Scene::load(self.path("scene.json"))
    }
    /// The message of the error that loading gives; it must name `file`.
    fn error(&self, file: &str) -> String {
        let text = self.load().expect_err("must be refused").to_string();
        assert!(text.contains(file), "{text}");
        text
    }
}

fn warned(report: &CheckReport) -> String {
    let texts: Vec<String> = report.warnings.iter().map(Warning::to_string).collect();
    texts.join("\n")
}

fn expect(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "\"{part}\" is not in: {text}");
    }
}

#[test]
fn a_sound_scene_is_understood() {
    let scene = Files::new().load().expect("a sound scene");
    assert_eq!(scene.mesh.num_elements(), 72);
    assert_eq!(scene.bones.of_node()[0], Bone::Cranium);
    assert_eq!(scene.joint.hinge().axis(), [1.0, 0.0, 0.0]);
    assert_eq!(scene.fiber_field.of_tet(3).len(), 2);
    assert_eq!(
        scene.regions[0].material,
        fem_materials::presets::SOFT_TISSUE.into()
    );
    let indices: Vec<u32> = scene.landmarks.iter().map(|l| l.index).collect();
    assert_eq!(indices, [0, 1]);
    let smile = scene.target("smile").expect("there");
    assert_eq!(smile.landmarks[1].position, [0.02; 3]);
    let point = scene.landmarks[1].point;
    assert_eq!(smile.landmarks[1].point, point);
    assert_eq!(scene.targets[1].kind, TargetKind::Identity);
    let text = scene.target("smyle").expect_err("absent").to_string();
    expect(&text, &["did you mean \"smile\"?"]);

    let report = check(&scene);
    assert_eq!(report.nodes_per_bone, [18, 12, 6]);
    assert_eq!((report.expressions, report.identities), (1, 1));
    assert_eq!(report.muscles[1].tets, 2);
    let expected = 1.25 * 0.002 / 72.0;
    assert!((report.muscles[1].volume - expected).abs() < 1e-15);
    assert_eq!(report.muscles[0].side, Side::Left);
    expect(
        &report.to_string(),
        &["100.0 x 200.0 x 100.0 mm", "smile_L", "2 landmarks"],
    );
    assert!(serde_json::to_string(&report).is_ok());
}

#[test]
fn scale_applies_to_every_length() {
    let files = Files::new();
    files.edit("scene.json", "\"name\": \"block\"", "\"scale\": 8");
    let scene = files.load().expect("a sound scene");
    assert_eq!(scene.name, "scene");
    assert_eq!(scene.mesh.node(1)[0], 0.4);
    assert_eq!(scene.joint.hinge().point(), [0.0, 0.8, 0.0]);
    assert_eq!(scene.targets[0].landmarks[1].position, [0.16; 3]);
    expect(&warned(&check(&scene)), &["this face is 1.600 m tall"]);
}

#[test]
fn a_value_that_makes_no_sense_is_found_in_its_line() {
    let files = Files::new();
    files.edit("scene.json", "\"name\": \"block\"", "\"scale\": 0");
    files.error("scene.json: line 2, scale: ");
    let files = Files::new();
    files.edit("scene.json", "[2, 0, 0]", "[0, 0, 0]");
    files.error("scene.json: line 6, face.files.hinge.line: ");
}

#[test]
fn json_errors_name_field_line_and_column() {
    let files = Files::new();
    files.edit("scene.json", "\"jaw\": 2", "\"jaw\": \"two\"");
    expect(
        &files.error("scene.json:5:"),
        &["face.files.bones.jaw: invalid type", "two"],
    );
    let files = Files::new();
    files.edit("scene.json", "\"mesh\"", "\"msh\"");
    expect(
        &files.error("scene.json:4:"),
        &["unknown field `msh`", "`mesh`"],
    );
    let files = Files::new();
    files.edit("scene.json", "\"smile_R\"]", "\"smile_R\"");
    files.error("scene.json:8:");
    let files = Files::new();
    files.edit("scene.json", "\"soft_tissue\"", "\"granite\"");
    expect(
        &files.error("scene.json"),
        &["material: there is no preset \"granite\"", "soft_tissue"],
    );
}

#[test]
fn missing_files_and_arrays() {
    let files = Files::new();
    fs::remove_file(files.path("fibers.csv")).expect("was there");
    files.error("fibers.csv");
    let files = Files::new();
    fs::remove_file(files.path("block.vtu")).expect("was there");
    files.error("block.vtu");
    let files = Files::new();
    files.edit("scene.json", "\"array\": \"bone\"", "\"array\": \"bones\"");
    expect(
        &files.error("block.vtu"),
        &["no point data array \"bones\"; the file has bone"],
    );
    let error = Scene::load(files.path("none.json")).expect_err("absent");
    expect(&error.to_string(), &["none.json"]);
}

#[test]
fn bad_meshes() {
    // Tet 5 is inverted in the file; the weights of its table follow the file's node order.
    let files = Files::new();
    let expected = files.load().expect("sound").landmarks[1];
    files.block(|file| file.connectivity.swap(22, 23));
    files.edit("embedding.csv", "0.3,0.4", "0.4,0.3");
    expect(
        &files.error("block.vtu"),
        &["negative volume", "1 of them: 5"],
    );
    let sound = "\"mesh\":";
    for field in ["inverted", "turned_over"] {
        let repaired = format!("\"{field}\": \"repair\", \"mesh\":");
        files.edit("scene.json", sound, &repaired);
        let scene = files.load().expect("repaired");
        assert_eq!(scene.landmarks[1], expected);
        expect(&warned(&check(&scene)), &["1 tets had negative volume"]);
        files.edit("scene.json", &repaired, sound);
    }

    let files = Files::new();
    files.block(|file| file.points[1] = file.points[0]);
    expect(&files.error("block.vtu"), &["zero volume"]);
    let files = Files::new();
    files.block(|file| file.connectivity[5] = 4000);
    expect(&files.error("block.vtu"), &["beyond the last"]);
    let files = Files::new();
    files.block(|file| file.point_data[0] = DataArray::integers("bone", vec![5; 36]));
    expect(
        &files.error("block.vtu"),
        &["\"bone\" at point 0", "label 5"],
    );
    let files = Files::new();
    files.block(|file| file.point_data[0] = DataArray::integers("bone", vec![0; 36]));
    expect(
        &files.error("block.vtu"),
        &["no node has the cranium's label"],
    );
    let files = Files::new();
    files.block(|file| file.point_data[0] = DataArray::vectors("bone", &[[0.0; 3]; 36]));
    expect(&files.error("block.vtu"), &["3 components, expected 1"]);
}

/// The writer refuses NaN and wrong lengths, so such files come from elsewhere.
#[test]
fn nan_coordinates_and_arrays_of_wrong_length() {
    let ascii = |x: &str, bones: &str| {
        format!(
            r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1"><Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">{x} 0 0 1 0 0 0 1 0 0 0 1</DataArray>
</Points><Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells><PointData>
<DataArray type="Int32" Name="bone" format="ascii">{bones}</DataArray></PointData>
</Piece></UnstructuredGrid></VTKFile>"#
        )
    };
    let files = Files::new();
    files.text("block.vtu", &ascii("nan", "0 1 1 2"));
    expect(
        &files.error("block.vtu"),
        &["NaN or infinite coordinate", "0"],
    );
    files.text("block.vtu", &ascii("0", "0 1 1"));
    expect(
        &files.error("block.vtu"),
        &["\"bone\"", "3 numbers, the grid needs 4"],
    );
}

#[test]
fn bad_fibers() {
    let cases = [
        ("3,0,0.5", "72,0,0.5", "tet 72 is not in the mesh"),
        ("3,0,0.5", "3,2,0.5", "muscle 2 is unknown"),
        ("3,0,0.5", "3,0,1.5", "weight 1.5"),
        ("3,0,0.5", "3,0,nan", "weight is \"nan\""),
        ("3,0,0.5", "3,0", "5 fields, expected 6"),
        ("3,0,0.5", "3.5,0,0.5", "tet is \"3.5\""),
        ("0.5,0,1,0", "0.5,0,2,0", "length 2, not 1"),
    ];
    for (from, to, message) in cases {
        let files = Files::new();
        files.edit("fibers.csv", from, to);
        expect(&files.error("fibers.csv: line 2"), &[message]);
    }
    let files = Files::new();
    files.edit("fibers.csv", "3,1,0.25", "3,0,0.25");
    expect(
        &files.error("fibers.csv: line 3"),
        &["muscle 0 appears twice in tet 3"],
    );
    let files = Files::new();
    files.text("fibers.csv", "tet,muscle,weight,fx,fy,fz\n");
    expect(&files.error("fibers.csv: line 2"), &["no rows"]);
    let files = Files::new();
    files.edit("fibers.csv", "tet,muscle", "muscle,tet");
    expect(
        &files.error("fibers.csv: line 1"),
        &["expected \"tet,muscle,weight,fx,fy,fz\""],
    );
    let files = Files::new();
    files.edit("scene.json", "\"smile_L\", ", "\"smile_R\", ");
    expect(&files.error("scene.json"), &["name 1", "unique"]);
}

#[test]
fn dense_fiber_arrays() {
    let files = Files::new();
    let arrays = r#"{ "arrays": { "muscle": "muscle", "weight": "weight", "fiber": "fiber" } }"#;
    files.edit("scene.json", "{ \"table\": \"fibers.csv\" }", arrays);
    let write = |label: i64| {
        files.block(|file| {
            let mut muscle = vec![-1; 72];
            (muscle[8], muscle[9]) = (0, label);
            file.cell_data.push(DataArray::integers("muscle", muscle));
            file.cell_data
                .push(DataArray::scalars("weight", &[0.5; 72]));
            file.cell_data
                .push(DataArray::vectors("fiber", &[[0.0, 0.0, -1.0]; 72]));
        });
    };
    write(1);
    let scene = files.load().expect("sound");
    assert_eq!(scene.fiber_field.entries().len(), 2);
    assert_eq!(scene.fiber_field.of_tet(9)[0].muscle, 1);
    write(2);
    expect(
        &files.error("block.vtu"),
        &["cell 9", "muscle 2 is unknown"],
    );
    write(-3);
    expect(&files.error("block.vtu"), &["cell 9", "-1 stands for none"]);
}

#[test]
fn bad_embeddings_and_landmarks() {
    let cases = [
        ("9,5,0.1", "9,5,0.2", "line 3", "sum to 1.1"),
        ("9,5,", "9,99,", "line 3", "tet 99 is not in the mesh"),
        ("9,5,", "7,5,", "line 3", "vertex 7 is already on line 2"),
        ("0.1,0.2,0.3,0.4", "4,-3,0,0", "line 3", "far outside tet 5"),
    ];
    for (from, to, line, message) in cases {
        let files = Files::new();
        files.edit("embedding.csv", from, to);
        expect(&files.error("embedding.csv"), &[line, message]);
    }
    let cases = [
        (
            "rest,0,7,0,0,0",
            "rest,0,8,0,0,0",
            "vertex 8 is not in the embedding table",
        ),
        (
            "rest,0,7,0,0,0",
            "rest,0,7,0.05,0,0",
            "50.0 mm from its position",
        ),
        ("rest,0,7,0,0,0", "rest,0,7,inf,0,0", "x is \"inf\""),
        (
            "rest,0,7,0,0,0",
            "rest,1,7,0,0,0",
            "landmark 1 of \"rest\" is already",
        ),
        (
            "smile,0,7",
            "smile,5,7",
            "landmark 5, which the face does not have",
        ),
    ];
    for (from, to, message) in cases {
        let files = Files::new();
        files.edit("landmarks.csv", from, to);
        expect(&files.error("landmarks.csv"), &["line", message]);
    }
    let files = Files::new();
    files.edit(
        "scene.json",
        "\"file\": \"landmarks.csv\"",
        "\"file\": \"landmarks.csv\", \"rest\": \"calm\"",
    );
    expect(
        &files.error("landmarks.csv"),
        &["no rows of target \"calm\""],
    );
}

#[test]
fn without_embedding_landmarks_are_located() {
    let files = Files::new();
    files.edit("scene.json", "\"embedding\": \"embedding.csv\",", "");
    let scene = files.load().expect("sound");
    let place = scene.landmarks[1].point.position(scene.mesh.nodes());
    let stated = fs::read_to_string(files.path("landmarks.csv")).expect("readable");
    let line = stated.lines().nth(1).expect("the first landmark");
    let numbers: Vec<f64> = line
        .split(',')
        .skip(3)
        .map(|v| v.parse().expect("a number"))
        .collect();
    assert!((0..3).all(|i| (place[i] - numbers[i]).abs() < 1e-15));
    files.edit("landmarks.csv", "rest,0,7,0,0,0", "rest,0,7,0,-0.3,0");
    expect(
        &files.error("landmarks.csv: line 3"),
        &["lies outside the mesh"],
    );
}

#[test]
fn another_table_keeps_what_the_scene_says_of_names() {
    let files = Files::new();
    let mut scene = files.load().expect("sound");
    let before: Vec<_> = scene
        .targets
        .iter()
        .map(|t| (t.name.clone(), t.kind))
        .collect();
    scene
        .read_targets(&files.path("landmarks.csv"), false)
        .expect("the same table");
    let after: Vec<_> = scene
        .targets
        .iter()
        .map(|t| (t.name.clone(), t.kind))
        .collect();
    assert_eq!(before, after);
    assert!(before.iter().any(|(_, kind)| *kind == TargetKind::Identity));

    // A scene that skips nothing of its own still knows that the rest state is no expression.
    files.edit("scene.json", "\"skip\": [\"rest\"], ", "");
    let mut scene = files.load().expect("sound");
    assert_eq!(scene.targets[0].name, "rest");
    scene
        .read_targets(&files.path("landmarks.csv"), false)
        .expect("the same table");
    assert_eq!(scene.targets[0].name, "smile");
}

#[test]
fn empty_targets() {
    let files = Files::new();
    files.edit(
        "scene.json",
        "\"skip\": [\"rest\"]",
        "\"skip\": [\"rest\", \"smile\", \"identity_a\"]",
    );
    expect(&files.error("landmarks.csv"), &["no target"]);
    let files = Files::new();
    files.edit(
        "scene.json",
        ",\n    \"landmarks\": { \"file\": \"landmarks.csv\" }",
        "",
    );
    expect(&files.error("scene.json"), &["targets need landmarks"]);
    let files = Files::new();
    files.text("landmarks.csv", "");
    files.error("landmarks.csv: line 1");
}

#[test]
fn regions_and_fiber_settings() {
    let files = Files::new();
    let regions = r#""regions": { "array": "layer", "labels": [ { "label": 2, "name": "stiff",
        "material": { "mooney_rivlin": { "a": 6e4, "b": 2e4, "bulk": 6e5 } } } ] },
        "fibers": { "curve": { "table": { "active": [[0.5, 0], [1, 1], [1.5, 0]],
        "passive": [[1, 0], [1.5, 1]] } }, "stretch": "deviatoric", "sigma_max": 3e5 }, "targets""#;
    files.edit("scene.json", "\"targets\"", regions);
    let scene = files.load().expect("sound");
    assert_eq!(scene.regions[1].name, "stiff");
    assert_eq!(scene.region_of_tet[..4], [0, 0, 1, 0]);
    let fibers = &scene.fibers;
    assert_eq!(fibers.max_isometric_stress, 3e5);
    assert_eq!(fibers.optimal_stretch, 1.0);
    assert_eq!(fibers.stretch, FiberStretch::Isochoric);
    files.edit("scene.json", "\"label\": 2", "\"label\": 7");
    expect(
        &files.error("scene.json"),
        &["regions.labels[0]", "no tet of the mesh has label 7"],
    );
    files.edit("scene.json", "\"sigma_max\": 3e5", "\"sigma_max\": 0");
    expect(
        &files.error("scene.json"),
        &["fibers: max_isometric_stress = 0"],
    );
}

#[test]
fn a_scene_may_name_the_built_in_face() {
    let files = Files::new();
    let text = r#"{ "face": { "builtin": { "tets": 5000 } }, "material": { "preset": "soft_tissue" },
        "targets": { "landmarks": "goals.csv" } }"#;
    files.text("scene.json", text);
    files.text(
        "goals.csv",
        "target,landmark,vertex,x,y,z\nsmile,48,0,0.01,0.02,0.03\n",
    );
    let scene = files.load().expect("sound");
    assert_eq!(scene.landmarks.len(), 68);
    let goal = scene.targets[0].landmarks[0];
    assert_eq!(goal.position, [0.01, 0.02, 0.03]);
    assert_eq!(goal.point, scene.landmarks[48].point);
    expect(
        &warned(&check(&scene)),
        &["target smile has 1 of 68 landmarks"],
    );
    files.edit("scene.json", "5000", "5");
    expect(
        &files.error("scene.json"),
        &["face.builtin.tets", "4000 to 2000000"],
    );
}

#[test]
fn the_shipped_scenes_describe_the_head_data() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let data = folder.join("../../../../shared/data/head");
    for (name, tets, bones, volume) in [
        ("head_coarse.json", 9_950, [1_593, 1_211, 332], 873.9),
        ("head_medium.json", 79_600, [13_071, 4_657, 1_300], 875.4),
    ] {
        SceneFile::read(folder.join(name)).expect("a scene file");
        if !data.is_dir() {
            println!("skipped: no head data at {}", data.display());
            continue;
        }
        let scene = Scene::load(folder.join(name)).expect("a sound scene");
        let report = check(&scene);
        assert_eq!((report.mesh.tets, report.nodes_per_bone), (tets, bones));
        assert!((report.mesh.volume * 1e6 - volume).abs() < 0.05);
        assert_eq!((report.muscles.len(), report.landmarks), (54, 68));
        assert_eq!((report.expressions, report.identities), (34, 2));
        assert_eq!(
            (report.embedded_points, report.skin_vertices),
            (9_492, 7_335)
        );
        if name == "head_coarse.json" {
            assert_eq!(report.tets_touching_both_bones, 371);
            assert_eq!(report.tets_all_prescribed, 198);
            let masseter = &report.muscles[20];
            assert_eq!((masseter.tets, masseter.side), (189, Side::Left));
            assert!((masseter.volume * 1e6 - 8.3407).abs() < 1e-3);
        }
        let jaw = scene
            .target("jawOpen")
            .expect("there")
            .jaw_truth
            .expect("known");
        let ([opening, protrusion, lateral, yaw], beside) = scene.joint.closest(&jaw);
        assert!((opening.to_degrees() - 25.334).abs() < 1e-2);
        let slides = [protrusion, lateral, 0.1 * yaw, beside];
        assert!(slides.iter().all(|s| s.abs() < 1e-4));
    }
}
