//! The data arrays of a mesh file.

use super::file_error::MeshFileError;
use std::path::Path;

/// The numbers of a data array: integers stay integers, 32-bit floats are widened.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// Real numbers.
    Floats(Vec<f64>),
    /// Whole numbers.
    Integers(Vec<i64>),
}

/// A named array with a fixed number of components for each point or cell.
#[derive(Clone, Debug, PartialEq)]
pub struct DataArray {
    /// Its name in the file.
    pub name: String,
    /// Numbers for each point or cell.
    pub components: usize,
    /// All numbers, the components of one point or cell next to each other.
    pub values: Values,
}

impl DataArray {
    /// One real number for each point or cell.
    pub fn scalars(name: impl Into<String>, values: &[f64]) -> Self {
        Self::vectors(name, values.as_chunks::<1>().0)
    }
    /// One whole number for each point or cell.
    pub fn integers(name: impl Into<String>, values: impl IntoIterator<Item = i64>) -> Self {
        Self {
            name: name.into(),
            components: 1,
            values: Values::Integers(values.into_iter().collect()),
        }
    }
    /// N real numbers for each point or cell.
    pub fn vectors<const N: usize>(name: impl Into<String>, values: &[[f64; N]]) -> Self {
        Self {
            name: name.into(),
            components: N,
            values: Values::Floats(values.iter().flatten().copied().collect()),
        }
    }
    /// How many numbers there are in all.
    pub fn len(&self) -> usize {
        match &self.values {
            Values::Floats(v) => v.len(),
            Values::Integers(v) => v.len(),
        }
    }
    /// Whether there is no number.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// An array together with what its messages need.
pub(super) struct Checked<'a> {
    pub(super) path: &'a Path,
    pub(super) kind: &'static str,
    pub(super) array: &'a DataArray,
    pub(super) count: usize,
}

impl<'a> Checked<'a> {
    pub(super) fn find(
        path: &'a Path,
        kind: &'static str,
        arrays: &'a [DataArray],
        name: &str,
        count: usize,
    ) -> Result<Self, MeshFileError> {
        let array =
            arrays
                .iter()
                .find(|a| a.name == name)
                .ok_or_else(|| MeshFileError::MissingArray {
                    path: path.to_path_buf(),
                    kind,
                    name: name.to_owned(),
                    present: arrays.iter().map(|a| a.name.clone()).collect(),
                })?;
        Ok(Self {
            path,
            kind,
            array,
            count,
        })
    }
    pub(super) fn shape(&self, components: usize) -> Result<(), MeshFileError> {
        let wrong = |what, found, expected| MeshFileError::Shape {
            path: self.path.to_path_buf(),
            kind: self.kind,
            name: self.array.name.clone(),
            what,
            found,
            expected,
        };
        if self.array.components != components || components == 0 {
            return Err(wrong(
                "components",
                self.array.components,
                components.max(1),
            ));
        }
        if self.array.len() != components * self.count {
            return Err(wrong("values", self.array.len(), components * self.count));
        }
        Ok(())
    }
    fn value(&self, at: usize, value: f64, wanted: &'static str) -> MeshFileError {
        MeshFileError::Value {
            path: self.path.to_path_buf(),
            kind: self.kind,
            name: self.array.name.clone(),
            index: at / self.array.components.max(1),
            value,
            wanted,
        }
    }
    pub(super) fn finite(&self) -> Result<(), MeshFileError> {
        if let Values::Floats(v) = &self.array.values
            && let Some(at) = v.iter().position(|x| !x.is_finite())
        {
            return Err(self.value(at, v[at], "finite"));
        }
        Ok(())
    }
    pub(super) fn vectors<const N: usize>(&self) -> Result<Vec<[f64; N]>, MeshFileError> {
        self.shape(N)?;
        self.finite()?;
        Ok(match &self.array.values {
            Values::Floats(v) => v.as_chunks::<N>().0.to_vec(),
            Values::Integers(v) => {
                let floats = v.as_chunks::<N>().0.iter();
                floats.map(|x| x.map(|i| i as f64)).collect()
            }
        })
    }
    pub(super) fn integers(&self) -> Result<Vec<i64>, MeshFileError> {
        self.shape(1)?;
        match &self.array.values {
            Values::Integers(v) => Ok(v.clone()),
            Values::Floats(v) => {
                let whole = |x: &f64| x.fract() == 0.0 && x.abs() < 9e15;
                match v.iter().position(|x| !whole(x)) {
                    Some(at) => Err(self.value(at, v[at], "whole")),
                    None => Ok(v.iter().map(|&x| x as i64).collect()),
                }
            }
        }
    }
}
