//! Meshes written where nothing can be written, and read from what is no mesh.

use crate::row::Evidence;
use crate::{Expected, Failure, Row};
use fem_assembly::mesh::{DataArray, MeshFile, atomic, kuhn_grid};
use std::io::Write;
use std::path::Path;

/// The rows.
pub fn rows() -> Vec<Row> {
    let row = |name: &str, what: &str, expected, run: fn(&Path) -> Result<Evidence, Failure>| {
        Row::new("files", name, what, expected, move |_| {
            let folder = tempfile::tempdir().map_err(|e| Failure::trial(&e))?;
            run(folder.path())
        })
    };
    let io = Expected::Error("MeshFileError::Io");
    vec![
        row(
            "file-no-folder",
            "written into a folder that does not exist",
            io,
            |at| written(&at.join("no/such/mesh.vtu")),
        ),
        row(
            "file-read-only-folder",
            "written into a folder that nobody may write to",
            io,
            |_| written(Path::new("/proc/mesh.vtu")),
        ),
        row(
            "file-in-place-of-folder",
            "written over a folder",
            io,
            |at| {
                let path = at.join("mesh.vtu");
                std::fs::create_dir(&path).map_err(|e| Failure::trial(&e))?;
                written(&path)
            },
        ),
        row(
            "file-disk-full-midway",
            "the disk is full midway: the file that was there is whole, and no other is there",
            Expected::Property,
            full,
        ),
        row(
            "file-cut-anywhere",
            "a VTU cut after any of its bytes: refused, or whole",
            Expected::Property,
            cut,
        ),
        row(
            "file-of-zeros",
            "a VTU of zeros",
            Expected::Error("MeshFileError::Format"),
            |at| {
                let path = at.join("zeros.vtu");
                std::fs::write(&path, [0; 4096]).map_err(|e| Failure::trial(&e))?;
                MeshFile::read(&path)?;
                Ok(Evidence::default())
            },
        ),
        row(
            "file-nan-points",
            "points that are NaN: not written",
            Expected::Error("MeshFileError::Format"),
            |at| {
                let mut file = block()?;
                file.points[3][1] = f64::NAN;
                file.write(at.join("nan.vtu"))?;
                Ok(Evidence::default())
            },
        ),
    ]
}

fn block() -> Result<MeshFile, Failure> {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3])?;
    let numbers: Vec<f64> = (0..mesh.num_nodes()).map(|n| n as f64).collect();
    Ok(MeshFile::from_tets(&mesh).with_point_data(DataArray::scalars("n", &numbers)))
}

fn written(path: &Path) -> Result<Evidence, Failure> {
    block()?.write(path)?;
    Ok(Evidence::default())
}

fn names(folder: &Path) -> Result<Vec<String>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|e| Failure::trial(&e))?;
    let names = entries.filter_map(|e| e.ok()?.file_name().into_string().ok());
    Ok(names.collect())
}

/// The old file must be left as it was when the writer of a new one fails.
fn full(at: &Path) -> Result<Evidence, Failure> {
    let path = at.join("mesh.vtu");
    block()?.write(&path)?;
    let before = std::fs::read(&path).map_err(|e| Failure::trial(&e))?;
    let failed = atomic::write(&path, |file| {
        file.write_all(&before[..before.len() / 2])?;
        std::fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")?
            .write_all(b"more")
    });
    let Err(error) = failed else {
        return Err(Failure::lie("a full disk, and a success"));
    };
    let after = std::fs::read(&path).map_err(|e| Failure::trial(&e))?;
    let (same, files) = (before == after, names(at)?);
    if same && files == ["mesh.vtu"] {
        Ok(Evidence::holds(error.to_string()))
    } else {
        Err(Failure::lie(format!(
            "the old file is the same: {same}; files: {files:?}"
        )))
    }
}

/// What is read of a file that was cut is refused, or everything.
fn cut(at: &Path) -> Result<Evidence, Failure> {
    let (path, whole) = (at.join("cut.vtu"), block()?);
    whole.write(&path)?;
    let bytes = std::fs::read(&path).map_err(|e| Failure::trial(&e))?;
    let mut read = 0;
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).map_err(|e| Failure::trial(&e))?;
        if let Ok(found) = MeshFile::read(&path) {
            if found.points != whole.points || found.point_data != whole.point_data {
                return Err(Failure::lie(format!("half a mesh from {length} bytes")));
            }
            read += 1;
        }
    }
    Ok(Evidence::holds(format!(
        "{} cuts, {read} of them read whole",
        bytes.len()
    )))
}
