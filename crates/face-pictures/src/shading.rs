//! Light: a warm key light, a cool fill, a rim light from behind and a soft ambient term.

use fem_solvers::parallel;

use super::camera::OnScreen;
use super::canvas::Canvas;
use super::colormap::{to_linear, to_srgb};
use super::occlusion::ambient_light;
use super::panel::{Edges, Layer, Paint};
use super::raster::{Hit, NOTHING, rasterize};
use super::{Camera, PictureError, corner_normals};

/// Samples a side of each pixel.
const SAMPLES: usize = 3;

/// The finished surfaces of a panel and the depth of each pixel, infinite for the background.
pub(super) struct Shaded {
    pub canvas: Canvas,
    pub depth: Vec<f32>,
}

pub(super) fn shade(
    layers: &[Layer<'_>],
    camera: &Camera,
    width: usize,
    height: usize,
) -> Result<Shaded, PictureError> {
    for layer in layers {
        layer.check()?;
    }
    let mut canvas = Canvas::new(width, height, [1.0; 3])?;
    let view = View::of(layers, camera, width, height);
    let count = width * height;
    // Ambient light at one sample per pixel.
    let depth: Vec<f32> = (0..count).map(|i| view.center(i).depth).collect();
    let normal = |i: usize| {
        if depth[i].is_finite() {
            view.normal(view.center(i))
        } else {
            [0.0, 0.0, 1.0]
        }
    };
    let normals: Vec<[f32; 3]> = (0..count).map(normal).collect();
    let pixel = camera.pixel(width, height) as f32;
    let radius = 0.09 * camera.half_height as f32;
    let ambient = ambient_light(&depth, &normals, width, height, pixel, radius);
    let color = |i: usize| view.pixel(i, ambient[i], 4.0 * pixel);
    let colors: Vec<[f32; 3]> = parallel::indexed(count, color);
    for (i, &c) in colors.iter().enumerate() {
        canvas.put(i % width, i / width, c);
    }
    Ok(Shaded { canvas, depth })
}

/// What every sample of a picture hits.
struct View<'a> {
    layers: &'a [Layer<'a>],
    width: usize,
    height: usize,
    /// The projected points of each layer.
    projected: Vec<Vec<OnScreen>>,
    /// The normals at the corners of each layer's triangles.
    normals: Vec<Vec<[[f32; 3]; 3]>>,
    hits: Vec<Hit>,
    /// Of the camera.
    axes: [[f32; 3]; 3],
}

impl<'a> View<'a> {
    fn of(layers: &'a [Layer<'a>], camera: &Camera, width: usize, height: usize) -> Self {
        let (w, h) = (width * SAMPLES, height * SAMPLES);
        let project = camera.projection(w, h);
        let of_layer = |l: &Layer| l.points.iter().map(|&p| project(p)).collect();
        let projected: Vec<Vec<OnScreen>> = layers.iter().map(of_layer).collect();
        let normals = layers.iter();
        let normals = normals.map(|l| corner_normals(l.points, l.triangles, l.crease_degrees));
        Self {
            layers,
            width,
            height,
            normals: normals.collect(),
            hits: rasterize(layers, &projected, w, h),
            projected,
            axes: camera.axes().map(|a| a.map(|x| x as f32)),
        }
    }

    /// A sample of a pixel.
    fn sample(&self, pixel: usize, sx: usize, sy: usize) -> &Hit {
        let (x, y) = (pixel % self.width, pixel / self.width);
        &self.hits[(y * SAMPLES + sy) * self.width * SAMPLES + x * SAMPLES + sx]
    }

    /// The one near the middle of a pixel.
    fn center(&self, pixel: usize) -> &Hit {
        self.sample(pixel, 1, 1)
    }

    /// Toward the viewer, along the camera's axes.
    fn normal(&self, hit: &Hit) -> [f32; 3] {
        let corners = self.normals[hit.layer as usize][hit.triangle as usize];
        let n = blend(corners, hit.weights);
        let v = self.axes.map(|a| a[0] * n[0] + a[1] * n[1] + a[2] * n[2]);
        unit(if v[2] < 0.0 { v.map(|x| -x) } else { v })
    }

    /// The color of a sample, linear.
    fn color(&self, hit: &Hit, pixel: usize, ambient: f32) -> [f32; 3] {
        if hit.layer == NOTHING {
            let (x, y) = (pixel % self.width, pixel / self.width);
            return background(x as f32 / self.width as f32, y as f32 / self.height as f32);
        }
        let layer = &self.layers[hit.layer as usize];
        let mut albedo = albedo(layer, hit);
        if layer.edges == Edges::Shown {
            let line = edge(layer, &self.projected[hit.layer as usize], hit);
            albedo = albedo.map(|a| a * (1.0 - 0.6 * line));
        }
        light(albedo, self.normal(hit), ambient, layer.gloss)
    }

    /// The color of a pixel; one sample is enough where depths differ by less than `step`.
    fn pixel(&self, i: usize, ambient: f32, step: f32) -> [f32; 3] {
        let (x, y) = (i % self.width, i / self.width);
        if plain(&self.hits, self.width * SAMPLES, x, y, self.layers, step) {
            return self.color(self.center(i), i, ambient).map(to_srgb);
        }
        let mut sum = [0.0; 3];
        for sy in 0..SAMPLES {
            for sx in 0..SAMPLES {
                let c = self.color(self.sample(i, sx, sy), i, ambient);
                for k in 0..3 {
                    sum[k] += c[k];
                }
            }
        }
        sum.map(|s| to_srgb(s / (SAMPLES * SAMPLES) as f32))
    }
}

