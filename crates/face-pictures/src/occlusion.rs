//! Soft ambient occlusion from the depth of a picture.

use fem_solvers::parallel;

const RINGS: usize = 5;
const SPOKES: usize = 8;

/// Share of the ambient light that reaches each pixel, in `[0, 1]`.
///
/// `depth` (infinite where nothing is seen) and `pixel` (world units per pixel) give positions;
/// occluders count within `radius` world units. A tap at a horizontal distance r that stands out by
/// h towards the camera above the tangent plane hides light in proportion to its elevation.
pub(super) fn ambient_light(
    depth: &[f32],
    normals: &[[f32; 3]],
    width: usize,
    height: usize,
    pixel: f32,
    radius: f32,
) -> Vec<f32> {
    let reach = (radius / pixel).max(2.0);
    let raw: Vec<f32> = parallel::indexed(width * height, |i| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        if !depth[i].is_finite() {
            return 1.0;
        }
        // A 4 x 4 pattern of rotations and ring offsets, averaged away below.
        let cell = (i % width % 4) * 4 + (i / width) % 4;
        let turn = (cell * 7 % 16) as f32 / 16.0;
        let offset = (cell * 11 % 16) as f32 / 16.0;
        let n = normals[i];
        let mut hidden = 0.0;
        for ring in 0..RINGS {
            let r = reach * ((ring as f32 + 0.2 + 0.8 * offset) / RINGS as f32).powi(2);
            for spoke in 0..SPOKES {
                let angle = std::f32::consts::TAU * (spoke as f32 + turn) / SPOKES as f32;
                let (sx, sy) = (x + r * angle.cos(), y + r * angle.sin());
                if !(sx >= 0.0 && sy >= 0.0 && sx < width as f32 && sy < height as f32) {
                    continue;
                }
                let j = sy as usize * width + sx as usize;
                if !depth[j].is_finite() || j == i {
                    continue;
                }
                let v = [
                    ((j % width) as f32 - x) * pixel,
                    (y - (j / width) as f32) * pixel,
                    depth[i] - depth[j],
                ];
                let d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
                let d = d2.sqrt();
                let rise = (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]) / d - 0.12;
                let fade = (1.0 - d2 / (4.0 * radius * radius)).max(0.0);
                hidden += rise.max(0.0) * fade;
            }
        }
        (1.0 - 1.9 * hidden / (RINGS * SPOKES) as f32).clamp(0.0, 1.0)
    });
    smoothed(&raw, depth, width, height, pixel)
}

/// The mean over the 4 x 4 pattern, over pixels of about the same depth only.
fn smoothed(raw: &[f32], depth: &[f32], width: usize, height: usize, pixel: f32) -> Vec<f32> {
    parallel::indexed(width * height, |i| {
        if !depth[i].is_finite() {
            return 1.0;
        }
        let (x, y) = (i % width, i / width);
        let (mut sum, mut weight) = (0.0, 0.0);
        for sy in y.saturating_sub(2)..(y + 2).min(height) {
            for sx in x.saturating_sub(2)..(x + 2).min(width) {
                let j = sy * width + sx;
                if (depth[j] - depth[i]).abs() < 6.0 * pixel {
                    sum += raw[j];
                    weight += 1.0;
                }
            }
        }
        if weight > 0.0 { sum / weight } else { raw[i] }
    })
}
