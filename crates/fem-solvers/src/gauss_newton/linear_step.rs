//! One bounded, damped linear least-squares step.

use super::{Bounds, StepMethod};
use crate::dense_qr::PivotedQr;
use crate::tall_qr::triangle;
use crate::vector::dot;
use std::borrow::Cow;

/// The linear model at `θ`: minimize `½‖r + J d‖² + ½ Σ w_k (θ_k + d_k − p_k)² + ½ Σ damping_k d_k²`.
pub(super) struct Model<'a> {
    m: usize,
    pub n: usize,
    /// How many residuals there are; more than `m` where a [`triangle`] is left of them.
    pub residuals: usize,
    /// Weighted residuals and weighted Jacobian, column-major.
    r: Cow<'a, [f64]>,
    j: Cow<'a, [f64]>,
    /// `w_k` and `θ_k − p_k`.
    prior: Option<(&'a [f64], &'a [f64])>,
    /// `∂cost/∂θ`.
    pub gradient: Vec<f64>,
    /// The diagonal of the Gauss-Newton matrix.
    pub diagonal: Vec<f64>,
}

/// How many times as many rows as columns are worth a triangle: each round of a step, and each damping that
/// is tried, takes a factorization of its own.
const TALL: usize = 4;

/// The Jacobian of the free parameters lost rank.
#[derive(Clone, Copy, Debug)]
pub(super) struct RankLoss {
    pub rank: usize,
    pub free: usize,
    pub parameter: usize,
}

impl<'a> Model<'a> {
    /// Of `n` parameters.
    pub fn new(
        n: usize,
        r: &'a [f64],
        j: &'a [f64],
        prior: Option<(&'a [f64], &'a [f64])>,
    ) -> Self {
        let m = r.len();
        let column = |k: usize| &j[k * m..(k + 1) * m];
        let expected = |k: usize| prior.map_or(0.0, |(w, e)| w[k] * e[k]);
        let weight = |k: usize| prior.map_or(0.0, |(w, _)| w[k]);
        Self {
            m,
            n,
            residuals: m,
            r: r.into(),
            j: j.into(),
            prior,
            gradient: (0..n).map(|k| dot(column(k), r) + expected(k)).collect(),
            diagonal: (0..n)
                .map(|k| dot(column(k), column(k)) + weight(k))
                .collect(),
        }
    }

    /// The same with the triangle of those columns that may move, if that is worth it; the others, which
    /// no step asks for, are 0.
    pub fn reduced(mut self, method: StepMethod, theta: &[f64], bounds: Option<&Bounds>) -> Self {
        let free = self.free(theta, bounds);
        let rows = free.len() + 1;
        if method != StepMethod::Qr || self.m <= TALL * rows {
            return self;
        }
        let columns: Vec<&[f64]> = free.iter().map(|&k| self.column(k)).collect();
        let (upper, right) = triangle(&columns, &self.r);
        let mut j = vec![0.0; rows * self.n];
        for (&k, column) in free.iter().zip(upper.chunks(rows)) {
            j[k * rows..(k + 1) * rows].copy_from_slice(column);
        }
        (self.m, self.r, self.j) = (rows, right.into(), j.into());
        self
    }

    /// The parameters that do not sit on a bound and are pushed outwards by the gradient.
    fn free(&self, theta: &[f64], bounds: Option<&Bounds>) -> Vec<usize> {
        let is_free = |&k: &usize| !blocked(theta[k], self.gradient[k], k, bounds);
        (0..self.n).filter(is_free).collect()
    }

    fn column(&self, k: usize) -> &[f64] {
        &self.j[k * self.m..(k + 1) * self.m]
    }

    /// Decrease of the undamped model along `d`.
    pub fn decrease(&self, d: &[f64]) -> f64 {
        let mut change = self.r.to_vec();
        let mut slope = 0.0;
        change.fill(0.0);
        for (k, &dk) in d.iter().enumerate() {
            if dk != 0.0 {
                crate::vector::axpy(dk, self.column(k), &mut change);
            }
        }
        slope += dot(&change, &self.r);
        let mut curvature = dot(&change, &change);
        if let Some((w, e)) = self.prior {
            for k in 0..self.n {
                slope += w[k] * e[k] * d[k];
                curvature += w[k] * d[k] * d[k];
            }
        }
        -(slope + 0.5 * curvature)
    }

    /// The minimizer over the box, by fixing parameters that would leave it and solving for the rest.
    ///
    /// A parameter that sits on a bound and is pushed outwards by the gradient does not move.
    pub fn step(
        &self,
        method: StepMethod,
        theta: &[f64],
        bounds: Option<&Bounds>,
        damping: Option<&[f64]>,
    ) -> Result<Vec<f64>, RankLoss> {
        let mut d = vec![0.0; self.n];
        let mut free = self.free(theta, bounds);
        while !free.is_empty() {
            let part = match method {
                StepMethod::Qr => self.by_qr(&free, &d, damping),
                StepMethod::NormalEquations => self.by_normal_equations(&free, &d, damping),
            }?;
            let Some(bounds) = bounds else {
                for (&k, &value) in free.iter().zip(&part) {
                    d[k] = value;
                }
                break;
            };
            let mut leaving = Vec::new();
            for (&k, &value) in free.iter().zip(&part) {
                let target = theta[k] + value;
                if target < bounds.lower[k] || target > bounds.upper[k] {
                    d[k] = target.clamp(bounds.lower[k], bounds.upper[k]) - theta[k];
                    leaving.push(k);
                }
            }
            if leaving.is_empty() {
                for (&k, &value) in free.iter().zip(&part) {
                    d[k] = value;
                }
                break;
            }
            free.retain(|k| !leaving.contains(k));
        }
        Ok(d)
    }

