//! The face ready to be drawn, in any pose.

use super::decoration::Decoration;
use super::face::BuiltinFace;
use super::flesh_color;
use crate::anatomy::Bone;
use crate::pictures::{Camera, Layer, Paint, Panel, ScalarBar};

/// A posed face with eyes, teeth and colors.
///
/// ```no_run
/// use face_rig::builtin::{BuiltinFace, Portrait};
/// use face_rig::pictures::{Camera, Sheet};
///
/// let face = BuiltinFace::with_tets(20_000)?;
/// let jaw = face.hinge.motion(0.2, [0.0; 3]);
/// let posed = face.nodes.clone(); // from a simulation
/// let portrait = Portrait::new(&face, &posed, |p| jaw.apply(p));
/// let camera = Camera::framing(&face.nodes, 25.0, 0.0)?;
/// let sheet = Sheet::new("pose").row(vec![portrait.panel("open", camera)]);
/// sheet.draw(500, 600)?.save("pose.png".as_ref())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Portrait {
    points: Vec<[f64; 3]>,
    material: Vec<[f64; 3]>,
    flesh: Vec<[u32; 3]>,
    decorations: Vec<Decoration>,
}

impl Portrait {
    /// The face with its nodes at `positions` (one per node of the mesh, meters) and its lower teeth
    /// moved by `jaw`, which maps a rest position to a position.
    pub fn new(
        face: &BuiltinFace,
        positions: &[[f64; 3]],
        jaw: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Self {
        let mut decorations = face.decorations();
        for decoration in decorations.iter_mut().filter(|d| d.bone == Bone::Jaw) {
            for point in &mut decoration.points {
                *point = jaw(*point);
            }
        }
        Self {
            points: positions.to_vec(),
            material: face.material.clone(),
            flesh: face.triangles(|_| true),
            decorations,
        }
    }

    /// A panel in natural colors.
    pub fn panel(&self, title: impl Into<String>, camera: Camera) -> Panel<'_> {
        let flesh = Paint::Pattern {
            coordinates: &self.material,
            color: &flesh_color,
        };
        let panel = Panel::new(title, camera).layer(Layer::new(&self.points, &self.flesh, flesh));
        self.decorations.iter().fold(panel, |panel, d| {
            let paint = Paint::Pattern {
                coordinates: &d.coordinates,
                color: d.ornament.pattern(),
            };
            panel.layer(Layer::new(&d.points, &d.triangles, paint).with_gloss(0.5))
        })
    }

    /// A panel colored by one value per node of the mesh, with a color bar.
    pub fn scalar_panel<'a>(
        &'a self,
        title: impl Into<String>,
        camera: Camera,
        values: &'a [f64],
        bar: ScalarBar,
    ) -> Panel<'a> {
        let paint = Paint::Scalar {
            values,
            range: bar.range,
            map: bar.map,
        };
        let layer = Layer::new(&self.points, &self.flesh, paint).with_gloss(0.12);
        let panel = Panel::new(title, camera).layer(layer).bar(bar);
        self.decorations.iter().fold(panel, |panel, d| {
            let gray = Paint::Uniform([0.62, 0.62, 0.64]);
            panel.layer(Layer::new(&d.points, &d.triangles, gray))
        })
    }
}
