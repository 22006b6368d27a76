//! Poisoned input: what no mesh, model or solver may take, and what looks odd but is fine.

use crate::{Evidence, Expected, Row};
use fem_assembly::mesh::SimplexMesh;

const FAMILY: &str = "input";

/// The rows.
pub fn rows() -> Vec<Row> {
    vec![Row::new(
        FAMILY,
        "input-empty-mesh",
        "a mesh without elements",
        Expected::Error("MeshError::Empty"),
        |_| {
            SimplexMesh::<3>::new(vec![[0.0; 3]; 4], vec![])?;
            Ok(Evidence::default())
        },
    )]
}
