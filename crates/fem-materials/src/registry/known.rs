//! What parameters a model takes.

use super::Parameter;
use std::fmt;

/// The parameters that a model takes; as text with their units, for people: "c1 in Pa, c2 in Pa".
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct KnownParameters {
    /// All parameters of the model.
    pub own: &'static [Parameter],
    /// The names of those that an elastic pair may stand for; empty where none may.
    pub replaced: Vec<&'static str>,
    /// The pairs of [`ELASTIC_PAIRS`](super::ELASTIC_PAIRS) that may.
    pub pairs: Vec<&'static [Parameter; 2]>,
}

impl fmt::Display for KnownParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own: Vec<_> = self.own.iter().map(with_unit).collect();
        write!(f, "{}", own.join(", "))?;
        // A model that no elastic constants determine.
        if self.replaced.is_empty() && self.pairs.is_empty() {
            return Ok(());
        }
        let pair = |[a, b]: &&[Parameter; 2]| format!("{} and {}", with_unit(a), with_unit(b));
        let pairs: Vec<_> = self.pairs.iter().map(pair).collect();
        let (replaced, pairs) = (self.replaced.join(", "), pairs.join(" or "));
        write!(f, " (for {replaced} also {pairs})")
    }
}

fn with_unit(parameter: &Parameter) -> String {
    match parameter.unit {
        "" => parameter.name.to_owned(),
        unit => format!("{} in {unit}", parameter.name),
    }
}
