//! What the scene files have in common: a mesh, a material, a curve.

use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{AssemblyBuilder, AssemblyError};
use fem_materials::curves::{Blemker, BuiltinCurve, PhysBam};
use fem_materials::isotropic::ByStretches;
use fem_materials::{
    CorotatedLinear, FiberLaw, Flesh, NeoHookean, QrAnisotropic, StVenantKirchhoff,
    StableNeoHookean, Stretch,
};
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
    /// A name that means nothing here.
    #[error("unknown {what} `{name}`")]
    Unknown {
        /// Material, curve, obstacle.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A parameter that the material needs.
    #[error("the material `{material}` needs the parameter `{parameter}`")]
    Missing {
        /// The material.
        material: String,
        /// The parameter.
        parameter: &'static str,
    },
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
    /// The scene files' name.
    pub material: String,
    /// Its numbers.
    pub parameters: BTreeMap<String, f64>,
}

impl NamedMaterial {
    /// A I₁ + B I₂ + K/2 ln²J.
    pub fn flesh(parameters: &BTreeMap<String, f64>) -> Self {
        Self {
            material: "mooney_rivlin".to_owned(),
            parameters: parameters.clone(),
        }
    }

    fn get(&self, parameter: &'static str) -> Result<f64, SceneError> {
        let found = self.parameters.get(parameter).copied();
        found.ok_or_else(|| SceneError::Missing {
            material: self.material.clone(),
            parameter,
        })
    }

    /// Gives it to the whole mesh.
    ///
    /// # Errors
    /// If the name is unknown or a number is missing.
    pub fn add_to(&self, builder: AssemblyBuilder<3>) -> Result<AssemblyBuilder<3>, SceneError> {
        if self.material == "mooney_rivlin" {
            let flesh = Flesh::new(self.get("A")?, self.get("B")?, self.get("K")?);
            return Ok(builder.material(flesh)?);
        }
        let (mu, lambda) = (self.get("mu")?, self.get("lambda")?);
        Ok(match self.material.as_str() {
            "neo_hookean" => builder.material(NeoHookean { mu, lambda })?,
            "stvk" => builder.material(StVenantKirchhoff { mu, lambda })?,
            "corotated" => builder.material(ByStretches(CorotatedLinear { mu, lambda }))?,
            "stable_neo_hookean" => builder.material(StableNeoHookean { mu, lambda })?,
            "qr" => {
                let (kx, ky) = (self.get("kx")?, self.get("ky")?);
                builder.material(QrAnisotropic { mu, lambda, kx, ky })?
            }
            other => {
                return Err(SceneError::Unknown {
                    what: "material",
                    name: other.to_owned(),
                });
            }
        })
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
