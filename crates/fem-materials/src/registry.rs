//! Models by name: what a program needs to build a material from a table or a scene file.
//!
//! [`with_solid`] builds any model of solids and hands it, with its own type, to a [`UseSolid`].

mod known;
mod recipe;

pub use known::KnownParameters;

use recipe::Recipe;

use crate::models::register_all;
use crate::{Lame, LameError, Material};
use fem_kinematics::Mat;
use std::collections::BTreeMap;
use std::fmt;

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
    /// Other names that tables and scene files may use.
    pub aliases: &'static [&'static str],
}

impl Parameter {
    /// A parameter in pascals.
    pub const fn pascals(name: &'static str, default: &'static str, about: &'static str) -> Self {
        Self {
            name,
            unit: "Pa",
            default,
            about,
            aliases: &[],
        }
    }
    /// A parameter without unit: a ratio, a direction, a name.
    pub const fn plain(name: &'static str, default: &'static str, about: &'static str) -> Self {
        Self {
            name,
            unit: "",
            default,
            about,
            aliases: &[],
        }
    }
    /// The same with other names that mean it too.
    pub const fn also(self, aliases: &'static [&'static str]) -> Self {
        Self { aliases, ..self }
    }
    fn is(&self, name: &str) -> bool {
        self.name == name || self.aliases.contains(&name)
    }
}

/// A model's own parameters, by name, from constants at rest; see [`Entry::elastic`].
pub type FromLame = fn(Lame) -> Vec<(&'static str, f64)>;

/// How to make a model of type `M`.
#[derive(Clone, Copy, Debug)]
pub struct Entry<M> {
    /// The model's name in tables and scene files.
    pub name: &'static str,
    /// Other names that tables and scene files may use.
    pub aliases: &'static [&'static str],
    /// One line: what to choose it for.
    pub about: &'static str,
    /// One line: the F for which the model is defined, "all F" or a condition; beyond it ψ = +∞.
    pub domain: &'static str,
    /// All its parameters.
    pub parameters: &'static [Parameter],
    /// The parameters that give the model, less its fibers and damage, these constants at rest;
    /// `None` for a model that they do not determine. With it, [`Entry::build`] takes a pair of
    /// [`ELASTIC_PAIRS`] in their stead.
    pub elastic: Option<FromLame>,
    /// Builds it from parameters whose names are known to be right; see [`Entry::build`].
    pub from_parameters: fn(&Parameters) -> Result<M, ParameterError>,
}

/// The pairs of elastic constants that a model with [`Entry::elastic`] takes.
///
/// Where the model's own parameters have these names, they are the model's own. A model in the
/// plane is the plane-strain slice of a solid with these constants ([`Space::Solid`](crate::Space::Solid)).
pub const ELASTIC_PAIRS: [[Parameter; 2]; 3] = [
    [
        Parameter::pascals("young", "3e4", "Young's modulus"),
        Parameter::plain("poisson", "0.47", "Poisson's ratio"),
    ],
    [
        Parameter::pascals("lambda", "4e5", "first Lamé parameter"),
        Parameter::pascals("mu", "1e5", "shear modulus"),
    ],
    [
        Parameter::pascals("bulk", "5e5", "bulk modulus"),
        Parameter::pascals("shear", "1e5", "shear modulus"),
    ],
];

/// [`Entry::elastic`] of a model whose `mu` and `lambda` are Lamé's.
pub(crate) fn lame_itself(lame: Lame) -> Vec<(&'static str, f64)> {
    vec![("mu", lame.mu), ("lambda", lame.lambda)]
}
/// [`Entry::elastic`] of a model whose `lambda` is Lamé's plus μ.
pub(crate) fn mu_and_lambda_plus_mu(lame: Lame) -> Vec<(&'static str, f64)> {
    vec![("mu", lame.mu), ("lambda", lame.lambda + lame.mu)]
}

impl<M> Entry<M> {
    /// Is this one of the model's names?
    pub fn is(&self, name: &str) -> bool {
        self.recipe().is(name)
    }
    /// The model with the given parameters, its own or a pair of [`ELASTIC_PAIRS`] for some.
    ///
    /// # Errors
    /// A parameter that the model does not have, one that is missing, one that is no number or
    /// lies outside its range.
    pub fn build(&self, parameters: &Parameters) -> Result<M, ParameterError> {
        (self.from_parameters)(&self.recipe().own_parameters(parameters)?)
    }
    /// The default value of every parameter.
    pub fn defaults(&self) -> Parameters {
        self.recipe().defaults()
    }
    /// The parameters, and the elastic pairs that may stand for some of them.
    pub fn known(&self) -> KnownParameters {
        self.recipe().known()
    }
    fn recipe(&self) -> Recipe {
        Recipe {
            name: self.name,
            aliases: self.aliases,
            parameters: self.parameters,
            elastic: self.elastic,
        }
    }
}

/// What the `register` function of a model's file calls.
pub trait Register {
    /// The recipe of a model of solids.
    fn solid<M: Material<3> + 'static>(&mut self, entry: &Entry<M>);
    /// The recipe of a model in the plane.
    fn plane<M: Material<2> + 'static>(&mut self, entry: &Entry<M>);
}

