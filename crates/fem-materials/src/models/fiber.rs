//! One family of muscle fibers with the same parameters everywhere (document 000, 4.2).

use crate::curves::{Blemker, PhysBam};
use crate::curves::{BuiltinCurve, TensionCurve};
use crate::fiber::{FiberLaw, FiberTerm, Stretch};
use crate::material::{Evaluation, Material};
use crate::registry::{Entry, Parameter, ParameterError, Parameters, Register};
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = σ_max (α F_a(l) + F_p(l)), l = λ/λ_ofl: a muscle's fibers without the flesh around them.
///
/// λ is |F a₀| or J^(−1/3) |F a₀| as `law.stretch` says. For muscles that differ from element to
/// element use [`FiberTerm`] itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fiber<C = BuiltinCurve> {
    /// Curve and kind of stretch.
    pub law: FiberLaw<C>,
    /// Direction, peak tension, activation and optimal stretch.
    pub term: FiberTerm<f64>,
}

/// The parameters of a fiber, in tables and scene files.
pub(crate) const PARAMETERS: [Parameter; 8] = [
    Parameter::plain("curve", "physbam", "`physbam` or `blemker`"),
    Parameter::plain("P1", "0.05", "height of the passive curve"),
    Parameter::plain("P2", "6.6", "growth of the passive curve"),
    Parameter::plain(
        "lambda_star",
        "1.4",
        "stretch from which the passive curve is straight",
    ),
    Parameter::pascals("sigma_max", "3e5", "peak tension"),
    Parameter::plain("lambda_ofl", "1.0", "optimal stretch"),
    Parameter::plain("alpha", "0.3", "activation, 0 to 1"),
    Parameter::plain(
        "a0",
        "0.6 0.0 0.8",
        "fiber direction in the rest shape, of length 1",
    ),
];

/// Reads a fiber from its [`PARAMETERS`].
pub(crate) fn fiber_from(p: &Parameters, stretch: Stretch) -> Result<Fiber, ParameterError> {
    let (P1, P2) = (p.non_negative("P1")?, p.positive("P2")?);
    let lambda_star = p.number_where("lambda_star", "1 or greater", |x| x >= 1.0)?;
    let curve = match p.text("curve")? {
        "physbam" => BuiltinCurve::PhysBam(PhysBam {
            P1,
            P2,
            lambda_star,
        }),
        "blemker" => BuiltinCurve::Blemker(Blemker {
            P1,
            P2,
            lambda_star,
        }),
        other => {
            return Err(ParameterError::Choice {
                name: "curve",
                text: other.to_owned(),
                choices: "`physbam`, `blemker`",
            });
        }
    };
    Ok(Fiber {
        law: FiberLaw { curve, stretch },
        term: FiberTerm {
            direction: p.direction("a0")?,
            max_isometric_stress: p.non_negative("sigma_max")?,
            activation: p.non_negative("alpha")?,
            optimal_stretch: p.positive("lambda_ofl")?,
        },
    })
}

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "fiber_isochoric",
        aliases: &["fiber_dev"],
        elastic: None,
        about: "muscle fibers alone, deviatoric stretch (document 000, 4.2)",
        parameters: &PARAMETERS,
        from_parameters: |p| fiber_from(p, Stretch::Isochoric),
    });
    visitor.solid(&Entry {
        name: "fiber_total",
        aliases: &["fiber_tilde"],
        elastic: None,
        about: "muscle fibers alone, plain stretch (what PhysBAM runs)",
        parameters: &PARAMETERS,
        from_parameters: |p| fiber_from(p, Stretch::Total),
    });
}

impl<C: TensionCurve + Copy> Fiber<C> {
    #[inline(always)]
    fn splat<T: Real>(&self) -> FiberTerm<T> {
        FiberTerm {
            direction: self.term.direction.map(T::from_f64),
            max_isometric_stress: T::from_f64(self.term.max_isometric_stress),
            activation: T::from_f64(self.term.activation),
            optimal_stretch: T::from_f64(self.term.optimal_stretch),
        }
    }
}

impl<C: TensionCurve + Copy> Material<3> for Fiber<C> {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        self.splat::<T>().energy(&self.law, F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        self.splat::<T>().stress(&self.law, F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        self.splat::<T>().stress_differential(&self.law, F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        self.splat::<T>().stress_derivative(&self.law, F)
    }
    #[inline(always)]
    fn filtered_derivative<T: Real>(
        &self,
        F: &Mat<T, 3>,
        filter: HessianProjection,
    ) -> Tensor4<T, 3> {
        self.splat::<T>().filtered_derivative(&self.law, F, filter)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, 3>) -> (T, Mat<T, 3>) {
        self.splat::<T>().energy_and_stress(&self.law, F)
    }
    #[inline(always)]
    fn evaluate<T: Real>(&self, F: &Mat<T, 3>, filter: HessianProjection) -> Evaluation<T, 3> {
        self.splat::<T>().evaluate(&self.law, F, filter)
    }
    #[inline(always)]
    fn stress_by_activation<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        self.splat::<T>().stress_by_activation(&self.law, F)
    }
}
