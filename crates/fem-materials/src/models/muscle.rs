//! The whole muscle of document 000, eq. 10.

use super::fiber::{Fiber, PARAMETERS as FIBER, fiber_from};
use super::{MooneyRivlin, VolumetricLog};
use crate::fiber::Stretch;
use crate::registry::{Entry, Parameter, ParameterError, Parameters, Register};
use crate::sum::Sum;

/// Passive flesh: A I₁ + B I₂ + K/2 (ln J)².
pub type Flesh = Sum<MooneyRivlin, VolumetricLog>;

/// Passive flesh with one family of fibers: W = A I₁ + B I₂ + U(J) + F₂(λ, α) (eq. 10).
pub type Muscle<C = crate::curves::BuiltinCurve> = Sum<Flesh, Fiber<C>>;

impl Flesh {
    /// A I₁ + B I₂ + K/2 (ln J)²; A, B and K in Pa.
    pub const fn new(A: f64, B: f64, K: f64) -> Self {
        Sum(MooneyRivlin { A, B }, VolumetricLog { K })
    }
}

const PARAMETERS: [Parameter; 11] = [
    Parameter::pascals("A", "6e4", "coefficient of I1"),
    Parameter::pascals("B", "2e4", "coefficient of I2"),
    Parameter::pascals("K", "6e4", "bulk modulus of the volume term"),
    FIBER[0],
    FIBER[1],
    FIBER[2],
    FIBER[3],
    FIBER[4],
    FIBER[5],
    FIBER[6],
    FIBER[7],
];

const FLESH: [Parameter; 3] = [
    PARAMETERS[0].also(&["a"]),
    PARAMETERS[1].also(&["b"]),
    PARAMETERS[2].also(&["bulk"]),
];

fn flesh_from(p: &Parameters) -> Result<Flesh, ParameterError> {
    let (A, B) = (p.non_negative("A")?, p.non_negative("B")?);
    if A + B == 0.0 {
        return Err(ParameterError::OutOfRange {
            name: "A",
            value: A,
            range: "greater than 0 where B is 0",
        });
    }
    Ok(Flesh::new(A, B, p.positive("K")?))
}

fn muscle_from(p: &Parameters, stretch: Stretch) -> Result<Muscle, ParameterError> {
    let flesh = Flesh::new(p.number("A")?, p.number("B")?, p.non_negative("K")?);
    Ok(Sum(flesh, fiber_from(p, stretch)?))
}

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "mooney_rivlin",
        aliases: &[],
        elastic: None,
        about: "passive flesh of a face: mooney_rivlin_isochoric and volumetric_log (document 000)",
        domain: "J > 0",
        parameters: &FLESH,
        from_parameters: flesh_from,
    });
    visitor.solid(&Entry {
        name: "muscle_isochoric",
        aliases: &["muscle_dev"],
        elastic: None,
        about: "muscles of a face, isochoric fiber stretch (document 000)",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| muscle_from(p, Stretch::Isochoric),
    });
    visitor.solid(&Entry {
        name: "muscle_total",
        aliases: &["muscle_tilde"],
        elastic: None,
        about: "muscles of a face, total fiber stretch (document 000 as PhysBAM runs it)",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| muscle_from(p, Stretch::Total),
    });
}
