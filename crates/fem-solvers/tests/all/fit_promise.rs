//! What a fit promises, checked by a model of its own: in these tests [`gauss_newton`] stands for that of
//! the crate, and trusts no `Ok`.

use fem_solvers::{
    GaussNewtonError, GaussNewtonInfo, GaussNewtonIteration, GaussNewtonParams, GaussNewtonStop,
    LeastSquares,
};
use nalgebra::{DMatrix, DVector};
use std::fmt::Debug;

/// A last step that gains little leaves this many times as much where each step leaves four fifths of what
/// was left before it.
const SLOWEST: f64 = 4.0;
/// Differences of cost below this share of it are rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Singular values below this share of the largest are zero.
const RANK: f64 = 1e-9;

#[track_caller]
pub fn gauss_newton<P: LeastSquares<Error: Debug>>(
    problem: &mut P,
    theta: &mut [f64],
    params: &GaussNewtonParams,
) -> Result<GaussNewtonInfo, GaussNewtonError<P::Error>> {
    gauss_newton_observed(problem, theta, params, &mut |_| {})
}

#[track_caller]
pub fn gauss_newton_observed<P: LeastSquares<Error: Debug>>(
    problem: &mut P,
    theta: &mut [f64],
    params: &GaussNewtonParams,
    observer: &mut dyn FnMut(&GaussNewtonIteration<'_>),
) -> Result<GaussNewtonInfo, GaussNewtonError<P::Error>> {
    let info = fem_solvers::gauss_newton_observed(problem, theta, params, observer)?;
    kept(problem, theta, params, &info);
    Ok(info)
}

/// Fails unless a step from `theta`, of any length that the bounds leave, gains no more by the undamped
/// model than the stop allows.
#[track_caller]
fn kept<P: LeastSquares<Error: Debug>>(
    problem: &mut P,
    theta: &[f64],
    params: &GaussNewtonParams,
    info: &GaussNewtonInfo,
) {
    let (m, n) = (problem.residuals(), problem.parameters());
    let (mut r, mut j) = (vec![0.0; m], vec![0.0; m * n]);
    problem.residual(theta, &mut r).unwrap();
    problem.jacobian(theta, &mut j).unwrap();
    assert!(
        r.iter().chain(&j).chain(theta).all(|v| v.is_finite()),
        "{info:?}"
    );
    let (mut r, mut j) = (DVector::from_vec(r), DMatrix::from_vec(m, n, j));
    let groups = m / params.group_size;
    let rms = (r.norm_squared() / groups.max(1) as f64).sqrt();
    assert!(
        (rms - info.residual).abs() <= ROUNDING * rms,
        "{rms:e} {info:?}"
    );
    let mut cost = 0.0;
    for group in 0..groups {
        let rows = group * params.group_size..(group + 1) * params.group_size;
        let square: f64 = rows.clone().map(|k| r[k] * r[k]).sum();
        cost += 0.5 * params.loss.value(square);
        let weight = params.loss.weight(square).sqrt();
        for k in rows {
            r[k] *= weight;
            j.row_mut(k).scale_mut(weight);
        }
    }
    if let Some(prior) = &params.prior {
        let roots = DVector::from_iterator(n, prior.weights.iter().map(|w| w.sqrt()));
        let off = DVector::from_fn(n, |k, _| roots[k] * (theta[k] - prior.values[k]));
        cost += 0.5 * off.norm_squared();
        r = stacked(&r, &off);
        j = DMatrix::from_fn(m + n, n, |row, column| match row.checked_sub(m) {
            None => j[(row, column)],
            Some(k) => f64::from(u8::from(k == column)) * roots[k],
        });
    }
    assert!(
        (cost - info.cost).abs() <= ROUNDING * cost,
        "{cost:e} {info:?}"
    );
    let gradient = j.transpose() * &r;
    let free: Vec<usize> = (0..n)
        .filter(|&k| {
            let Some(bounds) = &params.bounds else {
                return true;
            };
            assert!(bounds.lower[k] <= theta[k] && theta[k] <= bounds.upper[k]);
            let outwards = (theta[k] == bounds.lower[k] && gradient[k] >= 0.0)
                || (theta[k] == bounds.upper[k] && gradient[k] <= 0.0);
            !outwards
        })
        .collect();
    let pull = free
        .iter()
        .fold(0.0_f64, |most, &k| most.max(gradient[k].abs()));
    // The largest sum that a gradient entry is the rest of.
    let terms = (j.abs().transpose() * r.abs()).amax();
    let (gain, length) = best_step(&j.select_columns(&free), &r);
    let per_group = 2.0 * gain / groups.max(1) as f64;
    // As the residual falls where no group is an outlier and no prior pulls: the solver's own measure.
    let drop = rms - (rms * rms - per_group).max(0.0).sqrt();
    let is_rounding = gain <= ROUNDING * cost;
    let is_kept = match info.stop {
        GaussNewtonStop::Residual => rms <= params.residual_tolerance,
        GaussNewtonStop::Gradient => pull <= params.gradient_tolerance + ROUNDING * terms,
        _ => {
            is_rounding
                || length <= SLOWEST * params.step_tolerance
                || gain <= SLOWEST * params.cost_tolerance * cost
                || drop <= SLOWEST * params.residual_change
        }
    };
    assert!(
        is_kept,
        "{info:?}: a step of {length:e} is left, of the cost {cost:e} it gains {gain:e}, \
         of the residual {rms:e} it takes {drop:e}; gradient {pull:e}"
    );
}

fn stacked(upper: &DVector<f64>, lower: &DVector<f64>) -> DVector<f64> {
    DVector::from_iterator(
        upper.len() + lower.len(),
        upper.iter().chain(lower).copied(),
    )
}

/// What the least |r + J d|² / 2 gains over that of d = 0, and the largest entry of the shortest such d.
fn best_step(j: &DMatrix<f64>, r: &DVector<f64>) -> (f64, f64) {
    if j.is_empty() {
        return (0.0, 0.0);
    }
    // Columns of one length: parameters in other units are no loss of rank.
    let sizes = DVector::from_iterator(j.ncols(), j.column_iter().map(|c| c.norm()));
    let scaled = DMatrix::from_fn(j.nrows(), j.ncols(), |row, k| match sizes[k] > 0.0 {
        true => j[(row, k)] / sizes[k],
        false => 0.0,
    });
    let svd = scaled.svd(true, true);
    let (u, vt) = (svd.u.unwrap(), svd.v_t.unwrap());
    let largest = svd.singular_values.max();
    let mut gain = 0.0;
    let mut d = DVector::zeros(j.ncols());
    for (k, &value) in svd.singular_values.iter().enumerate() {
        if value > RANK * largest {
            let share = u.column(k).dot(r);
            gain += 0.5 * share * share;
            d += vt.row(k).transpose() * (-share / value);
        }
    }
    let entries = d.iter().zip(&sizes).filter(|(_, size)| **size > 0.0);
    let length = entries.fold(0.0_f64, |most, (d, size)| most.max((d / size).abs()));
    (gain, length)
}

/// `r = θ − 3`.
struct Line;

impl LeastSquares for Line {
    type Error = String;
    fn residuals(&self) -> usize {
        1
    }
    fn parameters(&self) -> usize {
        1
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), String> {
        r[0] = theta[0] - 3.0;
        Ok(())
    }
    fn jacobian(&mut self, _theta: &[f64], j: &mut [f64]) -> Result<(), String> {
        j[0] = 1.0;
        Ok(())
    }
}

/// The end of a fit is believed at its end alone.
#[test]
#[should_panic(expected = "a step of 1e0 is left")]
fn an_end_a_unit_away_is_none() {
    let params = GaussNewtonParams::default();
    let mut theta = [0.0];
    let mut info = fem_solvers::gauss_newton(&mut Line, &mut theta, &params).unwrap();
    kept(&mut Line, &theta, &params, &info);
    theta[0] -= 1.0;
    (info.cost, info.residual) = (0.5, 1.0);
    kept(&mut Line, &theta, &params, &info);
}
