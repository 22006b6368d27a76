//! Line plots as SVG: convergence curves and other small plots.

use std::fmt::Write as _;

use super::colormap::{tick_text, ticks};

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Evenly spaced.
    Linear,
    /// Powers of ten; values that are not positive are left out.
    Log,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points `(x, y)`; those that cannot be shown interrupt the line.
    pub points: Vec<[f64; 2]>,
}

impl Series {
    /// A curve over 0, 1, 2, ….
    pub fn counted(name: impl Into<String>, values: &[f64]) -> Self {
        let points = values
            .iter()
            .enumerate()
            .map(|(i, &y)| [i as f64, y])
            .collect();
        Self {
            name: name.into(),
            points,
        }
    }
}

/// A plot of one or more curves with axes and a legend.
///
/// ```
/// use face_pictures::{Axis, LinePlot, Series};
///
/// let svg = LinePlot::new("Newton's method", "iteration", "residual (N)")
///     .y_axis(Axis::Log)
///     .series(Series::counted("twist", &[1.0, 1e-2, 1e-5, 1e-11]))
///     .to_svg();
/// assert!(svg.starts_with("<svg") && svg.contains("iteration"));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LinePlot {
    title: String,
    x_label: String,
    y_label: String,
    axes: [Axis; 2],
    series: Vec<Series>,
    levels: Vec<(String, f64)>,
}

/// Colors that stay apart in print and for color-blind eyes: the palette of M. Okabe and K. Ito
/// (Color Universal Design, 2008), without its yellow.
const COLORS: [&str; 7] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222",
];
const DASHES: [&str; 3] = ["none", "7 4", "2 3"];
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 460.0;
const LEFT: f64 = 84.0;
const TOP: f64 = 50.0;
const BOTTOM: f64 = 62.0;

impl LinePlot {
    /// An empty plot with linear axes.
    pub fn new(
        title: impl Into<String>,
        x_label: impl Into<String>,
        y_label: impl Into<String>,
    ) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            axes: [Axis::Linear; 2],
            series: Vec::new(),
            levels: Vec::new(),
        }
    }

    /// Scale of the horizontal axis.
    pub fn x_axis(mut self, axis: Axis) -> Self {
        self.axes[0] = axis;
        self
    }

    /// Scale of the vertical axis.
    pub fn y_axis(mut self, axis: Axis) -> Self {
        self.axes[1] = axis;
        self
    }

    /// Adds a curve.
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a dashed horizontal line with a name, for example a tolerance.
    pub fn level(mut self, name: impl Into<String>, value: f64) -> Self {
        self.levels.push((name.into(), value));
        self
    }

    /// The plot as an SVG document. Values that are not finite, or not positive on a logarithmic
    /// axis, are left out; a plot of nothing says so.
    pub fn to_svg(&self) -> String {
        let longest = self
            .series
            .iter()
            .map(|s| s.name.chars().count())
            .max()
            .unwrap_or(0);
        let legend = if self.series.is_empty() {
            20.0
        } else {
            (48.0 + 6.9 * longest.min(40) as f64).max(70.0)
        };
        let frame = [LEFT, WIDTH - legend, TOP, HEIGHT - BOTTOM];
        let x = Scale::new(self.axes[0], self.values(0), [frame[0], frame[1]]);
        let y = Scale::new(self.axes[1], self.values(1), [frame[3], frame[2]]);
        let mut s = String::new();
        let _ = write!(
            s,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             width=\"{WIDTH}\" height=\"{HEIGHT}\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"13\" fill=\"#22252b\">\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n"
        );
        text(
            &mut s,
            [0.5 * (frame[0] + frame[1]), 28.0],
            "middle",
            16,
            &self.title,
        );
        text(
            &mut s,
            [0.5 * (frame[0] + frame[1]), HEIGHT - 18.0],
            "middle",
            13,
            &self.x_label,
        );
        let _ = writeln!(
            s,
            "<text transform=\"translate(22 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            0.5 * (frame[2] + frame[3]),
            escape(&self.y_label)
        );
        if let (Some(x), Some(y)) = (x, y) {
            self.draw(&mut s, &x, &y, frame);
        } else {
            let at = [0.5 * (frame[0] + frame[1]), 0.5 * (frame[2] + frame[3])];
            text(&mut s, at, "middle", 14, "no values to show");
        }
        s.push_str("</svg>\n");
        s
    }

    /// Writes the plot: the file appears whole or not at all.
    ///
    /// # Errors
    /// [`crate::export::WriteError`] naming the path.
    pub fn save(&self, path: &std::path::Path) -> Result<(), crate::export::WriteError> {
        crate::export::write_atomically(path, self.to_svg().as_bytes())
    }

    fn shown(&self, p: &[f64; 2]) -> bool {
        (0..2).all(|k| p[k].is_finite() && (self.axes[k] == Axis::Linear || p[k] > 0.0))
    }

    fn values(&self, k: usize) -> Vec<f64> {
        let points = self
            .series
            .iter()
            .flat_map(|s| &s.points)
            .filter(|p| self.shown(p));
        let mut values: Vec<f64> = points.map(|p| p[k]).collect();
        if k == 1 && !values.is_empty() {
            values.extend(
                self.levels
                    .iter()
                    .map(|l| l.1)
                    .filter(|&v| self.shown(&[1.0, v])),
            );
        }
        values
    }

    fn draw(&self, s: &mut String, x: &Scale, y: &Scale, f: [f64; 4]) {
        for (value, label) in x.marks() {
            let at = x.place(value);
            line(s, [at, f[2]], [at, f[3]], "#e4e6ea");
            text(s, [at, f[3] + 20.0], "middle", 13, &label);
        }
        for (value, label) in y.marks() {
            let at = y.place(value);
            line(s, [f[0], at], [f[1], at], "#e4e6ea");
            text(s, [f[0] - 8.0, at + 4.5], "end", 13, &label);
        }
        let _ = writeln!(
            s,
            "<path d=\"M{} {}V{}H{}\" fill=\"none\" stroke=\"#22252b\"/>",
            f[0], f[2], f[3], f[1]
        );
        for (name, value) in self.levels.iter().filter(|l| self.shown(&[1.0, l.1])) {
            let at = y.place(*value);
            let _ = writeln!(
                s,
                "<path d=\"M{} {at:.1}H{}\" stroke=\"#777777\" stroke-dasharray=\"5 4\"/>",
                f[0], f[1]
            );
            text(s, [f[1] - 4.0, at - 5.0], "end", 12, name);
        }
        for (i, series) in self.series.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let dash = DASHES[i / COLORS.len() % DASHES.len()];
            let mut path = String::new();
            let mut pen = 'M';
            let mut dots = String::new();
            for p in &series.points {
                if !self.shown(p) {
                    pen = 'M';
                    continue;
                }
                let at = [x.place(p[0]), y.place(p[1])];
                let _ = write!(path, "{pen}{:.1} {:.1}", at[0], at[1]);
                pen = 'L';
                if series.points.len() <= 60 {
                    let _ = write!(
                        dots,
                        "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.8\"/>",
                        at[0], at[1]
                    );
                }
            }
            let _ = writeln!(
                s,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.8\" \
                 stroke-linejoin=\"round\" stroke-dasharray=\"{dash}\"/>\n<g fill=\"{color}\">{dots}</g>"
            );
            let row = f[2] + 10.0 + 20.0 * i as f64;
            let _ = writeln!(
                s,
                "<path d=\"M{} {row}h20\" stroke=\"{color}\" stroke-width=\"2.4\" \
                 stroke-dasharray=\"{dash}\"/>",
                f[1] + 12.0
            );
            text(s, [f[1] + 38.0, row + 4.5], "start", 13, &series.name);
        }
    }
}