/// Shows every model of this crate to `visitor`, file by file in alphabetical order.
pub fn for_each_model(visitor: &mut impl ModelVisitor) {
    struct Every<'a, V>(&'a mut V);
    impl<V: ModelVisitor> Register for Every<'_, V> {
        fn solid<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
            self.0.visit::<M, 3>(entry);
        }
        fn plane<M: Material<2> + 'static>(&mut self, entry: &Entry<M>) {
            self.0.visit::<M, 2>(entry);
        }
    }
    register_all(&mut Every(visitor));
}

/// Shows every model of solids to `visitor`.
pub fn for_each_solid(visitor: &mut impl SolidVisitor) {
    struct Solids<'a, V>(&'a mut V);
    impl<V: SolidVisitor> Register for Solids<'_, V> {
        fn solid<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
            self.0.visit(entry);
        }
        fn plane<M: Material<2> + 'static>(&mut self, _: &Entry<M>) {}
    }
    register_all(&mut Solids(visitor));
}

/// What [`for_each_solid`] calls, once for each model.
pub trait SolidVisitor {
    /// Called with the recipe of one model.
    fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>);
}

/// What to do with a model that [`with_solid`] has built.
pub trait UseSolid {
    /// What comes of it.
    type Output;
    /// Called with the model.
    fn call<M: Material<3> + 'static>(self, model: M) -> Self::Output;
}

/// Builds the model of solids that has this name or alias and hands it to `user`.
///
/// # Errors
/// If no model has the name, or its parameters don't fit.
pub fn with_solid<U: UseSolid>(
    name: &str,
    parameters: &Parameters,
    user: U,
) -> Result<U::Output, ModelError> {
    struct Finder<'a, U: UseSolid> {
        name: &'a str,
        parameters: &'a Parameters,
        user: Option<U>,
        found: Option<Result<U::Output, ModelError>>,
    }
    impl<U: UseSolid> SolidVisitor for Finder<'_, U> {
        fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
            if !entry.is(self.name) {
                return;
            }
            let Some(user) = self.user.take() else {
                return;
            };
            self.found = Some(match entry.build(self.parameters) {
                Ok(model) => Ok(user.call(model)),
                Err(source) => Err(ModelError::Parameters {
                    model: entry.name,
                    known: Box::new(entry.known()),
                    source,
                }),
            });
        }
    }
    let mut finder = Finder {
        name,
        parameters,
        user: Some(user),
        found: None,
    };
    for_each_solid(&mut finder);
    finder.found.unwrap_or_else(|| {
        Err(ModelError::Unknown {
            name: name.to_owned(),
            known: solid_names(),
        })
    })
}

/// The names of all models of solids, without their aliases.
pub fn solid_names() -> Vec<&'static str> {
    struct Names(Vec<&'static str>);
    impl SolidVisitor for Names {
        fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
            self.0.push(entry.name);
        }
    }
    let mut names = Names(Vec::new());
    for_each_solid(&mut names);
    names.0
}

/// Lamé's parameters of a solid at rest, from its dP/dF at F = I in the plane (x, y); of an
/// anisotropic model those of this plane alone.
pub fn at_rest<M: Material<3>>(model: &M) -> Lame {
    let derivative = model.stress_derivative::<f64>(&Mat::identity());
    let stress = |i, j| derivative.apply(&Mat::unit(i, j));
    Lame {
        mu: 0.5 * (stress(0, 1)[(0, 1)] + stress(0, 1)[(1, 0)]),
        lambda: stress(1, 1)[(0, 0)],
    }
}

/// Why no model was made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Nothing has this name.
    #[error("there is no model `{name}`; there are {}", known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// The names that exist.
        known: Vec<&'static str>,
    },
    /// The parameters do not fit.
    #[error("model `{model}`: {source}; it takes {known}")]
    Parameters {
        /// The model.
        model: &'static str,
        /// Its parameters.
        known: Box<KnownParameters>,
        /// What is wrong.
        source: ParameterError,
    },
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
    fn visit<M: Material<D> + 'static, const D: usize>(&mut self, entry: &Entry<M>);
}

impl fmt::Display for Parameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, (name, text)) in self.0.iter().enumerate() {
            let comma = if k == 0 { "" } else { ", " };
            write!(f, "{comma}{name} = {text}")?;
        }
        Ok(())
    }
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
    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(k, v)| (k.as_str(), v.as_str()))
    }
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
#[non_exhaustive]
pub enum ParameterError {
    /// A parameter is not given.
    #[error("parameter `{name}` is missing: give it a value")]
    Missing {
        /// The parameter.
        name: &'static str,
    },
    /// A name that the model does not have.
    #[error("model `{model}` has no parameter `{name}`")]
    Unknown {
        /// The model.
        model: &'static str,
        /// The name that was given.
        name: String,
        /// The names that exist.
        known: Box<KnownParameters>,
    },
    /// A parameter that is given under two names, or by itself and by an elastic pair.
    #[error("parameter `{name}` is given twice")]
    Twice {
        /// The parameter.
        name: &'static str,
    },
    /// A pair of elastic constants that no stable material has.
    #[error(transparent)]
    Elastic(LameError),
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
