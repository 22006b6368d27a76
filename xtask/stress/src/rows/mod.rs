//! The rows, a family in each file.

mod input;
mod loads;
mod materials;
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
        input::rows(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
