//! Which gradients count as none.

use super::{NewtonParams, NonlinearProblem, StopReason};
use crate::vector::norm_inf;

/// The largest entries of a gradient that count as none.
#[derive(Clone)]
pub(super) struct Target {
    absolute: f64,
    relative: Relative,
}

/// The share of the reference that an entry may have.
#[derive(Clone)]
enum Relative {
    Same(f64),
    Each(Vec<f64>),
}

/// The targets of one solve.
pub(super) struct Targets<'a> {
    params: &'a NewtonParams,
    /// The largest entry of the gradient at the start.
    start: f64,
    /// What none of them exceeds, where the problem knows.
    largest: Option<Target>,
}

impl<'a> Targets<'a> {
    pub fn new<const D: usize>(
        problem: &(impl NonlinearProblem<D> + ?Sized),
        params: &'a NewtonParams,
        unknowns: usize,
        start: f64,
    ) -> Self {
        let scales = is_asked(params).then(|| problem.largest_gradient_scales());
        Self {
            params,
            start,
            largest: Target::of_scales(params, scales.flatten(), unknowns),
        }
    }

    /// At `x`.
    pub fn at<const D: usize>(
        &self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
    ) -> Target {
        let params = self.params;
        // The problem has to evaluate something to tell, so it is asked only if it matters.
        let scales = is_asked(params).then(|| problem.gradient_scales(x));
        Target::of_scales(params, scales.flatten(), x.len()).unwrap_or_else(|| Target {
            absolute: params.gradient_tolerance,
            relative: Relative::Same(
                params.relative_gradient_tolerance * params.reference.unwrap_or(self.start),
            ),
        })
    }

    /// After a step: far from the end the largest target that can be says so, and costs nothing.
    pub fn after_step<const D: usize>(
        &self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        gradient: &[f64],
        stalled: bool,
    ) -> Target {
        let far = |largest: &&Target| largest.met_by(gradient).is_none();
        match self.largest.as_ref().filter(far) {
            Some(largest) if !stalled => largest.clone(),
            _ => self.at(problem, x),
        }
    }
}

impl Target {
    fn of_scales(params: &NewtonParams, scales: Option<Vec<f64>>, unknowns: usize) -> Option<Self> {
        let usable = |s: &Vec<f64>| s.len() == unknowns && s.iter().all(|s| s.is_finite());
        let mut scales = scales.filter(usable)?;
        let share = params.relative_gradient_tolerance;
        scales.iter_mut().for_each(|s| *s *= share);
        Some(Self {
            absolute: params.gradient_tolerance,
            relative: Relative::Each(scales),
        })
    }

    fn of(&self, i: usize) -> f64 {
        match &self.relative {
            Relative::Same(size) => *size,
            Relative::Each(sizes) => sizes[i],
        }
    }

    /// Is entry `i` small enough?
    pub fn allows(&self, i: usize, g: f64) -> bool {
        g.abs() <= self.absolute || g.abs() <= self.of(i)
    }

    pub fn met_by(&self, gradient: &[f64]) -> Option<StopReason> {
        if norm_inf(gradient) <= self.absolute {
            Some(StopReason::Gradient)
        } else if (gradient.iter().enumerate()).all(|(i, &g)| self.allows(i, g)) {
            Some(StopReason::RelativeGradient)
        } else {
            None
        }
    }

    /// The reduction that still separates the gradient from what is allowed, at most 1.
    pub fn remaining(&self, gradient: &[f64]) -> f64 {
        let left = |(i, g): (usize, &f64)| self.of(i).max(self.absolute) / g.abs();
        let entries = gradient.iter().enumerate().filter(|(_, g)| **g != 0.0);
        entries.map(left).fold(1.0, f64::min)
    }
}

/// Does the problem say how large forces are?
fn is_asked(params: &NewtonParams) -> bool {
    params.relative_gradient_tolerance > 0.0 && params.reference.is_none()
}