/// Whether all samples of a pixel see one smooth piece of surface, so that one of them will do.
fn plain(hits: &[Hit], width: usize, x: usize, y: usize, layers: &[Layer<'_>], step: f32) -> bool {
    let first = &hits[y * SAMPLES * width + x * SAMPLES];
    if first.layer == NOTHING || layers[first.layer as usize].edges == Edges::Shown {
        return false;
    }
    let mut range = [first.depth; 2];
    for row in 0..SAMPLES {
        let at = (y * SAMPLES + row) * width + x * SAMPLES;
        for hit in &hits[at..at + SAMPLES] {
            if hit.layer != first.layer {
                return false;
            }
            range = [range[0].min(hit.depth), range[1].max(hit.depth)];
        }
    }
    range[1] - range[0] < step
}

fn background(x: f32, y: f32) -> [f32; 3] {
    let r = (x - 0.5).hypot(0.8 * (y - 0.42));
    let v = 0.86 - 0.34 * r * r;
    [0.985 * v, v, 1.02 * v]
}

fn albedo(layer: &Layer<'_>, hit: &Hit) -> [f32; 3] {
    let t = layer.triangles[hit.triangle as usize].map(|i| i as usize);
    let srgb = match layer.paint {
        Paint::Uniform(c) => c,
        Paint::PerVertex(colors) => blend(t.map(|i| colors[i]), hit.weights),
        Paint::Scalar { values, range, map } => {
            let [w1, w2] = hit.weights.map(f64::from);
            let v = (1.0 - w1 - w2) * values[t[0]] + w1 * values[t[1]] + w2 * values[t[2]];
            map.color((v - range[0]) / (range[1] - range[0]))
        }
        Paint::Pattern { coordinates, color } => {
            let [w1, w2] = hit.weights.map(f64::from);
            let [a, b, c] = t.map(|i| coordinates[i]);
            color([0, 1, 2].map(|k| (1.0 - w1 - w2) * a[k] + w1 * b[k] + w2 * c[k]))
        }
    };
    srgb.map(to_linear)
}

/// Light towards the camera from a point with a view-space normal, in linear colors.
fn light(albedo: [f32; 3], n: [f32; 3], open: f32, gloss: f32) -> [f32; 3] {
    // Direction, color, and how far the light wraps around the terminator; red goes farther in
    // skin than blue.
    const LIGHTS: [([f32; 3], [f32; 3]); 3] = [
        ([-0.50, 0.56, 0.66], [0.94, 0.90, 0.83]),
        ([0.78, 0.12, 0.61], [0.25, 0.28, 0.33]),
        ([0.70, 0.50, -0.51], [0.30, 0.31, 0.34]),
    ];
    const WRAP: [f32; 3] = [0.28, 0.16, 0.12];
    let mut out = [0.0; 3];
    let mut shine = 0.0;
    for (d, color) in LIGHTS {
        let cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
        for k in 0..3 {
            let wrapped = ((cosine + WRAP[k]) / (1.0 + WRAP[k])).max(0.0);
            out[k] += albedo[k] * color[k] * wrapped * (0.45 + 0.55 * open);
        }
        let half = unit([d[0], d[1], d[2] + 1.0]);
        let s = (n[0] * half[0] + n[1] * half[1] + n[2] * half[2]).max(0.0);
        shine += color[1] * cosine.max(0.0) * (0.22 * s.powi(18) + 0.25 * s.powi(70));
    }
    let up = 0.5 + 0.5 * n[1];
    let sky = [0.20 + 0.14 * up, 0.19 + 0.16 * up, 0.19 + 0.18 * up];
    let grazing = (1.0 - n[2].clamp(0.0, 1.0)).powi(4);
    for k in 0..3 {
        // Light lost in folds of skin comes back a little redder.
        let tint = open.powf([0.8, 1.1, 1.2][k]);
        out[k] += albedo[k] * sky[k] * tint + gloss * shine * open + 0.10 * gloss * grazing * open;
    }
    out
}

/// 1 on an edge of the triangle, 0 from about one pixel away.
fn edge(layer: &Layer<'_>, projected: &[OnScreen], hit: &Hit) -> f32 {
    let c = layer.triangles[hit.triangle as usize].map(|i| projected[i as usize]);
    let area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    let [w1, w2] = hit.weights.map(f64::from);
    let weights = [1.0 - w1 - w2, w1, w2];
    let nearest = (0..3)
        .map(|k| {
            let (a, b) = (c[(k + 1) % 3], c[(k + 2) % 3]);
            weights[k] * area.abs() / (a.x - b.x).hypot(a.y - b.y).max(1e-9)
        })
        .fold(f64::INFINITY, f64::min);
    let half = 0.35 * SAMPLES as f64;
    (1.0 - (nearest - half) / half).clamp(0.0, 1.0) as f32
}

fn blend(corners: [[f32; 3]; 3], weights: [f32; 2]) -> [f32; 3] {
    let first = 1.0 - weights[0] - weights[1];
    [0, 1, 2]
        .map(|k| first * corners[0][k] + weights[0] * corners[1][k] + weights[1] * corners[2][k])
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if length > 0.0 {
        v.map(|x| x / length)
    } else {
        [0.0, 0.0, 1.0]
    }
}
