//! JSON files with errors that name field, line and column.

use super::SceneError;
use serde::de::DeserializeOwned;
use std::fmt;
use std::path::Path;

/// Reads a whole JSON file as `T`.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, SceneError> {
    let text = std::fs::read_to_string(path).map_err(SceneError::io(path))?;
    // Editors on some systems put a byte-order mark first.
    parse(path, text.trim_start_matches('\u{feff}'))
}

pub(super) fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, SceneError> {
    let syntax = |error: serde_json::Error, field: Option<String>| SceneError::Syntax {
        path: path.to_path_buf(),
        line: error.line(),
        column: error.column(),
        field,
        source: error.into(),
    };
    let mut source = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut source).map_err(|error| {
        let field = Some(error.path().to_string()).filter(|field| field != ".");
        syntax(error.into_inner(), field)
    })?;
    source.end().map_err(|error| syntax(error, None))?;
    Ok(value)
}

/// The field and what the reader says of it.
pub(super) struct Said<'a> {
    pub field: &'a Option<String>,
    pub source: &'a dyn std::error::Error,
}

impl fmt::Display for Said<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(field) = self.field {
            write!(f, "{field}: ")?;
        }
        // serde_json appends the place, which the message already has.
        let reason = self.source.to_string();
        let end = reason.rfind(" at line ").unwrap_or(reason.len());
        f.write_str(&reason[..end])
    }
}

/// The line, from 1, of a field like `face.files.bones` in a JSON file; none for other files, and for
/// places that are no field.
pub(super) fn line_in_file(path: &Path, field: &str) -> Option<usize> {
    if path.extension()? != "json" {
        return None;
    }
    line_of(&std::fs::read_to_string(path).ok()?, field)
}

/// The line of a field in JSON text that is known to be valid. An index like `regions[1]` is taken for the
/// list.
fn line_of(text: &str, field: &str) -> Option<usize> {
    let wanted: Vec<&str> = field
        .split('.')
        .map(|key| key.split_once('[').map_or(key, |(list, _)| list))
        .collect();
    // The key that is being read in every bracket that is open; none in a list.
    let mut open: Vec<Option<&str>> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['{', '}', '[', ']', '"']) {
        let found = rest.as_bytes()[at];
        rest = &rest[at + 1..];
        match found {
            b'{' | b'[' => open.push(None),
            b'}' | b']' => {
                open.pop();
            }
            _ => {
                let end = end_of_string(rest)?;
                let (key, after) = (&rest[..end], &rest[end + 1..]);
                if after.trim_start().starts_with(':') {
                    *open.last_mut()? = Some(key);
                    if open.iter().flatten().eq(&wanted) {
                        let before = text.len() - rest.len();
                        return Some(1 + text[..before].matches('\n').count());
                    }
                }
                rest = after;
            }
        }
    }
    None
}

/// Where a string ends whose opening quote has been read.
fn end_of_string(text: &str) -> Option<usize> {
    let mut escaped = false;
    text.bytes().position(|b| {
        let end = b == b'"' && !escaped;
        escaped = b == b'\\' && !escaped;
        end
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_found_by_its_whole_path() {
        let text = "{ \"a\": { \"b\": \"c\\\" }: \" },\n  \"list\": [{ \"b\": 1 }],\n  \"b\": {\n \"a\": {\n\
                    \"b\": 2 } } }";
        serde_json::from_str::<serde_json::Value>(text).expect("valid");
        assert_eq!(line_of(text, "a.b"), Some(1));
        assert_eq!(line_of(text, "list[0].b"), Some(2));
        assert_eq!(line_of(text, "b"), Some(3));
        assert_eq!(line_of(text, "b.a.b"), Some(5));
        assert_eq!(line_of(text, "c"), None);
        assert_eq!(line_of("{", "line 12"), None);
    }
}
