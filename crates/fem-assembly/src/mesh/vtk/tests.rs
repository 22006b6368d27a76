use super::super::{
    DataArray, MeshFile, MeshFileError, Orientation, Orphans, Quality, SimplexMesh, kuhn_grid,
};
use super::super::{QuadraticMesh, Values};
use std::path::{Path, PathBuf};

#[path = "../../../../../tests/fuzz.rs"]
mod fuzz;
mod hostile_tests;
mod samples_tests;
mod variants_tests;

fn sample() -> MeshFile {
    let mesh = kuhn_grid(2, 2, 3, [0.1, 0.2, 0.3]).expect("a grid");
    let height: Vec<f64> = mesh.nodes().iter().map(|x| x[2] / 3.0).collect();
    let fibers: Vec<[f64; 3]> = (0..mesh.num_elements())
        .map(|e| [1.0 / (e + 1) as f64, -0.0, 1e-300])
        .collect();
    MeshFile::from_tets(&mesh)
        .with_point_data(DataArray::scalars("height", &height))
        .with_point_data(DataArray::vectors("place", mesh.nodes()))
        .with_cell_data(DataArray::vectors("fiber", &fibers))
        .with_cell_data(DataArray::integers("label", (0..72).map(|e| e % 5 - 1)))
        .with_cell_data(DataArray::integers("large", (0..72).map(|e| e << 32)))
}

fn written(file: &MeshFile, name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    file.write(&path).expect("writable");
    (folder, path)
}

#[test]
fn both_formats_round_trip_bit_for_bit() {
    for name in ["mesh.vtu", "mesh.vtk"] {
        let file = sample();
        let (_folder, path) = written(&file, name);
        let back = MeshFile::read(&path).expect(name);
        assert_eq!(back, MeshFile { path, ..file }, "{name}");
    }
}

/// 4,096 doubles fill one compression block exactly; 8,192 fill two.
#[test]
fn whole_compression_blocks_round_trip() {
    for count in [4095, 4096, 4097, 8192, 16384] {
        let points: Vec<[f64; 3]> = (0..count).map(|i| [i as f64, 0.5, -1.0]).collect();
        let first: Vec<f64> = points.iter().map(|x| x[0]).collect();
        let file = MeshFile::from_triangles(points, &[[0, 1, 2], [1, 2, 3]])
            .with_point_data(DataArray::scalars("first", &first));
        let (_folder, path) = written(&file, "points.vtu");
        let back = MeshFile::read(&path).expect("readable");
        assert_eq!(
            back.point_scalars("first").expect("there"),
            first,
            "{count}"
        );
        assert_eq!(back.triangles().expect("triangles").len(), 2);
    }
}

