//! Numbers of θ beside activations and bones: pressures, loads, strengths, stiffnesses, motions.

use super::error::RigError;
use super::parameters::Parameters;
use fem_assembly::Assembly;

/// A number c of θ that an animator sets or a fit finds beside activations and bones.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// What counts as much as an activation of 1 when poses are compared: the largest value in use, in
    /// the control's own unit (say, 3000 Pa).
    pub unit: f64,
    /// What it does.
    pub effect: Effect,
}

/// What a control does.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Effect {
    /// It is the next control of the assembly past those of the muscles: a pressure (pascals), the
    /// factor of a load, the relative change of a strength or stiffness.
    Energy,
    /// Prescribed coordinates (node, axis) stand c times so many meters from rest, in the cranium's
    /// frame; motions of the same coordinate add up.
    Motion(Vec<(usize, usize, f64)>),
}

/// The controls of a rig, checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Controls {
    list: Vec<Control>,
    muscles: usize,
}

impl Controls {
    pub fn none(assembly: &Assembly<3>) -> Self {
        Self {
            list: Vec::new(),
            muscles: assembly.controls(),
        }
    }

    pub fn new(list: Vec<Control>, assembly: &Assembly<3>, jaw: &[u32]) -> Result<Self, RigError> {
        let energies = list.iter().filter(|c| c.effect == Effect::Energy).count();
        let Some(muscles) = assembly.controls().checked_sub(energies) else {
            return Err(RigError::WrongLength {
                what: "controls of the energy",
                found: energies,
                expected: assembly.controls(),
            });
        };
        for (control, Control { unit, effect }) in list.iter().enumerate() {
            if !(*unit > 0.0 && unit.is_finite()) {
                let unit = *unit;
                return Err(RigError::ControlUnit { control, unit });
            }
            let Effect::Motion(moved) = effect else {
                continue;
            };
            for &(node, axis, meters) in moved {
                let free = !assembly.dofs().is_prescribed(node, axis);
                if free || jaw.contains(&(node as u32)) || !meters.is_finite() {
                    return Err(RigError::MotionNotPrescribed {
                        control,
                        node,
                        axis,
                    });
                }
            }
        }
        Ok(Self { list, muscles })
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }
    pub fn muscles(&self) -> usize {
        self.muscles
    }

    /// What the assembly's energy is given.
    pub fn of_energy(&self, parameters: &Parameters) -> Vec<f64> {
        let own = self.list.iter().zip(&parameters.controls);
        let own = own.filter(|(c, _)| c.effect == Effect::Energy);
        let own = own.map(|(_, value)| *value);
        parameters.activations.iter().copied().chain(own).collect()
    }

    /// Which control of the assembly's energy this one is.
    pub fn place(&self, control: usize) -> Option<usize> {
        let (before, here) = (self.list.get(..control)?, self.list.get(control)?);
        let energies = before.iter().filter(|c| c.effect == Effect::Energy);
        (here.effect == Effect::Energy).then(|| self.muscles + energies.count())
    }

    /// (node, axis, meters at 1) of a motion; nothing for others.
    pub fn motion(&self, control: usize) -> &[(usize, usize, f64)] {
        match self.list.get(control).map(|c| &c.effect) {
            Some(Effect::Motion(moved)) => moved,
            _ => &[],
        }
    }

    /// Does this change move prescribed nodes?
    pub fn moves(&self, change: &[f64]) -> bool {
        (0..self.len()).any(|k| change[k] != 0.0 && !self.motion(k).is_empty())
    }

    /// The part of a change that moves prescribed nodes, 0 for the others.
    pub fn only_moves(&self, change: &[f64]) -> Vec<f64> {
        let moves = |k: usize| k < self.len() && !self.motion(k).is_empty();
        let kept = change.iter().enumerate();
        kept.map(|(k, c)| if moves(k) { *c } else { 0.0 }).collect()
    }

    /// Puts the coordinates that motions prescribe where they are at these values.
    pub fn place_moved(&self, rest: &[[f64; 3]], values: &[f64], z: &mut [[f64; 3]]) {
        for k in 0..self.len() {
            for &(node, axis, _) in self.motion(k) {
                z[node][axis] = rest[node][axis];
            }
        }
        for (k, value) in values.iter().enumerate().take(self.len()) {
            for &(node, axis, meters) in self.motion(k) {
                z[node][axis] += value * meters;
            }
        }
    }

    /// Each change in its own unit.
    pub fn in_units<'a>(&'a self, change: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        change.iter().zip(&self.list).map(|(d, c)| d / c.unit)
    }
}
