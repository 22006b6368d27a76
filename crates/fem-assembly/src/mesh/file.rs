//! A mesh file in memory: points, cells and named data arrays.

use super::array::{Checked, DataArray};
use super::error::MeshError;
use super::file_error::MeshFileError;
use super::quadratic::QuadraticMesh;
use super::simplex::SimplexMesh;
use super::validate::{Orientation, Orphans, Repairs};
use std::path::PathBuf;

/// VTK's cell types.
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;
const QUADRATIC_TRIANGLE: u8 = 22;
const QUADRATIC_TETRAHEDRON: u8 = 24;

/// What a VTU or legacy VTK file holds: points, cells of any kind, and data arrays by name.
///
/// ```
/// use fem_assembly::mesh::{kuhn_grid, DataArray, MeshFile};
/// let mesh = kuhn_grid(1, 1, 1, [1.0; 3])?;
/// let path = std::env::temp_dir().join("fem_assembly_mesh_file_example.vtu");
/// MeshFile::from_tets(&mesh)
///     .with_cell_data(DataArray::integers("label", [3, 1, 4, 1, 5, 9]))
///     .write(&path)?;
/// let back = MeshFile::read(&path)?;
/// assert_eq!(back.cell_integers("label")?, [3, 1, 4, 1, 5, 9]);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// Where it was read from, for messages; empty for a mesh made in memory.
    pub path: PathBuf,
    /// Point positions.
    pub points: Vec<[f64; 3]>,
    /// Point indices of all cells one after the other.
    pub connectivity: Vec<u32>,
    /// Where each cell ends in `connectivity`.
    pub offsets: Vec<u32>,
    /// VTK's type of each cell (5 triangle, 10 tetrahedron, 22 and 24 the quadratic ones).
    pub cell_types: Vec<u8>,
    /// Arrays with a value for each point.
    pub point_data: Vec<DataArray>,
    /// Arrays with a value for each cell.
    pub cell_data: Vec<DataArray>,
}

impl MeshFile {
    /// A tetrahedral mesh without data.
    pub fn from_tets(mesh: &SimplexMesh<3>) -> Self {
        Self::from_cells(
            mesh.nodes().to_vec(),
            mesh.connectivity().to_vec(),
            4,
            TETRAHEDRON,
        )
    }
    /// A surface of triangles without data; positions in meters.
    pub fn from_triangles(points: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        Self::from_cells(points, triangles.as_flattened().to_vec(), 3, TRIANGLE)
    }
    /// A mesh of quadratic tetrahedra without data.
    pub fn from_quadratic_tets(mesh: &QuadraticMesh<3>) -> Self {
        let connectivity = mesh.connectivity().to_vec();
        Self::from_cells(
            mesh.nodes().to_vec(),
            connectivity,
            10,
            QUADRATIC_TETRAHEDRON,
        )
    }
    /// A plane mesh of quadratic triangles at z = 0 without data.
    pub fn from_quadratic_triangles(mesh: &QuadraticMesh<2>) -> Self {
        let points = mesh.nodes().iter().map(|&[x, y]| [x, y, 0.0]).collect();
        Self::from_cells(points, mesh.connectivity().to_vec(), 6, QUADRATIC_TRIANGLE)
    }
    fn from_cells(points: Vec<[f64; 3]>, connectivity: Vec<u32>, nodes: u32, kind: u8) -> Self {
        let cells = connectivity.len() as u32 / nodes;
        Self {
            path: PathBuf::new(),
            points,
            connectivity,
            offsets: (1..=cells).map(|c| c * nodes).collect(),
            cell_types: vec![kind; cells as usize],
            point_data: Vec::new(),
            cell_data: Vec::new(),
        }
    }
    /// Adds an array with a value for each point.
    #[must_use]
    pub fn with_point_data(mut self, array: DataArray) -> Self {
        self.point_data.push(array);
        self
    }
    /// Adds an array with a value for each cell.
    #[must_use]
    pub fn with_cell_data(mut self, array: DataArray) -> Self {
        self.cell_data.push(array);
        self
    }

