//! Pictures without a GPU or a window: shaded surfaces, color bars, sheets of panels, line plots.
//!
//! Everything is a pure function of its input: the same arrays give the same bytes, for any number
//! of threads. A picture is built from [`Layer`]s (triangle surfaces with a [`Paint`]) seen by a
//! [`Camera`], put into [`Panel`]s and laid out as a [`Sheet`], which is written as PNG; plots of
//! numbers go to SVG through [`LinePlot`]. Surfaces for other programs are written by [`export`].
//!
//! ```
//! use face_pictures::{Camera, Layer, Paint, Panel, Sheet};
//!
//! let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let triangles = [[0, 1, 2]];
//! let panel = Panel::new("a triangle", Camera::framing(&points, 20.0, 5.0)?)
//!     .layer(Layer::new(&points, &triangles, Paint::Uniform([0.8, 0.6, 0.5])));
//! let canvas = Sheet::new("one panel").row(vec![panel]).draw(200, 160)?;
//! assert!(canvas.to_png()?.starts_with(b"\x89PNG"));
//! # Ok::<(), face_pictures::PictureError>(())
//! ```

// Comparisons are written so that a value that is not a number takes the safe branch.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod export;

mod camera;
mod canvas;
mod colormap;
mod font;
mod normals;
mod occlusion;
mod panel;
mod portrait;
mod raster;
mod shading;
mod sheet;
mod svg;

pub use camera::Camera;
pub use canvas::Canvas;
pub use colormap::{ColorMap, ScalarBar};
pub use normals::corner_normals;
pub use panel::{Edges, Layer, Marker, Occlusion, Paint, Panel, Segment, Symbol};
pub use portrait::{Patterned, Portrait};
pub use sheet::Sheet;
pub use svg::{Axis, LinePlot, Series};

/// What can be wrong with the input of a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// A triangle names a point that does not exist.
    #[error("{what} {element} refers to point {point}, but there are only {count} points")]
    IndexOutOfRange {
        /// `triangle`.
        what: &'static str,
        /// Index of the element.
        element: usize,
        /// The offending point.
        point: usize,
        /// Number of points.
        count: usize,
    },
    /// An array has the wrong length.
    #[error("{what} has {found} entries, expected {expected}")]
    WrongLength {
        /// Which array.
        what: &'static str,
        /// Length found.
        found: usize,
        /// Length expected.
        expected: usize,
    },
    /// There is no finite point to put into the frame.
    #[error("nothing to frame: no point with finite coordinates")]
    NothingToFrame,
    /// A picture of no pixels, or of absurdly many, was asked for.
    #[error("a picture of {width} x {height} pixels cannot be drawn: use 16 to 16384 a side")]
    BadSize {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// A sheet without a panel.
    #[error("the sheet has no panel: add a row with at least one")]
    EmptySheet,
    /// The PNG encoder failed.
    #[error("PNG encoding failed: {0}")]
    Encoding(#[from] png::EncodingError),
    /// Writing the file failed.
    #[error(transparent)]
    Write(#[from] crate::export::WriteError),
}