    /// Residual of the model with the parameters outside `free` already moved.
    fn moved(&self, free: &[usize], d: &[f64]) -> Vec<f64> {
        let mut r = self.r.to_vec();
        for k in (0..self.n).filter(|k| d[*k] != 0.0 && !free.contains(k)) {
            crate::vector::axpy(d[k], self.column(k), &mut r);
        }
        r
    }

    fn by_qr(
        &self,
        free: &[usize],
        d: &[f64],
        damping: Option<&[f64]>,
    ) -> Result<Vec<f64>, RankLoss> {
        let extra_prior = if self.prior.is_some() { free.len() } else { 0 };
        let extra_damping = if damping.is_some() { free.len() } else { 0 };
        let rows = self.m + extra_prior + extra_damping;
        let mut a = vec![0.0; rows * free.len()];
        let mut b: Vec<f64> = self.moved(free, d).iter().map(|v| -v).collect();
        b.resize(rows, 0.0);
        for (c, &k) in free.iter().enumerate() {
            let column = &mut a[c * rows..(c + 1) * rows];
            column[..self.m].copy_from_slice(self.column(k));
            if let Some((w, e)) = self.prior {
                column[self.m + c] = w[k].sqrt();
                b[self.m + c] = -w[k].sqrt() * e[k];
            }
            if let Some(damping) = damping {
                column[self.m + extra_prior + c] = damping[k].sqrt();
            }
        }
        let qr = PivotedQr::new(a, rows, free.len());
        let rank = qr.rank_of(self.residuals + rows - self.m);
        if rank < free.len() {
            return Err(RankLoss {
                rank,
                free: free.len(),
                parameter: free[qr.pivot(rank)],
            });
        }
        Ok(qr.least_squares(&b))
    }

    fn by_normal_equations(
        &self,
        free: &[usize],
        d: &[f64],
        damping: Option<&[f64]>,
    ) -> Result<Vec<f64>, RankLoss> {
        let n = free.len();
        let r = self.moved(free, d);
        let mut a = vec![0.0; n * n];
        let mut x = vec![0.0; n];
        for (i, &k) in free.iter().enumerate() {
            for (j, &l) in free[..=i].iter().enumerate() {
                a[i * n + j] = dot(self.column(k), self.column(l));
            }
            x[i] = -dot(self.column(k), &r);
            if let Some((w, e)) = self.prior {
                a[i * n + i] += w[k];
                x[i] -= w[k] * e[k];
            }
            if let Some(damping) = damping {
                a[i * n + i] += damping[k];
            }
        }
        // Cholesky, row by row; a pivot lost to rounding is a loss of rank.
        for i in 0..n {
            let original = a[i * n + i];
            for j in 0..=i {
                let (row_i, row_j) = (&a[i * n..i * n + j], &a[j * n..j * n + j]);
                let value = a[i * n + j] - dot(row_i, row_j);
                if i == j {
                    if !(value > n as f64 * f64::EPSILON * original) {
                        return Err(RankLoss {
                            rank: i,
                            free: n,
                            parameter: free[i],
                        });
                    }
                    a[i * n + i] = value.sqrt();
                } else {
                    a[i * n + j] = value / a[j * n + j];
                }
            }
        }
        for i in 0..n {
            x[i] = (x[i] - dot(&a[i * n..i * n + i], &x[..i])) / a[i * n + i];
        }
        for i in (0..n).rev() {
            x[i] /= a[i * n + i];
            for j in 0..i {
                x[j] -= a[i * n + j] * x[i];
            }
        }
        Ok(x)
    }
}

