//! Panels side by side with titles and color bars.

use super::camera::OnScreen;
use super::canvas::Canvas;
use super::colormap::{tick_text, ticks};
use super::panel::{Marker, Occlusion, Panel, Symbol};
use super::shading::{Shaded, shade};
use super::{PictureError, ScalarBar};
use fem_solvers::parallel;

const PAPER: [f32; 3] = [1.0, 1.0, 1.0];
const INK: [f32; 3] = [0.13, 0.14, 0.17];

/// Rows of panels under a title.
#[derive(Clone)]
pub struct Sheet<'a> {
    title: String,
    rows: Vec<(String, Vec<Panel<'a>>)>,
}

impl<'a> Sheet<'a> {
    /// A sheet without panels.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            rows: Vec::new(),
        }
    }

    /// Adds a row of panels.
    pub fn row(self, panels: Vec<Panel<'a>>) -> Self {
        self.titled_row("", panels)
    }

    /// Adds a row of panels under a heading.
    pub fn titled_row(mut self, heading: impl Into<String>, panels: Vec<Panel<'a>>) -> Self {
        self.rows.push((heading.into(), panels));
        self
    }

    /// Draws the sheet; every panel's picture has the given size in pixels, titles and margins come
    /// on top.
    ///
    /// # Errors
    /// [`PictureError`] for an empty sheet, bad sizes, wrong array lengths or indices.
    pub fn draw(&self, panel_width: usize, panel_height: usize) -> Result<Canvas, PictureError> {
        let columns = self.rows.iter().map(|r| r.1.len()).max().unwrap_or(0);
        if columns == 0 {
            return Err(PictureError::EmptySheet);
        }
        let size = text_size(panel_width);
        let gap = (0.9 * size).ceil() as usize;
        let line = (2.3 * size).ceil() as usize;
        let head = if self.title.is_empty() {
            gap
        } else {
            gap + (1.35 * line as f64) as usize
        };
        let row_height =
            |heading: &str| panel_height + line + gap + if heading.is_empty() { 0 } else { line };
        let width = columns * (panel_width + gap) + gap;
        let height = head + self.rows.iter().map(|r| row_height(&r.0)).sum::<usize>();
        let mut canvas = Canvas::new(width, height, PAPER)?;
        fit_text(
            &mut canvas,
            &self.title,
            [gap as f64, 2.2 * size],
            1.25 * size,
            width - 2 * gap,
        );
        let panels: Vec<&Panel> = self.rows.iter().flat_map(|row| &row.1).collect();
        let draw = |panel: &Panel| panel.draw(panel_width, panel_height);
        let pictures: Result<Vec<_>, _> = parallel::map(panels, draw);
        let mut pictures = pictures?.into_iter();
        let mut top = head;
        for (heading, panels) in &self.rows {
            let mut y = top;
            if !heading.is_empty() {
                let at = [gap as f64, y as f64 + 1.5 * size];
                fit_text(&mut canvas, heading, at, 1.1 * size, width - 2 * gap);
                y += line;
            }
            for (i, panel) in panels.iter().enumerate() {
                let x = gap + i * (panel_width + gap);
                let at = [x as f64, y as f64 + 1.5 * size];
                fit_text(&mut canvas, &panel.title, at, size, panel_width);
                if let Some(picture) = pictures.next() {
                    canvas.paste(x, y + line, &picture);
                }
            }
            top += row_height(heading);
        }
        Ok(canvas)
    }
}

fn fit_text(canvas: &mut Canvas, text: &str, at: [f64; 2], size: f64, room: usize) {
    let width = Canvas::text_width(text, size).max(1.0);
    canvas.text(text, at, size * (room as f64 / width).min(1.0), INK);
}

/// Height of letters beside a panel of this width, pixels.
fn text_size(panel_width: usize) -> f64 {
    (panel_width as f64 / 36.0).clamp(8.0, 15.0)
}

impl Panel<'_> {
    /// The picture without its title, as a sheet shows it.
    ///
    /// # Errors
    /// [`PictureError`] for bad sizes, wrong array lengths or indices.
    pub fn draw(&self, width: usize, height: usize) -> Result<Canvas, PictureError> {
        match self.drawn {
            Some(picture) => Ok(picture.clone()),
            None => draw_panel(self, width, height),
        }
    }
}

fn draw_panel(panel: &Panel<'_>, width: usize, height: usize) -> Result<Canvas, PictureError> {
    let size = text_size(width);
    // The color bar has a strip of its own beside the picture.
    let strip = if panel.bar.is_some() {
        (6.8 * size) as usize
    } else {
        0
    };
    let full = width;
    let width = width.saturating_sub(strip).max(16);
    let Shaded { mut canvas, depth } = shade(&panel.layers, &panel.camera, width, height)?;
    let project = panel.camera.projection(width, height);
    let slack = 0.02 * panel.camera.half_height;
    let strength = |s: OnScreen| -> f64 {
        if panel.occlusion == Occlusion::Ignored {
            return 1.0;
        }
        if !(s.x >= 0.0 && s.y >= 0.0 && s.x < width as f64 && s.y < height as f64) {
            return 1.0;
        }
        let behind = s.depth - slack > f64::from(depth[s.y as usize * width + s.x as usize]);
        match (behind, panel.occlusion) {
            (false, _) => 1.0,
            (true, Occlusion::Hidden) => 0.0,
            (true, _) => 0.22,
        }
    };
    for segment in &panel.segments {
        let [a, b] = segment.ends.map(&project);
        let middle = project([0, 1, 2].map(|k| 0.5 * (segment.ends[0][k] + segment.ends[1][k])));
        let line = [[a.x, a.y], [b.x, b.y]];
        canvas.polyline(&line, segment.width, segment.color, strength(middle));
    }
    for marker in &panel.markers {
        let s = project(marker.position);
        draw_marker(&mut canvas, marker, [s.x, s.y], strength(s));
    }
    if let Some(bar) = &panel.bar {
        let mut wide = Canvas::new(full, height, PAPER)?;
        wide.paste(0, 0, &canvas);
        draw_bar(&mut wide, bar, size, strip);
        return Ok(wide);
    }
    Ok(canvas)
}

