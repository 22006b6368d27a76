//! Files of one shape: the flesh as VTU, the skin as OBJ and glTF.

use super::args::Format;
use super::error::Failure;
use face_pictures::export::{GlbMesh, MorphTarget, glb, obj, write_atomically};
use face_rig::rig::{Parameters, Rig, RigError};
use face_scenes::{Scene, Skin};
use fem_assembly::Positions;
use fem_assembly::mesh::{DataArray, MeshFile};
use std::path::Path;

/// What a VTU file says of each tetrahedron.
pub struct Fields {
    volume_ratios: Vec<f64>,
    /// Stretch of the dominant fiber, 1 without fibers.
    stretch: Vec<f64>,
    activation: Vec<f64>,
}

impl Fields {
    /// Those of a pose, if a file needs them.
    pub fn of(
        formats: &[Format],
        scene: &Scene,
        rig: &Rig,
        parameters: &Parameters,
        positions: &[[f64; 3]],
    ) -> Result<Option<Self>, Failure> {
        if !formats.contains(&Format::Vtu) {
            return Ok(None);
        }
        let shape = rig.assembly().positions(positions);
        let shape = shape.map_err(RigError::from)?;
        let volume_ratios = rig
            .assembly()
            .volume_ratios(shape)
            .map_err(RigError::from)?;
        let (stretch, activation) = fibers(scene, rig, parameters, shape)?;
        Ok(Some(Self {
            volume_ratios,
            stretch,
            activation,
        }))
    }
}

/// Writes a shape into a folder in all `formats` and says which files that made; a VTU needs fields.
pub fn write(
    folder: &Path,
    formats: &[Format],
    name: &str,
    scene: &Scene,
    fields: Option<&Fields>,
    positions: &[[f64; 3]],
) -> Result<Vec<String>, Failure> {
    let mut files = Vec::new();
    let mut path = |ending: &str| {
        let file = format!("{name}.{ending}");
        let path = folder.join(&file);
        files.push(file);
        path
    };
    if let (true, Some(fields)) = (formats.contains(&Format::Vtu), fields) {
        flesh(scene, fields, positions).write(path("vtu"))?;
    }
    if formats.contains(&Format::Obj) || formats.contains(&Format::Glb) {
        let skin = scene.surface();
        let posed = carry(&skin, positions);
        if formats.contains(&Format::Obj) {
            let text = obj(name, &posed, &skin.triangles)?;
            write_atomically(&path("obj"), text.as_bytes())?;
        }
        if formats.contains(&Format::Glb) {
            let at_rest = carry(&skin, scene.mesh.nodes());
            let binary = glb(&GlbMesh {
                name,
                points: &at_rest,
                triangles: &skin.triangles,
                base_color: [0.62, 0.40, 0.32],
                targets: &[MorphTarget {
                    name,
                    displacements: &moved(&posed, &at_rest),
                }],
            })?;
            write_atomically(&path("glb"), &binary)?;
        }
    }
    Ok(files)
}

fn flesh(scene: &Scene, fields: &Fields, positions: &[[f64; 3]]) -> MeshFile {
    let mut volume = MeshFile::from_tets(&scene.mesh);
    volume.points = positions.to_vec();
    let bones = scene.bones.of_node().iter().map(|b| *b as i64);
    let displacement = moved(positions, scene.mesh.nodes());
    volume
        .with_point_data(DataArray::vectors("displacement", &displacement))
        .with_point_data(DataArray::integers("bone", bones))
        .with_cell_data(DataArray::scalars("det_F", &fields.volume_ratios))
        .with_cell_data(DataArray::scalars("fiber_stretch", &fields.stretch))
        .with_cell_data(DataArray::scalars("activation", &fields.activation))
}

fn moved(to: &[[f64; 3]], from: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let pairs = to.iter().zip(from);
    pairs
        .map(|(x, r)| std::array::from_fn(|i| x[i] - r[i]))
        .collect()
}

/// The skin's vertices when the flesh is at `positions`.
pub fn carry(skin: &Skin, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    skin.points.iter().map(|p| p.position(positions)).collect()
}

/// Per tet: stretch of its dominant fiber (1 without) and its activation, weighted.
fn fibers(
    scene: &Scene,
    rig: &Rig,
    parameters: &Parameters,
    positions: Positions<3>,
) -> Result<(Vec<f64>, Vec<f64>), RigError> {
    (0_u32..)
        .take(scene.mesh.num_elements())
        .map(|tet| {
            let of_tet = scene.fiber_field.of_tet(tet);
            let dominant = of_tet.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
            let stretch = match dominant {
                Some(fiber) => {
                    let squares = rig
                        .assembly()
                        .deformation_gradients(tet as usize, positions)?
                        .map(|gradient| gradient.mul_vec(fiber.direction).map(|c| c * c))
                        .map(|squares| squares.iter().sum::<f64>());
                    squares.fold(0.0, f64::max).sqrt()
                }
                None => 1.0,
            };
            let activation: f64 = of_tet
                .iter()
                .map(|f| f.weight * parameters.activations[f.muscle as usize])
                .sum();
            Ok((stretch, activation))
        })
        .collect()
}
