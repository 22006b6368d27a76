//! Pictures of faces, built-in or from files.

use super::error::Failure;
use super::plain_portrait::plain_portrait;
use super::portrait::portrait;
use super::shape_files::carry;
use super::source::Source;
use face_pictures::{
    Axis, Camera, Canvas, ColorMap, Layer, LinePlot, Paint, Panel, Portrait, ScalarBar, Series,
    Sheet,
};
use face_rig::fit::FitIteration;
use face_rig::rig::AffineMap;
use std::path::Path;

const PANEL: [usize; 2] = [480, 560];
/// A panel of a row of four, and of a sheet of many.
const ROW: [usize; 2] = [420, 490];
const CELL: [usize; 2] = [225, 262];
const CELLS_IN_ROW: usize = 4;
/// The colors of a pose at rest should not show its rounding; millimeters.
const SMALLEST_RANGE: f64 = 0.1;
const OBSERVED: [f32; 3] = [0.10, 0.45, 0.80];
const WANTED: [f32; 3] = [0.85, 0.15, 0.15];

/// One shape of a face, ready to be drawn in several panels.
pub struct Shape {
    portrait: Portrait,
    points: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Shape {
    pub fn new(source: &Source, positions: &[[f64; 3]], jaw: &AffineMap) -> Self {
        let skin = source.scene.surface();
        let points = carry(&skin, positions);
        Self {
            portrait: match &source.builtin {
                Some(face) => portrait(face, positions, |p| jaw.apply(p)),
                None => plain_portrait(&source.scene, &points, &skin.triangles, Some(jaw)),
            },
            points,
            triangles: skin.triangles,
        }
    }

    /// A dense target: the skin's vertices at other places. Where its jaw is nobody knows.
    pub fn of_skin(source: &Source, points: Vec<[f64; 3]>) -> Self {
        let triangles = source.scene.surface().triangles;
        Self {
            portrait: plain_portrait(&source.scene, &points, &triangles, None),
            points,
            triangles,
        }
    }

    fn plain(&self, title: &str, camera: Camera) -> Panel<'_> {
        self.portrait.panel(title, camera)
    }

    fn painted<'a>(
        &'a self,
        title: &str,
        camera: Camera,
        values: &'a [f64],
        largest: f64,
    ) -> Panel<'a> {
        let (range, map) = ([0.0, largest], ColorMap::Violet);
        Panel::new(title, camera)
            .layer(Layer::new(
                &self.points,
                &self.triangles,
                Paint::Scalar { values, range, map },
            ))
            .bar(ScalarBar {
                label: "mm".into(),
                range,
                map,
            })
    }
}

/// Distance of paired points, millimeters.
fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<f64> {
    let distance = |(a, b): (&[f64; 3], &[f64; 3])| {
        1e3 * (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    };
    a.iter().zip(b).map(distance).collect()
}

/// rest | pose | how far the skin moved.
pub fn pose(path: &Path, title: &str, rest: &Shape, posed: &Shape) -> Result<(), Failure> {
    let camera = Camera::framing(&rest.points, 0.0, 0.0)?;
    let side = camera.turned(35.0, 5.0);
    let moved = apart(&posed.points, &rest.points);
    let finite = moved.iter().copied().filter(|v| v.is_finite());
    let largest = finite.fold(SMALLEST_RANGE, f64::max);
    let sheet = Sheet::new(title)
        .row(vec![
            rest.plain("rest", camera),
            posed.plain("pose", camera),
        ])
        .row(vec![
            posed.plain("pose, three quarters", side),
            posed.painted("moved from rest by", camera, &moved, largest),
        ]);
    Ok(sheet.draw(PANEL[0], PANEL[1])?.save(path)?)
}

/// A fitted expression with what it should have been.
pub struct Fitted<'a> {
    /// The line above its row.
    pub heading: &'a str,
    /// The words above its place on a sheet of many.
    pub caption: &'a str,
    pub fitted: &'a Shape,
    /// The whole target, where it is known.
    pub target: Option<&'a Shape>,
    pub observed: &'a [[f64; 3]],
    pub wanted: &'a [[f64; 3]],
}

/// A place on a sheet of many fits: the result, and where it is how far off.
pub struct Cell {
    caption: String,
    pictures: [Canvas; 2],
}

