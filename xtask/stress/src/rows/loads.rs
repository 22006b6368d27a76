//! Ends of a bar that are moved far: twisted, stretched, squashed, at once and in parts.

use crate::body::Body;
use crate::named::Named;
use crate::row::{Evidence, Settings};
use crate::{Expected, Failure, Row};
use fem_solvers::ProjectionPolicy;

/// Where the top of a bar of 1 × 1 × 4 m goes.
#[derive(Clone, Copy)]
struct Way {
    /// Degrees.
    turn: f64,
    /// Of its length.
    stretch: f64,
    /// Parts that are solved one after the other; 1 for one solve from a start that follows linearly.
    parts: usize,
    /// Cubes across.
    cells: usize,
}

const LOGARITHMIC: &str = "neo_hookean";
const DEFINED_EVERYWHERE: &str = "stable_neo_hookean";

/// The rows.
pub fn rows() -> Vec<Row> {
    let row = |name: &str, what: &str, expected, model: &'static str, way: Way| {
        let run = move |settings: &Settings| bar(model, way, settings);
        Row::new("loads", name, what, expected, run)
    };
    let way = |turn, stretch, parts| Way {
        turn,
        stretch,
        parts,
        cells: 2,
    };
    let outside = Expected::Error("NewtonFailure::OutsideDomain");
    let answer = Expected::Answer;
    vec![
        row(
            "load-twist-720-at-once-log",
            "twisted twice round at once: the linear start is inside out",
            outside,
            LOGARITHMIC,
            way(720.0, 1.0, 1),
        ),
        row(
            "load-twist-720-at-once",
            "the same where every F has an energy",
            answer,
            DEFINED_EVERYWHERE,
            way(720.0, 1.0, 1),
        ),
        row(
            "load-twist-720-in-parts-log",
            "twisted twice round in 24 parts",
            answer,
            LOGARITHMIC,
            way(720.0, 1.0, 24),
        ),
        row(
            "load-twist-720-in-parts",
            "the same where every F has an energy",
            answer,
            DEFINED_EVERYWHERE,
            way(720.0, 1.0, 24),
        ),
        row(
            "load-stretch-5-at-once-log",
            "pulled to five times its length at once",
            answer,
            LOGARITHMIC,
            way(0.0, 5.0, 1),
        ),
        row(
            "load-stretch-5-at-once",
            "the same where every F has an energy",
            answer,
            DEFINED_EVERYWHERE,
            way(0.0, 5.0, 1),
        ),
        row(
            "load-stretch-5-in-parts-log",
            "pulled to five times its length in 8 parts",
            answer,
            LOGARITHMIC,
            way(0.0, 5.0, 8),
        ),
        row(
            "load-squash-5-percent-at-once-log",
            "squashed to 5 % at once",
            answer,
            LOGARITHMIC,
            way(0.0, 0.05, 1),
        )
        .long(),
        row(
            "load-squash-5-percent-at-once",
            "the same where every F has an energy",
            answer,
            DEFINED_EVERYWHERE,
            way(0.0, 0.05, 1),
        ),
        row(
            "load-squash-5-percent-in-parts-log",
            "squashed to 5 % in 19 parts",
            answer,
            LOGARITHMIC,
            way(0.0, 0.05, 19),
        ),
        row(
            "load-stretch-5-one-cell-wide",
            "a bar of one cube across: its symmetric shape is a saddle",
            answer,
            DEFINED_EVERYWHERE,
            Way {
                cells: 1,
                ..way(0.0, 5.0, 1)
            },
        ),
        row(
            "load-pushed-through-log",
            "the top pushed below the bottom at once",
            outside,
            LOGARITHMIC,
            way(0.0, -0.25, 1),
        ),
    ]
}

fn moved(way: Way, share: f64, p: [f64; 3]) -> [f64; 3] {
    let (s, c) = (share * way.turn * p[2] / 4.0).to_radians().sin_cos();
    let (x, y) = (p[0] - 0.5, p[1] - 0.5);
    let stretch = 1.0 + share * (way.stretch - 1.0);
    [0.5 + c * x - s * y, 0.5 + s * x + c * y, stretch * p[2]]
}

fn bar(model: &str, way: Way, settings: &Settings) -> Result<Evidence, Failure> {
    let n = way.cells;
    let material = Named::elastic(model, 1e5, 0.45);
    let body = Body::block([n, n, 4 * n], [1.0, 1.0, 4.0], material)?;
    let body = body.holding(|p| p[2] == 0.0 || p[2] == 4.0);
    if way.parts == 1 {
        let whole = |p| moved(way, 1.0, p);
        return Ok(body
            .solve(body.placed(whole, whole), settings, 500)?
            .evidence);
    }
    let mut params = settings.newton(100);
    params.projection = ProjectionPolicy::ExactThenShifted;
    let to = |share| body.placed(|p| moved(way, share, p), |p| p);
    Ok(body.walk(to, way.parts, &params)?.evidence)
}
