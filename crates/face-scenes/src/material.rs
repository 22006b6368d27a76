//! Materials as a scene describes them.

use super::defect::{FibersDefect, MaterialDefect};
use super::names;
use fem_assembly::{AssemblyBuilder, AssemblyError};
use fem_kinematics::{Mat, cauchy_from_piola};
use fem_materials::presets::{PRESETS, Preset, preset};
use fem_materials::registry::{
    ELASTIC_PAIRS, Entry, ModelError, Parameters, SolidVisitor, for_each_solid,
};
use fem_materials::{Lame, Material};
use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};
use std::fmt;

/// A model of [`fem_materials::registry`] by its name, with its parameters in SI units.
///
/// In a scene file `{ "yeoh": { "c1": 2e5, "c2": -1e4, "c3": 2e3, "K": 2e6 } }`: numbers, text, or
/// lists of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMaterial {
    /// The model's name.
    pub model: String,
    /// Its parameters.
    pub parameters: Parameters,
}

impl NamedMaterial {
    /// A model with numbers.
    pub fn new<'a>(model: &str, numbers: impl IntoIterator<Item = (&'a str, f64)>) -> Self {
        let texts = numbers.into_iter().map(|(name, x)| (name, x.to_string()));
        Self {
            model: model.to_owned(),
            parameters: texts.collect(),
        }
    }
    /// Gives the material to some elements.
    ///
    /// # Errors
    /// If no model has the name, or its parameters do not fit; within, where an element does not exist.
    pub fn add_to(
        &self,
        builder: AssemblyBuilder<3>,
        elements: &[usize],
    ) -> Result<Result<AssemblyBuilder<3>, AssemblyError>, ModelError> {
        fem_catalog::region(builder, elements, &self.model, &self.parameters)
    }
    /// Lamé's parameters at rest, from the model itself.
    ///
    /// # Errors
    /// As [`NamedMaterial::add_to`].
    pub fn at_rest(&self) -> Result<Lame, ModelError> {
        fem_catalog::at_rest(&self.model, &self.parameters)
    }
    /// Equivalent stress of von Mises, √(3/2) |dev σ| with σ = P Fᵀ / J, pascals: 0 where F is a
    /// rotation times a number.
    ///
    /// # Errors
    /// As [`NamedMaterial::add_to`].
    pub fn von_mises_stress(&self, deformation_gradient: &Mat<f64, 3>) -> Result<f64, ModelError> {
        let piola = fem_catalog::stress(&self.model, &self.parameters, deformation_gradient)?;
        let sigma = cauchy_from_piola(deformation_gradient, &piola);
        let deviator = sigma - Mat::identity().scale(sigma.trace() / 3.0);
        Ok((1.5 * deviator.dot(&deviator)).sqrt())
    }
}

impl NamedMaterial {
    /// The same with another first Lamé parameter λ at rest, pascals, and the same μ; `None` for a
    /// model that elastic constants do not determine.
    pub fn with_lambda(&self, lambda: f64) -> Option<Self> {
        let lame = self.at_rest().ok()?;
        let own = OwnParameters::of(&self.model, Lame { lambda, ..lame })?;
        let given = self.parameters.iter();
        let kept = given.filter(|(name, _)| {
            let replaced = own.0.iter().any(|(own, _)| own == name);
            let pair = ELASTIC_PAIRS.iter().flatten().any(|p| p.name == *name);
            !replaced && !pair
        });
        let kept = kept.map(|(name, text)| (name.to_owned(), text.to_owned()));
        let own = own
            .0
            .iter()
            .map(|(name, x)| ((*name).to_owned(), x.to_string()));
        Some(Self {
            model: self.model.clone(),
            parameters: kept.chain(own).collect(),
        })
    }
}

