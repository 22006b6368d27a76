//! What pushes the flesh when a pose changes.

use super::control::Controls;
use super::parameters::Direction;
use crate::anatomy::AffineMap;
use fem_assembly::{Assembly, AssemblyError, Configuration};

/// The forces that directions exert at one equilibrium.
#[derive(Debug)]
pub(super) struct Loads<'a> {
    pub assembly: &'a Assembly<3>,
    pub at: Configuration<'a, 3>,
    pub jaw: &'a [u32],
    pub controls: &'a Controls,
}

/// What a change of the pose does before the flesh gives way.
pub(super) struct Push {
    /// dz^C, zero at the free nodes.
    pub bones: Vec<[f64; 3]>,
    /// The force on the free nodes: K dz^U is this.
    pub force: Vec<f64>,
}

impl Loads<'_> {
    /// Of one change of activations, jaw and controls together.
    pub fn push(
        &self,
        activations: &[f64],
        jaw: &AffineMap,
        controls: &[f64],
    ) -> Result<Push, AssemblyError> {
        let mut bones = self.bone_motion(&Direction::Jaw(*jaw));
        let mut force = vec![0.0; self.assembly.dofs().vector_len()];
        let mut unit = vec![0.0; force.len()];
        let muscles = activations.iter().enumerate();
        let muscles = muscles.map(|(m, c)| (Direction::Activation(m), *c));
        let numbers = controls.iter().enumerate();
        let numbers = numbers.map(|(k, c)| (Direction::Control(k), *c));
        for (direction, change) in muscles.chain(numbers).filter(|(_, c)| *c != 0.0) {
            match self.of_energy(&direction) {
                Some(_) => self.load(&direction, &mut unit)?,
                None => {
                    self.add_motion(&direction, change, &mut bones);
                    continue;
                }
            }
            force
                .iter_mut()
                .zip(&unit)
                .for_each(|(f, u)| *f -= change * u);
        }
        self.assembly.hessian_vector(self.at, &bones, &mut unit)?;
        force.iter_mut().zip(&unit).for_each(|(f, u)| *f -= u);
        Ok(Push { bones, force })
    }

    /// ∂²E/∂z^U∂θ dθ: minus the force that a direction exerts on the free nodes.
    pub fn load(&self, direction: &Direction, rhs: &mut [f64]) -> Result<(), AssemblyError> {
        match direction {
            Direction::Cranium(_) => {
                rhs.fill(0.0);
                Ok(())
            }
            _ => match self.of_energy(direction) {
                Some(control) => self.assembly.control_gradient(self.at, control, rhs),
                None => self
                    .assembly
                    .hessian_vector(self.at, &self.bone_motion(direction), rhs),
            },
        }
    }

    /// The control of the assembly's energy that a direction is, if it is one.
    pub fn of_energy(&self, direction: &Direction) -> Option<usize> {
        match direction {
            Direction::Activation(muscle) => Some(*muscle),
            Direction::Control(control) => self.controls.place(*control),
            Direction::Cranium(_) | Direction::Jaw(_) => None,
        }
    }

    /// Adds a motion's dz^C.
    fn add_motion(&self, direction: &Direction, change: f64, dz: &mut [[f64; 3]]) {
        if let Direction::Control(control) = direction {
            for &(node, axis, meters) in self.controls.motion(*control) {
                dz[node][axis] += change * meters;
            }
        }
    }

    /// dz^C of a direction; zero at the free nodes.
    pub fn bone_motion(&self, direction: &Direction) -> Vec<[f64; 3]> {
        let rest = self.assembly.rest();
        let mut dz = vec![[0.0; 3]; rest.len()];
        if let Direction::Jaw(d) = direction {
            let d: &AffineMap = d;
            for &node in self.jaw {
                dz[node as usize] = d.apply(rest[node as usize]);
            }
        }
        self.add_motion(direction, 1.0, &mut dz);
        dz
    }
}
