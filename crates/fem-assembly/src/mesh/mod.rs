//! Simplex meshes and mesh files.
//!
//! [`SimplexMesh`] is validated when it is made, so that everything after it may trust its indices
//! and its volumes. `MeshFile` (feature `vtk`, on by default) reads and writes VTU and legacy VTK files with their data arrays,
//! [`kuhn_grid`] fills a box with tetrahedra, [`SimplexMesh::refine`] splits every element.
//!
//! ```
//! use fem_assembly::mesh::{kuhn_grid, Quality};
//! let bar = kuhn_grid(2, 2, 8, [1.0, 1.0, 4.0])?;
//! assert_eq!((bar.num_nodes(), bar.num_elements()), (81, 192));
//! let quality = Quality::measure(&bar);
//! assert!((quality.volume - 4.0).abs() < 1e-12);
//! # Ok::<(), fem_assembly::mesh::MeshError>(())
//! ```

#[cfg(feature = "vtk")]
mod array;
pub mod atomic;
mod embedded;
mod error;
#[cfg(feature = "vtk")]
mod file;
#[cfg(feature = "vtk")]
mod file_error;
mod grid;
mod quadratic;
mod quality;
mod refine;
mod simplex;
mod topology;
mod validate;
#[cfg(feature = "vtk")]
mod vtk;

#[cfg(feature = "vtk")]
pub use array::{DataArray, Values};
pub use embedded::EmbeddedPoint;
pub use error::{Ids, MeshError};
#[cfg(feature = "vtk")]
pub use file::MeshFile;
#[cfg(feature = "vtk")]
pub use file_error::MeshFileError;
pub use grid::kuhn_grid;
pub use quadratic::QuadraticMesh;
pub use quality::{Distribution, Quality};
pub use refine::Refined;
pub use simplex::SimplexMesh;
pub use topology::{Boundary, Csr};
pub use validate::{Orientation, Orphans, Repairs};
