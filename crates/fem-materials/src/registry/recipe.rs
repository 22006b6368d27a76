//! What an [`Entry`](super::Entry) says of its model without the model's type: compiled once, not for every model.

use super::{ELASTIC_PAIRS, FromLame, KnownParameters, Parameter, ParameterError, Parameters};
use crate::{Lame, LameError, Space};

pub(super) struct Recipe {
    pub name: &'static str,
    pub aliases: &'static [&'static str],
    pub parameters: &'static [Parameter],
    pub elastic: Option<FromLame>,
}

impl Recipe {
    pub fn is(&self, name: &str) -> bool {
        self.name == name || self.aliases.contains(&name)
    }

    pub fn defaults(&self) -> Parameters {
        self.parameters
            .iter()
            .map(|p| (p.name, p.default))
            .collect()
    }

    pub fn known(&self) -> KnownParameters {
        let replaced = self.elastic.map_or_else(Vec::new, |elastic| {
            elastic(Lame {
                mu: 1.0,
                lambda: 1.0,
            })
        });
        KnownParameters {
            own: self.parameters,
            replaced: replaced.into_iter().map(|(name, _)| name).collect(),
            pairs: self.elastic_pairs().collect(),
        }
    }

    /// The model's own parameters, by their own names, all of them known.
    pub fn own_parameters(&self, given: &Parameters) -> Result<Parameters, ParameterError> {
        let elastic = self.without_elastic_pair(given)?;
        let given = elastic.as_ref().unwrap_or(given);
        let mut own = Parameters::default();
        for (name, text) in &given.0 {
            let Some(parameter) = self.parameters.iter().find(|p| p.is(name)) else {
                return Err(ParameterError::Unknown {
                    model: self.name,
                    name: name.clone(),
                    known: Box::new(self.known()),
                });
            };
            if own.0.insert(parameter.name.into(), text.clone()).is_some() {
                return Err(ParameterError::Twice {
                    name: parameter.name,
                });
            }
        }
        Ok(own)
    }

    /// The pairs that cannot be mistaken for parameters of the model's own.
    fn elastic_pairs(&self) -> impl Iterator<Item = &'static [Parameter; 2]> {
        let own = |p: &Parameter| self.parameters.iter().any(|q| q.is(p.name));
        ELASTIC_PAIRS
            .iter()
            .filter(move |[a, b]| self.elastic.is_some() && !(own(a) && own(b)))
    }

    /// The model's own parameters where `given` has an elastic pair.
    fn without_elastic_pair(
        &self,
        given: &Parameters,
    ) -> Result<Option<Parameters>, ParameterError> {
        let both = |[a, b]: &&[Parameter; 2]| [a, b].iter().all(|p| given.0.contains_key(p.name));
        let pairs = || self.elastic_pairs().find(both);
        let (Some(elastic), Some([a, b])) = (self.elastic, pairs()) else {
            return Ok(None);
        };
        let (first, second) = (given.number(a.name)?, given.number(b.name)?);
        let lame = match a.name {
            "young" => Lame::from_young_poisson(first, second, Space::Solid),
            "lambda" => Lame::new(second, first, Space::Solid),
            _ => Lame::from_bulk_shear(first, second, Space::Solid),
        };
        let lame = lame.map_err(|error| {
            ParameterError::Elastic(LameError {
                first_name: a.name,
                first,
                second_name: b.name,
                second,
                ..error
            })
        })?;
        let mut own = given.clone();
        own.0.remove(a.name);
        own.0.remove(b.name);
        for (name, value) in elastic(lame) {
            if own.0.insert(name.into(), value.to_string()).is_some() {
                return Err(ParameterError::Twice { name });
            }
        }
        Ok(Some(own))
    }
}
