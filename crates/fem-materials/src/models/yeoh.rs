//! Yeoh's rubber elasticity (1993).

use crate::isotropic::{FirstInvariant, FirstInvariantEnergy, Volume};
use crate::lame::Space;
use crate::registry::{Entry, Parameter, Register};
use fem_kinematics::Real;

/// W = c₁ i + c₂ i² + c₃ i³ with i = J^(−2/3) tr C − 3: filled rubber, which softens (c₂ < 0) and
/// then stiffens (c₃ > 0). The shear modulus at rest is 2c₁.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yeoh {
    /// c₁, c₂, c₃ in Pa.
    pub c: [f64; 3],
}

const PARAMETERS: [Parameter; 4] = [
    Parameter::pascals("c1", "2e5", "half the shear modulus at rest"),
    Parameter::pascals("c2", "-1e4", "coefficient of i²"),
    Parameter::pascals("c3", "2e3", "coefficient of i³"),
    Parameter::pascals("K", "2e6", "bulk modulus"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "yeoh",
        aliases: &[],
        elastic: Some(|lame| vec![("c1", 0.5 * lame.mu), ("K", lame.bulk(Space::Solid))]),
        about: "rubber whose stiffness rises at large stretch; filled rubber from simple tests",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            let shape = Yeoh {
                c: [p.number("c1")?, p.number("c2")?, p.number("c3")?],
            };
            Ok(FirstInvariant {
                shape,
                volume: Volume {
                    K: p.non_negative("K")?,
                },
            })
        },
    });
}

impl FirstInvariantEnergy for Yeoh {
    #[inline(always)]
    fn energy_and_slopes<T: Real>(&self, i: T) -> [T; 3] {
        let f = T::from_f64;
        let [a, b, c] = self.c.map(f);
        [
            i * (a + i * (b + i * c)),
            a + i * (f(2.0) * b + f(3.0) * c * i),
            f(2.0) * b + f(6.0) * c * i,
        ]
    }
}
