//! Points of time against error, and what is claimed of them.

/// What differs from point to point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// How fine the mesh is.
    Mesh,
    /// Where the solver stops.
    Tolerance,
    /// How a linear system is solved, and in which precision.
    Solver,
    /// The constitutive model.
    Model,
    /// What is done about indefinite matrices.
    Projection,
    /// How many threads there are.
    Threads,
    /// How a derivative is taken.
    Derivative,
    /// By which of several ways the same number is found.
    Route,
    /// The direction of the fibers.
    Angle,
}

impl Axis {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Tolerance => "tolerance",
            Self::Solver => "solver",
            Self::Model => "model",
            Self::Projection => "projection",
            Self::Threads => "threads",
            Self::Derivative => "derivative",
            Self::Route => "route",
            Self::Angle => "angle",
        }
    }
}

/// What one setting cost, and what it gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// The value on the curve's axis.
    pub setting: String,
    /// How far from the truth, in the scene's own measure.
    pub error: f64,
    /// The fastest of the repetitions, seconds.
    pub seconds: f64,
    /// Numbers that were looked for.
    pub unknowns: usize,
    /// Newton's steps, or those in time.
    pub steps: usize,
    /// Numeric factorizations.
    pub factorizations: usize,
    /// Iterations of conjugate gradients.
    pub iterations: usize,
    /// The most memory that the process held meanwhile, MiB, where the system tells.
    pub memory: Option<f64>,
}

/// What must hold of a curve; a run in which it does not is a failure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Claim {
    /// Each error is smaller than the one before, until all are at most this.
    FallsTo(f64),
    /// No error is larger than this.
    AtMost(f64),
    /// The settings are tolerances, and no error is larger than the tolerance times the first number, or
    /// than the second.
    PerTolerance(f64, f64),
    /// The same of tolerances up to the third number. Looser ones are shown: a solve may end at them
    /// near a shape that is no equilibrium, where forces nearly cancel.
    PerToleranceUpTo(f64, f64, f64),
    /// Only shown.
    Nothing,
}

/// Points that differ in one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What is the same for all points.
    pub name: String,
    /// What differs.
    pub axis: Axis,
    /// What is claimed.
    pub claim: Claim,
    /// Whether a picture has it: not where points are no sequence, or errors of another kind.
    pub drawn: bool,
    /// The points, coarsest first.
    pub points: Vec<Point>,
}

impl Curve {
    /// A curve without points.
    pub fn new(name: impl Into<String>, axis: Axis, claim: Claim) -> Self {
        Self {
            name: name.into(),
            axis,
            claim,
            drawn: matches!(
                axis,
                Axis::Mesh | Axis::Tolerance | Axis::Derivative | Axis::Angle
            ),
            points: Vec::new(),
        }
    }

    /// The same, in tables alone.
    #[must_use]
    pub fn undrawn(mut self) -> Self {
        self.drawn = false;
        self
    }

    /// What breaks the claim; NaN breaks it.
    pub fn broken(&self) -> Option<String> {
        let mut errors = self.points.iter().map(|p| p.error);
        if errors.clone().any(f64::is_nan) {
            return Some("an error is no number".to_owned());
        }
        match self.claim {
            Claim::Nothing => None,
            Claim::AtMost(bound) => errors
                .find(|e| !(*e <= bound))
                .map(|e| format!("an error of {e:.1e} is more than {bound:.1e}")),
            Claim::PerTolerance(share, floor) => self.beyond(share, floor, f64::INFINITY),
            Claim::PerToleranceUpTo(share, floor, loosest) => self.beyond(share, floor, loosest),
            Claim::FallsTo(floor) => {
                let falls = |pair: &&[Point]| {
                    let [before, after] = [pair[0].error, pair[1].error];
                    after < before || after <= floor
                };
                let pairs = self.points.windows(2);
                pairs
                    .into_iter()
                    .find(|pair| !falls(pair))
                    .map(|pair| rises(&pair[0], &pair[1]))
            }
        }
    }

    /// The first error of a tolerance up to `loosest` that is larger than it allows.
    fn beyond(&self, share: f64, floor: f64, loosest: f64) -> Option<String> {
        self.points
            .iter()
            .map(|p| (p, tolerance(p)))
            .filter(|(_, tolerance)| !(*tolerance > loosest))
            .map(|(p, tolerance)| (p, allowed(tolerance, share, floor)))
            .find(|(p, bound)| !(p.error <= *bound))
            .map(|(p, bound)| format!("{}: {:.1e} is more than {bound:.1e}", p.setting, p.error))
    }
}

/// NaN where the setting is no number.
fn tolerance(point: &Point) -> f64 {
    point.setting.parse().unwrap_or(f64::NAN)
}

fn allowed(tolerance: f64, share: f64, floor: f64) -> f64 {
    if tolerance.is_nan() {
        return f64::NAN;
    }
    (share * tolerance).max(floor)
}

fn rises(before: &Point, after: &Point) -> String {
    format!(
        "the error does not fall from {} ({:.1e}) to {} ({:.1e})",
        before.setting, before.error, after.setting, after.error
    )
}