/// Pictures of fits of one face: the rest shape is drawn once, distances have one scale in all.
pub struct Sheets {
    rest: Shape,
    camera: Camera,
    /// End of the scale of distances, millimeters.
    scale: f64,
    at_rest: Canvas,
}

impl Sheets {
    pub fn new(source: &Source, scale: f64) -> Result<Self, Failure> {
        let rest = Shape::new(source, source.scene.mesh.nodes(), &AffineMap::IDENTITY);
        let camera = Camera::framing(&rest.points, 0.0, 0.0)?.turned(15.0, 0.0);
        let at_rest = rest.plain("rest", camera).draw(ROW[0], ROW[1])?;
        Ok(Self {
            rest,
            camera,
            scale,
            at_rest,
        })
    }

    /// One row for each fit: rest | result | target | result colored by distance.
    pub fn rows(&self, path: &Path, title: &str, fits: &[Fitted]) -> Result<(), Failure> {
        let distances: Vec<Vec<f64>> = fits.iter().map(|fit| self.distances(fit)).collect();
        let mut sheet = Sheet::new(title);
        for (fit, distance) in fits.iter().zip(&distances) {
            let title = match fit.target {
                Some(_) => "target",
                None => "rest, wanted landmarks",
            };
            let target = fit.target.unwrap_or(&self.rest).plain(title, self.camera);
            sheet = sheet.titled_row(
                fit.heading,
                vec![
                    Panel::drawn("rest", self.camera, &self.at_rest),
                    self.result(fit),
                    target.dots(fit.wanted, WANTED, 2.5),
                    self.off(fit, distance),
                ],
            );
        }
        Ok(sheet.draw(ROW[0], ROW[1])?.save(path)?)
    }

    /// The place of a fit on a sheet of many.
    pub fn cell(&self, fit: &Fitted) -> Result<Cell, Failure> {
        let distance = self.distances(fit);
        let draw = |panel: Panel<'_>| panel.draw(CELL[0], CELL[1]);
        Ok(Cell {
            caption: fit.caption.to_owned(),
            pictures: [draw(self.result(fit))?, draw(self.off(fit, &distance))?],
        })
    }

    /// All fits on one sheet.
    pub fn many(&self, path: &Path, title: &str, cells: &[Cell]) -> Result<(), Failure> {
        let mut sheet = Sheet::new(title);
        for row in cells.chunks(CELLS_IN_ROW) {
            let panels = row.iter().flat_map(|cell| {
                let [result, off] = &cell.pictures;
                let title = format!("off by, up to {} mm", self.scale);
                [
                    Panel::drawn(cell.caption.clone(), self.camera, result),
                    Panel::drawn(title, self.camera, off),
                ]
            });
            sheet = sheet.row(panels.collect());
        }
        Ok(sheet.draw(CELL[0], CELL[1])?.save(path)?)
    }

    fn distances(&self, fit: &Fitted) -> Vec<f64> {
        apart(&fit.fitted.points, &fit.target.unwrap_or(&self.rest).points)
    }

    fn result<'a>(&self, fit: &Fitted<'a>) -> Panel<'a> {
        let panel = fit.fitted.plain("result", self.camera);
        panel.dots(fit.observed, OBSERVED, 2.5)
    }

    fn off<'a>(&self, fit: &Fitted<'a>, distance: &'a [f64]) -> Panel<'a> {
        let title = match fit.target {
            Some(_) => "result, distance to target",
            None => "result, moved from rest by",
        };
        fit.fitted.painted(title, self.camera, distance, self.scale)
    }
}

/// Residual over the iterations of each fit.
pub fn convergence<'f>(
    path: &Path,
    fits: impl IntoIterator<Item = (&'f str, &'f [FitIteration])>,
) -> Result<(), Failure> {
    let plot = fits.into_iter().fold(
        LinePlot::new(
            "Convergence",
            "Gauss-Newton step",
            "RMS distance of the points (mm)",
        )
        .y_axis(Axis::Log),
        |plot, (name, history)| {
            let values: Vec<f64> = history.iter().map(|i| i.rms_mm.max(1e-6)).collect();
            plot.series(Series::counted(name, &values))
        },
    );
    Ok(plot.save(path)?)
}
