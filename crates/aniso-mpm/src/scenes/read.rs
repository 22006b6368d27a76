//! Reading numbers out of a JSON file, with the place in the message when one is missing.

use super::Deviation;
use crate::float::worse;
use fem_kinematics::Mat;
use serde_json::Value;

pub fn at<'a>(value: &'a Value, key: &str) -> Result<&'a Value, String> {
    value.get(key).ok_or_else(|| format!("`{key}` is missing"))
}

pub fn number(value: &Value, key: &str) -> Result<f64, String> {
    at(value, key)?
        .as_f64()
        .ok_or_else(|| format!("`{key}` is not a number"))
}

pub fn list<'a>(value: &'a Value, key: &str) -> Result<&'a [Value], String> {
    at(value, key)?
        .as_array()
        .map(Vec::as_slice)
        .ok_or_else(|| format!("`{key}` is not a list"))
}

fn flatten(value: &Value, out: &mut Vec<f64>) -> Result<(), String> {
    match value {
        Value::Array(values) => values.iter().try_for_each(|v| flatten(v, out)),
        other => {
            out.push(
                other
                    .as_f64()
                    .ok_or("a list holds something that is not a number")?,
            );
            Ok(())
        }
    }
}

/// All numbers of a nested list, row after row.
pub fn numbers(value: &Value, key: &str) -> Result<Vec<f64>, String> {
    let mut out = Vec::new();
    flatten(at(value, key)?, &mut out)?;
    Ok(out)
}

pub fn vectors<const D: usize>(value: &Value, key: &str) -> Result<Vec<[f64; D]>, String> {
    let flat = numbers(value, key)?;
    if !flat.len().is_multiple_of(D) {
        return Err(format!("`{key}` is not a list of vectors"));
    }
    Ok(flat
        .chunks(D)
        .map(|c| core::array::from_fn(|a| c[a]))
        .collect())
}

pub fn matrices<const D: usize>(value: &Value, key: &str) -> Result<Vec<Mat<f64, D>>, String> {
    let rows = vectors::<D>(value, key)?;
    if !rows.len().is_multiple_of(D) {
        return Err(format!("`{key}` is not a list of matrices"));
    }
    Ok(rows
        .chunks(D)
        .map(|r| Mat(core::array::from_fn(|a| r[a])))
        .collect())
}

/// The node with a flat index i + G (j + G k).
pub fn node<const D: usize>(flat: usize, per_axis: usize) -> [i32; D] {
    let per_axis = per_axis.max(1);
    core::array::from_fn(|a| ((flat / per_axis.saturating_pow(a as u32)) % per_axis) as i32)
}

/// Refuses a list of another length than what belongs to it.
pub fn of_length(key: &str, found: usize, expected: usize) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    Err(format!("`{key}` has {found} entries, expected {expected}"))
}

/// max |a − b| over max |b| (over 1 where b is 0): NaN where lengths differ or a NaN occurs.
pub fn relative(ours: &[f64], theirs: &[f64]) -> f64 {
    if ours.len() != theirs.len() {
        return f64::NAN;
    }
    let mut scale = 0.0f64;
    let mut worst = 0.0f64;
    for (a, b) in ours.iter().zip(theirs) {
        scale = worse(scale, b.abs());
        let error = (a - b).abs();
        worst = worse(worst, error);
    }
    worst / if scale == 0.0 { 1.0 } else { scale }
}

/// Gathers deviations under one prefix.
pub struct Report {
    pub prefix: String,
    pub deviations: Vec<Deviation>,
}
impl Report {
    pub fn push(&mut self, name: &str, error: f64, tolerance: f64) {
        self.deviations.push(Deviation {
            name: format!("{}/{name}", self.prefix),
            error,
            tolerance,
        });
    }
}
