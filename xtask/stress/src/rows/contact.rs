//! Contact: starts deep inside, two obstacles, a corner, lips that cross, a lid behind the eye.

use crate::body::Body;
use crate::named::Named;
use crate::row::{Evidence, Settings};
use crate::{Expected, Failure, Row};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{
    ContactPoint, FleshContact, FleshContactParams, ImplicitSurface, Penalty, RigidContact,
    RigidContactParams, RigidSurface,
};
use fem_solvers::{NewtonParams, ProjectionPolicy};

/// The rows.
pub fn rows() -> Vec<Row> {
    let answer = Expected::Answer;
    vec![
        row(
            "contact-penalty-deep",
            "a ball whose middle lies on the surface of a block: half its nodes deep inside",
            answer,
            |s| penalized(vec![ball([0.5, 0.5, 1.0], 0.4)], s),
        ),
        row(
            "contact-penalty-two-balls",
            "balls that press from two sides",
            answer,
            |s| {
                penalized(
                    vec![ball([-0.2, 0.5, 0.5], 0.4), ball([1.2, 0.5, 0.5], 0.4)],
                    s,
                )
            },
        ),
        row(
            "contact-penalty-vise",
            "two half-spaces that leave half the width of a block",
            answer,
            |s| {
                penalized(
                    vec![plane([0.25, 0.0, 0.0], 1.0), plane([0.75, 0.0, 0.0], -1.0)],
                    s,
                )
            },
        ),
        row(
            "contact-penalty-no-room",
            "two half-spaces that leave no room at all",
            answer,
            |s| {
                penalized(
                    vec![plane([0.6, 0.0, 0.0], 1.0), plane([0.4, 0.0, 0.0], -1.0)],
                    s,
                )
            },
        ),
        row(
            "contact-penalty-corner",
            "the sharp corner of a box in the top of a block",
            answer,
            |s| penalized(vec![corner()], s),
        ),
        row(
            "contact-rigid-start-inside",
            "flesh above a ball, started a third of a radius inside, no bound on the depth",
            answer,
            |s| above_a_ball(0.16, f64::INFINITY, s),
        ),
        row(
            "contact-rigid-start-beyond",
            "the same, started past the middle of the ball",
            answer,
            |s| above_a_ball(0.7, f64::INFINITY, s),
        ),
        row(
            "contact-rigid-start-beyond-depth",
            "the same with a bound on the depth",
            Expected::Error("NewtonFailure::OutsideDomain"),
            |s| above_a_ball(0.7, 0.05, s),
        ),
        row(
            "contact-lips-crossed",
            "two blocks, started a little inside each other",
            answer,
            |s| lips(0.06, 0, s),
        ),
        row(
            "contact-lips-crossed-deep",
            "the same, 0.2 of their height inside each other",
            answer,
            |s| lips(0.2, 0, s),
        )
        .long(),
        row(
            "contact-lips-walked",
            "the same, walked from where they do not touch",
            answer,
            |s| lips(0.2, 6, s),
        ),
        row(
            "contact-lid-behind-eye",
            "a lid started behind the middle of the eyeball, no bound on the depth",
            answer,
            |s| lid(f64::INFINITY, s),
        ),
        row(
            "contact-lid-behind-eye-depth",
            "the same with the bound that faces have",
            Expected::Error("NewtonFailure::OutsideDomain"),
            |s| lid(1.5e-3, s),
        ),
    ]
}

type Run = fn(&Settings) -> Result<Evidence, Failure>;

fn row(name: &str, what: &str, expected: Expected, run: Run) -> Row {
    Row::new("contact", name, what, expected, run)
}

fn ball(center: [f64; 3], radius: f64) -> ImplicitSurface<3> {
    ImplicitSurface::Sphere { center, radius }
}

/// The solid behind a plane across x.
fn plane(point: [f64; 3], outward: f64) -> ImplicitSurface<3> {
    let normal = [outward, 0.0, 0.0];
    ImplicitSurface::HalfSpace { point, normal }
}

