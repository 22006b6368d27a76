//! Convex solids given by their signed distance φ: what bodies collide with.

use crate::mat::{Mat, Vector, dot};
use thiserror::Error;

/// A solid in D dimensions and its signed distance φ, meters: negative inside, zero on the surface.
///
/// ∇φ is the outward unit normal n and ∇²φ the curvature of the parallel surface through the point,
/// both exact wherever φ is smooth. It is not at a sphere's center, on a capsule's axis and where
/// two faces of a box are equally near from inside; there one of the normals is taken. ∇²φ jumps
/// where a flat part of the surface meets a round one. All solids are convex, so ∇²φ has no
/// negative eigenvalue.
///
/// ```
/// use fem_kinematics::ImplicitSurface;
/// let ball = ImplicitSurface::Sphere { center: [0.0, 0.0, 1.0], radius: 0.5 };
/// assert_eq!(ball.distance(&[0.0, 0.0, 2.0]), 0.5);
/// assert_eq!(ball.normal(&[0.0, 0.0, 2.0]), [0.0, 0.0, 1.0]);
/// assert_eq!(ball.curvature(&[0.0, 0.0, 2.0]).0[0][0], 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ImplicitSurface<const D: usize> {
    /// All points closer than `radius` to `center`.
    Sphere {
        /// Center, meters.
        center: [f64; D],
        /// Radius, meters.
        radius: f64,
    },
    /// All points x with `normal · (x − point) < 0`: everything behind a plane.
    HalfSpace {
        /// A point of the plane, meters.
        point: [f64; D],
        /// Unit normal; points out of the solid.
        normal: [f64; D],
    },
    /// An axis-aligned box.
    Box {
        /// Lowest corner, meters.
        min: [f64; D],
        /// Highest corner, meters.
        max: [f64; D],
    },
    /// All points closer than `radius` to the segment between two points.
    Capsule {
        /// Ends of the segment, meters.
        ends: [[f64; D]; 2],
        /// Radius, meters.
        radius: f64,
    },
}

/// A number that no distance can be computed with.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{what} of an obstacle is {value}, it must be {needed}")]
pub struct UnusableSurface {
    /// What it is.
    pub what: &'static str,
    /// Its value.
    pub value: f64,
    /// What it has to be.
    pub needed: &'static str,
}

impl<const D: usize> ImplicitSurface<D> {
    /// φ(x), meters; NaN for an x that is NaN.
    #[inline]
    pub fn distance(&self, x: &[f64; D]) -> f64 {
        match self {
            Self::Sphere { center, radius } => length(&difference(x, center)) - radius,
            Self::HalfSpace { point, normal } => {
                // Summed as n·(x − p): the difference of two dot products would lose digits.
                (0..D).map(|k| normal[k] * (x[k] - point[k])).sum()
            }
            Self::Box { min, max } => {
                let beyond = beyond(x, min, max);
                let outside = beyond.map(|b| if b < 0.0 { 0.0 } else { b });
                let inside = beyond.into_iter().fold(f64::NEG_INFINITY, larger);
                if inside < 0.0 {
                    inside
                } else {
                    length(&outside)
                }
            }
            Self::Capsule { ends, radius } => length(&from_segment(x, ends).0) - radius,
        }
    }

    /// n = ∇φ(x), of length 1.
    #[inline]
    pub fn normal(&self, x: &[f64; D]) -> [f64; D] {
        match self {
            Self::Sphere { center, .. } => {
                direction(&difference(x, center)).unwrap_or_else(|| axis(D - 1, 1.0))
            }
            Self::HalfSpace { normal, .. } => *normal,
            Self::Box { min, max } => {
                let outside = beyond(x, min, max).map(|b| if b > 0.0 { b } else { 0.0 });
                match direction(&outside) {
                    Some(n) => core::array::from_fn(|k| n[k] * side(x, min, max, k)),
                    None => {
                        let k = nearest_face(x, min, max);
                        axis(k, side(x, min, max, k))
                    }
                }
            }
            Self::Capsule { ends, .. } => {
                let (offset, _) = from_segment(x, ends);
                direction(&offset).unwrap_or_else(|| across(&difference(&ends[1], &ends[0])))
            }
        }
    }

    /// ∇²φ(x), 1/m.
    pub fn curvature(&self, x: &[f64; D]) -> Mat<f64, D> {
        match self {
            Self::Sphere { center, .. } => bent(
                Mat::identity(),
                self.normal(x),
                length(&difference(x, center)),
            ),
            Self::HalfSpace { .. } => Mat::zeros(),
            Self::Box { min, max } => {
                // Round about a corner or an edge, in the directions that leave the box.
                let out = beyond(x, min, max).map(|b| if b > 0.0 { b } else { 0.0 });
                let leaving = Mat::from_diagonal(out.map(|b| f64::from(b > 0.0)));
                let n = direction(&out).map(|_| self.normal(x)).unwrap_or([0.0; D]);
                bent(leaving, n, length(&out))
            }
            Self::Capsule { ends, .. } => {
                let (offset, beside) = from_segment(x, ends);
                let along = direction(&difference(&ends[1], &ends[0])).filter(|_| beside);
                let straight = along.map_or(Mat::zeros(), |u| Mat::outer(u, u));
                bent(Mat::identity() - straight, self.normal(x), length(&offset))
            }
        }
    }