/// Names that are no names to XML or to words in a line.
#[test]
fn arrays_of_any_name_round_trip() {
    let names = [
        "a & b",
        "<x>",
        "\"quoted\" 'n'",
        "two words",
        "tab\tline\n",
        "Größe µ",
        "100%25",
    ];
    for format in ["mesh.vtu", "mesh.vtk"] {
        let mut file = sample();
        for name in names {
            file = file.with_cell_data(DataArray::integers(name, 0..72));
        }
        let (_folder, path) = written(&file, format);
        let back = MeshFile::read(&path).expect(format);
        assert_eq!(back, MeshFile { path, ..file }, "{format}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["", "bell\u{7}"] {
        let file = sample().with_cell_data(DataArray::integers(name, 0..72));
        let error = file
            .write(folder.path().join("mesh.vtu"))
            .expect_err("no name");
        assert!(
            error.to_string().contains("cannot name an array"),
            "{error}"
        );
    }
}

#[test]
fn quadratic_meshes_round_trip() {
    let linear = kuhn_grid(1, 2, 1, [0.3; 3]).expect("a grid");
    let tets = QuadraticMesh::from_linear(&linear).expect("quadratic");
    let square = vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.3], [0.0, 0.3]];
    let flat = SimplexMesh::<2>::new(square, vec![0, 1, 2, 0, 2, 3]).expect("two triangles");
    let triangles = QuadraticMesh::from_linear(&flat).expect("quadratic");
    for format in ["mesh.vtu", "mesh.vtk"] {
        let (_folder, path) = written(&MeshFile::from_quadratic_tets(&tets), format);
        let back = MeshFile::read(&path).expect(format);
        assert!(back.cell_types.iter().all(|&t| t == 24));
        let (mesh, _) = back
            .quadratic_tet_mesh(Orientation::Refuse, Orphans::Refuse)
            .expect(format);
        assert_eq!(mesh, tets);
        let file = MeshFile::from_quadratic_triangles(&triangles);
        let (_folder, path) = written(&file, format);
        let mut back = MeshFile::read(&path).expect(format);
        assert!(back.cell_types.iter().all(|&t| t == 22));
        let (mesh, _) = back
            .quadratic_triangle_mesh(Orientation::Refuse, Orphans::Refuse)
            .expect(format);
        assert_eq!(mesh, triangles);
        back.points[3][2] = 1e-3;
        let error = back
            .quadratic_triangle_mesh(Orientation::Refuse, Orphans::Refuse)
            .expect_err("not plane");
        assert!(
            error.to_string().contains("point 3 has z = 0.001"),
            "{error}"
        );
    }
}

#[test]
fn cells_that_do_not_fit_their_type_are_not_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mesh.vtu");
    let mut file = sample();
    file.cell_types[5] = 24;
    let text = file.write(&path).expect_err("4 points").to_string();
    assert!(
        text.contains("cell 5 of VTK type 24 has 4 points"),
        "{text}"
    );
    let mut file = sample();
    file.offsets.pop();
    assert!(file.write(&path).is_err());
    assert!(!path.exists());
}