fn corner() -> ImplicitSurface<3> {
    ImplicitSurface::Box {
        min: [0.45, 0.45, 0.8],
        max: [2.0, 2.0, 2.0],
    }
}

/// Where flesh buckles a shift leads on.
fn shifted(settings: &Settings, steps: usize) -> NewtonParams {
    NewtonParams {
        projection: ProjectionPolicy::ExactThenShifted,
        ..settings.newton(steps)
    }
}

/// A block on the ground, its nodes pushed out of obstacles.
fn penalized(obstacles: Vec<ImplicitSurface<3>>, settings: &Settings) -> Result<Evidence, Failure> {
    let n = if settings.quick { 4 } else { 8 };
    let flesh = Named::elastic("stable_neo_hookean", 1e4, 0.4);
    let body = Body::block([n, n, n], [1.0; 3], flesh)?.holding(|p| p[2] == 0.0);
    let nodes = body.mesh().num_nodes();
    let body = body.with_terms(move |mut builder| {
        for obstacle in &obstacles {
            builder = builder.penalty(Penalty {
                nodes: (0..nodes).collect(),
                stiffness: 1e4,
                obstacle: *obstacle,
            })?;
        }
        Ok(builder)
    });
    let start = body.mesh().nodes().to_vec();
    Ok(body.solve_with(start, &shifted(settings, 200))?.evidence)
}

const RADIUS: f64 = 0.5;

/// A block hung above a ball that just touches it at rest, pressed down by 0.1; the free nodes are
/// started `inside` deep.
fn above_a_ball(inside: f64, depth: f64, settings: &Settings) -> Result<Evidence, Failure> {
    let n = if settings.quick { 3 } else { 6 };
    let flesh = Named::elastic("stable_neo_hookean", 1e4, 0.4);
    let body = Body::block([n; 3], [1.0; 3], flesh)?.holding(|p| p[2] == 1.0);
    let center = [0.5, 0.5, -RADIUS];
    let body = touching(body, ball(center, RADIUS), depth, 0.05);
    let start = body.placed(
        |p| [p[0], p[1], p[2] - 0.1],
        |p| [p[0], p[1], p[2] - 0.1 - inside],
    );
    let solved = body.solve_with(start, &shifted(settings, 300))?;
    Ok(with_gap(solved.evidence, &solved.positions, center, RADIUS))
}

/// The same body, its surface pushed out of a solid.
fn touching(body: Body, solid: ImplicitSurface<3>, depth: f64, activation: f64) -> Body {
    let mesh = body.mesh().clone();
    let params = RigidContactParams {
        activation,
        pressure: 1e4,
        depth,
    };
    body.with_terms(move |builder| {
        let points = ContactPoint::on_faces(&mesh, &mesh.boundary().faces);
        let surface = RigidSurface::Implicit(solid);
        builder.term(RigidContact::new(
            vec![surface],
            None,
            points,
            mesh.nodes(),
            params,
        )?)
    })
}

