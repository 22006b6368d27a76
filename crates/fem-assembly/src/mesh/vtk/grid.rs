//! What both kinds of file say, and what can be wrong with it.

use super::super::array::{DataArray, Values};

/// An unstructured grid with as many types as cells, whose offsets ascend to the length of its
/// connectivity.
#[derive(Default)]
pub(super) struct Grid {
    pub(super) points: Vec<[f64; 3]>,
    pub(super) connectivity: Vec<u32>,
    pub(super) offsets: Vec<u32>,
    pub(super) types: Vec<u8>,
    pub(super) point_data: Vec<DataArray>,
    pub(super) cell_data: Vec<DataArray>,
}

/// Why a file gives no grid.
#[derive(Debug, thiserror::Error)]
pub(super) enum Problem {
    #[error("not a readable VTU file: {0}; it is cut off or damaged, write it again")]
    Xml(String),
    #[error("the file holds no unstructured grid; convert it to one")]
    NoGrid,
    #[error("the file has no {0}")]
    Missing(&'static str),
    #[error("the {section} array \"{name}\" cannot be read: {reason}")]
    Array {
        section: &'static str,
        name: String,
        reason: String,
    },
    #[error("line {line}: {reason}")]
    Line { line: usize, reason: String },
    #[error("{0}")]
    Other(String),
}

impl Grid {
    pub(super) fn set_points(&mut self, values: Values) -> Result<(), Problem> {
        let coordinates = match values {
            Values::Floats(v) => v,
            Values::Integers(v) => v.into_iter().map(|x| x as f64).collect(),
        };
        let (points, []) = coordinates.as_chunks::<3>() else {
            return Err(Problem::Other(
                "the point coordinates are no multiple of three".into(),
            ));
        };
        self.points = points.to_vec();
        Ok(())
    }

    /// Takes the end of every cell and returns the last.
    pub(super) fn set_offsets(&mut self, values: Values) -> Result<usize, Problem> {
        self.offsets = narrow(values, "offsets")?;
        if !self.offsets.is_sorted() {
            let reason = "the cells' offsets do not ascend".into();
            return Err(Problem::Other(reason));
        }
        Ok(self.offsets.last().map_or(0, |&end| end as usize))
    }

    pub(super) fn set_connectivity(&mut self, values: Values) -> Result<(), Problem> {
        self.connectivity = narrow(values, "connectivity")?;
        Ok(())
    }

    pub(super) fn set_types(&mut self, values: Values) -> Result<(), Problem> {
        self.types = narrow(values, "types")?;
        Ok(())
    }
}

fn narrow<T: TryFrom<i64>>(values: Values, name: &str) -> Result<Vec<T>, Problem> {
    let bad = |reason: String| Problem::Array {
        section: "Cells",
        name: name.to_owned(),
        reason,
    };
    let Values::Integers(values) = values else {
        return Err(bad("it holds no whole numbers".into()));
    };
    let each = values.into_iter().map(|v| {
        T::try_from(v).map_err(|_| bad(format!("{v} is out of range, or the file is too large")))
    });
    each.collect()
}
