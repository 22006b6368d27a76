//! Flesh by its elastic constants, in every kind of element.

use crate::failure::Failure;
use fem_assembly::mesh::{QuadraticMesh, SimplexMesh};
use fem_assembly::{Assembly, AssemblyBuilder, AssemblyError, Dofs, Term, VolumePatches};
use fem_materials::NeoHookean;

/// Kinds of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Linear tetrahedra.
    Linear,
    /// Linear tetrahedra that keep their volume in patches around edges.
    Patches,
    /// Quadratic tetrahedra.
    Quadratic,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Patches, Self::Quadratic];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Patches => "averaged volume",
            Self::Quadratic => "quadratic",
        }
    }
}

/// The nodes of a mesh as the elements have them: for quadratic ones with the middles of its edges.
///
/// # Errors
/// If there are too many.
pub fn nodes(mesh: &SimplexMesh<3>, kind: Kind) -> Result<Vec<[f64; 3]>, Failure> {
    Ok(match kind {
        Kind::Linear | Kind::Patches => mesh.nodes().to_vec(),
        Kind::Quadratic => QuadraticMesh::from_linear(mesh)?.nodes().to_vec(),
    })
}

/// Neo-Hookean flesh (ψ = μ/2 (tr FᵀF − 3) − μ ln J + λ/2 (ln J)², Pa). Its patches keep
/// (λ − μ)/2 (J̄ − 1)²: another law, as far as J is not 1.
///
/// # Errors
/// If something does not fit the mesh.
pub fn flesh(
    mesh: &SimplexMesh<3>,
    kind: Kind,
    [mu, lambda]: [f64; 2],
    dofs: Dofs<3>,
    term: Option<impl Term<3> + 'static>,
) -> Result<Assembly<3>, Failure> {
    let whole = NeoHookean { mu, lambda };
    if kind == Kind::Quadratic {
        let mesh = QuadraticMesh::from_linear(mesh)?;
        let builder = AssemblyBuilder::quadratic(&mesh, dofs)?.material(whole)?;
        return Ok(match term {
            Some(term) => builder.term(term)?,
            None => builder,
        }
        .build()?);
    }
    let builder = AssemblyBuilder::new(mesh, dofs)?;
    let builder = match kind {
        Kind::Patches => {
            let builder = named(builder, mesh, "neo_hookean", [mu, mu])?;
            let bulk = vec![lambda - mu; mesh.num_elements()];
            builder.mean_volume(&VolumePatches::around_edges(mesh), &bulk)?
        }
        _ => named(builder, mesh, "neo_hookean", [mu, lambda])?,
    };
    Ok(with(builder, term)?.build()?)
}

fn with(
    builder: AssemblyBuilder<3>,
    term: Option<impl Term<3> + 'static>,
) -> Result<AssemblyBuilder<3>, AssemblyError> {
    match term {
        Some(term) => builder.term(term),
        None => Ok(builder),
    }
}

/// All elements of a registered model that these constants determine, Pa.
///
/// # Errors
/// If there is no such model, or they do not determine it.
pub fn named(
    builder: AssemblyBuilder<3>,
    mesh: &SimplexMesh<3>,
    model: &str,
    [mu, lambda]: [f64; 2],
) -> Result<AssemblyBuilder<3>, Failure> {
    let all: Vec<usize> = (0..mesh.num_elements()).collect();
    let constants = [("mu", mu), ("lambda", lambda)];
    let parameters = constants.map(|(name, value)| (name, value.to_string()));
    let parameters = parameters.into_iter().collect();
    Ok(fem_catalog::region(builder, &all, model, &parameters)??)
}

/// μ and λ from Young's modulus (Pa) and Poisson's ratio.
pub fn lame(young: f64, poisson: f64) -> [f64; 2] {
    let mu = young / (2.0 * (1.0 + poisson));
    [mu, 2.0 * mu * poisson / (1.0 - 2.0 * poisson)]
}

/// No term at all.
pub const NONE: Option<fem_assembly::NodalLoads<3>> = None;
