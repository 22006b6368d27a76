//! What all particles of one kind share.

use crate::damage::DamageModel;

/// Is the fiber direction e₁ of a body's fiber frame free to stretch?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fiber {
    /// As far as the law lets it.
    Extensible,
    /// Not at all: the grid velocity is projected (document 001, alg. 11).
    Inextensible,
}

/// The law, the damage and the fiber of one kind of material.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<L, const D: usize> {
    /// Elasticity.
    pub law: L,
    /// Damage, if the material can tear.
    pub damage: Option<DamageModel<D>>,
    /// The fiber constraint.
    pub fiber: Fiber,
}

impl<L, const D: usize> Body<L, D> {
    /// A body that neither tears nor has inextensible fibers.
    pub fn elastic(law: L) -> Self {
        Self {
            law,
            damage: None,
            fiber: Fiber::Extensible,
        }
    }
}