/// A model's own parameters that come of elastic constants.
struct OwnParameters(Vec<(&'static str, f64)>);

impl OwnParameters {
    fn of(model: &str, lame: Lame) -> Option<Self> {
        struct Finder<'a>(&'a str, Lame, Option<OwnParameters>);
        impl SolidVisitor for Finder<'_> {
            fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
                if let (true, Some(elastic)) = (entry.is(self.0), entry.elastic) {
                    self.2 = Some(OwnParameters(elastic(self.1)));
                }
            }
        }
        let mut finder = Finder(model, lame, None);
        for_each_solid(&mut finder);
        finder.2
    }
}

impl From<Preset> for NamedMaterial {
    fn from(preset: Preset) -> Self {
        Self {
            model: preset.model.to_owned(),
            parameters: preset.parameters(),
        }
    }
}

impl fmt::Display for NamedMaterial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} with {}", self.model, self.parameters)
    }
}

impl Serialize for NamedMaterial {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let value = |text: &str| match text.parse::<f64>() {
            Ok(number) => Value::from(number),
            Err(_) => Value::from(text),
        };
        let texts = self.parameters.iter();
        let values: Map<String, Value> = texts.map(|(k, v)| (k.to_owned(), value(v))).collect();
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(&self.model, &values)?;
        map.end()
    }
}

/// A material of a scene file: a preset's name or the model with its parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneMaterial {
    /// One of [`fem_materials::presets`].
    Preset(String),
    /// Any model.
    Model(NamedMaterial),
}

impl Serialize for SceneMaterial {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Model(model) => model.serialize(serializer),
            Self::Preset(name) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("preset", name)?;
                map.end()
            }
        }
    }
}

impl<'de> Deserialize<'de> for SceneMaterial {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let map = Map::<String, Value>::deserialize(deserializer)?;
        let count = map.len();
        let (1, Some((name, value))) = (count, map.into_iter().next()) else {
            return Err(D::Error::custom(format!(
                "{count} materials; give one, such as {{ \"preset\": \"soft_tissue\" }}"
            )));
        };
        match value {
            Value::String(preset) if name == "preset" => Ok(Self::Preset(preset)),
            Value::Object(values) if name != "preset" => {
                let parameter = |(key, value): (String, Value)| match text(&value) {
                    Some(text) => Ok((key, text)),
                    None => Err(D::Error::custom(format!(
                        "{name}.{key} is {value}; give a number, text or a list of numbers"
                    ))),
                };
                let parameters = values.into_iter().map(parameter);
                Ok(Self::Model(NamedMaterial {
                    parameters: parameters.collect::<Result<_, _>>()?,
                    model: name,
                }))
            }
            _ if name == "preset" => Err(D::Error::custom("a preset is a name in quotes")),
            _ => Err(D::Error::custom(format!(
                "{name} needs its parameters in braces"
            ))),
        }
    }
}

/// A parameter as the registry reads it.
fn text(value: &Value) -> Option<String> {
    match value {
        Value::Number(number) => Some(number.to_string()),
        Value::String(text) => Some(text.clone()),
        Value::Array(list) => {
            let numbers = list.iter().map(|v| v.as_f64().map(|x| x.to_string()));
            Some(numbers.collect::<Option<Vec<_>>>()?.join(" "))
        }
        _ => None,
    }
}

