//! What is in one picture: surfaces, markers, lines, and how they are painted.

use super::{Camera, Canvas, ColorMap, PictureError, ScalarBar};

/// How a surface is colored; colors are sRGB in `[0, 1]`.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Paint<'a> {
    /// One color.
    Uniform([f32; 3]),
    /// One color per point, blended inside triangles.
    PerVertex(&'a [[f32; 3]]),
    /// One scalar per point through a color map; not-a-number is gray.
    Scalar {
        /// One value per point.
        values: &'a [f64],
        /// Values at the ends of the map.
        range: [f64; 2],
        /// The map.
        map: ColorMap,
    },
    /// A color as a function of a coordinate that is carried by the points, for example their
    /// place at rest: it stays sharp on a coarse mesh and moves with the surface.
    Pattern {
        /// One coordinate per point.
        coordinates: &'a [[f64; 3]],
        /// Color of a coordinate.
        color: &'a (dyn Fn([f64; 3]) -> [f32; 3] + Sync),
    },
}

/// Whether the edges of the triangles are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// Surface only.
    Hidden,
    /// Thin dark lines along the edges.
    Shown,
}

/// A surface in a panel.
#[derive(Clone, Copy)]
pub struct Layer<'a> {
    /// Points in world units.
    pub points: &'a [[f64; 3]],
    /// Triangles, counter-clockwise from outside.
    pub triangles: &'a [[u32; 3]],
    /// Colors.
    pub paint: Paint<'a>,
    /// Neighboring triangles that meet at a larger angle show a sharp edge, in degrees.
    pub crease_degrees: f64,
    /// Strength of the highlights: 0 chalk, 0.3 skin, 1 wet.
    pub gloss: f32,
    /// Edge lines.
    pub edges: Edges,
}

impl<'a> Layer<'a> {
    /// A surface with the gloss of skin, smooth up to 75 degrees, without edge lines.
    pub fn new(points: &'a [[f64; 3]], triangles: &'a [[u32; 3]], paint: Paint<'a>) -> Self {
        Self {
            points,
            triangles,
            paint,
            crease_degrees: 75.0,
            gloss: 0.3,
            edges: Edges::Hidden,
        }
    }

    /// The same with edge lines.
    pub fn with_edges(self) -> Self {
        Self {
            edges: Edges::Shown,
            ..self
        }
    }

    /// The same with another gloss.
    pub fn with_gloss(self, gloss: f32) -> Self {
        Self { gloss, ..self }
    }

    pub(super) fn check(&self) -> Result<(), PictureError> {
        let count = self.points.len();
        for (element, t) in self.triangles.iter().enumerate() {
            if let Some(&point) = t.iter().find(|&&p| p as usize >= count) {
                return Err(PictureError::IndexOutOfRange {
                    what: "triangle",
                    element,
                    point: point as usize,
                    count,
                });
            }
        }
        let (what, found) = match self.paint {
            Paint::Uniform(_) => return Ok(()),
            Paint::PerVertex(colors) => ("the color array", colors.len()),
            Paint::Scalar { values, .. } => ("the scalar array", values.len()),
            Paint::Pattern { coordinates, .. } => {
                ("the pattern coordinate array", coordinates.len())
            }
        };
        if found != count {
            return Err(PictureError::WrongLength {
                what,
                found,
                expected: count,
            });
        }
        Ok(())
    }
}

/// Shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Symbol {
    /// A filled disc with a light rim.
    Dot,
    /// A diagonal cross.
    Cross,
    /// A circle.
    Ring,
}

/// A mark at a point, for example a landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// World position.
    pub position: [f64; 3],
    /// sRGB color.
    pub color: [f32; 3],
    /// Radius in pixels.
    pub radius: f64,
    /// Shape.
    pub symbol: Symbol,
}

/// A straight line between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// World positions of the ends.
    pub ends: [[f64; 3]; 2],
    /// sRGB color.
    pub color: [f32; 3],
    /// Width in pixels.
    pub width: f64,
}

/// What happens to markers and segments behind a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occlusion {
    /// Drawn as if nothing were in front.
    Ignored,
    /// Drawn faintly.
    Faint,
    /// Not drawn.
    Hidden,
}

/// One picture of a sheet.
#[derive(Clone)]
pub struct Panel<'a> {
    pub(super) title: String,
    pub(super) camera: Camera,
    pub(super) layers: Vec<Layer<'a>>,
    pub(super) markers: Vec<Marker>,
    pub(super) segments: Vec<Segment>,
    pub(super) bar: Option<ScalarBar>,
    pub(super) occlusion: Occlusion,
    pub(super) drawn: Option<&'a Canvas>,
}

impl<'a> Panel<'a> {
    /// An empty panel.
    pub fn new(title: impl Into<String>, camera: Camera) -> Self {
        Self {
            title: title.into(),
            camera,
            layers: Vec::new(),
            markers: Vec::new(),
            segments: Vec::new(),
            bar: None,
            occlusion: Occlusion::Faint,
            drawn: None,
        }
    }

    /// A picture that [`Panel::draw`] made, for sheets that share it; what else the panel is given is
    /// not drawn.
    pub fn drawn(title: impl Into<String>, camera: Camera, picture: &'a Canvas) -> Self {
        Self {
            drawn: Some(picture),
            ..Self::new(title, camera)
        }
    }

    /// Adds a surface.
    pub fn layer(mut self, layer: Layer<'a>) -> Self {
        self.layers.push(layer);
        self
    }

    /// Adds markers.
    pub fn markers(mut self, markers: impl IntoIterator<Item = Marker>) -> Self {
        self.markers.extend(markers);
        self
    }

    /// Adds one dot of the given color and radius (pixels) per position.
    pub fn dots(self, positions: &[[f64; 3]], color: [f32; 3], radius: f64) -> Self {
        self.markers(positions.iter().map(|&position| Marker {
            position,
            color,
            radius,
            symbol: Symbol::Dot,
        }))
    }

    /// Adds lines.
    pub fn segments(mut self, segments: impl IntoIterator<Item = Segment>) -> Self {
        self.segments.extend(segments);
        self
    }

    /// Adds a color bar.
    pub fn bar(mut self, bar: ScalarBar) -> Self {
        self.bar = Some(bar);
        self
    }

    /// What happens to markers and lines behind surfaces; [`Occlusion::Faint`] unless told.
    pub fn occlusion(mut self, occlusion: Occlusion) -> Self {
        self.occlusion = occlusion;
        self
    }
}
