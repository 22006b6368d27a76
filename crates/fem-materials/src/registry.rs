//! Models by name: what a program needs to build a material from a table or a scene file.

use crate::Material;
use std::collections::BTreeMap;

pub use crate::models::for_each_model;

/// One parameter of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in tables and scene files.
    pub name: &'static str,
    /// SI unit, empty for a pure number.
    pub unit: &'static str,
    /// A sensible value, as text.
    pub default: &'static str,
    /// What it means.
    pub about: &'static str,
}

impl Parameter {
    /// A parameter in pascals.
    pub const fn pascals(name: &'static str, default: &'static str, about: &'static str) -> Self {
        Self {
            name,
            unit: "Pa",
            default,
            about,
        }
    }
    /// A parameter without unit: a ratio, a direction, a name.
    pub const fn plain(name: &'static str, default: &'static str, about: &'static str) -> Self {
        Self {
            name,
            unit: "",
            default,
            about,
        }
    }
}

/// How to make a model of type `M`.
#[derive(Clone, Copy, Debug)]
pub struct Entry<M> {
    /// The model's name in tables and scene files.
    pub name: &'static str,
    /// One line: what it is for.
    pub about: &'static str,
    /// All its parameters.
    pub parameters: &'static [Parameter],
    /// Builds it from parameters whose names are known to be right; see [`Entry::build`].
    pub from_parameters: fn(&Parameters) -> Result<M, ParameterError>,
}

impl<M> Entry<M> {
    /// The model with the given parameters.
    ///
    /// # Errors
    /// A parameter that the model does not have, one that is missing, one that is no number or
    /// lies outside its range.
    pub fn build(&self, parameters: &Parameters) -> Result<M, ParameterError> {
        for name in parameters.0.keys() {
            if !self.parameters.iter().any(|p| p.name == name) {
                let known: Vec<_> = self.parameters.iter().map(|p| p.name).collect();
                return Err(ParameterError::Unknown {
                    model: self.name,
                    name: name.clone(),
                    known: known.join(", "),
                });
            }
        }
        (self.from_parameters)(parameters)
    }
    /// The default value of every parameter.
    pub fn defaults(&self) -> Parameters {
        self.parameters
            .iter()
            .map(|p| (p.name, p.default))
            .collect()
    }
}

/// What [`for_each_model`] calls, once for each model and dimension.
///
/// ```
/// use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
/// use fem_materials::Material;
/// struct Names(Vec<String>);
/// impl ModelVisitor for Names {
///     fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
///         self.0.push(format!("{} {D}D", entry.name));
///     }
/// }
/// let mut names = Names(Vec::new());
/// for_each_model(&mut names);
/// assert!(names.0.contains(&"neo_hookean 2D".to_owned()));
/// ```
pub trait ModelVisitor {
    /// Called with the recipe of one model in `D` dimensions.
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>);
}

/// Parameters by name, each as the text that a table or a scene file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(BTreeMap<String, String>);

impl<K: Into<String>, V: Into<String>> FromIterator<(K, V)> for Parameters {
    fn from_iter<I: IntoIterator<Item = (K, V)>>(pairs: I) -> Self {
        Self(
            pairs
                .into_iter()
                .map(|(k, v)| (k.into(), v.into()))
                .collect(),
        )
    }
}

