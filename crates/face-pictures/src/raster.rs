//! Which triangle is seen where: a z-buffer that keeps barycentric coordinates.

use fem_solvers::parallel;

use super::Layer;
use super::camera::OnScreen;

pub(super) const NOTHING: u32 = u32::MAX;

/// The nearest surface point of one sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub layer: u32,
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub weights: [f32; 2],
    /// Distance along the line of sight.
    pub depth: f32,
}

const MISS: Hit = Hit {
    layer: NOTHING,
    triangle: 0,
    weights: [0.0; 2],
    depth: f32::INFINITY,
};

/// Rows of a band; fixed so that the result does not depend on the number of threads.
const BAND: usize = 32;

/// Hits of all samples, row by row. `projected` holds the projected points of each layer.
pub(super) fn rasterize(
    layers: &[Layer<'_>],
    projected: &[Vec<OnScreen>],
    width: usize,
    height: usize,
) -> Vec<Hit> {
    let mut hits = vec![MISS; width * height];
    parallel::each(hits.chunks_mut(BAND * width).enumerate(), |(band, rows)| {
        let first = band * BAND;
        for (l, layer) in layers.iter().enumerate() {
            for (t, triangle) in layer.triangles.iter().enumerate() {
                let corners = triangle.map(|i| projected[l][i as usize]);
                fill(rows, width, first, corners, l as u32, t as u32);
            }
        }
    });
    hits
}

fn fill(rows: &mut [Hit], width: usize, first: usize, c: [OnScreen; 3], layer: u32, triangle: u32) {
    let count = rows.len() / width;
    let (low_y, high_y) = (
        c[0].y.min(c[1].y).min(c[2].y),
        c[0].y.max(c[1].y).max(c[2].y),
    );
    // Written so that a coordinate that is not a number is skipped as well.
    if !(high_y >= first as f64 && low_y <= (first + count) as f64) {
        return;
    }
    if !c
        .iter()
        .all(|p| p.x.is_finite() && p.depth > 0.0 && p.depth.is_finite())
    {
        return;
    }
    let area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    if !(area.abs() > 1e-12) {
        return;
    }
    let (low_x, high_x) = (
        c[0].x.min(c[1].x).min(c[2].x),
        c[0].x.max(c[1].x).max(c[2].x),
    );
    let clip = |v: f64, n: usize| v.clamp(0.0, n as f64) as usize;
    let xs = clip((low_x - 0.5).ceil(), width)..clip((high_x - 0.5).floor() + 1.0, width);
    let top = clip((low_y - 0.5).ceil() - first as f64, count);
    let bottom = clip((high_y - 0.5).floor() + 1.0 - first as f64, count);
    let inverse_depth = c.map(|p| 1.0 / p.depth);
    for row in top..bottom {
        let y = (first + row) as f64 + 0.5;
        for x in xs.clone() {
            let px = x as f64 + 0.5;
            let l1 = ((px - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (y - c[0].y)) / area;
            let l2 = ((c[1].x - c[0].x) * (y - c[0].y) - (px - c[0].x) * (c[1].y - c[0].y)) / area;
            let l0 = 1.0 - l1 - l2;
            if !(l0 >= 0.0 && l1 >= 0.0 && l2 >= 0.0) {
                continue;
            }
            // Perspective: 1/depth is what is linear on the screen.
            let s = l0 * inverse_depth[0] + l1 * inverse_depth[1] + l2 * inverse_depth[2];
            let depth = (1.0 / s) as f32;
            let hit = &mut rows[row * width + x];
            if depth < hit.depth {
                let weights = [
                    (l1 * inverse_depth[1] / s) as f32,
                    (l2 * inverse_depth[2] / s) as f32,
                ];
                *hit = Hit {
                    layer,
                    triangle,
                    weights,
                    depth,
                };
            }
        }
    }
}