    /// Refuses what no distance can be computed with.
    ///
    /// # Errors
    /// The first number that is not finite, radius or side of a box that is not positive, or length
    /// of a normal that differs from 1 by more than `unit_tolerance`.
    pub fn check(&self, unit_tolerance: f64) -> Result<(), UnusableSurface> {
        match self {
            Self::Sphere { center, radius } => {
                finite("a coordinate of the center", center)?;
                positive("the radius", *radius)
            }
            Self::HalfSpace { point, normal } => {
                finite("a coordinate of the point", point)?;
                let length = length(normal);
                let unit = (length - 1.0).abs() <= unit_tolerance;
                require(unit, "the length of the normal", length, "1")
            }
            Self::Box { min, max } => {
                finite("a coordinate of the lowest corner", min)?;
                finite("a coordinate of the highest corner", max)?;
                (0..D).try_for_each(|k| positive("a side of the box", max[k] - min[k]))
            }
            Self::Capsule { ends, radius } => {
                finite("a coordinate of an end", &ends[0])?;
                finite("a coordinate of an end", &ends[1])?;
                positive("the radius", *radius)
            }
        }
    }
}

fn require(
    holds: bool,
    what: &'static str,
    value: f64,
    needed: &'static str,
) -> Result<(), UnusableSurface> {
    let error = UnusableSurface {
        what,
        value,
        needed,
    };
    if holds { Ok(()) } else { Err(error) }
}

fn finite<const D: usize>(what: &'static str, place: &[f64; D]) -> Result<(), UnusableSurface> {
    let bad = place.iter().find(|x| !x.is_finite());
    bad.map_or(Ok(()), |&x| require(false, what, x, "finite"))
}

fn positive(what: &'static str, x: f64) -> Result<(), UnusableSurface> {
    let holds = x > 0.0 && x.is_finite();
    require(holds, what, x, "finite and greater than 0")
}

/// (I₊ − n nᵀ)/r, I₊ the directions in which the surface is round; 0 where r is 0.
fn bent<const D: usize>(round: Mat<f64, D>, n: [f64; D], r: f64) -> Mat<f64, D> {
    if r > 0.0 {
        (round - Mat::outer(n, n)).scale(1.0 / r)
    } else {
        Mat::zeros()
    }
}

#[inline]
fn difference<const D: usize>(a: &[f64; D], b: &[f64; D]) -> Vector<f64, D> {
    core::array::from_fn(|k| a[k] - b[k])
}

#[inline]
fn length<const D: usize>(v: &[f64; D]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

#[inline]
fn direction<const D: usize>(v: &[f64; D]) -> Option<[f64; D]> {
    let length = length(v);
    (length > 0.0).then(|| v.map(|c| c / length))
}

fn axis<const D: usize>(k: usize, sign: f64) -> [f64; D] {
    core::array::from_fn(|i| if i == k { sign } else { 0.0 })
}

/// A unit vector at right angles to `v`.
fn across<const D: usize>(v: &[f64; D]) -> [f64; D] {
    let Some(u) = direction(v) else {
        return axis(D - 1, 1.0);
    };
    let smallest = (0..D).fold(
        0,
        |best, k| if u[k].abs() < u[best].abs() { k } else { best },
    );
    let e: [f64; D] = axis(smallest, 1.0);
    let rest = core::array::from_fn(|k| e[k] - u[smallest] * u[k]);
    direction(&rest).unwrap_or(e)
}

/// The larger one, NaN before all others.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// How far x lies beyond the nearer of the two faces across each axis; negative between them.
#[inline]
fn beyond<const D: usize>(x: &[f64; D], min: &[f64; D], max: &[f64; D]) -> [f64; D] {
    core::array::from_fn(|k| larger(min[k] - x[k], x[k] - max[k]))
}

/// On which side of the box the nearer face across axis `k` lies, −1 or 1.
#[inline]
fn side<const D: usize>(x: &[f64; D], min: &[f64; D], max: &[f64; D], k: usize) -> f64 {
    if min[k] - x[k] >= x[k] - max[k] {
        -1.0
    } else {
        1.0
    }
}

/// The axis across which the nearest face of a box lies, seen from inside; the first of several.
#[inline]
fn nearest_face<const D: usize>(x: &[f64; D], min: &[f64; D], max: &[f64; D]) -> usize {
    let beyond = beyond(x, min, max);
    (0..D).fold(0, |best, k| if beyond[k] > beyond[best] { k } else { best })
}

/// From the nearest point of a segment to x, and whether that point is none of its ends.
#[inline]
fn from_segment<const D: usize>(x: &[f64; D], ends: &[[f64; D]; 2]) -> ([f64; D], bool) {
    let along = difference(&ends[1], &ends[0]);
    let from_start = difference(x, &ends[0]);
    let square = dot(along, along);
    let t = if square > 0.0 {
        dot(from_start, along) / square
    } else {
        0.0
    };
    if t <= 0.0 {
        (from_start, false)
    } else if t >= 1.0 {
        (difference(x, &ends[1]), false)
    } else {
        (core::array::from_fn(|k| from_start[k] - t * along[k]), true)
    }
}
