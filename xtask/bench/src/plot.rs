//! Curves as pictures: seconds to the right, the error upwards, both logarithmic.

use crate::curve::{Axis as Varies, Curve};
use face_pictures::{Axis, LinePlot, Series};

/// An error of less than this is drawn as this: the logarithm of an exact answer has no place.
const SMALLEST: f64 = 1e-16;

/// The curves of a scene, or nothing where none can be drawn.
pub fn plot(title: &str, measure: &str, curves: &[Curve]) -> Option<LinePlot> {
    let drawn: Vec<&Curve> = curves
        .iter()
        .filter(|c| c.drawn && c.points.len() > 1)
        .collect();
    if drawn.is_empty() {
        return None;
    }
    let series = drawn.into_iter().map(series);
    let empty = match curves.iter().all(|c| c.axis == Varies::Angle) {
        true => LinePlot::new(title, "fiber angle, degrees", measure),
        false => LinePlot::new(title, "seconds", measure)
            .x_axis(Axis::Log)
            .y_axis(Axis::Log),
    };
    Some(series.fold(empty, LinePlot::series))
}

fn series(curve: &Curve) -> Series {
    let place = |p: &crate::Point| match curve.axis {
        Varies::Angle => [p.setting.parse().unwrap_or(f64::NAN), p.error],
        _ => [p.seconds, p.error.max(SMALLEST)],
    };
    Series {
        name: curve.name.clone(),
        points: curve.points.iter().map(place).collect(),
    }
}