struct Scale {
    axis: Axis,
    range: [f64; 2],
    pixels: [f64; 2],
}

impl Scale {
    fn new(axis: Axis, values: Vec<f64>, pixels: [f64; 2]) -> Option<Self> {
        let value = |v: f64| if axis == Axis::Log { v.log10() } else { v };
        let low = values
            .iter()
            .copied()
            .map(value)
            .fold(f64::INFINITY, f64::min);
        let high = values
            .iter()
            .copied()
            .map(value)
            .fold(f64::NEG_INFINITY, f64::max);
        if !(high >= low) {
            return None;
        }
        let range = match axis {
            Axis::Log => [low.floor(), high.ceil().max(low.floor() + 1.0)],
            Axis::Linear if high > low => {
                let pad = 0.04 * (high - low);
                [if low == 0.0 { 0.0 } else { low - pad }, high + pad]
            }
            Axis::Linear => [
                low - 0.5 * low.abs().max(1.0),
                high + 0.5 * high.abs().max(1.0),
            ],
        };
        Some(Self {
            axis,
            range,
            pixels,
        })
    }

    fn place(&self, value: f64) -> f64 {
        let v = if self.axis == Axis::Log {
            value.log10()
        } else {
            value
        };
        let t = (v - self.range[0]) / (self.range[1] - self.range[0]);
        self.pixels[0] + t * (self.pixels[1] - self.pixels[0])
    }

    fn marks(&self) -> Vec<(f64, String)> {
        let span = self.range[1] - self.range[0];
        match self.axis {
            Axis::Linear => ticks(self.range, 6)
                .into_iter()
                .map(|v| (v, tick_text(v, span)))
                .collect(),
            Axis::Log => {
                let every = (span / 9.0).ceil().max(1.0) as i64;
                (self.range[0] as i64..=self.range[1] as i64)
                    .filter(|e| e.rem_euclid(every) == 0)
                    .map(|e| (10f64.powi(e as i32), format!("1e{e}")))
                    .collect()
            }
        }
    }
}

fn line(s: &mut String, a: [f64; 2], b: [f64; 2], color: &str) {
    let _ = writeln!(
        s,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{color}\"/>",
        a[0], a[1], b[0], b[1]
    );
}

fn text(s: &mut String, at: [f64; 2], anchor: &str, size: u32, what: &str) {
    let _ = writeln!(
        s,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\">{}</text>",
        at[0],
        at[1],
        escape(what)
    );
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_evenly_spaced_and_bad_values_left_out() {
        let plot = LinePlot::new("a < b", "n", "r")
            .y_axis(Axis::Log)
            .series(Series::counted(
                "one",
                &[1.0, 1e-2, 0.0, f64::NAN, 1e-4, -3.0],
            ))
            .level("tolerance", 1e-3);
        let svg = plot.to_svg();
        assert!(svg.contains("a &lt; b") && svg.contains("tolerance") && !svg.contains("NaN"));
        assert_eq!(svg.matches("<circle").count(), 3);
        let scale = Scale::new(Axis::Log, plot.values(1), [400.0, 0.0]).unwrap();
        assert_eq!(scale.range, [-4.0, 0.0]);
        assert!((scale.place(1e-2) - 200.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_to_show_says_so() {
        let svg = LinePlot::new("t", "x", "y")
            .series(Series::counted("s", &[f64::NAN]))
            .to_svg();
        assert!(svg.contains("no values to show"));
    }
}
