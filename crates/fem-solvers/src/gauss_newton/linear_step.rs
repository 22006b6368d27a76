//! One bounded, damped linear least-squares step.

use super::{Bounds, StepMethod};
use crate::dense_qr::PivotedQr;
use crate::vector::dot;

/// The linear model at `θ`: minimize `½‖r + J d‖² + ½ Σ w_k (θ_k + d_k − p_k)² + ½ Σ damping_k d_k²`.
pub(super) struct Model<'a> {
    pub m: usize,
    pub n: usize,
    /// Weighted residuals and weighted Jacobian, column-major.
    pub r: &'a [f64],
    pub j: &'a [f64],
    /// `w_k` and `θ_k − p_k`.
    pub prior: Option<(&'a [f64], &'a [f64])>,
}

/// The Jacobian of the free parameters lost rank.
#[derive(Clone, Copy, Debug)]
pub(super) struct RankLoss {
    pub rank: usize,
    pub free: usize,
    pub parameter: usize,
}

impl Model<'_> {
    pub fn column(&self, k: usize) -> &[f64] {
        &self.j[k * self.m..(k + 1) * self.m]
    }

    /// `∂cost/∂θ`.
    pub fn gradient(&self) -> Vec<f64> {
        (0..self.n)
            .map(|k| dot(self.column(k), self.r) + self.prior.map_or(0.0, |(w, e)| w[k] * e[k]))
            .collect()
    }

    /// Diagonal of the Gauss-Newton matrix.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.n)
            .map(|k| dot(self.column(k), self.column(k)) + self.prior.map_or(0.0, |(w, _)| w[k]))
            .collect()
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
        slope += dot(&change, self.r);
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
        let gradient = self.gradient();
        let mut d = vec![0.0; self.n];
        let mut free: Vec<usize> = (0..self.n)
            .filter(|&k| !blocked(theta[k], gradient[k], k, bounds))
            .collect();
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
        let rank = qr.rank();
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
