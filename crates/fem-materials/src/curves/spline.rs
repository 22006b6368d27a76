//! A user's measured curve: a monotone cubic spline through a table.

use super::{CurvePoint, TensionCurve};
use fem_kinematics::Real;

/// How a [`Spline`] goes on outside its table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Constant; the spline arrives with slope 0. For active curves.
    Flat,
    /// Straight, with the slope that the spline arrives with. For passive curves.
    Linear,
}

/// Why a table is no curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// Fewer than two rows.
    #[error("a tension curve needs at least 2 rows, this table has {rows}")]
    TooShort {
        /// How many rows there are.
        rows: usize,
    },
    /// The two columns differ in length.
    #[error("a tension curve has {stretches} stretches but {values} values; give one value each")]
    Lengths {
        /// Number of stretches.
        stretches: usize,
        /// Number of values.
        values: usize,
    },
    /// A number that is NaN or infinite.
    #[error("row {row} of a tension curve is not finite: stretch {stretch}, value {value}")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// Its stretch.
        stretch: f64,
        /// Its value.
        value: f64,
    },
    /// Stretches out of order.
    #[error(
        "row {row} of a tension curve has stretch {stretch}, not above {previous} before it; sort the rows and remove doubles"
    )]
    NotIncreasing {
        /// Row, from 0.
        row: usize,
        /// Its stretch.
        stretch: f64,
        /// The stretch of the row before.
        previous: f64,
    },
    /// The normalized stretch 1 lies outside the table.
    #[error(
        "a tension curve covers stretches {first} to {last} but must include 1, the optimal length"
    )]
    RestNotCovered {
        /// First stretch.
        first: f64,
        /// Last stretch.
        last: f64,
    },
}

/// A cubic of t = l − anchor on the stretches from `start` to the next piece's start.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start: f64,
    anchor: f64,
    /// Coefficients of 1, t, t², t³.
    c: [f64; 4],
    /// ∫ from 1 to the anchor.
    integral: f64,
}

impl Piece {
    fn integral_to(&self, l: f64) -> f64 {
        let t = l - self.anchor;
        let [a, b, c, d] = self.c;
        t * (a + t * (b / 2.0 + t * (c / 3.0 + t * d / 4.0)))
    }
    /// The same cubic about another anchor.
    fn about(&self, anchor: f64) -> Self {
        let h = anchor - self.anchor;
        let [a, b, c, d] = self.c;
        Self {
            anchor,
            c: [
                a + h * (b + h * (c + h * d)),
                b + h * (2.0 * c + 3.0 * h * d),
                c + 3.0 * h * d,
                d,
            ],
            ..*self
        }
    }
}

/// A C¹ piecewise cubic that rises and falls only where its table does (Fritsch and Carlson
/// 1980, with the slopes of Fritsch and Butland 1984), and its exact integral from 1.
///
/// Pieces are anchored on the side of l = 1, and l = 1 is a joint, so the integral keeps its
/// digits there.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    pieces: Vec<Piece>,
}

impl Spline {
    /// The spline through `values[i]` at normalized stretch `stretches[i]`.
    ///
    /// # Errors
    /// If the table has fewer than two rows, columns of different length, a number that is not
    /// finite, stretches that don't increase, or does not include stretch 1.
    pub fn new(stretches: &[f64], values: &[f64], ends: Ends) -> Result<Self, CurveError> {
        check(stretches, values)?;
        let mut pieces = pieces(stretches, values, ends);
        // Outward from 1 in both directions.
        for i in 1..pieces.len() {
            if pieces[i].anchor > 1.0 {
                pieces[i].integral =
                    pieces[i - 1].integral + pieces[i - 1].integral_to(pieces[i].anchor);
            }
        }
        for i in (0..pieces.len() - 1).rev() {
            if pieces[i].anchor < 1.0 {
                pieces[i].integral =
                    pieces[i + 1].integral + pieces[i + 1].integral_to(pieces[i].anchor);
            }
        }
        Ok(Self { pieces })
    }

    /// Is it 0 at every stretch?
    pub fn is_zero(&self) -> bool {
        self.pieces.iter().all(|piece| piece.c == [0.0; 4])
    }

    /// The curve at l.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn evaluate<T: Real>(&self, l: T) -> CurvePoint<T> {
        let f = T::from_f64;
        let zero = T::zero();
        let (mut anchor, mut base) = (zero, zero);
        let mut c = [zero; 4];
        for piece in &self.pieces {
            let here = f(piece.start).le(l);
            anchor = T::select(here, f(piece.anchor), anchor);
            base = T::select(here, f(piece.integral), base);
            for k in 0..4 {
                c[k] = T::select(here, f(piece.c[k]), c[k]);
            }
        }
        let t = l - anchor;
        let (third, two) = (f(1.0 / 3.0), f(2.0));
        CurvePoint {
            integral: base
                + t * (c[0] + t * (f(0.5) * c[1] + t * (third * c[2] + f(0.25) * t * c[3]))),
            value: c[0] + t * (c[1] + t * (c[2] + t * c[3])),
            slope: c[1] + t * (two * c[2] + f(3.0) * t * c[3]),
        }
    }
}