fn draw_marker(canvas: &mut Canvas, marker: &Marker, at: [f64; 2], alpha: f64) {
    let r = marker.radius;
    match marker.symbol {
        Symbol::Dot => {
            canvas.polyline(&[at], 2.0 * r + 1.6, [1.0; 3], 0.8 * alpha);
            canvas.polyline(&[at], 2.0 * r, marker.color, alpha);
        }
        Symbol::Cross => {
            for d in [[r, r], [r, -r]] {
                let ends = [[at[0] - d[0], at[1] - d[1]], [at[0] + d[0], at[1] + d[1]]];
                canvas.polyline(&ends, 1.6, marker.color, alpha);
            }
        }
        Symbol::Ring => {
            let circle: Vec<[f64; 2]> = (0..=24)
                .map(|i| {
                    let (s, c) = (std::f64::consts::TAU * f64::from(i) / 24.0).sin_cos();
                    [at[0] + r * c, at[1] + r * s]
                })
                .collect();
            canvas.polyline(&circle, 1.6, marker.color, alpha);
        }
    }
}

fn draw_bar(canvas: &mut Canvas, bar: &ScalarBar, size: f64, strip: usize) {
    let (w, h) = (canvas.width() as f64, canvas.height() as f64);
    let small = (0.8 * size).max(7.0);
    let (top, bottom) = (0.12 * h, 0.94 * h);
    let left = w - strip as f64 + 0.8 * small;
    let right = left + 1.3 * small;
    let span = bar.range[1] - bar.range[0];
    let steps = (bottom - top).max(1.0) as usize;
    canvas.rectangle([left - 1.0, top - 1.0], [right + 1.0, bottom + 1.0], INK);
    for i in 0..steps {
        let y = top + i as f64;
        let value = 1.0 - (i as f64 + 0.5) / steps as f64;
        canvas.rectangle([left, y], [right, y + 1.0], bar.map.color(value));
    }
    for value in ticks(bar.range, 5) {
        let y = if span > 0.0 {
            bottom - (value - bar.range[0]) / span * (bottom - top)
        } else {
            bottom
        };
        canvas.polyline(&[[right + 1.0, y], [right + 4.0, y]], 1.0, INK, 1.0);
        let at = [right + 0.7 * small, y + 0.5 * small];
        canvas.text(&tick_text(value, span), at, small, INK);
    }
    let room = (strip as f64 - small) / Canvas::text_width(&bar.label, small).max(1.0);
    canvas.text(
        &bar.label,
        [left, top - 1.2 * small],
        small * room.min(1.0),
        INK,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, ColorMap, Layer, Paint};

    fn picture() -> Canvas {
        let points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.3],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, f64::NAN],
        ];
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let values = [0.0, 1.0, 2.0, 3.0];
        let camera = Camera::framing(&points, 10.0, 5.0).unwrap();
        let scalar = Paint::Scalar {
            values: &values,
            range: [0.0, 3.0],
            map: ColorMap::Violet,
        };
        let bar = ScalarBar {
            label: "x (mm)".into(),
            range: [0.0, 3.0],
            map: ColorMap::Violet,
        };
        let panel = Panel::new("values", camera)
            .layer(Layer::new(&points, &triangles, scalar).with_edges())
            .dots(&points, [0.8, 0.1, 0.1], 3.0)
            .bar(bar);
        let plain = Panel::new("plain", camera).layer(Layer::new(
            &points,
            &triangles,
            Paint::Uniform([0.5; 3]),
        ));
        Sheet::new("sheet")
            .titled_row("row", vec![panel, plain])
            .draw(220, 180)
            .unwrap()
    }

    #[test]
    fn a_sheet_has_many_colours_and_always_the_same_bytes() {
        let one = picture();
        let mut colors: Vec<[u8; 3]> = one.pixels().to_vec();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() > 500, "{} colors", colors.len());
        let alone = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        assert_eq!(
            one.to_png().unwrap(),
            alone.install(picture).to_png().unwrap()
        );
    }

    #[test]
    fn wrong_input_is_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let camera = Camera::framing(&points, 0.0, 0.0).unwrap();
        let draw = |triangles: &[[u32; 3]], paint: Paint<'_>| {
            let panel = Panel::new("", camera).layer(Layer::new(&points, triangles, paint));
            Sheet::new("").row(vec![panel]).draw(40, 40).map(|_| ())
        };
        let uniform = Paint::Uniform([0.5; 3]);
        assert!(draw(&[[0, 1, 2]], uniform).is_ok());
        assert!(matches!(
            draw(&[[0, 1, 3]], uniform),
            Err(PictureError::IndexOutOfRange { point: 3, .. })
        ));
        assert!(matches!(
            draw(&[[0, 1, 2]], Paint::PerVertex(&[[0.0; 3]])),
            Err(PictureError::WrongLength {
                found: 1,
                expected: 3,
                ..
            })
        ));
        assert!(matches!(
            Sheet::new("").draw(40, 40),
            Err(PictureError::EmptySheet)
        ));
    }
}
