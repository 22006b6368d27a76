//! The signed distance of a triangle surface, sampled on a grid and twice continuously differentiable.

use super::geometry::{Aabb, Point, norm};
use super::solid::Solid;
use crate::error::AssemblyError;
use fem_kinematics::Mat;
use fem_solvers::parallel::map;

/// Most samples of a surface: 0.5 GB once made, several times that while they are made.
const MOST_SAMPLES: f64 = 6.4e7;

/// Neighbors on both sides of a face at right angles to the grid have distances that add up to the
/// spacing but for rounding.
const ROUNDED: f64 = 1.001;
/// Size of the triangles that close holes, in spacings: what they follow is smooth.
const LID: f64 = 2.0;
/// Room for rounding in how far a node can be.
const FARTHER: f64 = 1.0 + 1e-9;

/// φ of a solid with a surface of triangles, meters, negative inside.
///
/// The exact distance at the nodes of a grid becomes the coefficients of a tricubic B-spline by the
/// quasi-interpolant c = (−f₋₁ + 8 f₀ − f₊₁)/6 along each axis, which reproduces cubics: φ is twice
/// continuously differentiable, and its error is of fourth order in the spacing where the surface is
/// smooth, a tenth of the spacing at edges. Inside is where the surface goes round more than half
/// (parts may overlap). Holes are closed where the open surface goes round a half, which is the plane of
/// a plane hole: inside is what a winding number of the open surface above a half says, with a distance.
///
/// ```
/// use fem_assembly::SampledDistance;
/// let cube = fem_assembly::mesh::kuhn_grid(4, 4, 4, [0.04; 3])?;
/// let phi = SampledDistance::new(cube.nodes(), &cube.boundary().faces, 1e-3, 4e-3)?;
/// let at = phi.jet([0.02, 0.02, 0.042]).expect("near");
/// assert!((at.value - 2e-3).abs() < 1e-9 && (at.gradient[2] - 1.0).abs() < 1e-9);
/// assert!(phi.jet([0.1; 3]).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SampledDistance {
    origin: Point,
    spacing: f64,
    size: [usize; 3],
    /// z runs fastest.
    coefficients: Vec<f64>,
    /// |∇φ| is nowhere more.
    steepest: f64,
    /// φ is nowhere less at the border of what is sampled, meters.
    border: f64,
}

/// A function at a point with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// φ, meters.
    pub value: f64,
    /// ∇φ.
    pub gradient: [f64; 3],
    /// ∇²φ, 1/m.
    pub hessian: Mat<f64, 3>,
}

impl SampledDistance {
    /// Samples the distance of a surface (points in meters) every `spacing` meters, up to at least
    /// `reach` meters around it.
    ///
    /// # Errors
    /// When there is no triangle, a triangle names a point that does not exist, a number is not
    /// finite or not positive, or the grid would have more than 64 million nodes.
    pub fn new(
        points: &[[f64; 3]],
        triangles: &[[u32; 3]],
        spacing: f64,
        reach: f64,
    ) -> Result<Self, AssemblyError> {
        for (what, value) in [
            ("the spacing of a distance", spacing),
            ("the reach of a distance", reach),
            (
                "the number of triangles of a surface",
                triangles.len() as f64,
            ),
        ] {
            if !(value > 0.0 && value < f64::INFINITY) {
                return Err(AssemblyError::UnusableContact { what, value });
            }
        }
        let count = points.len();
        if let Some(&node) = triangles
            .as_flattened()
            .iter()
            .find(|&&n| n as usize >= count)
        {
            let node = node as usize;
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        if let Some(index) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            let what = "point of a surface";
            return Err(AssemblyError::NotFinite { what, index });
        }
        let named = || triangles.as_flattened().iter().map(|&n| points[n as usize]);
        cells(Aabb::around(named()), spacing, reach)?;
        let whole = Solid::new(points, triangles, LID * spacing);
        let (around, lengths) = cells(whole.bounds(), spacing, reach)?;
        // Even beyond both ends, so that the mirror image of a closed surface has that of its distances.
        let origin = |i: usize| 0.5 * (around.low[i] + around.high[i] - spacing * lengths[i]);
        let grid = Self {
            origin: std::array::from_fn(origin),
            spacing,
            size: lengths.map(|l| l as usize + 1),
            coefficients: Vec::new(),
            steepest: f64::INFINITY,
            border: f64::NEG_INFINITY,
        };
        let coefficients = grid.coefficients(grid.sampled(&whole));
        let mut made = Self {
            coefficients,
            ..grid
        };
        (made.steepest, made.border) = made.bounds();
        Ok(made)
    }