/// Every attribute of "VTK File Formats", as text.
#[test]
fn legacy_attributes_of_every_kind_are_read() {
    let text = "# vtk DataFile Version 3.0\r\nbox\r\nASCII\r\nDATASET UNSTRUCTURED_GRID\r\n\
        POINTS 3 float\r\n0 0 0 1 0 0 0 1 0\r\nCELLS 1 4\r\n3 0 1 2\r\nCELL_TYPES 1\r\n5\r\n\
        POINT_DATA 3\r\nSCALARS two%20words int 2\r\nLOOKUP_TABLE mine\r\n1 2 3 4 5 6\r\n\
        LOOKUP_TABLE mine 2\r\n0 0 0 1 1 1 1 1\r\nSCALARS bare char\r\n7 8 9\r\n\
        VECTORS v double\r\n1 2 3 4 5 6 7 8 9\r\nNORMALS n float\r\n1 0 0 0 1 0 0 0 1\r\n\
        TEXTURE_COORDINATES t 2 float\r\n0 0.5 1 0 0 1\r\nCOLOR_SCALARS c 1\r\n0 0.25 1\r\n\
        CELL_DATA 1\r\nTENSORS s float\r\n1 0 0\r\n0 1 0\r\n0 0 1\r\n\
        TENSORS6 s6 float\r\n1 2 3 4 5 6\r\nGLOBAL_IDS ids vtkIdType\r\n41\r\n";
    let file = read_text("a.vtk", text.as_bytes()).expect("readable");
    let whole = |v: &[i64]| Values::Integers(v.to_vec());
    assert_eq!(file.point_data[0].name, "two words");
    assert_eq!(file.point_data[0].values, whole(&[1, 2, 3, 4, 5, 6]));
    assert_eq!(file.point_integers("bare").expect("there"), [7, 8, 9]);
    let v = file.point_vectors::<3>("v").expect("there");
    assert_eq!(v[2], [7.0, 8.0, 9.0]);
    assert_eq!(
        file.point_vectors::<3>("n").expect("there")[1],
        [0.0, 1.0, 0.0]
    );
    assert_eq!(file.point_vectors::<2>("t").expect("there")[0], [0.0, 0.5]);
    assert_eq!(file.point_scalars("c").expect("there"), [0.0, 0.25, 1.0]);
    let s = file.cell_vectors::<9>("s").expect("there");
    assert_eq!(s, [[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]]);
    assert_eq!(file.cell_vectors::<6>("s6").expect("there")[0][5], 6.0);
    assert_eq!(file.cell_integers("ids").expect("there"), [41]);
    assert_eq!(file.triangles().expect("triangles"), [[0, 1, 2]]);
    for (right, wrong, why) in [
        (
            "POINT_DATA 3",
            "POINT_DATA 2",
            "line 11: POINT_DATA 2: the grid has 3",
        ),
        ("CELLS 1 4", "CELLS 2 4", "2 cells are announced, 1 follow"),
        ("\r\n3 0 1 2", "\r\n9 0 1 2", "cell 0 has 9 points"),
        (
            "1 2 3 4 5 6\r\nL",
            "1 2 3 4 5 x\r\nL",
            "two words: \"x\" is no number",
        ),
        ("v double", "v quadruple", "\"quadruple\" is not known"),
        (
            "CELL_TYPES 1\r\n5",
            "CELL_TYPES 0",
            "not as many cell types as cells",
        ),
    ] {
        let error = read_text("a.vtk", text.replace(right, wrong).as_bytes());
        let error = error.expect_err(wrong).to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn missing_and_misshapen_arrays_are_named() {
    let file = sample();
    let text = file.cell_integers("bones").expect_err("absent").to_string();
    assert!(
        text.contains("\"bones\"; the file has fiber, label, large"),
        "{text}"
    );
    let text = file.cell_scalars("fiber").expect_err("vectors").to_string();
    assert!(
        text.contains("\"fiber\" has 3 components, expected 1"),
        "{text}"
    );
    let text = file
        .point_integers("height")
        .expect_err("fractions")
        .to_string();
    assert!(text.contains("is not a whole number"), "{text}");
    let text = file.triangles().expect_err("tets").to_string();
    assert!(text.contains("cell 0 has VTK type 10"), "{text}");
}

#[test]
fn nan_and_wrong_lengths_are_not_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bad.vtu");
    let mut nan = vec![0.0; 36];
    nan[7] = f64::NAN;
    let bad = sample().with_point_data(DataArray::scalars("bad", &nan));
    let text = bad.write(&path).expect_err("NaN").to_string();
    assert!(
        text.contains("bad.vtu") && text.contains("at point 7"),
        "{text}"
    );
    let short = sample().with_cell_data(DataArray::scalars("short", &[1.0]));
    let text = short.write(&path).expect_err("length").to_string();
    assert!(text.contains("has 1 values, expected 72"), "{text}");
    assert!(matches!(
        sample().write(folder.path().join("mesh.stl")),
        Err(MeshFileError::Format { .. })
    ));
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        0
    );
}

const ASCII: &str = r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells>
<PointData><DataArray type="Float32" Name="heat" format="ascii">1 2 3 4</DataArray></PointData>
</Piece></UnstructuredGrid></VTKFile>"#;

fn read_text(name: &str, text: &[u8]) -> Result<MeshFile, MeshFileError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("writable");
    MeshFile::read(&path)
}

#[test]
fn ascii_files_are_read() {
    let file = read_text("a.vtu", ASCII.as_bytes()).expect("readable");
    assert_eq!(
        file.point_scalars("heat").expect("there"),
        [1.0, 2.0, 3.0, 4.0]
    );
    let (mesh, _) = file
        .tet_mesh(Orientation::Refuse, Orphans::Refuse)
        .expect("one tet");
    assert_eq!(mesh.volume(0), 1.0 / 6.0);
}

#[test]
fn arrays_of_wrong_length_are_an_error_not_left_out() {
    let text = ASCII.replace("1 2 3 4</", "1 2 3</");
    let error = read_text("a.vtu", text.as_bytes()).expect_err("short array");
    assert!(error.to_string().contains("\"heat\""), "{error}");
}

