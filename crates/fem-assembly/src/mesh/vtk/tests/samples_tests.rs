//! Files written by VTK 9.7.2 itself, with values known from the program that made them, and those
//! that were refused once.

use super::super::super::{MeshFile, Orientation, Orphans, QuadraticMesh, SimplexMesh, Values};
use std::path::{Path, PathBuf};

fn sample(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/mesh/vtk/samples");
    folder.join(name)
}

/// Two tetrahedra with arrays of every kind, texts and data of the file, in eight encodings.
#[test]
fn files_of_vtk_hold_what_was_put_into_them() {
    for name in [
        "raw_lzma_big.vtu",
        "raw_plain.vtu",
        "appended_zlib.vtu",
        "inline_lz4.vtu",
        "legacy_42_ascii.vtk",
        "legacy_42_binary.vtk",
        "legacy_51_ascii.vtk",
        "legacy_51_binary.vtk",
    ] {
        let file = MeshFile::read(sample(name)).expect(name);
        let (mesh, _) = file
            .tet_mesh(Orientation::Refuse, Orphans::Refuse)
            .expect(name);
        assert_eq!(mesh.connectivity(), [0, 1, 2, 3, 1, 2, 3, 4], "{name}");
        assert_eq!(mesh.node(4), [1.0; 3], "{name}");
        assert_eq!(mesh.volume(0), 1.0 / 6.0, "{name}");
        assert_eq!(
            file.cell_integers("label").expect(name),
            [-7, 300],
            "{name}"
        );
        assert_eq!(
            file.cell_integers("sign").expect(name),
            [-128, 127],
            "{name}"
        );
        assert_eq!(file.cell_integers("bits").expect(name), [0, 1], "{name}");
        let fibers = file.cell_vectors::<3>("fiber of muscle").expect(name);
        assert_eq!(fibers, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], "{name}");
        assert!(fibers[1][1].is_sign_negative(), "{name}");
        let small = [0.1_f32, 0.2, 0.3, 0.4, 0.5].map(f64::from);
        assert_eq!(file.point_scalars("small").expect(name), small, "{name}");
        let heat = file
            .point_data
            .iter()
            .find(|a| a.name == "heat")
            .expect(name);
        let Values::Floats(heat) = &heat.values else {
            panic!("{name}: heat is real")
        };
        assert_eq!(heat[..3], [1.5, -2.0, 1e-300], "{name}");
        assert!(heat[3].is_nan() && heat[4] == f64::INFINITY, "{name}");
        // Texts are no numbers.
        assert_eq!(
            (file.point_data.len(), file.cell_data.len()),
            (2, 4),
            "{name}"
        );
    }
}

/// The ten points of `vtkQuadraticTetra::GetParametricCoords`, scaled and shifted, as 32-bit floats.
#[test]
fn a_quadratic_tetrahedron_of_vtk_is_one_here() {
    let file = MeshFile::read(sample("quadratic_tet.vtu")).expect("readable");
    let (mesh, _) = file
        .quadratic_tet_mesh(Orientation::Refuse, Orphans::Refuse)
        .expect("a straight tetrahedron");
    assert!((mesh.corners().volume(0) * 630.0 - 1.0).abs() < 1e-6);
    let corners = SimplexMesh::<3>::new(mesh.nodes()[..4].to_vec(), vec![0, 1, 2, 3]);
    let made = QuadraticMesh::from_linear(&corners.expect("a tet")).expect("quadratic");
    for (&n, &m) in mesh.element(0).iter().zip(made.element(0)) {
        let (x, y) = (mesh.node(n), made.node(m));
        assert!((0..3).all(|i| (x[i] - y[i]).abs() < 1e-7));
    }
    let text = file
        .tet_mesh(Orientation::Refuse, Orphans::Refuse)
        .expect_err("not linear")
        .to_string();
    assert!(text.contains("cell 0 has VTK type 24"), "{text}");
}

fn cases() -> Option<PathBuf> {
    let shared = std::env::var_os("FEM_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let folder = shared.join("cases");
    if folder.is_dir() {
        Some(folder)
    } else {
        println!("skipped: no cases at {}", folder.display());
        None
    }
}

/// The same box of 360 tetrahedra from several programs; the numbers are those of their READMEs.
#[test]
fn files_that_were_refused_are_read() {
    let Some(folder) = cases() else { return };
    for name in [
        "vtk42_traits/v42_field_asc.vtk",
        "vtk42_traits/v42_nan_asc.vtk",
        "vtk42_traits/v42_schar_asc.vtk",
        "vtk42_traits/v42_string_asc.vtk",
        "vtk51_meshio/meshio_ascii.vtk",
        "vtk51_meshio/meshio_def.vtk",
        "vtk51_pyvista/pv_ascii.vtk",
        "vtk51_pyvista/pv_bin.vtk",
        "vtu_raw_appended/vtk_app_zlib_h64_raw.vtu",
    ] {
        let file = MeshFile::read(folder.join(name)).expect(name);
        let (mesh, _) = file
            .tet_mesh(Orientation::Refuse, Orphans::Refuse)
            .expect(name);
        assert_eq!(
            (mesh.num_elements(), mesh.num_nodes()),
            (360, 120),
            "{name}"
        );
        assert!((mesh.total_volume() - 0.00384).abs() < 1e-12, "{name}");
        let bone = file.point_integers("bone").expect(name);
        let count = |of: &[i64], label| of.iter().filter(|&&b| b == label).count();
        assert_eq!(
            [0, 1, 2].map(|label| count(&bone, label)),
            [90, 20, 10],
            "{name}"
        );
        let muscle = file.cell_integers("muscle").expect(name);
        assert_eq!(count(&muscle, 0), 65, "{name}");
    }
    let one = MeshFile::read(folder.join("vtu_raw_appended/real_tet.vtu")).expect("readable");
    let (mesh, repairs) = one
        .tet_mesh(Orientation::Repair, Orphans::Refuse)
        .expect("one tet");
    assert_eq!(repairs.inverted, [0]);
    // A regular tetrahedron whose corners lie on the unit sphere, as 32-bit floats.
    let regular = 8.0 * 3.0_f64.sqrt() / 27.0;
    assert!((mesh.volume(0) / regular - 1.0).abs() < 1e-6);
    for (name, array) in [("w_0.vtu", "a & b"), ("w_2.vtu", "a>b")] {
        let file = MeshFile::read(folder.join("vtu_escaped_name").join(name)).expect(name);
        assert_eq!(file.cell_scalars(array).expect(name), [1.5; 48], "{name}");
    }
    let full = MeshFile::read(folder.join("vtu_full_last_block/m.vtu")).expect("readable");
    assert_eq!(full.point_integers("bone").expect("there").len(), 27);
    let error = MeshFile::read(folder.join("vtu_header_1e12_abort/m.vtu")).expect_err("1e12");
    let text = error.to_string();
    assert!(
        text.contains("\"bone\"") && text.contains("1000000000000 bytes"),
        "{text}"
    );
}
