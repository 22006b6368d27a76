//! A rig that trusts no `Ok`: in tests it stands for that of the crate.
#![allow(dead_code)] // Crates share this file.

#[path = "../../../fem-assembly/tests/all/promise.rs"]
mod body;

use face_rig::fit::{FitError, FitIteration, FitReport, Fitter};
use face_rig::rig::{Control, Equilibrium, Parameters, RigError, RigParams, Sensitivity, Work};
use fem_assembly::{Assembly, Evaluations};
use fem_solvers::{StopReason, Watch};
use std::ops::Deref;

/// Checks every pose that it finds, by sums of its own.
#[derive(Debug)]
pub struct Rig {
    inner: face_rig::rig::Rig,
    params: RigParams,
    /// What the checks evaluated, which no solve paid for.
    checks: Vec<Evaluations>,
}

impl Rig {
    pub fn new(assembly: Assembly<3>, jaw: &[usize], params: RigParams) -> Result<Self, RigError> {
        let inner = face_rig::rig::Rig::new(assembly, jaw, params)?;
        Ok(Self::of(inner, params))
    }

    /// Of a rig that was made with these settings.
    pub fn of(inner: face_rig::rig::Rig, params: RigParams) -> Self {
        let checks = Vec::new();
        Self {
            inner,
            params,
            checks,
        }
    }

    pub fn with_controls(mut self, controls: Vec<Control>) -> Result<Self, RigError> {
        self.inner = self.inner.with_controls(controls)?;
        Ok(self)
    }

    pub fn watched_by(mut self, watch: Watch) -> Self {
        self.inner = self.inner.watched_by(watch);
        self
    }

    #[track_caller]
    pub fn solve(&mut self, pose: &Parameters) -> Result<&Equilibrium, RigError> {
        self.inner.solve(pose)?;
        self.check();
        Ok(self.inner.equilibrium())
    }

    /// What solves by itself, a fit: the pose that it leaves is checked.
    #[track_caller]
    pub fn lent<T, E>(
        &mut self,
        to: impl FnOnce(&mut face_rig::rig::Rig) -> Result<T, E>,
    ) -> Result<T, E> {
        let done = to(&mut self.inner)?;
        self.check();
        Ok(done)
    }

    #[track_caller]
    pub fn fit(
        &mut self,
        fitter: &Fitter<'_>,
        start: &[f64],
        observer: &mut dyn FnMut(&FitIteration),
    ) -> Result<FitReport, FitError> {
        self.lent(|rig| fitter.fit(rig, start, observer))
    }

    pub fn sensitivity(&mut self) -> Result<Sensitivity<'_>, RigError> {
        self.inner.sensitivity()
    }

    pub fn start_from(&mut self, equilibrium: Equilibrium) -> Result<(), RigError> {
        self.inner.start_from(equilibrium)
    }

    /// Without that of the checks.
    pub fn work(&self) -> Work {
        let mut work = self.inner.work();
        for checked in &self.checks {
            work.evaluations = work.evaluations - *checked;
        }
        work
    }

    /// The same with what touches there: of a body like the rig's that has seen nothing before.
    #[track_caller]
    pub fn check_afresh(&self, mut body: Assembly<3>) {
        let at = self.inner.equilibrium();
        let controls = self.inner.energy_controls(&at.parameters);
        let z = &at.in_cranium_frame;
        body.renew(body.configuration(z, &controls).unwrap())
            .unwrap();
        let (params, stop) = (&self.params.newton, StopReason::Rounding);
        body::came_to_rest(&body, z, &controls, params, stop);
    }

    #[track_caller]
    fn check(&mut self) {
        let (rig, at) = (&self.inner, self.inner.equilibrium());
        let before = rig.assembly().evaluations();
        let controls = rig.energy_controls(&at.parameters);
        // A rig does not say which test its last solve met: the weakest promise.
        let stop = StopReason::Rounding;
        let z = &at.in_cranium_frame;
        body::came_to_rest(rig.assembly(), z, &controls, &self.params.newton, stop);
        self.checks.push(rig.assembly().evaluations() - before);
    }
}

impl Deref for Rig {
    type Target = face_rig::rig::Rig;
    fn deref(&self) -> &Self::Target {
        &self.inner
    }
}