/// Says how near the nodes come to a ball.
fn with_gap(evidence: Evidence, x: &[[f64; 3]], center: [f64; 3], radius: f64) -> Evidence {
    let far = |p: &[f64; 3]| {
        (0..3)
            .map(|k| (p[k] - center[k]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let least = x.iter().map(far).fold(f64::INFINITY, f64::min) - radius;
    Evidence {
        note: format!("smallest gap {least:.1e} m"),
        ..evidence
    }
}

/// Two blocks, 0.1 m apart at rest, the upper one lowered until it would lie `inside` the lower one:
/// started there, or walked in so many parts.
fn lips(inside: f64, parts: usize, settings: &Settings) -> Result<Evidence, Failure> {
    let low = kuhn_grid(4, 4, 3, [1.0; 3])?;
    let high = kuhn_grid(3, 3, 2, [0.8, 0.8, 0.7])?;
    let (s, c) = 0.3_f64.sin_cos();
    let above = high.nodes().iter().map(|p| {
        let (x, y) = (c * p[0] - s * p[1], s * p[0] + c * p[1]);
        [0.2 + x, 0.03 + y, 1.1 + p[2]]
    });
    let nodes: Vec<[f64; 3]> = low.nodes().iter().copied().chain(above).collect();
    let first = low.num_nodes() as u32;
    let tets = low.connectivity().iter().copied();
    let tets = tets.chain(high.connectivity().iter().map(|n| n + first));
    let mesh = SimplexMesh::new(nodes, tets.collect())?;
    let flesh = Named::elastic("neo_hookean", 2.8e4, 0.4);
    let body = Body::new(mesh, flesh).holding(|p| p[2] == 0.0 || p[2] > 1.75);
    let own = body.mesh().clone();
    let body = body.with_terms(move |builder| {
        let params = FleshContactParams {
            activation: 0.05,
            pressure: 1e4,
            depth: 0.3,
            margin: 0.2,
            neighbors: 2,
            edges: true,
        };
        builder.term(FleshContact::new(&own, &own.boundary().faces, params)?)
    });
    let down = |share: f64, p: [f64; 3]| {
        let by = if p[2] > 1.05 { 0.1 + inside } else { 0.0 };
        [p[0], p[1], p[2] - share * by]
    };
    // Its forces are summed over the pairs of a fresh look.
    let params = shifted(settings, 400);
    let solved = if parts == 0 {
        body.solve_with(body.placed(|p| down(1.0, p), |p| down(1.0, p)), &params)?
    } else {
        let to = |share| body.placed(|p| down(share, p), |p| p);
        body.walk(to, parts, &params)?
    };
    let heights = |low: bool| {
        let rest = body.mesh().nodes().iter().zip(&solved.positions);
        let of = rest.filter(move |(r, _)| {
            let inner = (0.35..0.65).contains(&r[0]) && (0.35..0.65).contains(&r[1]);
            inner && (if low { r[2] == 1.0 } else { r[2] == 1.1 })
        });
        of.map(|(_, x)| x[2])
    };
    let crossed = heights(true).fold(f64::MIN, f64::max) - heights(false).fold(f64::MAX, f64::min);
    Ok(solved.evidence.and(Evidence {
        left: crossed.max(0.0),
        allowed: 0.02,
        note: format!("{crossed:.1e} m inside each other at the middle"),
        ..Evidence::default()
    }))
}

/// A lid of 30 × 10 × 2 mm held at its upper edge before an eyeball of 12 mm, started behind it.
fn lid(depth: f64, settings: &Settings) -> Result<Evidence, Failure> {
    let flesh = Named::elastic("stable_neo_hookean", 3e4, 0.45);
    let cells = if settings.quick {
        [6, 1, 3]
    } else {
        [12, 2, 6]
    };
    let body = Body::block(cells, [0.03, 0.002, 0.01], flesh)?;
    let body = body.holding(|p| p[2] == 0.01);
    let center = [0.015, -0.0125, 0.0];
    let body = touching(body, ball(center, 0.012), depth, 0.5e-3);
    let behind = |p: [f64; 3]| [p[0], p[1] - 0.02 * (1.0 - p[2] / 0.01), p[2]];
    let solved = body.solve_with(body.placed(|p| p, behind), &shifted(settings, 400))?;
    let lowest = body.mesh().nodes().iter().zip(&solved.positions);
    let front = lowest.filter(|(r, _)| r[2] == 0.0 && (r[0] - 0.015).abs() < 0.006);
    let depth = front.map(|(_, x)| x[1]).fold(f64::INFINITY, f64::min);
    let side = if depth > center[1] {
        "before"
    } else {
        "behind"
    };
    let evidence = with_gap(solved.evidence, &solved.positions, center, 0.012);
    let note = format!("{}, {side} the middle of the eye", evidence.note);
    Ok(Evidence { note, ..evidence })
}
