//! What the scene files have in common: a mesh, a material, a curve.

use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{AssemblyBuilder, AssemblyError};
use fem_materials::curves::{Blemker, BuiltinCurve, PhysBam};
use fem_materials::{FiberLaw, Stretch};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Why a scene could not be run.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be used.
    #[error(transparent)]
    Read(#[from] crate::shared::ReadError),
    /// The mesh is not valid.
    #[error(transparent)]
    Mesh(#[from] fem_assembly::mesh::MeshError),
    /// The assembly refuses it.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The rig refuses it, or has no equilibrium.
    #[error(transparent)]
    Rig(#[from] face_rig::rig::RigError),
    /// A solve failed.
    #[error(transparent)]
    Newton(#[from] fem_solvers::NewtonError),
    /// A solve that claims more than it did.
    #[error("a force of {left:e} N is left where {allowed:e} N are allowed")]
    Unbalanced {
        /// What is left, newtons.
        left: f64,
        /// What was promised, newtons.
        allowed: f64,
    },
    /// A name that means nothing here.
    #[error("unknown {what} `{name}`")]
    Unknown {
        /// Material, curve, obstacle.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// No model of the registry has this name, or its parameters do not fit.
    #[error(transparent)]
    Model(#[from] fem_materials::registry::ModelError),
}

/// Nodes and tets.
#[derive(Clone, Debug, Deserialize)]
pub struct Mesh {
    /// Rest positions.
    pub X: Vec<[f64; 3]>,
    /// Node indices.
    pub tets: Vec<[u32; 4]>,
}

impl Mesh {
    /// The validated mesh.
    ///
    /// # Errors
    /// If it is not valid.
    pub fn build(&self) -> Result<SimplexMesh<3>, SceneError> {
        let connectivity = self.tets.as_flattened().to_vec();
        Ok(SimplexMesh::new(self.X.clone(), connectivity)?)
    }
}

/// A material by name with its numbers.
#[derive(Clone, Debug, Deserialize)]
pub struct NamedMaterial {
    /// A name of the registry.
    pub material: String,
    /// Its numbers.
    pub parameters: BTreeMap<String, f64>,
}

impl NamedMaterial {
    /// A I₁ + B I₂ + K/2 ln²J.
    pub fn flesh(parameters: &BTreeMap<String, f64>) -> Self {
        let flesh = parameters
            .iter()
            .filter(|(name, _)| ["A", "B", "K"].contains(&name.as_str()));
        Self {
            material: "mooney_rivlin".to_owned(),
            parameters: flesh.map(|(name, &x)| (name.clone(), x)).collect(),
        }
    }

    /// Gives it to the whole mesh of the builder, which has this many elements.
    ///
    /// # Errors
    /// If the name is unknown, or the numbers do not fit.
    pub fn add_to(
        &self,
        builder: AssemblyBuilder<3>,
        elements: usize,
    ) -> Result<AssemblyBuilder<3>, SceneError> {
        let numbers = self.parameters.iter().map(|(name, &x)| (name.as_str(), x));
        let material = face_scenes::NamedMaterial::new(&self.material, numbers);
        let all: Vec<usize> = (0..elements).collect();
        Ok(material.add_to(builder, &all)??)
    }
}

/// A tension curve.
#[derive(Clone, Debug, Deserialize)]
pub struct Curve {
    curve: String,
    P1: f64,
    P2: f64,
    lambda_star: f64,
    /// λ_ofl.
    pub lambda_ofl: f64,
}

impl Curve {
    /// The law of all fibers of a scene.
    ///
    /// # Errors
    /// If the curve's name is unknown.
    pub fn law(&self, stretch: Stretch) -> Result<FiberLaw<BuiltinCurve>, SceneError> {
        let (P1, P2, lambda_star) = (self.P1, self.P2, self.lambda_star);
        let curve = match self.curve.as_str() {
            "physbam" => BuiltinCurve::PhysBam(PhysBam {
                P1,
                P2,
                lambda_star,
            }),
            "blemker" => BuiltinCurve::Blemker(Blemker {
                P1,
                P2,
                lambda_star,
            }),
            other => {
                return Err(SceneError::Unknown {
                    what: "curve",
                    name: other.to_owned(),
                });
            }
        };
        Ok(FiberLaw { curve, stretch })
    }
}

/// `deviatoric: true` or `false`, as the files have it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(from = "bool")]
pub struct FiberStretch(pub Stretch);

impl From<bool> for FiberStretch {
    fn from(deviatoric: bool) -> Self {
        Self(match deviatoric {
            true => Stretch::Isochoric,
            false => Stretch::Total,
        })
    }
}