    /// Values and slopes of a B-spline are means of coefficients and of their differences.
    fn bounds(&self) -> (f64, f64) {
        let [_, y, z] = self.size;
        let mut steepest = [0.0_f64; 3];
        let mut border = f64::INFINITY;
        for (k, &coefficient) in self.coefficients.iter().enumerate() {
            let places = [k / (y * z), k / z % y, k % z];
            for (axis, stride) in [y * z, z, 1].into_iter().enumerate() {
                if places[axis] > 0 {
                    let difference = coefficient - self.coefficients[k - stride];
                    steepest[axis] = steepest[axis].max(difference.abs());
                }
                if places[axis] < 3 || places[axis] + 3 >= self.size[axis] {
                    border = border.min(coefficient);
                }
            }
        }
        (norm(steepest) / self.spacing, border)
    }

    /// How far from x at least nothing has φ < d, meters; 0 where that is not known.
    pub(crate) fn clear_way(&self, x: [f64; 3], d: f64) -> f64 {
        if let Some(value) = self.value(x) {
            return ((value - d) / self.steepest).max(0.0);
        }
        let beyond = |i: usize| {
            let low = self.origin[i] + self.spacing;
            let high = self.origin[i] + self.spacing * (self.size[i] - 2) as f64;
            (low - x[i]).max(x[i] - high).max(0.0)
        };
        let to_border = norm(std::array::from_fn(beyond));
        to_border + ((self.border - d) / self.steepest).max(0.0)
    }

    fn node(&self, index: usize) -> Point {
        let [_, y, z] = self.size;
        let places = [index / (y * z), index / z % y, index % z];
        std::array::from_fn(|i| self.origin[i] + self.spacing * places[i] as f64)
    }

    /// φ at the nodes.
    fn sampled(&self, whole: &Solid) -> Vec<f64> {
        let [outer, idle] = whole.parted(0.02 * self.spacing);
        let count: usize = self.size.iter().product();
        let distances = self.distances(&outer);
        // What separates nothing closes gaps: sides are told apart by all triangles.
        let to_any: Vec<f64> = map((0..count).collect(), |k: usize| {
            idle.distance_below(self.node(k), distances[k])
        });
        let groups = self.groups(&to_any);
        let inside = |k: usize| groups[k] == k as u32 && whole.winding(self.node(k)) > 0.5;
        let inside: Vec<bool> = map((0..count).collect(), inside);
        let signed = |(d, group): (&f64, &u32)| if inside[*group as usize] { -d } else { *d };
        distances.iter().zip(&groups).map(signed).collect()
    }

    /// How far the nodes are from a surface. A node is no farther from it than its neighbor and the
    /// spacing, so most triangles need no look.
    fn distances(&self, solid: &Solid) -> Vec<f64> {
        let [x, y, z] = self.size;
        let row = |row: usize| {
            let mut before = f64::INFINITY;
            let along = |k: usize| {
                let bound = FARTHER * (before + self.spacing);
                before = solid.distance_below(self.node(row * z + k), bound);
                before
            };
            (0..z).map(along).collect()
        };
        let rows: Vec<Vec<f64>> = map((0..x * y).collect(), row);
        rows.into_iter().flatten().collect()
    }

    /// The first node of those that are on the same side as each node: no surface is between
    /// neighbors whose distances add up to more than the spacing.
    fn groups(&self, distances: &[f64]) -> Vec<u32> {
        fn root(parents: &mut [u32], mut k: u32) -> u32 {
            while parents[k as usize] != k {
                parents[k as usize] = parents[parents[k as usize] as usize];
                k = parents[k as usize];
            }
            k
        }
        let [_, y, z] = self.size;
        let mut parents: Vec<u32> = (0..distances.len() as u32).collect();
        for k in 0..distances.len() {
            let before = [(k / (y * z), y * z), (k / z % y, z), (k % z, 1)];
            for (_, stride) in before.into_iter().filter(|(place, _)| *place > 0) {
                if distances[k] + distances[k - stride] > ROUNDED * self.spacing {
                    let a = root(&mut parents, k as u32);
                    let b = root(&mut parents, (k - stride) as u32);
                    parents[a.max(b) as usize] = a.min(b);
                }
            }
        }
        (0..distances.len() as u32)
            .map(|k| root(&mut parents, k))
            .collect()
    }

