//! Stresses of models by their names, outside the kernels of an assembly.

use fem_kinematics::Mat;
use fem_materials::registry::{
    Entry, ModelError, Parameters, SolidVisitor, UseSolid, for_each_solid, with_solid,
};
use fem_materials::{Material, Outlined};

/// P(F), pascals.
pub type StressFunction = Box<dyn Fn(&Mat<f64, 3>) -> Mat<f64, 3> + Send + Sync>;

/// A model with its parameters.
#[derive(Clone, Debug)]
pub struct Named {
    /// Its name.
    pub model: String,
    /// Its parameters.
    pub parameters: Parameters,
}

impl Named {
    /// A model that Young's modulus (Pa) and Poisson's ratio determine.
    pub fn elastic(model: &str, young: f64, poisson: f64) -> Self {
        Self::new(model, &[("young", young), ("poisson", poisson)])
    }

    /// A model with numbers.
    pub fn new(model: &str, numbers: &[(&str, f64)]) -> Self {
        let text = |(name, x): &(&str, f64)| ((*name).to_owned(), x.to_string());
        Self {
            model: model.to_owned(),
            parameters: numbers.iter().map(text).collect(),
        }
    }

    /// A model with its defaults, or nothing of that name.
    pub fn of_defaults(model: &str) -> Option<Self> {
        struct Defaults<'a>(&'a str, Option<Parameters>);
        impl SolidVisitor for Defaults<'_> {
            fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
                if entry.name == self.0 {
                    self.1 = Some(entry.defaults());
                }
            }
        }
        let mut found = Defaults(model, None);
        for_each_solid(&mut found);
        let model = model.to_owned();
        Some(Self {
            model,
            parameters: found.1?,
        })
    }

    /// Its stress.
    pub fn stress(&self) -> Result<StressFunction, ModelError> {
        struct Boxed;
        impl UseSolid for Boxed {
            type Output = StressFunction;
            fn call<M: Material<3> + 'static>(self, model: M) -> StressFunction {
                let model = Outlined(model);
                Box::new(move |F| model.stress(F))
            }
        }
        with_solid(&self.model, &self.parameters, Boxed)
    }
}
