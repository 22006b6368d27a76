//! CSV tables of numbers, with errors that name line and column.

use super::SceneError;
use std::path::{Path, PathBuf};

/// A table with a header line, fields separated by commas, no quotes.
pub(super) struct Table {
    path: PathBuf,
    text: String,
    columns: Vec<String>,
}

impl Table {
    /// Reads a file and checks its header against `columns`; alternatives are written `a|b`.
    pub fn read(path: &Path, columns: &[&str]) -> Result<Self, SceneError> {
        Self::read_either(path, columns, None)
    }
    /// As [`Table::read`]; one more column may follow.
    pub fn read_with(path: &Path, columns: &[&str], optional: &str) -> Result<Self, SceneError> {
        Self::read_either(path, columns, Some(optional))
    }
    fn read_either(
        path: &Path,
        columns: &[&str],
        optional: Option<&str>,
    ) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path).map_err(SceneError::io(path))?;
        let header = text
            .lines()
            .next()
            .unwrap_or("")
            .trim_start_matches('\u{feff}');
        let found: Vec<String> = header.split(',').map(|c| c.trim().to_owned()).collect();
        let named = match optional {
            Some(last) if found.last().is_some_and(|name| name == last) => {
                &found[..found.len() - 1]
            }
            _ => &found[..],
        };
        let fits = named.len() == columns.len()
            && named
                .iter()
                .zip(columns)
                .all(|(name, accepted)| accepted.split('|').any(|a| a == name));
        if !fits {
            let wanted = columns.join(",");
            return Err(SceneError::invalid(
                path,
                "line 1",
                format!("the header is \"{header}\", expected \"{wanted}\""),
            ));
        }
        Ok(Self {
            path: path.to_path_buf(),
            columns: found,
            text,
        })
    }
    /// The lines after the header that are not empty.
    pub fn rows(&self) -> impl Iterator<Item = Result<Row<'_>, SceneError>> {
        let lines = self.text.lines().enumerate().skip(1);
        lines
            .filter(|(_, line)| !line.trim().is_empty())
            .map(|(number, line)| {
                let row = Row {
                    table: self,
                    line: number + 1,
                    fields: line.split(',').map(str::trim).collect(),
                };
                let (found, wanted) = (row.fields.len(), self.columns.len());
                if found == wanted {
                    Ok(row)
                } else {
                    Err(row.error(format!("{found} fields, expected {wanted}")))
                }
            })
    }
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// One line of a [`Table`].
pub(super) struct Row<'a> {
    table: &'a Table,
    pub line: usize,
    fields: Vec<&'a str>,
}

impl Row<'_> {
    pub fn text(&self, column: usize) -> &str {
        self.fields[column]
    }
    /// Is there such a column?
    pub fn has(&self, column: usize) -> bool {
        column < self.fields.len()
    }
    pub fn index(&self, column: usize) -> Result<u32, SceneError> {
        let field = self.fields[column];
        field.parse().map_err(|_| {
            let name = &self.table.columns[column];
            self.error(format!(
                "{name} is \"{field}\", expected a whole number from 0"
            ))
        })
    }
    pub fn number(&self, column: usize) -> Result<f64, SceneError> {
        let field = self.fields[column];
        let value = field.parse().ok().filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| {
            let name = &self.table.columns[column];
            self.error(format!("{name} is \"{field}\", expected a finite number"))
        })
    }
    /// N numbers from `column` on.
    pub fn numbers<const N: usize>(&self, column: usize) -> Result<[f64; N], SceneError> {
        let mut values = [0.0; N];
        for (k, value) in values.iter_mut().enumerate() {
            *value = self.number(column + k)?;
        }
        Ok(values)
    }
    pub fn error(&self, reason: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.table.path, format!("line {}", self.line), reason)
    }
}