#[test]
fn nan_coordinates_are_found() {
    let text = ASCII.replace("0 1 0 0 0 1<", "0 nan 0 0 0 1<");
    let file = read_text("a.vtu", text.as_bytes()).expect("the file itself is well formed");
    let error = file
        .tet_mesh(Orientation::Refuse, Orphans::Refuse)
        .expect_err("NaN");
    assert!(error.to_string().contains("NaN"), "{error}");
}

#[test]
fn damaged_files_are_errors() {
    let error = MeshFile::read("no/such/file.vtu").expect_err("absent");
    assert!(matches!(error, MeshFileError::Io { .. }), "{error}");
    assert!(error.to_string().contains("file.vtu"), "{error}");
    assert!(read_text("a.vtu", b"").is_err());
    assert!(read_text("a.vtk", b"# vtk DataFile").is_err());
    assert!(read_text("a.obj", b"v 0 0 0").is_err());
    let offsets = ASCII.replace(">4</DataArray>", ">3</DataArray>");
    assert!(read_text("a.vtu", offsets.as_bytes()).is_err());
    let (_folder, path) = written(&sample(), "whole.vtu");
    let bytes = std::fs::read(path).expect("readable");
    for share in [3, 5, 8] {
        assert!(read_text("cut.vtu", &bytes[..bytes.len() * share / 10]).is_err());
    }
    // Base64 of a header that announces far more blocks than there are.
    let text = String::from_utf8(bytes).expect("text");
    let at = text.find("format=\"binary\"").expect("binary");
    let data = at + text[at..].find('>').expect("the end of the tag") + 1;
    let broken = format!("{}/////////w{}", &text[..data], &text[data + 10..]);
    assert!(read_text("broken.vtu", broken.as_bytes()).is_err());
}

fn head() -> Option<PathBuf> {
    let shared = std::env::var_os("FEM_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let folder = shared.join("data/head");
    if folder.is_dir() {
        Some(folder)
    } else {
        println!("skipped: no head data at {}", folder.display());
        None
    }
}

/// Counts and qualities that the data's README states.
#[test]
fn the_head_meshes_are_what_their_readme_says() {
    let Some(folder) = head() else { return };
    let file = MeshFile::read(folder.join("head_coarse.vtu")).expect("readable");
    let (mesh, repairs) = file
        .tet_mesh(Orientation::Refuse, Orphans::Refuse)
        .expect("a good mesh");
    assert_eq!((mesh.num_elements(), mesh.num_nodes()), (9_950, 3_136));
    assert!(repairs.inverted.is_empty() && repairs.orphans.is_empty());
    let bone = file.point_integers("bone").expect("bone labels");
    let count = |label| bone.iter().filter(|&&b| b == label).count();
    assert_eq!([count(0), count(1), count(2)], [1_593, 1_211, 332]);
    let quality = Quality::measure(&mesh);
    assert!((quality.volume * 1e6 - 873.9).abs() < 0.05);
    assert!((quality.smallest_dihedral.min - 9.2).abs() < 0.05);
    assert!((quality.largest_dihedral.max - 161.4).abs() < 0.05);
    assert!((quality.smallest_dihedral.median - 41.8).abs() < 0.05);
    assert!((quality.radius_ratio.min - 0.11).abs() < 0.005);
    assert_eq!(quality.slivers, 2);
    assert_eq!(mesh.components().1, 1);
    assert_eq!(mesh.overlapping_faces(), 0);

    let targets = MeshFile::read(folder.join("targets_shared.vtu")).expect("readable");
    assert_eq!(targets.points.len(), 7_335);
    let smile = targets
        .point_vectors::<3>("disp_mouthSmile_L")
        .expect("a smile");
    assert!(smile.iter().flatten().any(|&d| d.abs() > 1e-3));
    assert!(!targets.triangles().expect("triangles").is_empty());
}
