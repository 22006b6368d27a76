//! A face ready to be drawn: its flesh, and the eyes and teeth that belong to it.

use super::{Camera, Layer, Paint, Panel, ScalarBar};

/// A surface whose colors are a function of coordinates that do not move with it.
pub struct Patterned {
    /// Where its points are.
    pub points: Vec<[f64; 3]>,
    /// Triangles between them, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One for each point, the same in every pose.
    pub coordinates: Vec<[f64; 3]>,
    /// sRGB color at a coordinate.
    pub color: Box<dyn Fn([f64; 3]) -> [f32; 3] + Send + Sync>,
}

/// A posed face with eyes, teeth and colors.
///
/// ```
/// use face_pictures::{Camera, Patterned, Portrait, Sheet};
///
/// let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let camera = Camera::framing(&points, 25.0, 0.0)?;
/// let portrait = Portrait::new(Patterned {
///     coordinates: points.clone(),
///     points,
///     triangles: vec![[0, 1, 2]],
///     color: Box::new(|c| [0.8, 0.6, 0.4 + 0.1 * c[0] as f32]),
/// });
/// Sheet::new("a flat face").row(vec![portrait.panel("rest", camera)]).draw(100, 120)?;
/// # Ok::<(), face_pictures::PictureError>(())
/// ```
pub struct Portrait {
    flesh: Patterned,
    ornaments: Vec<Patterned>,
    depths: Vec<Patterned>,
}

impl Portrait {
    /// The flesh alone.
    pub fn new(flesh: Patterned) -> Self {
        Self {
            flesh,
            ornaments: Vec::new(),
            depths: Vec::new(),
        }
    }

    /// Adds an eye, a row of teeth or another surface that glosses more than skin does.
    pub fn ornament(mut self, ornament: Patterned) -> Self {
        self.ornaments.push(ornament);
        self
    }

    /// Adds a surface that light hardly reaches, such as the back of the mouth: without gloss.
    pub fn depth(mut self, depth: Patterned) -> Self {
        self.depths.push(depth);
        self
    }

    /// A panel in natural colors.
    pub fn panel(&self, title: impl Into<String>, camera: Camera) -> Panel<'_> {
        let panel = Panel::new(title, camera).layer(natural(&self.flesh));
        let panel = self.depths.iter().fold(panel, |panel, depth| {
            panel.layer(natural(depth).with_gloss(0.0))
        });
        self.ornaments.iter().fold(panel, |panel, ornament| {
            panel.layer(natural(ornament).with_gloss(0.5))
        })
    }

    /// A panel colored by one value per point of the flesh, with a color bar.
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
        let layer = Layer::new(&self.flesh.points, &self.flesh.triangles, paint).with_gloss(0.12);
        let panel = Panel::new(title, camera).layer(layer).bar(bar);
        let inside = self.ornaments.iter().chain(&self.depths);
        inside.fold(panel, |panel, ornament| {
            let gray = Paint::Uniform([0.62, 0.62, 0.64]);
            panel.layer(Layer::new(&ornament.points, &ornament.triangles, gray))
        })
    }
}

fn natural(surface: &Patterned) -> Layer<'_> {
    let paint = Paint::Pattern {
        coordinates: &surface.coordinates,
        color: &*surface.color,
    };
    Layer::new(&surface.points, &surface.triangles, paint)
}
