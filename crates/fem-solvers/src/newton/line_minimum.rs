//! A better step on the line of a good one.
//!
//! A direction from a changed Hessian is often too short, one from a Hessian that is about to become
//! indefinite too long; either shows in the slope at its end. An evaluation costs a small part of a
//! factorization, so a few are spent there. After a Newton step that fits, the slope is nearly 0 and
//! nothing is done.

use super::NonlinearProblem;
use super::line_search::{Accepted, Start};
use crate::vector::{dot, first_non_finite};

/// Share of the first slope that is left alone at the end.
const FLAT: f64 = 0.3;
/// Evaluations spent.
const MOST: usize = 3;

/// A place on the line, with the derivative of the energy along it.
#[derive(Clone, Copy)]
struct Place {
    t: f64,
    energy: f64,
    slope: f64,
}

/// Moves an accepted step toward the minimum along its line while that lowers the energy; `x` and
/// `gradient` follow.
pub(super) fn improve<const D: usize>(
    problem: &(impl NonlinearProblem<D> + ?Sized),
    start: &Start<'_>,
    longest: f64,
    x: &mut [f64],
    gradient: &mut [f64],
    accepted: &mut Accepted,
) {
    let steep = FLAT * dot(start.gradient, start.direction).abs();
    let mut best = Place {
        t: accepted.t,
        energy: accepted.energy,
        slope: dot(gradient, start.direction),
    };
    let mut low = Place {
        t: 0.0,
        energy: start.energy,
        slope: -steep / FLAT,
    };
    let mut high = None;
    let mut spare: Option<(Vec<f64>, Vec<f64>)> = None;
    for _ in 0..MOST {
        match best.slope {
            slope if slope > steep => high = Some(best),
            slope if slope < -steep => low = best,
            // Flat, or no number.
            _ => break,
        }
        let t = match high {
            Some(high) => between(low, high),
            None => beyond(best, steep / FLAT),
        };
        if !(t <= longest) {
            break;
        }
        let (trial, slopes) = spare.get_or_insert_with(|| (vec![0.0; x.len()], vec![0.0; x.len()]));
        for ((trial, x), d) in trial.iter_mut().zip(start.x).zip(start.direction) {
            *trial = x + t * d;
        }
        let energy = problem.energy_and_gradient(trial, slopes);
        accepted.evaluations += 1;
        if !(energy <= best.energy) || first_non_finite(slopes).is_some() {
            break;
        }
        let slope = dot(slopes, start.direction);
        best = Place { t, energy, slope };
        x.copy_from_slice(trial);
        gradient.copy_from_slice(slopes);
    }
    (accepted.t, accepted.energy) = (best.t, best.energy);
}

/// The minimum of the cubic through both places, well inside.
fn between(a: Place, b: Place) -> f64 {
    let width = b.t - a.t;
    let s = a.slope + b.slope + 3.0 * (a.energy - b.energy) / width;
    let root = (s * s - a.slope * b.slope).max(0.0).sqrt();
    let t = b.t - width * (b.slope + root - s) / (b.slope - a.slope + 2.0 * root);
    let (least, most) = (a.t + 0.1 * width, b.t - 0.1 * width);
    if t.is_finite() {
        t.clamp(least, most)
    } else {
        0.5 * (a.t + b.t)
    }
}

/// Where a slope that goes on rising from −`first` would reach 0.
fn beyond(at: Place, first: f64) -> f64 {
    let t = at.t * first / (first + at.slope);
    if t > 0.0 {
        t.clamp(1.2 * at.t, 3.0 * at.t)
    } else {
        3.0 * at.t
    }
}