    /// The cells as a validated tetrahedral mesh.
    ///
    /// # Errors
    /// [`MeshFileError::CellType`] for any other cell, [`MeshFileError::Mesh`] for a bad mesh.
    pub fn tet_mesh(
        &self,
        orientation: Orientation,
        orphans: Orphans,
    ) -> Result<(SimplexMesh<3>, Repairs), MeshFileError> {
        let connectivity = self.cells_of(TETRAHEDRON, "tetrahedra", 4)?;
        SimplexMesh::with_repairs(self.points.clone(), connectivity, orientation, orphans)
            .map_err(|source| self.mesh_error(source))
    }
    /// The cells as a validated mesh of straight quadratic tetrahedra.
    ///
    /// # Errors
    /// [`MeshFileError::CellType`] for any other cell, [`MeshFileError::Mesh`] for a bad mesh.
    pub fn quadratic_tet_mesh(
        &self,
        orientation: Orientation,
        orphans: Orphans,
    ) -> Result<(QuadraticMesh<3>, Repairs), MeshFileError> {
        let wanted = "quadratic tetrahedra";
        let connectivity = self.cells_of(QUADRATIC_TETRAHEDRON, wanted, 10)?;
        QuadraticMesh::with_repairs(self.points.clone(), connectivity, orientation, orphans)
            .map_err(|source| self.mesh_error(source))
    }
    /// The cells as a validated plane mesh of straight quadratic triangles; all points have the
    /// same z, which is dropped.
    ///
    /// # Errors
    /// As [`MeshFile::quadratic_tet_mesh`]; [`MeshFileError::Format`] where the mesh is not plane.
    pub fn quadratic_triangle_mesh(
        &self,
        orientation: Orientation,
        orphans: Orphans,
    ) -> Result<(QuadraticMesh<2>, Repairs), MeshFileError> {
        let wanted = "quadratic triangles";
        let connectivity = self.cells_of(QUADRATIC_TRIANGLE, wanted, 6)?;
        let level = self.points.first().map_or(0.0, |x| x[2]);
        if let Some(point) = self.points.iter().position(|x| !(x[2] == level)) {
            let z = self.points[point][2];
            return Err(self.format(format!(
                "point {point} has z = {z}, point 0 has {level}: a plane mesh needs one z"
            )));
        }
        let points = self.points.iter().map(|&[x, y, _]| [x, y]).collect();
        QuadraticMesh::with_repairs(points, connectivity, orientation, orphans)
            .map_err(|source| self.mesh_error(source))
    }
    fn mesh_error(&self, source: MeshError) -> MeshFileError {
        MeshFileError::Mesh {
            path: self.path.clone(),
            source,
        }
    }
    /// The cells as triangles, indices checked.
    ///
    /// # Errors
    /// [`MeshFileError::CellType`] for any other cell, [`MeshFileError::Format`] for a bad index.
    pub fn triangles(&self) -> Result<Vec<[u32; 3]>, MeshFileError> {
        let connectivity = self.cells_of(TRIANGLE, "triangles", 3)?;
        let (triangles, _) = connectivity.as_chunks::<3>();
        let beyond = |t: &[u32; 3]| t.iter().any(|&n| n as usize >= self.points.len());
        match triangles.iter().position(beyond) {
            Some(t) => Err(self.format(format!(
                "triangle {t} names a point beyond the last of {}",
                self.points.len()
            ))),
            None => Ok(triangles.to_vec()),
        }
    }
    fn cells_of(
        &self,
        expected: u8,
        wanted: &'static str,
        nodes: u32,
    ) -> Result<Vec<u32>, MeshFileError> {
        if let Some(cell) = self.cell_types.iter().position(|&t| t != expected) {
            return Err(MeshFileError::CellType {
                path: self.path.clone(),
                cell,
                found: self.cell_types[cell],
                wanted,
                expected,
            });
        }
        let regular =
            |(c, &end): (usize, &u32)| u64::from(end) == (c as u64 + 1) * u64::from(nodes);
        let complete = self.connectivity.len() == self.cell_types.len() * nodes as usize;
        if !(complete && self.offsets.iter().enumerate().all(regular)) {
            return Err(self.format(format!("the cells do not all have {nodes} points")));
        }
        Ok(self.connectivity.clone())
    }
    fn format(&self, reason: String) -> MeshFileError {
        MeshFileError::Format {
            path: self.path.clone(),
            reason,
        }
    }

    /// N finite numbers for each point.
    ///
    /// # Errors
    /// [`MeshFileError::MissingArray`] (naming those present), `Shape`, `Value`.
    pub fn point_vectors<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Vec<[f64; N]>, MeshFileError> {
        self.points_array(name)?.vectors()
    }
    /// One finite number for each point.
    ///
    /// # Errors
    /// As [`MeshFile::point_vectors`].
    pub fn point_scalars(&self, name: &str) -> Result<Vec<f64>, MeshFileError> {
        Ok(self
            .points_array(name)?
            .vectors::<1>()?
            .as_flattened()
            .to_vec())
    }
    /// One whole number for each point.
    ///
    /// # Errors
    /// As [`MeshFile::point_vectors`].
    pub fn point_integers(&self, name: &str) -> Result<Vec<i64>, MeshFileError> {
        self.points_array(name)?.integers()
    }
    /// N finite numbers for each cell.
    ///
    /// # Errors
    /// As [`MeshFile::point_vectors`].
    pub fn cell_vectors<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>, MeshFileError> {
        self.cells_array(name)?.vectors()
    }
    /// One finite number for each cell.
    ///
    /// # Errors
    /// As [`MeshFile::point_vectors`].
    pub fn cell_scalars(&self, name: &str) -> Result<Vec<f64>, MeshFileError> {
        Ok(self
            .cells_array(name)?
            .vectors::<1>()?
            .as_flattened()
            .to_vec())
    }
    /// One whole number for each cell.
    ///
    /// # Errors
    /// As [`MeshFile::point_vectors`].
    pub fn cell_integers(&self, name: &str) -> Result<Vec<i64>, MeshFileError> {
        self.cells_array(name)?.integers()
    }
    fn points_array(&self, name: &str) -> Result<Checked<'_>, MeshFileError> {
        Checked::find(
            &self.path,
            "point",
            &self.point_data,
            name,
            self.points.len(),
        )
    }
    fn cells_array(&self, name: &str) -> Result<Checked<'_>, MeshFileError> {
        Checked::find(
            &self.path,
            "cell",
            &self.cell_data,
            name,
            self.cell_types.len(),
        )
    }
    /// Checks every array for its length and for finite values, as a file to be written needs.
    pub(super) fn check_arrays(&self) -> Result<(), MeshFileError> {
        let points = self
            .point_data
            .iter()
            .map(|a| ("point", a, self.points.len()));
        let cells = self
            .cell_data
            .iter()
            .map(|a| ("cell", a, self.cell_types.len()));
        for (kind, array, count) in points.chain(cells) {
            let checked = Checked {
                path: &self.path,
                kind,
                array,
                count,
            };
            checked.shape(array.components)?;
            checked.finite()?;
        }
        Ok(())
    }
}
