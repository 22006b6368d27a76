//! Pictures of faces, built-in or from files.

use super::error::Failure;
use super::output::carry;
use super::portrait::portrait;
use super::source::Source;
use face_pictures::{
    Axis, Camera, ColorMap, Layer, LinePlot, Paint, Panel, Portrait, ScalarBar, Series, Sheet,
};
use face_rig::fit::FitIteration;
use face_rig::rig::AffineMap;
use std::path::Path;

const PANEL: [usize; 2] = [480, 560];
/// The colors of an exact fit should not show its rounding; millimeters.
const SMALLEST_RANGE: f64 = 0.1;
const PLAIN: [f32; 3] = [0.84, 0.69, 0.60];
const SEEN: [f32; 3] = [0.10, 0.45, 0.80];
const WANTED: [f32; 3] = [0.85, 0.15, 0.15];

/// One shape of a face, ready to be drawn in several panels.
pub struct Shape {
    portrait: Option<Portrait>,
    points: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Shape {
    pub fn new(source: &Source, positions: &[[f64; 3]], jaw: &AffineMap) -> Self {
        let skin = source.scene.surface();
        Self {
            portrait: source
                .builtin
                .as_ref()
                .map(|face| portrait(face, positions, |p| jaw.apply(p))),
            points: carry(&skin, positions),
            triangles: skin.triangles,
        }
    }

    /// A dense target: the skin's vertices at other places.
    pub fn of_skin(source: &Source, points: Vec<[f64; 3]>) -> Self {
        Self {
            portrait: None,
            points,
            triangles: source.scene.surface().triangles,
        }
    }

    fn plain(&self, title: &str, camera: Camera) -> Panel<'_> {
        match &self.portrait {
            Some(portrait) => portrait.panel(title, camera),
            None => Panel::new(title, camera).layer(Layer::new(
                &self.points,
                &self.triangles,
                Paint::Uniform(PLAIN),
            )),
        }
    }

    fn painted<'a>(
        &'a self,
        title: &str,
        camera: Camera,
        values: &'a [f64],
        label: &str,
    ) -> Panel<'a> {
        let largest = values
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .fold(SMALLEST_RANGE, f64::max);
        let (range, map) = ([0.0, largest], ColorMap::Violet);
        Panel::new(title, camera)
            .layer(Layer::new(
                &self.points,
                &self.triangles,
                Paint::Scalar { values, range, map },
            ))
            .bar(ScalarBar {
                label: label.into(),
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
    let sheet = Sheet::new(title)
        .row(vec![
            rest.plain("rest", camera),
            posed.plain("pose", camera),
        ])
        .row(vec![
            posed.plain("pose, three quarters", side),
            posed.painted("moved from rest by", camera, &moved, "mm"),
        ]);
    Ok(sheet.draw(PANEL[0], PANEL[1])?.save(path)?)
}

/// A fitted expression with what it should have been.
pub struct Fitted<'a> {
    pub heading: String,
    pub fitted: &'a Shape,
    /// The whole target, where it is known.
    pub target: Option<&'a Shape>,
    pub seen: &'a [[f64; 3]],
    pub wanted: &'a [[f64; 3]],
}

/// One row for each expression: rest | result | target | result colored by distance.
pub fn expressions(path: &Path, title: &str, rest: &Shape, fits: &[Fitted]) -> Result<(), Failure> {
    let camera = Camera::framing(&rest.points, 0.0, 0.0)?.turned(15.0, 0.0);
    let distances: Vec<Vec<f64>> = fits
        .iter()
        .map(|f| apart(&f.fitted.points, &f.target.unwrap_or(rest).points))
        .collect();
    let mut sheet = Sheet::new(title);
    for (fit, distance) in fits.iter().zip(&distances) {
        let over = match fit.target {
            Some(_) => "result, distance to target",
            None => "result, moved from rest by",
        };
        let target = fit
            .target
            .unwrap_or(rest)
            .plain(
                if fit.target.is_some() {
                    "target"
                } else {
                    "rest, wanted landmarks"
                },
                camera,
            )
            .dots(fit.wanted, WANTED, 2.5);
        sheet = sheet.titled_row(
            fit.heading.clone(),
            vec![
                rest.plain("rest", camera),
                fit.fitted.plain("result", camera).dots(fit.seen, SEEN, 2.5),
                target,
                fit.fitted.painted(over, camera, distance, "mm"),
            ],
        );
    }
    Ok(sheet.draw(PANEL[0] * 7 / 8, PANEL[1] * 7 / 8)?.save(path)?)
}

/// Residual over the iterations of each fit.
pub fn convergence(path: &Path, fits: &[(&str, &[FitIteration])]) -> Result<(), Failure> {
    let plot = fits.iter().fold(
        LinePlot::new(
            "Convergence",
            "Gauss-Newton step",
            "RMS distance of the points (mm)",
        )
        .y_axis(Axis::Log),
        |plot, (name, history)| {
            let values: Vec<f64> = history.iter().map(|i| i.rms_mm.max(1e-6)).collect();
            plot.series(Series::counted(*name, &values))
        },
    );
    Ok(plot.save(path)?)
}
