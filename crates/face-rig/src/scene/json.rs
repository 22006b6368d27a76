//! JSON files with errors that name field, line and column.

use super::SceneError;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads a whole JSON file as `T`.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, SceneError> {
    let text = std::fs::read_to_string(path).map_err(SceneError::io(path))?;
    parse(path, &text)
}

pub(super) fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, SceneError> {
    let syntax = |error: &serde_json::Error, field: String| {
        // serde_json appends the place, which the message already has.
        let reason = error.to_string();
        let end = reason.rfind(" at line ").unwrap_or(reason.len());
        SceneError::Syntax {
            path: path.to_path_buf(),
            line: error.line(),
            column: error.column(),
            field: match field.as_str() {
                "." => String::new(),
                _ => format!("{field}: "),
            },
            reason: reason[..end].to_owned(),
        }
    };
    let mut source = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut source)
        .map_err(|error| syntax(error.inner(), error.path().to_string()))?;
    source.end().map_err(|error| syntax(&error, ".".into()))?;
    Ok(value)
}
