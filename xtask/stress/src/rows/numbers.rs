//! Numbers that no solve may start from: NaN, infinite, denormal, and an energy without curvature.

use super::meshes::back;
use crate::body::Body;
use crate::named::Named;
use crate::row::{Evidence, Settings};
use crate::{Expected, Failure, Row};
use fem_assembly::NodalLoads;
use fem_solvers::{BlockPattern, BlockSymmetric, HessianProjection, Newton, NonlinearProblem};
use std::sync::Arc;

/// The rows.
pub fn rows() -> Vec<Row> {
    let error = Expected::Error;
    let start = |name: &str, what: &str, expected, value: f64| {
        Row::new("input", name, what, expected, move |settings| {
            let body = block("neo_hookean")?;
            let mut from = body.mesh().nodes().to_vec();
            if let Some(free) = (0..from.len()).find(|&n| from[n][2] > 0.0) {
                from[free][1] = value;
            }
            back(&body, from, settings)
        })
    };
    let model = |name: &str, what: &str, expected, mu: f64, lambda: f64| {
        Row::new("input", name, what, expected, move |settings| {
            let flesh = Named::new("neo_hookean", &[("mu", mu), ("lambda", lambda)]);
            let body = Body::block([2; 3], [1.0; 3], flesh)?.holding(|p| p[2] == 0.0);
            let pulled = |p: [f64; 3]| [p[0], p[1], 1.1 * p[2]];
            back(&body, body.placed(|p| p, pulled), settings)
        })
    };
    vec![
        start(
            "input-nan-start",
            "a start that is NaN",
            error("AssemblyError::NotFinite"),
            f64::NAN,
        ),
        start(
            "input-infinite-start",
            "a start that is infinite",
            error("AssemblyError::NotFinite"),
            f64::INFINITY,
        ),
        start(
            "input-huge-start",
            "a start of 1e300 m",
            error("NewtonFailure::OutsideDomain"),
            1e300,
        ),
        start(
            "input-denormal-start",
            "a start of 1e-310 m",
            Expected::Answer,
            1e-310,
        ),
        model(
            "input-nan-modulus",
            "a modulus that is NaN",
            error("ModelError::Parameters"),
            f64::NAN,
            1e4,
        ),
        model(
            "input-negative-modulus",
            "a modulus below 0",
            error("ModelError::Parameters"),
            -1e4,
            1e4,
        ),
        Row::new(
            "input",
            "input-zero-moduli",
            "moduli of 0: flesh that resists nothing is at rest anywhere",
            Expected::Answer,
            |settings| soft(0.0, settings),
        ),
        Row::new(
            "input",
            "input-zero-moduli-named",
            "moduli of 0: named before a solve",
            Expected::Property,
            |_| {
                let body = without_shear(0.0)?;
                let assembly = body.assembly()?;
                let rest = assembly.configuration(body.mesh().nodes(), &[])?;
                match assembly.free_motions(rest).as_slice() {
                    [part] if part.limp => Ok(Evidence::holds(part.to_string())),
                    parts => Err(Failure::lie(format!("{parts:?}"))),
                }
            },
        ),
        Row::new(
            "input",
            "input-fluid",
            "a shear modulus of 0: any shape of its volume is at rest",
            Expected::Answer,
            |settings| soft(1e4, settings),
        ),
        model(
            "input-denormal-modulus",
            "moduli of 1e-310 Pa, whose products are 0",
            error("NewtonFailure::Indefinite"),
            1e-310,
            1e-310,
        ),
        model(
            "input-tiny-modulus",
            "moduli of 1e-290 Pa",
            Expected::Answer,
            1e-290,
            1e-290,
        ),
        model(
            "input-huge-modulus",
            "moduli of 1e290 Pa",
            Expected::Answer,
            1e290,
            1e290,
        ),
        Row::new(
            "input",
            "input-nan-tolerance",
            "a tolerance that is NaN",
            error("NewtonFailure::Params"),
            |settings| {
                let body = block("neo_hookean")?;
                let mut params = settings.newton(100);
                params.relative_gradient_tolerance = f64::NAN;
                Ok(body
                    .solve_with(body.mesh().nodes().to_vec(), &params)?
                    .evidence)
            },
        ),
        Row::new(
            "input",
            "input-nan-load",
            "a force that is NaN",
            error("AssemblyError::NotFinite"),
            |settings| loaded([f64::NAN, 0.0, 0.0], settings),
        ),
        Row::new(
            "input",
            "input-denormal-load",
            "a force of 1e-310 N",
            Expected::Answer,
            |settings| loaded([1e-310, 0.0, 0.0], settings),
        ),
        Row::new(
            "input",
            "input-zero-hessian",
            "an energy without any curvature, and a slope: it falls without end",
            Expected::ErrorAfter("NewtonFailure::NotConverged", 100),
            |settings| zero_hessian(1.0, settings),
        ),
        Row::new(
            "input",
            "input-zero-hessian-at-rest",
            "an energy that is 0 everywhere",
            Expected::Property,
            |settings| zero_hessian(0.0, settings),
        ),
    ]
}

fn block(model: &str) -> Result<Body, Failure> {
    let flesh = Named::elastic(model, 1e4, 0.4);
    Ok(Body::block([2; 3], [1.0; 3], flesh)?.holding(|p| p[2] == 0.0))
}

/// No shear modulus: rest is not one shape.
fn without_shear(lambda: f64) -> Result<Body, Failure> {
    let flesh = Named::new("neo_hookean", &[("mu", 0.0), ("lambda", lambda)]);
    Ok(Body::block([2; 3], [1.0; 3], flesh)?.holding(|p| p[2] == 0.0))
}

fn soft(lambda: f64, settings: &Settings) -> Result<Evidence, Failure> {
    let body = without_shear(lambda)?;
    let pulled = |p: [f64; 3]| [p[0], p[1], 1.1 * p[2]];
    Ok(body
        .solve(body.placed(|p| p, pulled), settings, 100)?
        .evidence)
}

fn loaded(force: [f64; 3], settings: &Settings) -> Result<Evidence, Failure> {
    let body = block("neo_hookean")?;
    let last = body.mesh().num_nodes() - 1;
    let body = body.with_terms(move |builder| builder.term(NodalLoads::new(vec![(last, force)])?));
    Ok(body
        .solve(body.mesh().nodes().to_vec(), settings, 100)?
        .evidence)
}

/// E = slope · x, whose Hessian is 0.
struct Flat {
    pattern: Arc<BlockPattern>,
    slope: f64,
}

impl NonlinearProblem<3> for Flat {
    fn blocks(&self) -> usize {
        self.pattern.blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        x.iter().map(|x| self.slope * x).sum()
    }
    fn gradient(&self, _: &[f64], g: &mut [f64]) {
        g.fill(self.slope);
    }
    fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<3>) {
        out.values_mut().fill([[0.0; 3]; 3]);
    }
}

fn zero_hessian(slope: f64, settings: &Settings) -> Result<Evidence, Failure> {
    let pattern = BlockPattern::from_adjacency(5, (1..5).map(|i| (i - 1, i)));
    let pattern = Arc::new(pattern.map_err(|e| Failure::trial(&e))?);
    let flat = Flat { pattern, slope };
    let mut x = vec![0.5; 15];
    let info = Newton::new(&flat).solve(&flat, &mut x, &settings.newton(100))?;
    Ok(Evidence {
        steps: info.iterations,
        left: info.gradient_norm,
        ..Evidence::default()
    })
}
