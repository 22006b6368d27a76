//! One family of muscle fibers with the same parameters everywhere (document 000, 4.2).

use crate::curves::BuiltinCurve;
use crate::curves::{Blemker, PhysBam};
use crate::fiber::{FiberLaw, FiberTerm, Stretch};
use crate::field::At;
use crate::registry::{Entry, Parameter, ParameterError, Parameters, Register};

/// ψ = σ_max (α F_a(l) + F_p(l)), l = λ/λ_ofl: a muscle's fibers without the flesh around them.
///
/// λ is |F a₀| or J^(−1/3) |F a₀| as `field.stretch` says. Muscles that differ from element to
/// element are the field [`FiberLaw`] itself; ∂P/∂α is its
/// [`stress_by_control`](crate::field::MaterialField::stress_by_control) at `local`.
pub type Fiber<C = BuiltinCurve> = At<FiberLaw<C>, FiberTerm<f64>>;

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
    Parameter::pascals("max_isometric_stress", "3e5", "largest active tension")
        .also(&["sigma_max"]),
    Parameter::plain(
        "optimal_stretch",
        "1.0",
        "stretch of the largest active tension",
    )
    .also(&["lambda_ofl"]),
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
        field: FiberLaw { curve, stretch },
        local: FiberTerm {
            direction: p.direction("a0")?,
            max_isometric_stress: p.non_negative("max_isometric_stress")?,
            activation: p.non_negative("alpha")?,
            optimal_stretch: p.positive("optimal_stretch")?,
        },
    })
}

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "fiber_isochoric",
        aliases: &["fiber_dev"],
        elastic: None,
        about: "muscle fibers that do not feel a change of volume, isochoric stretch (document 000, 4.2)",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| fiber_from(p, Stretch::Isochoric),
    });
    visitor.solid(&Entry {
        name: "fiber_total",
        aliases: &["fiber_tilde"],
        elastic: None,
        about: "muscle fibers on top of any flesh, total stretch (what PhysBAM runs)",
        domain: "all F",
        parameters: &PARAMETERS,
        from_parameters: |p| fiber_from(p, Stretch::Total),
    });
}
