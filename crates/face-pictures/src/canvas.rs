//! A picture of sRGB pixels with antialiased lines, dots and text, and its PNG encoding.

use super::{PictureError, font};

/// An sRGB picture, 8 bits a channel, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    /// A picture of one color.
    ///
    /// # Errors
    /// [`PictureError::BadSize`] outside 16 to 16384 pixels a side.
    pub fn new(width: usize, height: usize, color: [f32; 3]) -> Result<Self, PictureError> {
        if !(16..=16384).contains(&width) || !(16..=16384).contains(&height) {
            return Err(PictureError::BadSize { width, height });
        }
        Ok(Self {
            width,
            height,
            pixels: vec![color.map(to_byte); width * height],
        })
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PictureError::Encoding`].
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Writes the picture as PNG: the file appears whole or not at all.
    ///
    /// # Errors
    /// [`PictureError::Encoding`] or [`PictureError::Write`].
    pub fn save(&self, path: &std::path::Path) -> Result<(), PictureError> {
        Ok(crate::export::write_atomically(path, &self.to_png()?)?)
    }

    pub(super) fn put(&mut self, x: usize, y: usize, color: [f32; 3]) {
        self.pixels[y * self.width + x] = color.map(to_byte);
    }

    fn blend(&mut self, x: usize, y: usize, color: [f32; 3], alpha: f64) {
        let pixel = &mut self.pixels[y * self.width + x];
        let a = alpha.clamp(0.0, 1.0) as f32;
        *pixel = [0, 1, 2].map(|k| to_byte(f32::from(pixel[k]) / 255.0 * (1.0 - a) + color[k] * a));
    }

    pub(super) fn rectangle(&mut self, low: [f64; 2], high: [f64; 2], color: [f32; 3]) {
        let range = |a: f64, b: f64, n: usize| {
            (a.round().clamp(0.0, n as f64) as usize)..(b.round().clamp(0.0, n as f64) as usize)
        };
        for y in range(low[1], high[1], self.height) {
            for x in range(low[0], high[0], self.width) {
                self.put(x, y, color);
            }
        }
    }

    /// Copies another picture to the place `(x, y)`, cutting off what sticks out.
    pub(super) fn paste(&mut self, x: usize, y: usize, other: &Canvas) {
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let n = other.width.min(self.width.saturating_sub(x));
            let to = (y + row) * self.width + x;
            self.pixels[to..to + n]
                .copy_from_slice(&other.pixels[row * other.width..row * other.width + n]);
        }
    }

    /// A round-ended line. Many segments of one stroke meet without darker joints because the
    /// coverage of the stroke is the maximum over its segments.
    pub(super) fn polyline(
        &mut self,
        points: &[[f64; 2]],
        width: f64,
        color: [f32; 3],
        alpha: f64,
    ) {
        let Some(first) = points.first() else { return };
        if !points.iter().flatten().all(|x| x.is_finite()) {
            return;
        }
        let reach = 0.5 * width + 1.0;
        let (mut low, mut high) = (*first, *first);
        for p in points {
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let bound = |v: f64, n: usize| v.clamp(0.0, n as f64) as usize;
        let xs = bound(low[0] - reach, self.width)..bound(high[0] + reach + 1.0, self.width);
        let ys = bound(low[1] - reach, self.height)..bound(high[1] + reach + 1.0, self.height);
        let one = [*first, *first];
        for y in ys {
            for x in xs.clone() {
                let p = [x as f64 + 0.5, y as f64 + 0.5];
                let segments = if points.len() == 1 { &one[..] } else { points };
                let nearest = segments
                    .windows(2)
                    .map(|s| distance_to_segment(p, s[0], s[1]))
                    .fold(f64::INFINITY, f64::min);
                let cover = (0.5 * width + 0.5 - nearest).clamp(0.0, 1.0).min(width);
                if cover > 0.0 {
                    self.blend(x, y, color, alpha * cover);
                }
            }
        }
    }

    /// Width in pixels of a text whose capitals are `size` pixels high.
    pub(super) fn text_width(text: &str, size: f64) -> f64 {
        font::strokes(text).1 * size
    }

    /// A text whose baseline starts at `at`; capitals are `size` pixels high.
    pub(super) fn text(&mut self, text: &str, at: [f64; 2], size: f64, color: [f32; 3]) {
        let (lines, _) = font::strokes(text);
        let pen = (0.13 * size).max(1.15);
        for line in lines {
            let points: Vec<[f64; 2]> = line
                .iter()
                .map(|p| [at[0] + p[0] * size, at[1] - p[1] * size])
                .collect();
            self.polyline(
                &points,
                if points.len() == 1 { 1.5 * pen } else { pen },
                color,
                1.0,
            );
        }
    }
}

fn to_byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let q = [p[0] - a[0], p[1] - a[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let t = if length2 > 0.0 {
        ((q[0] * d[0] + q[1] * d[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (q[0] - t * d[0]).hypot(q[1] - t * d[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_reads_back_the_same_pixels() {
        let mut canvas = Canvas::new(80, 30, [1.0, 1.0, 1.0]).unwrap();
        canvas.text("Ag 12", [4.0, 20.0], 12.0, [0.0; 3]);
        let bytes = canvas.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        assert_eq!(data, canvas.pixels().as_flattened());
        let dark = canvas.pixels().iter().filter(|p| p[0] < 80).count();
        assert!(
            (30..600).contains(&dark),
            "{dark} dark pixels in a short text"
        );
    }

    #[test]
    fn lines_outside_the_picture_or_not_finite_are_harmless() {
        let mut canvas = Canvas::new(16, 16, [0.5; 3]).unwrap();
        let before = canvas.clone();
        canvas.polyline(&[[-1e9, -50.0], [1e9, -40.0]], 2.0, [0.0; 3], 1.0);
        canvas.polyline(&[[f64::NAN, 3.0], [4.0, 4.0]], 2.0, [0.0; 3], 1.0);
        assert_eq!(canvas, before);
        assert!(Canvas::new(0, 5, [0.0; 3]).is_err());
    }
}
