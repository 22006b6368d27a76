//! From drawn strips of fibers to weights and directions per tet.

use fem_solvers::parallel;

use super::anatomy::{Extent, MUSCLES, Strips};
use super::form::{EYES, MOUTH};
use super::grid::Grid;
use face_rig::anatomy::FiberEntry;

/// Sample points of a tet a side; their number is 35.
const LATTICE: usize = 4;
/// Smaller shares are left out.
const SMALLEST_SHARE: f64 = 0.02;

/// Names of the muscles, all of the left side (`_L`), then those of the right side (`_R`).
pub(super) fn names() -> Vec<String> {
    ["L", "R"]
        .iter()
        .flat_map(|s| MUSCLES.iter().map(move |m| format!("{}_{s}", m.name)))
        .collect()
}

/// Entries sorted by tet, then by muscle; the shares of one tet sum to at most 1. A direction points
/// from the insertion to the origin, the way the skin is pulled; in the rings of eye and mouth it
/// runs along the ring.
pub(super) fn entries(
    grid: &Grid,
    nodes: &[[f64; 3]],
    tets: &[[u32; 4]],
    material: &[[f64; 3]],
) -> Vec<FiberEntry> {
    let lattice = lattice();
    let boxes: Vec<[[f64; 2]; 2]> = MUSCLES.iter().map(bounds).collect();
    let left: Vec<Vec<FiberEntry>> = parallel::indexed(tets.len(), |t| {
        let tet = &tets[t];
        let m = tet.map(|n| material[n as usize]);
        if !m.iter().any(|p| p[0] > 0.0) {
            return Vec::new();
        }
        let to_space = Map::new(m, tet.map(|n| nodes[n as usize]));
        let mut found: Vec<FiberEntry> = Vec::new();
        for (i, muscle) in MUSCLES.iter().enumerate() {
            let apart = (0..2).any(|k| {
                m.iter().all(|p| p[k] < boxes[i][0][k]) || m.iter().all(|p| p[k] > boxes[i][1][k])
            });
            let (share, along) = if apart {
                (0.0, [0.0; 3])
            } else {
                muscle_share(muscle, &m, &lattice)
            };
            if share >= SMALLEST_SHARE
                && let Some(direction) = to_space.direction(along)
            {
                found.push(FiberEntry {
                    tet: t as u32,
                    muscle: i as u32,
                    weight: share,
                    direction,
                });
            }
        }
        let sum: f64 = found.iter().map(|e| e.weight).sum();
        if sum > 1.0 {
            for entry in &mut found {
                entry.weight /= sum * (1.0 + 1e-12);
            }
        }
        found
    });
    let mut all: Vec<FiberEntry> = left.iter().flatten().copied().collect();
    all.extend(left.iter().flatten().map(|e| FiberEntry {
        tet: grid.mirror_tet(e.tet as usize) as u32,
        muscle: e.muscle + MUSCLES.len() as u32,
        weight: e.weight,
        direction: [-e.direction[0], e.direction[1], e.direction[2]],
    }));
    all.sort_by_key(|e| (e.tet, e.muscle));
    all
}

fn lattice() -> Vec<[f64; 4]> {
    let mut points = Vec::new();
    let n = LATTICE;
    for i in 0..=n {
        for j in 0..=n - i {
            for k in 0..=n - i - j {
                let l = n - i - j - k;
                points.push([i, j, k, l].map(|c| (c as f64 + 0.25) / (n as f64 + 1.0)));
            }
        }
    }
    points
}

fn bounds(muscle: &Strips) -> [[f64; 2]; 2] {
    let points = || muscle.paths.iter().flat_map(|p| p.iter());
    [
        [0, 1].map(|k| points().map(|p| p[k]).fold(f64::INFINITY, f64::min) - muscle.half_width),
        [0, 1]
            .map(|k| points().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) + muscle.half_width),
    ]
}

/// Share of the sample points inside, and the mean direction there in material coordinates.
fn muscle_share(muscle: &Strips, m: &[[f64; 3]; 4], lattice: &[[f64; 4]]) -> (f64, [f64; 3]) {
    let mut count = 0usize;
    let mut along = [0.0; 3];
    for weights in lattice {
        let p = [0, 1, 2].map(|k| (0..4).map(|c| weights[c] * m[c][k]).sum::<f64>());
        let allowed = match muscle.extent {
            Extent::Whole => true,
            Extent::AboveMouth => p[1] > MOUTH,
            Extent::BelowMouth => p[1] < MOUTH,
            Extent::AboveEyes => p[1] > EYES,
        };
        if allowed && let Some(d) = inside(muscle, p) {
            count += 1;
            for k in 0..3 {
                along[k] += d[k];
            }
        }
    }
    (count as f64 / lattice.len() as f64, along)
}

/// Direction of the nearest course at a material point, towards the origin, or `None` outside.
fn inside(muscle: &Strips, p: [f64; 3]) -> Option<[f64; 3]> {
    let mut best = (f64::INFINITY, 0.0, [0.0; 3]);
    for path in muscle.paths {
        let last = path.len() - 2;
        for (i, ends) in path.windows(2).enumerate() {
            let d = [0, 1, 2].map(|k| ends[1][k] - ends[0][k]);
            let q = [p[0] - ends[0][0], p[1] - ends[0][1]];
            let t = (q[0] * d[0] + q[1] * d[1]) / (d[0] * d[0] + d[1] * d[1]);
            let s = t.clamp(0.0, 1.0);
            let [x, y] = [q[0] - s * d[0], q[1] - s * d[1]];
            let mut square = x * x + y * y;
            // Ends are flatter than round: past them distance counts twice.
            if (i == 0 && t < 0.0) || (i == last && t > 1.0) {
                square *= 4.0;
            }
            if square < best.0 {
                let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
                best = (square, ends[0][2] + s * d[2], d.map(|x| -x / length));
            }
        }
    }
    let (square, w, along) = best;
    (square < muscle.half_width * muscle.half_width && (p[2] - w).abs() < muscle.half_depth)
        .then_some(along)
}

/// The linear map from material coordinates to space in a tet.
struct Map([[f64; 3]; 3]);

impl Map {
    fn new(m: [[f64; 3]; 4], x: [[f64; 3]; 4]) -> Self {
        let d = [1, 2, 3].map(|c| [0, 1, 2].map(|k| m[c][k] - m[0][k]));
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        // Rows of the inverse of the matrix whose columns are d.
        let rows = [cross(d[1], d[2]), cross(d[2], d[0]), cross(d[0], d[1])];
        let det: f64 = (0..3).map(|k| d[0][k] * rows[0][k]).sum();
        let mut map = [[0.0; 3]; 3];
        for c in 0..3 {
            for i in 0..3 {
                for k in 0..3 {
                    map[i][k] += (x[c + 1][i] - x[0][i]) * rows[c][k] / det;
                }
            }
        }
        Self(map)
    }

    fn direction(&self, along: [f64; 3]) -> Option<[f64; 3]> {
        let v = self
            .0
            .map(|row| row[0] * along[0] + row[1] * along[1] + row[2] * along[2]);
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        (length > 0.0 && length.is_finite()).then(|| v.map(|x| x / length))
    }
}