/// Whether a parameter sits on a bound and its descent direction leads outside.
pub(super) fn blocked(theta: f64, gradient: f64, k: usize, bounds: Option<&Bounds>) -> bool {
    bounds.is_some_and(|b| {
        (theta <= b.lower[k] && gradient >= 0.0) || (theta >= b.upper[k] && gradient <= 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::{Bounds, Model, StepMethod};

    const ROWS: usize = 300;
    const COLUMNS: usize = 9;

    /// Columns that have little to do with each other.
    fn wave(k: usize) -> f64 {
        ((k * k) as f64 * 0.37 + k as f64).sin()
    }

    /// Steps of a tall model, whole and as a triangle, to within rounding.
    #[test]
    fn a_triangle_takes_the_steps_of_all_rows() {
        let j: Vec<f64> = (0..ROWS * COLUMNS).map(wave).collect();
        let r: Vec<f64> = (0..ROWS).map(|k| wave(5 * k + 2)).collect();
        let theta: Vec<f64> = (0..COLUMNS).map(|k| [0.0, 0.01, 1.0][k % 3]).collect();
        let bounds = Bounds {
            lower: vec![0.0; COLUMNS],
            upper: vec![1.0; COLUMNS],
        };
        let (weights, offsets) = (vec![2.0; COLUMNS], vec![0.3; COLUMNS]);
        let damping: Vec<f64> = (0..COLUMNS).map(|k| 0.5 * k as f64).collect();
        let mut still = 0;
        for prior in [None, Some((&weights[..], &offsets[..]))] {
            for (bounds, damping) in [
                (None, None),
                (Some(&bounds), None),
                (Some(&bounds), Some(&damping[..])),
            ] {
                let whole = || Model::new(COLUMNS, &r, &j, prior);
                let triangle = whole().reduced(StepMethod::Qr, &theta, bounds);
                assert!(triangle.m <= COLUMNS + 1 && triangle.residuals == ROWS);
                let step = |model: &Model<'_>| {
                    let step = model.step(StepMethod::Qr, &theta, bounds, damping);
                    step.unwrap()
                };
                let (d, e) = (step(&whole()), step(&triangle));
                assert!(d.iter().zip(&e).all(|(d, e)| (d - e).abs() < 1e-13));
                let apart = whole().decrease(&d) - triangle.decrease(&d);
                assert!(apart.abs() < 1e-12, "{apart:e}");
                still += d.iter().filter(|d| **d == 0.0).count();
            }
        }
        assert!(still > 5, "{still} parameters did not move");
    }

    #[test]
    fn equal_columns_and_other_methods_are_told_as_before() {
        let mut j: Vec<f64> = (0..ROWS * COLUMNS).map(wave).collect();
        j.copy_within(0..ROWS, 4 * ROWS);
        let r: Vec<f64> = (0..ROWS).map(wave).collect();
        let model = || Model::new(COLUMNS, &r, &j, None);
        let theta = [0.5; COLUMNS];
        let loss = |model: &Model<'_>| model.step(StepMethod::Qr, &theta, None, None).unwrap_err();
        let triangle = model().reduced(StepMethod::Qr, &theta, None);
        let (whole, left) = (loss(&model()), loss(&triangle));
        assert_eq!((whole.rank, whole.free), (left.rank, left.free));
        let normal = model().reduced(StepMethod::NormalEquations, &theta, None);
        assert_eq!(normal.m, ROWS);
    }
    /// ½|r + J d|² + ½ Σ w (e + d)² at 0 and at d.
    #[test]
    fn a_decrease_is_the_difference_of_two_costs() {
        let (r, j) = ([1.0, -2.0, 0.5], [1.0, 2.0, 0.0, -1.0, 0.0, 3.0]);
        let (w, e, d) = ([2.0, 5.0], [0.3, -0.4], [0.7, -0.2]);
        let cost = |d: &[f64; 2]| {
            let data = (0..3).map(|i| (r[i] + j[i] * d[0] + j[3 + i] * d[1]).powi(2));
            let prior = (0..2).map(|k| w[k] * (e[k] + d[k]).powi(2));
            0.5 * (data.sum::<f64>() + prior.sum::<f64>())
        };
        let model = Model::new(2, &r, &j, Some((&w, &e)));
        let expected = cost(&[0.0; 2]) - cost(&d);
        assert!((model.decrease(&d) - expected).abs() < 1e-14);
    }

    /// Columns that are one to within rounding: of 4,000 rows ε times 4,000, and as a triangle no less.
    #[test]
    fn a_loss_of_rank_is_judged_by_all_rows_and_named() {
        let rows = 4_000;
        let column: Vec<f64> = (0..rows).map(wave).collect();
        let nearly = |k: usize| column[k] * (1.0 + 3e-13 * wave(3 * k + 1));
        // Nothing, a column, and nearly that column.
        let mut j = vec![0.0; rows];
        j.extend_from_slice(&column);
        j.extend((0..rows).map(nearly));
        let r = vec![1.0; rows];
        let of = |j: &[f64], n: usize| {
            let model = Model::new(n, &r, j, None).reduced(StepMethod::Qr, &[0.0; 3][..n], None);
            assert!(model.m < rows);
            model.step(StepMethod::Qr, &[0.0; 3][..n], None, None)
        };
        assert_eq!(of(&j[rows..], 2).unwrap_err().rank, 1);
        // The one that has no effect is named, which is not the last.
        j[2 * rows..].copy_from_slice(&r);
        let lost = of(&j, 3).unwrap_err();
        assert_eq!((lost.rank, lost.parameter), (2, 0));
        // A pivot of ε is rounding: (1, 0) and (1, 2⁻²⁶).
        let j = [1.0, 0.0, 1.0, 2.0_f64.powi(-26)];
        let model = Model::new(2, &[1.0; 2], &j, None);
        let lost = model.step(StepMethod::NormalEquations, &[0.0; 2], None, None);
        assert_eq!(lost.unwrap_err().parameter, 1);
    }
}
