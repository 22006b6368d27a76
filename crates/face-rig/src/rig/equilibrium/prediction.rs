//! Where the flesh goes, to first order, when a pose changes.

use super::super::loads::{Loads, Push};
use super::{Equilibrium, Rig};
use crate::anatomy::AffineMap;
use crate::rig::Parameters;
use fem_assembly::Quasistatic;

/// Share of the force that may be left when a change is predicted by conjugate gradients.
const PREDICTION: f64 = 1e-4;
/// Of the whole change, what is tried beside it as a guess. Quarters of equal numbers add up to them to the
/// last bit, so bones stay exactly where they are.
const SHARES: [f64; 4] = [0.75, 0.5, 0.25, 0.0];
/// Right-hand sides of a prediction: the whole change, and that of the bones alone.
const PREDICTED: usize = 2;

impl Rig {
    /// z at `state` moved along the tangent to `pose`, bones exactly there. Only a guess: where the
    /// tangent does not exist the flesh stays. Muscles may bend the way so much that it is better
    /// to follow the bones alone, or the muscles for a part of the way.
    pub(super) fn predict(&mut self, state: &Equilibrium, pose: &Parameters) -> Vec<[f64; 3]> {
        let mut stays = state.in_cranium_frame.clone();
        self.place_bones(&mut stays, pose);
        let change = Change::between(&state.parameters, pose);
        let moves_bones = state.parameters.jaw != pose.jaw || self.controls.moves(&change.controls);
        let known = self.tangent.as_ref().is_some_and(|t| t.at == *state);
        if !(known || moves_bones) || self.renew(state).is_err() {
            return stays;
        }
        let Some(whole) = self.along(state, &change, pose) else {
            return stays;
        };
        let of_bones = Change {
            activations: vec![0.0; change.activations.len()],
            controls: self.controls.only_moves(&change.controls),
            jaw: change.jaw,
        };
        if of_bones.activations == change.activations && of_bones.controls == change.controls {
            return whole;
        }
        let other = match moves_bones {
            true => self.along(state, &of_bones, pose).unwrap_or(stays),
            false => stays,
        };
        self.least_energy(&whole, &other, pose)
    }

    /// Of guesses on the way from `some` to `all` of a change the one that is closest to an equilibrium;
    /// the whole change where none has an energy. An energy costs a thirtieth of a Newton step, and far
    /// along a tangent lips lie in each other, from where a solve takes dozens of steps.
    fn least_energy(
        &self,
        all: &[[f64; 3]],
        some: &[[f64; 3]],
        pose: &Parameters,
    ) -> Vec<[f64; 3]> {
        let controls = self.controls.of_energy(pose);
        let between = |share: f64| -> Vec<[f64; 3]> {
            let mixed = |(a, b): (&[f64; 3], &[f64; 3])| {
                std::array::from_fn(|i| share * a[i] + (1.0 - share) * b[i])
            };
            all.iter().zip(some).map(mixed).collect()
        };
        let energy = |z: &[[f64; 3]]| {
            let at = self.assembly.configuration(z, &controls);
            at.map_or(f64::INFINITY, |at| self.assembly.energy(at))
        };
        let mut best = all.to_vec();
        let mut least = energy(&best);
        for share in SHARES {
            let guess = between(share);
            let of_guess = energy(&guess);
            if of_guess < least {
                (best, least) = (guess, of_guess);
            }
        }
        best
    }

    /// z moved along a change, bones at their pose.
    fn along(
        &mut self,
        state: &Equilibrium,
        change: &Change,
        pose: &Parameters,
    ) -> Option<Vec<[f64; 3]>> {
        let known = self.tangent.as_ref().is_some_and(|t| t.at == *state);
        let dz = if known || !self.multigrid {
            self.solved_change(state, change)
        } else {
            self.iterated_change(state, change)
        };
        let moved = state.in_cranium_frame.iter().zip(dz?);
        let moved = moved.map(|(z, d)| std::array::from_fn(|i| z[i] + d[i]));
        let mut z: Vec<[f64; 3]> = moved.collect();
        self.place_bones(&mut z, pose);
        Some(z)
    }

    /// dz of a change, by what the stiffness of the tangent is solved with.
    fn solved_change(&mut self, state: &Equilibrium, change: &Change) -> Option<Vec<[f64; 3]>> {
        self.ensure_tangent(state, PREDICTED).ok()?;
        let tangent = self.tangent.as_ref()?;
        let Push { bones, mut force } = self.push(state, &tangent.energy, change)?;
        let solved = tangent.stiffness.solve_many(&mut force, 1, PREDICTION);
        self.work.add(0, 0, solved.ok()?.iterations);
        self.with_flesh(bones, &force)
    }

    /// dz of a change, by conjugate gradients.
    fn iterated_change(&mut self, state: &Equilibrium, change: &Change) -> Option<Vec<[f64; 3]>> {
        let energy = self.controls.of_energy(&state.parameters);
        let Push { bones, force } = self.push(state, &energy, change)?;
        let z = state.in_cranium_frame.clone();
        let problem = Quasistatic::new(&self.assembly, z, energy).ok()?;
        let (x, params) = (problem.unknowns(), &self.params.newton);
        let newton = &mut self.newton;
        let found = newton.linearized(&problem, &x, &force, PREDICTION, params);
        self.with_flesh(bones, &found.ok()?)
    }

    fn push(&self, state: &Equilibrium, energy: &[f64], change: &Change) -> Option<Push> {
        let at = self.assembly.configuration(&state.in_cranium_frame, energy);
        let loads = Loads {
            assembly: &self.assembly,
            at: at.ok()?,
            jaw: &self.jaw,
            controls: &self.controls,
        };
        let pushed = loads.push(&change.activations, &change.jaw, &change.controls);
        pushed.ok()
    }

    fn with_flesh(&self, mut dz: Vec<[f64; 3]>, flesh: &[f64]) -> Option<Vec<[f64; 3]>> {
        self.assembly.dofs().scatter(flesh, &mut dz).ok()?;
        Some(dz)
    }
}

/// What changes the shape in the cranium's frame on the way between two poses.
pub(super) struct Change {
    pub activations: Vec<f64>,
    pub jaw: AffineMap,
    pub controls: Vec<f64>,
}

impl Change {
    pub fn between(from: &Parameters, to: &Parameters) -> Self {
        let (a, b) = (from.jaw.to_array(), to.jaw.to_array());
        let less = |b: &[f64], a: &[f64]| b.iter().zip(a).map(|(b, a)| b - a).collect();
        Self {
            activations: less(&to.activations, &from.activations),
            controls: less(&to.controls, &from.controls),
            jaw: AffineMap::from_array(std::array::from_fn(|k| b[k] - a[k])),
        }
    }
}
