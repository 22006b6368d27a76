//! What all particles of one kind share.

use crate::damage::DamageModel;

/// Is the fiber direction e₁ of a body's fiber frame free to stretch?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fiber {
    /// As far as the material lets it.
    Extensible,
    /// Not at all: the grid velocity is projected (document 001, alg. 11).
    Inextensible,
}

/// The material, the damage and the fiber of one kind of material.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<M, const D: usize> {
    /// Elasticity, in the particles' fiber frame: F maps it to the world, so a particle whose fibers
    /// lie along the unit vector a starts with a rotation whose first column is a, and the axes of
    /// the material are fiber directions without any rotation at run time.
    pub material: M,
    /// Damage, if the material can tear.
    pub damage: Option<DamageModel<D>>,
    /// The fiber constraint.
    pub fiber: Fiber,
}

impl<M, const D: usize> Body<M, D> {
    /// A body that neither tears nor has inextensible fibers.
    pub fn elastic(material: M) -> Self {
        Self {
            material,
            damage: None,
            fiber: Fiber::Extensible,
        }
    }
}
