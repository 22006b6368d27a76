//! Every constitutive model that [`fem_materials::registry`] knows, by its name and parameters: as elements
//! of an assembly, and its stress and constants at rest as numbers.
//!
//! ```
//! use fem_assembly::{AssemblyBuilder, Dofs, mesh::kuhn_grid};
//! use fem_materials::registry::Parameters;
//!
//! let mesh = kuhn_grid(1, 1, 1, [1.0; 3])?;
//! let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0, 1, 2, 3])?;
//! let builder = AssemblyBuilder::new(&mesh, dofs)?;
//! let soft = [("young", "3e4"), ("poisson", "0.45")];
//! let parameters: Parameters = soft.map(|(name, text)| (name, text.to_owned())).into_iter().collect();
//! let builder = fem_catalog::region(builder, &[0, 1, 2, 3, 4, 5], "neo_hookean", &parameters)??;
//! assert_eq!(builder.build()?.dofs().free_nodes(), 4);
//! let lame = fem_catalog::at_rest("neo_hookean", &parameters)?;
//! assert!((lame.mu - 3e4 / 2.9).abs() < 1e-9);
//! let F = fem_kinematics::Mat([[1.1, 0.2, 0.0], [0.0, 0.9, 0.1], [0.0, 0.0, 1.0]]);
//! let flesh = fem_materials::NeoHookean { mu: lame.mu, lambda: lame.lambda };
//! let off = fem_catalog::stress("neo_hookean", &parameters, &F)? - fem_materials::Material::stress(&flesh, &F);
//! assert!(off.norm_squared() < 1e-15);
//! assert!(fem_catalog::region(AssemblyBuilder::new(&mesh, Dofs::with_prescribed_nodes(mesh.nodes(), &[0])?)?,
//!     &[0], "neo_hukean", &parameters).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use fem_assembly::{AssemblyBuilder, AssemblyError};
use fem_kinematics::Mat;
use fem_materials::registry::{self, ModelError, Parameters, UseSolid, with_solid};
use fem_materials::{Lame, Material};

/// Gives some elements the model of that name, its parameters in SI units.
///
/// # Errors
/// If no model has the name, or its parameters do not fit; within, as [`AssemblyBuilder::region`].
pub fn region(
    builder: AssemblyBuilder<3>,
    elements: &[usize],
    model: &str,
    parameters: &Parameters,
) -> Result<Result<AssemblyBuilder<3>, AssemblyError>, ModelError> {
    with_solid(model, parameters, AsElements(builder, elements))
}

/// Lamé's parameters at rest, pascals, from the model itself ([`registry::at_rest`]).
///
/// # Errors
/// If no model has the name, or its parameters do not fit.
pub fn at_rest(model: &str, parameters: &Parameters) -> Result<Lame, ModelError> {
    struct AtRest;
    impl UseSolid for AtRest {
        type Output = Lame;
        fn call<M: Material<3> + 'static>(self, model: M) -> Lame {
            registry::at_rest(&model)
        }
    }
    with_solid(model, parameters, AtRest)
}

/// First Piola-Kirchhoff stress P(F) = ∂ψ/∂F, pascals.
///
/// # Errors
/// As [`at_rest`].
pub fn stress(
    model: &str,
    parameters: &Parameters,
    deformation_gradient: &Mat<f64, 3>,
) -> Result<Mat<f64, 3>, ModelError> {
    struct At<'a>(&'a Mat<f64, 3>);
    impl UseSolid for At<'_> {
        type Output = Mat<f64, 3>;
        fn call<M: Material<3> + 'static>(self, model: M) -> Mat<f64, 3> {
            model.stress(self.0)
        }
    }
    with_solid(model, parameters, At(deformation_gradient))
}

struct AsElements<'a>(AssemblyBuilder<3>, &'a [usize]);

impl UseSolid for AsElements<'_> {
    type Output = Result<AssemblyBuilder<3>, AssemblyError>;
    fn call<M: Material<3> + 'static>(self, model: M) -> Self::Output {
        // One instance of the element kernels for each model: builds without optimization compile each
        // method once instead of at every call.
        #[cfg(debug_assertions)]
        let model = fem_materials::Outlined(model);
        self.0.region(self.1, model)
    }
}