impl SceneMaterial {
    /// The material, or what is wrong with it.
    pub(super) fn resolve(&self) -> Result<NamedMaterial, MaterialDefect> {
        let material = match self {
            Self::Model(model) => model.clone(),
            Self::Preset(name) => preset(name).map(NamedMaterial::from).ok_or_else(|| {
                let known = PRESETS.map(|p| p.name);
                MaterialDefect::UnknownPreset {
                    name: name.clone(),
                    similar: names::similar(name, known),
                    known: known.to_vec(),
                }
            })?,
        };
        match material.at_rest() {
            Ok(_) => Ok(material),
            Err(ModelError::Unknown { name, known }) => {
                let similar = names::similar(&name, known.iter().copied());
                Err(MaterialDefect::UnknownModel {
                    name,
                    known,
                    similar,
                })
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// A region of the flesh and what it is made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// What it is made of.
    pub material: NamedMaterial,
}

impl Region {
    /// The region of everything that no other region claims.
    pub(super) fn of_all(material: NamedMaterial) -> Self {
        Self {
            name: "flesh".into(),
            material,
        }
    }
}

/// Tension of a fiber over its normalized stretch l = λ/λ_ofl.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum FiberCurve {
    /// PhysBAM's, with a continuous slope.
    Physbam,
    /// Blemker et al. 2005, as published.
    Blemker,
    /// A monotone spline through a table of the user's own.
    Table {
        /// Rows [l, f] of the active tension; l = 1 must lie within.
        active: Vec<[f64; 2]>,
        /// Rows [l, f] of the passive tension; l = 1 must lie within.
        passive: Vec<[f64; 2]>,
    },
}

/// Which stretch a fiber feels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FiberStretch {
    /// λ = |F a₀| (what PhysBAM runs).
    #[serde(alias = "plain")]
    Total,
    /// λ = J^(−1/3) |F a₀| (document 000, 4.2).
    #[serde(alias = "deviatoric")]
    Isochoric,
}

/// What all muscles share: σ = σ_max (α f_act(λ/λ_ofl) + f_pas(λ/λ_ofl)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fibers {
    /// Tension curve.
    pub curve: FiberCurve,
    /// Which stretch.
    pub stretch: FiberStretch,
    /// σ_max, Pa.
    #[serde(alias = "sigma_max")]
    pub max_isometric_stress: f64,
    /// λ_ofl, the stretch at which the active tension peaks.
    #[serde(alias = "lambda_ofl")]
    pub optimal_stretch: f64,
}

impl Default for Fibers {
    /// PhysBAM's curve on the plain stretch, σ_max = 200 kPa (the lower end of measured peak muscle
    /// stress, 0.2 to 0.3 MPa), λ_ofl = 1: strongest at rest.
    fn default() -> Self {
        Self {
            curve: FiberCurve::Physbam,
            stretch: FiberStretch::Total,
            max_isometric_stress: 200e3,
            optimal_stretch: 1.0,
        }
    }
}

impl Fibers {
    pub(super) fn defect(&self) -> Option<FibersDefect> {
        let positive = |v: f64| v > 0.0 && v.is_finite();
        let (max_isometric_stress, optimal_stretch) =
            (self.max_isometric_stress, self.optimal_stretch);
        if !positive(max_isometric_stress) {
            return Some(FibersDefect::MaxIsometricStress {
                max_isometric_stress,
            });
        }
        if !positive(optimal_stretch) {
            return Some(FibersDefect::OptimalStretch { optimal_stretch });
        }
        if let FiberCurve::Table { active, passive } = &self.curve {
            return table_defect("active", active).or_else(|| table_defect("passive", passive));
        }
        None
    }
}

