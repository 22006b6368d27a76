//! The rows, a family in each file.

mod contact;
mod faces;
mod files;
mod loads;
mod materials;
mod meshes;
mod numbers;
mod programs;
mod scales;
mod starts;

use crate::Row;

/// All rows, in the order of the table.
pub fn all() -> Vec<Row> {
    [
        materials::rows(),
        starts::rows(),
        loads::rows(),
        scales::rows(),
        faces::rows(),
        contact::rows(),
        meshes::rows(),
        numbers::rows(),
        files::rows(),
        programs::rows(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
