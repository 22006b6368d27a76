//! CSV tables of numbers, with errors that name line and column.

use super::SceneError;
use super::defect::{Defect, Location, TableDefect};
use csv::StringRecord;
use std::path::{Path, PathBuf};

/// A table with a header line and fields separated by commas, quoted or not (RFC 4180), on one line
/// each; spaces around a field and lines without any count for nothing.
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
        let header = records(path, &text).next().transpose()?;
        let (line, header) = header.unwrap_or((1, StringRecord::new()));
        let found: Vec<String> = header.iter().map(str::to_owned).collect();
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
            let expected = columns.iter().map(|&c| c.to_owned()).collect();
            let defect = TableDefect::Header { found, expected };
            return Err(SceneError::invalid(path, Location::Line(line), defect));
        }
        Ok(Self {
            path: path.to_path_buf(),
            columns: found,
            text,
        })
    }
    /// The lines after the header that are not empty.
    pub fn rows(&self) -> impl Iterator<Item = Result<Row<'_>, SceneError>> {
        records(&self.path, &self.text).skip(1).map(move |record| {
            let (line, fields) = record?;
            let table = self;
            let row = Row {
                table,
                line,
                fields,
            };
            let (found, wanted) = (row.fields.len(), self.columns.len());
            if found == wanted {
                Ok(row)
            } else {
                let expected = wanted;
                Err(row.error(TableDefect::Fields { found, expected }))
            }
        })
    }
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The records of a text that are not empty, each with its line from 1.
fn records(
    path: &Path,
    text: &str,
) -> impl Iterator<Item = Result<(usize, StringRecord), SceneError>> {
    let reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let (mut line, mut seen) = (1, 0);
    reader.into_records().filter_map(move |record| {
        let invalid = |line, defect: TableDefect| {
            Some(Err(SceneError::invalid(path, Location::Line(line), defect)))
        };
        let record = match record {
            Ok(record) => record,
            Err(error) => return invalid(line, TableDefect::Unreadable(error.into())),
        };
        // The reader's own position lies before the empty lines that it skips.
        let start = record.position().map_or(seen, |p| p.byte() as usize);
        let empty = |byte: &&u8| matches!(**byte, b'\r' | b'\n');
        let start = start + text.as_bytes()[start..].iter().take_while(empty).count();
        line += line_ends(&text.as_bytes()[seen..start]);
        seen = start;
        if record.iter().any(|field| field.contains(['\r', '\n'])) {
            return invalid(line, TableDefect::OpenQuote);
        }
        let blank = record.len() == 1 && record[0].is_empty();
        (!blank).then_some(Ok((line, record)))
    })
}

/// Lines end with `\n`, `\r\n` or `\r`.
fn line_ends(text: &[u8]) -> usize {
    let count = |end| text.iter().filter(|&&byte| byte == end).count();
    count(b'\n').max(count(b'\r'))
}

/// One line of a [`Table`].
pub(super) struct Row<'a> {
    table: &'a Table,
    pub line: usize,
    fields: StringRecord,
}

impl Row<'_> {
    pub fn text(&self, column: usize) -> &str {
        &self.fields[column]
    }
    /// Is there such a column?
    pub fn has(&self, column: usize) -> bool {
        column < self.fields.len()
    }
    pub fn index(&self, column: usize) -> Result<u32, SceneError> {
        let field = &self.fields[column];
        field.parse().map_err(|_| {
            self.error(TableDefect::NotAnIndex {
                column: self.table.columns[column].clone(),
                found: field.to_owned(),
            })
        })
    }
    pub fn number(&self, column: usize) -> Result<f64, SceneError> {
        let field = &self.fields[column];
        let value = field.parse().ok().filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| {
            self.error(TableDefect::NotANumber {
                column: self.table.columns[column].clone(),
                found: field.to_owned(),
            })
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
    pub fn error(&self, defect: impl Into<Defect>) -> SceneError {
        SceneError::invalid(&self.table.path, Location::Line(self.line), defect)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Table, SceneError> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("goals.csv");
        std::fs::write(&path, text).expect("writable");
        Table::read_with(&path, &["target", "id|vertex", "x"], "weight")
    }
    fn rows(text: &str) -> Vec<(usize, String, u32, f64)> {
        let table = table(text).expect("a sound header");
        let rows = table.rows().map(|row| {
            let row = row?;
            Ok((
                row.line,
                row.text(0).to_owned(),
                row.index(1)?,
                row.number(2)?,
            ))
        });
        rows.collect::<Result<_, SceneError>>().expect("sound rows")
    }
    /// The message without the folder.
    fn refusal(text: &str) -> String {
        let error = match table(text) {
            Ok(table) => table
                .rows()
                .find_map(|row| match row {
                    Ok(row) => row.index(1).and(row.number(2)).err(),
                    Err(error) => Some(error),
                })
                .expect("must be refused"),
            Err(error) => error,
        };
        let text = error.to_string();
        text[text.find("goals.csv").expect("the file's name")..].to_owned()
    }

    #[test]
    fn every_way_to_write_a_table_gives_the_same_rows_on_their_own_lines() {
        let expected = [
            (2, "smile".into(), 7, 0.5),
            (5, "a \"b\", c".into(), 8, -1.0),
        ];
        let plain = "target,vertex,x\nsmile,7,0.5\n  \n\n\"a \"\"b\"\", c\",8,-1\n";
        assert_eq!(rows(plain), expected);
        assert_eq!(rows(&format!("\u{feff}{plain}")), expected);
        assert_eq!(rows(plain.trim_end()), expected);
        assert_eq!(rows(&plain.replace('\n', "\r\n")), expected);
        assert_eq!(rows(&plain.replace('\n', "\r")), expected);
        let spaced = plain.replace("smile,7,0.5", " smile\t,  7 ,0.5 ");
        assert_eq!(rows(&spaced), expected);
        let quoted = "\"target\",\"id\",\"x\",\"weight\"\n\"smile\",\"7\",\"0.5\",\"1\"\n";
        assert_eq!(rows(quoted), expected[..1]);
        assert_eq!(rows("target,id,x"), []);
    }

    #[test]
    fn refusals_name_file_line_and_column() {
        let cases = [
            (
                "",
                "goals.csv: line 1: the header is \"\", expected \"target,id|vertex,x\"",
            ),
            (
                "target,x,id\n",
                "goals.csv: line 1: the header is \"target,x,id\", expected",
            ),
            (
                "\r\n\r\ntarget,x\r\n",
                "goals.csv: line 3: the header is \"target,x\", expected",
            ),
            (
                "target,id,x\r\n\r\na,1,2\r\na,1\r\n",
                "goals.csv: line 4: 2 fields, expected 3",
            ),
            (
                "target,id,x,weight\na,1,2\n",
                "goals.csv: line 2: 3 fields, expected 4",
            ),
            (
                "target,id,x\n\"a,b\",1.5,2\n",
                "line 2: id is \"1.5\", expected a whole number from 0",
            ),
            (
                "target,vertex,x\n\na,1,inf\n",
                "line 3: x is \"inf\", expected a finite number",
            ),
            (
                "target,id,x\na,1,2\n\"b,1,2\nc,1,2\n",
                "goals.csv: line 3: a quoted field goes on",
            ),
            (
                "\"target,id,x\na,1,2\n",
                "goals.csv: line 1: a quoted field goes on",
            ),
        ];
        for (text, message) in cases {
            let found = refusal(text);
            assert!(found.contains(message), "{text:?} gave {found:?}");
        }
    }
}