fn table_defect(table: &'static str, rows: &[[f64; 2]]) -> Option<FibersDefect> {
    let finite = rows.iter().flatten().all(|v| v.is_finite());
    let ascending = rows.windows(2).all(|w| w[0][0] < w[1][0]);
    let around_one =
        matches!((rows.first(), rows.last()), (Some(a), Some(b)) if a[0] <= 1.0 && 1.0 <= b[0]);
    let good = rows.len() >= 2 && finite && ascending && around_one;
    (!good).then_some(FibersDefect::Table { table })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<NamedMaterial, String> {
        let spec: SceneMaterial = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let material = spec.resolve().map_err(|e| e.to_string())?;
        let written = serde_json::to_string(&spec).map_err(|e| e.to_string())?;
        let again: SceneMaterial = serde_json::from_str(&written).map_err(|e| e.to_string())?;
        assert_eq!(again.resolve().map(|m| m.at_rest()), Ok(material.at_rest()));
        Ok(material)
    }

    #[test]
    fn every_preset_and_the_default_fibers_are_sound() {
        for preset in PRESETS {
            let text = format!("{{ \"preset\": \"{}\" }}", preset.name);
            assert_eq!(read(&text), Ok(preset.into()));
        }
        assert_eq!(Fibers::default().defect(), None);
    }

    #[test]
    fn every_way_to_write_a_material_is_read() {
        for text in [
            r#"{ "stable_neo_hookean": { "young": 30000.0, "poisson": 0.47 } }"#,
            r#"{ "neo_hookean": { "young": 3e4, "poisson": 0.45 } }"#,
            r#"{ "neo_hookean": { "lambda": 40000, "mu": 10000 } }"#,
            r#"{ "mooney_rivlin": { "a": 6e4, "b": 2e4, "bulk": 6e5 } }"#,
            r#"{ "ogden": { "mu": [6.3e5, 1200, -1e4], "alpha": "1.3 5.0 -2.0", "K": 5e6 } }"#,
            r#"{ "gent": { "young": 3e4, "poisson": 0.45, "Jm": 30 } }"#,
        ] {
            let material = read(text).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!(material.at_rest().is_ok_and(|lame| lame.mu > 0.0), "{text}");
        }
        let lame = read(r#"{ "stable_neo_hookean": { "young": 30000.0, "poisson": 0.47 } }"#)
            .and_then(|m| m.at_rest().map_err(|e| e.to_string()))
            .expect("sound");
        assert!((lame.mu - 3e4 / 2.94).abs() < 1e-8, "{lame:?}");
    }

    #[test]
    fn unsound_materials_are_refused() {
        for (text, parts) in [
            (r#"{ "preset": "steel" }"#, &["steel", "soft_tissue"][..]),
            (r#"{ "preset": 3 }"#, &["preset is a name"]),
            (
                r#"{ "yeo": { "c1": 1 } }"#,
                &["\"yeo\"", "did you mean \"yeoh\"?", "ogden"],
            ),
            (
                r#"{ "yeoh": { "c": 1 } }"#,
                &["no parameter `c`", "c1 in Pa"],
            ),
            (
                r#"{ "yeoh": { "c1": "30 kPa", "c2": 0, "c3": 0, "K": 1 } }"#,
                &["30 kPa", "in Pa"],
            ),
            (r#"{ "yeoh": 3 }"#, &["yeoh needs its parameters"]),
            (r#"{ "yeoh": { "c1": null } }"#, &["yeoh.c1 is null"]),
            (
                r#"{ "neo_hookean": { "young": 1e4, "poisson": 0.5 } }"#,
                &["poisson = 0.5"],
            ),
            (
                r#"{ "neo_hookean": { "young": -1e4, "poisson": 0.4 } }"#,
                &["young = -10000"],
            ),
            (
                r#"{ "mooney_rivlin": { "a": -1, "b": 1, "bulk": 1 } }"#,
                &["must be 0 or greater"],
            ),
            (r#"{ "yeoh": {}, "gent": {} }"#, &["2 materials"]),
            ("{}", &["0 materials"]),
        ] {
            let error = read(text).expect_err(text);
            for part in parts {
                assert!(error.contains(part), "{text}: {error}");
            }
        }
    }

    #[test]
    fn unsound_fibers_are_refused() {
        let mut fibers = Fibers {
            curve: FiberCurve::Table {
                active: vec![[0.5, 0.0], [0.9, 1.0]],
                passive: vec![],
            },
            ..Fibers::default()
        };
        assert!(
            fibers
                .defect()
                .is_some_and(|e| e.to_string().contains("curve.table.active"))
        );
        fibers.max_isometric_stress = -1.0;
        let max_isometric_stress = -1.0;
        assert_eq!(
            fibers.defect(),
            Some(FibersDefect::MaxIsometricStress {
                max_isometric_stress
            })
        );
    }
}
