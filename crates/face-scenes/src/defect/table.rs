//! Tables.

/// What is wrong with the form of a table.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableDefect {
    /// The columns are others.
    #[error("the header is \"{}\", expected \"{}\"", found.join(","), expected.join(","))]
    Header {
        /// Names found.
        found: Vec<String>,
        /// Names wanted; alternatives are written `a|b`.
        expected: Vec<String>,
    },
    /// More or fewer fields than columns.
    #[error("{found} fields, expected {expected}")]
    Fields {
        /// Fields found.
        found: usize,
        /// Columns.
        expected: usize,
    },
    /// A quote that is not closed on its line.
    #[error(
        "a quoted field goes on to the next line; close the quote, and write \"\" for \
                          one that belongs to the text"
    )]
    OpenQuote,
    /// A record that cannot be read.
    #[error("{0}")]
    Unreadable(std::io::Error),
    /// A field that is no index.
    #[error("{column} is \"{found}\", expected a whole number from 0")]
    NotAnIndex {
        /// The column.
        column: String,
        /// Its text.
        found: String,
    },
    /// A field that is no finite number.
    #[error("{column} is \"{found}\", expected a finite number")]
    NotANumber {
        /// The column.
        column: String,
        /// Its text.
        found: String,
    },
    /// A header alone.
    #[error("it has no rows")]
    NoRows,
}