    /// The quasi-interpolant, axis by axis; at the ends, which no evaluation reads, f itself.
    fn coefficients(&self, mut values: Vec<f64>) -> Vec<f64> {
        let [x, y, z] = self.size;
        for (stride, length) in [(1, z), (z, y), (y * z, x)] {
            let old = values.clone();
            for (k, value) in values.iter_mut().enumerate() {
                let place = k / stride % length;
                if place > 0 && place + 1 < length {
                    *value = (8.0 * old[k] - old[k - stride] - old[k + stride]) / 6.0;
                }
            }
        }
        values
    }

    /// The first of the 4 × 4 × 4 coefficients at a point, and the way from its second node in
    /// spacings.
    fn cell(&self, x: [f64; 3]) -> Option<(usize, Point)> {
        let u: Point = std::array::from_fn(|i| (x[i] - self.origin[i]) / self.spacing);
        let first = u.map(|u| u.floor() - 1.0);
        let within = |i: usize| first[i] >= 0.0 && first[i] + 4.0 <= self.size[i] as f64;
        if !(0..3).all(within) {
            return None;
        }
        let [i, j, k] = first.map(|f| f as usize);
        let start = (i * self.size[1] + j) * self.size[2] + k;
        Some((start, std::array::from_fn(|i| u[i] - first[i] - 1.0)))
    }

    /// φ alone, meters; `None` farther away than the grid reaches, and for NaN.
    pub fn value(&self, x: [f64; 3]) -> Option<f64> {
        let (start, t) = self.cell(x)?;
        let [a, b, c] = t.map(|t| weights(t)[0]);
        let mut sum = 0.0;
        for (i, wi) in a.iter().enumerate() {
            for (j, wj) in b.iter().enumerate() {
                let row = start + (i * self.size[1] + j) * self.size[2];
                let along: f64 = (0..4).map(|k| c[k] * self.coefficients[row + k]).sum();
                sum += wi * wj * along;
            }
        }
        Some(sum)
    }

    /// φ with its derivatives; `None` farther away than the grid reaches, and for NaN.
    pub fn jet(&self, x: [f64; 3]) -> Option<Jet> {
        let (start, t) = self.cell(x)?;
        let [a, b, c] = t.map(weights);
        let mut sums = [0.0; 10];
        for i in 0..4 {
            for j in 0..4 {
                let row = start + (i * self.size[1] + j) * self.size[2];
                let mut along = [0.0; 3];
                for k in 0..4 {
                    let f = self.coefficients[row + k];
                    (0..3).for_each(|order| along[order] += c[order][k] * f);
                }
                let orders = [
                    (0, 0, 0),
                    (1, 0, 0),
                    (0, 1, 0),
                    (0, 0, 1),
                    (2, 0, 0),
                    (0, 2, 0),
                    (0, 0, 2),
                    (1, 1, 0),
                    (1, 0, 1),
                    (0, 1, 1),
                ];
                for (sum, (p, q, r)) in sums.iter_mut().zip(orders) {
                    *sum += a[p][i] * b[q][j] * along[r];
                }
            }
        }
        let (h, square) = (self.spacing, self.spacing * self.spacing);
        let [value, x, y, z, xx, yy, zz, xy, xz, yz] = sums;
        Some(Jet {
            value,
            gradient: [x / h, y / h, z / h],
            hessian: Mat([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).scale(1.0 / square),
        })
    }
}

/// What is sampled around a surface, and its cells along each axis.
fn cells(surface: Aabb, spacing: f64, reach: f64) -> Result<(Aabb, Point), AssemblyError> {
    let around = surface.grown(reach + 3.0 * spacing);
    let lengths: Point =
        std::array::from_fn(|i| ((around.high[i] - around.low[i]) / spacing).ceil());
    let samples: f64 = lengths.iter().map(|l| l + 1.0).product();
    if !(samples < MOST_SAMPLES) {
        let what = "the number of samples of a distance (below 6.4e7; choose a wider spacing)";
        return Err(AssemblyError::UnusableContact {
            what,
            value: samples,
        });
    }
    Ok((around, lengths))
}

/// The four cubic B-splines that are not 0 at t of a cell, with first and second derivatives.
fn weights(t: f64) -> [[f64; 4]; 3] {
    let s = 1.0 - t;
    let inner = |t: f64| (3.0 * t - 6.0) * t * t + 4.0;
    [
        [
            s * s * s / 6.0,
            inner(t) / 6.0,
            inner(s) / 6.0,
            t * t * t / 6.0,
        ],
        [
            -0.5 * s * s,
            (1.5 * t - 2.0) * t,
            (2.0 - 1.5 * s) * s,
            0.5 * t * t,
        ],
        [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
    ]
}