/// A table that a curve can run through.
fn check(stretches: &[f64], values: &[f64]) -> Result<(), CurveError> {
    let n = stretches.len();
    if n != values.len() {
        return Err(CurveError::Lengths {
            stretches: n,
            values: values.len(),
        });
    }
    if n < 2 {
        return Err(CurveError::TooShort { rows: n });
    }
    for row in 0..n {
        let (stretch, value) = (stretches[row], values[row]);
        if !(stretch.is_finite() && value.is_finite()) {
            return Err(CurveError::NotFinite {
                row,
                stretch,
                value,
            });
        }
        if row > 0 && stretch <= stretches[row - 1] {
            let previous = stretches[row - 1];
            return Err(CurveError::NotIncreasing {
                row,
                stretch,
                previous,
            });
        }
    }
    let (first, last) = (stretches[0], stretches[n - 1]);
    if !(first <= 1.0 && 1.0 <= last) {
        return Err(CurveError::RestNotCovered { first, last });
    }
    Ok(())
}

/// The cubics between the rows, cut at stretch 1, and the lines beyond them; not yet integrated.
fn pieces(stretches: &[f64], values: &[f64], ends: Ends) -> Vec<Piece> {
    let n = stretches.len();
    let slopes = monotone_slopes(stretches, values, ends);
    let line = |start: f64, i: usize| Piece {
        start,
        anchor: stretches[i],
        c: [values[i], slopes[i], 0.0, 0.0],
        integral: 0.0,
    };
    let mut pieces = vec![line(f64::NEG_INFINITY, 0)];
    for i in 0..n - 1 {
        let h = stretches[i + 1] - stretches[i];
        let secant = (values[i + 1] - values[i]) / h;
        let piece = Piece {
            start: stretches[i],
            anchor: stretches[i],
            c: [
                values[i],
                slopes[i],
                (3.0 * secant - 2.0 * slopes[i] - slopes[i + 1]) / h,
                (slopes[i] + slopes[i + 1] - 2.0 * secant) / (h * h),
            ],
            integral: 0.0,
        };
        let end = stretches[i + 1];
        if end <= 1.0 {
            pieces.push(piece.about(end));
        } else if stretches[i] < 1.0 {
            pieces.push(piece.about(1.0));
            pieces.push(Piece {
                start: 1.0,
                ..piece.about(1.0)
            });
        } else {
            pieces.push(piece);
        }
    }
    pieces.push(line(stretches[n - 1], n - 1));
    pieces
}

/// Slopes at the knots: the weighted harmonic mean of the neighboring secants, 0 at extrema.
fn monotone_slopes(x: &[f64], y: &[f64], ends: Ends) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = (0..n - 1).map(|i| x[i + 1] - x[i]).collect();
    let d: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
    let mut m = vec![0.0; n];
    for i in 1..n - 1 {
        if d[i - 1] * d[i] > 0.0 {
            let (w1, w2) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
            m[i] = (w1 + w2) / (w1 / d[i - 1] + w2 / d[i]);
        }
    }
    if ends == Ends::Linear {
        m[0] = end_slope(&h, &d);
        let (h, d): (Vec<f64>, Vec<f64>) = (
            h.iter().rev().copied().collect(),
            d.iter().rev().copied().collect(),
        );
        m[n - 1] = end_slope(&h, &d);
    }
    m
}

/// One-sided three-point slope, limited so that the first piece stays monotone.
fn end_slope(h: &[f64], d: &[f64]) -> f64 {
    if h.len() == 1 {
        return d[0];
    }
    let slope = ((2.0 * h[0] + h[1]) * d[0] - h[0] * d[1]) / (h[0] + h[1]);
    if slope * d[0] <= 0.0 {
        0.0
    } else if d[0] * d[1] <= 0.0 && slope.abs() > 3.0 * d[0].abs() {
        3.0 * d[0]
    } else {
        slope
    }
}

/// Active and passive tension from a user's tables.
///
/// ```
/// use fem_materials::curves::{Ends, Spline, SplineCurve, TensionCurve};
/// let curve = SplineCurve {
///     active: Spline::new(&[0.4, 0.7, 1.0, 1.3, 1.6], &[0.0, 0.7, 1.0, 0.7, 0.0], Ends::Flat)?,
///     passive: Spline::new(&[1.0, 1.2, 1.5], &[0.0, 0.1, 0.8], Ends::Linear)?,
/// };
/// assert_eq!(curve.active(1.0_f64).value, 1.0);
/// # Ok::<(), fem_materials::curves::CurveError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SplineCurve {
    /// f_a.
    pub active: Spline,
    /// f_p.
    pub passive: Spline,
}

impl TensionCurve for SplineCurve {
    #[inline(always)]
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        self.active.evaluate(l)
    }
    #[inline(always)]
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        self.passive.evaluate(l)
    }
    fn has_active(&self) -> bool {
        !self.active.is_zero()
    }
    fn has_passive(&self) -> bool {
        !self.passive.is_zero()
    }
}
