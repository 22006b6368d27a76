//! Where something is wrong.

use std::fmt;

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// A line of a table, from 1.
    Line(usize),
    /// A table as a whole.
    Table,
    /// A field of a scene or of another JSON file.
    Field {
        /// Its path, like `contact.solids[0].shape`.
        path: String,
        /// Its line, from 1, where it is known.
        line: Option<usize>,
    },
    /// A name of a list, from 0.
    Name(usize),
    /// An array over the points of a mesh file.
    PointArray {
        /// Its name.
        name: String,
        /// The point, if it is one.
        point: Option<usize>,
    },
    /// An array over the cells of a mesh file.
    CellArray {
        /// Its name.
        name: String,
        /// The cell.
        cell: usize,
    },
    /// A point of a mesh file.
    Point(usize),
    /// A cell of a mesh file.
    Cell(usize),
    /// The triangles of a mesh file.
    Triangles,
}

impl From<&str> for Location {
    fn from(field: &str) -> Self {
        field.to_owned().into()
    }
}

impl From<String> for Location {
    fn from(path: String) -> Self {
        Self::Field { path, line: None }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Table => f.write_str("table"),
            Self::Field { path, line: None } => f.write_str(path),
            Self::Field {
                path,
                line: Some(line),
            } => write!(f, "line {line}, {path}"),
            Self::Name(k) => write!(f, "name {k}"),
            Self::PointArray { name, point: None } => write!(f, "point data array \"{name}\""),
            Self::PointArray {
                name,
                point: Some(point),
            } => write!(f, "point data array \"{name}\" at point {point}"),
            Self::CellArray { name, cell } => {
                write!(f, "cell data array \"{name}\" at cell {cell}")
            }
            Self::Point(point) => write!(f, "point {point}"),
            Self::Cell(cell) => write!(f, "cell {cell}"),
            Self::Triangles => f.write_str("triangles"),
        }
    }
}
