//! What the registry knows of a model, without its type.

use fem_materials::Material;
use fem_materials::registry::{Entry, ModelVisitor, Parameter, for_each_model};

/// A registered model.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Its name.
    pub name: &'static str,
    /// Its other names.
    pub aliases: &'static [&'static str],
    /// What to choose it for.
    pub about: &'static str,
    /// Where it is defined.
    pub domain: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// In how many dimensions it is there, ascending.
    pub dimensions: Vec<usize>,
    /// Whether energy, stress and derivative decompose F.
    pub decomposes: bool,
}

/// Every registered model by its name, in alphabetical order.
pub fn summaries() -> Vec<Summary> {
    let mut found = Found(Vec::new());
    for_each_model(&mut found);
    found.0.sort_by_key(|model| model.name);
    found.0
}

struct Found(Vec<Summary>);

impl ModelVisitor for Found {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        if let Some(known) = self.0.iter_mut().find(|known| known.name == entry.name) {
            known.dimensions.push(D);
            known.dimensions.sort_unstable();
            return;
        }
        self.0.push(Summary {
            name: entry.name,
            aliases: entry.aliases,
            about: entry.about,
            domain: entry.domain,
            parameters: entry.parameters,
            dimensions: vec![D],
            decomposes: M::DECOMPOSES,
        });
    }
}