impl Parameters {
    /// The text of a parameter.
    ///
    /// # Errors
    /// If it is missing.
    pub fn text(&self, name: &'static str) -> Result<&str, ParameterError> {
        self.0
            .get(name)
            .map(String::as_str)
            .ok_or(ParameterError::Missing { name })
    }
    /// A finite number.
    ///
    /// # Errors
    /// If it is missing, no number, or not finite.
    pub fn number(&self, name: &'static str) -> Result<f64, ParameterError> {
        parse(name, self.text(name)?)
    }
    /// A finite number, or `default` where it is not given.
    ///
    /// # Errors
    /// If it is given and is no finite number.
    pub fn number_or(&self, name: &'static str, default: f64) -> Result<f64, ParameterError> {
        match self.0.get(name) {
            Some(text) => parse(name, text),
            None => Ok(default),
        }
    }
    /// A finite number > 0.
    ///
    /// # Errors
    /// As [`Parameters::number`], and where it is not positive.
    pub fn positive(&self, name: &'static str) -> Result<f64, ParameterError> {
        self.number_where(name, "greater than 0", |x| x > 0.0)
    }
    /// A finite number ≥ 0.
    ///
    /// # Errors
    /// As [`Parameters::number`], and where it is negative.
    pub fn non_negative(&self, name: &'static str) -> Result<f64, ParameterError> {
        self.number_where(name, "0 or greater", |x| x >= 0.0)
    }
    /// A finite number that satisfies `allowed`.
    ///
    /// # Errors
    /// As [`Parameters::number`], and where `allowed` is false; `range` says what it should be.
    pub fn number_where(
        &self,
        name: &'static str,
        range: &'static str,
        allowed: impl Fn(f64) -> bool,
    ) -> Result<f64, ParameterError> {
        let value = self.number(name)?;
        if allowed(value) {
            Ok(value)
        } else {
            Err(ParameterError::OutOfRange { name, value, range })
        }
    }
    /// N finite numbers separated by white space.
    ///
    /// # Errors
    /// If it is missing, has another length, or holds something that is no finite number.
    pub fn vector<const N: usize>(&self, name: &'static str) -> Result<[f64; N], ParameterError> {
        let text = self.text(name)?;
        let numbers: Vec<f64> = text
            .split_whitespace()
            .map(|part| parse(name, part))
            .collect::<Result<_, _>>()?;
        let count = numbers.len();
        numbers.try_into().map_err(|_| ParameterError::Length {
            name,
            expected: N,
            count,
        })
    }
    /// As [`Parameters::non_negative`], or `default` where it is not given.
    ///
    /// # Errors
    /// If it is given and is no finite number, or negative.
    pub fn non_negative_or(&self, name: &'static str, default: f64) -> Result<f64, ParameterError> {
        match self.0.contains_key(name) {
            true => self.non_negative(name),
            false => Ok(default),
        }
    }
    /// N finite numbers whose length is 1 to 1e-3; they are used as given.
    ///
    /// # Errors
    /// As [`Parameters::vector`], and where the length is another.
    pub fn direction<const N: usize>(
        &self,
        name: &'static str,
    ) -> Result<[f64; N], ParameterError> {
        let direction = self.vector(name)?;
        let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        let unit = (length - 1.0).abs() <= 1e-3;
        if unit {
            Ok(direction)
        } else {
            Err(ParameterError::NotUnit { name, length })
        }
    }
}

fn parse(name: &'static str, text: &str) -> Result<f64, ParameterError> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(ParameterError::NotANumber {
            name,
            text: text.to_owned(),
        }),
    }
}

/// Why a model could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// A parameter is not given.
    #[error("parameter `{name}` is missing: give it a value")]
    Missing {
        /// The parameter.
        name: &'static str,
    },
    /// A name that the model does not have.
    #[error("model `{model}` has no parameter `{name}`; it has {known}")]
    Unknown {
        /// The model.
        model: &'static str,
        /// The name that was given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// Text that is no finite number.
    #[error("parameter `{name}` is `{text}`, which is no finite number")]
    NotANumber {
        /// The parameter.
        name: &'static str,
        /// Its text.
        text: String,
    },
    /// A vector of the wrong length.
    #[error("parameter `{name}` has {count} numbers; it needs {expected}")]
    Length {
        /// The parameter.
        name: &'static str,
        /// How many it needs.
        expected: usize,
        /// How many it has.
        count: usize,
    },
    /// A direction that is not of length 1.
    #[error("parameter `{name}` has length {length}; give a unit vector")]
    NotUnit {
        /// The parameter.
        name: &'static str,
        /// Its length.
        length: f64,
    },
    /// A number outside the range where the model makes sense.
    #[error("parameter `{name}` is {value}; it must be {range}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range.
        range: &'static str,
    },
    /// A name that is none of the choices.
    #[error("parameter `{name}` is `{text}`; choose one of {choices}")]
    Choice {
        /// The parameter.
        name: &'static str,
        /// Its text.
        text: String,
        /// The choices.
        choices: &'static str,
    },
}
