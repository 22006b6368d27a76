//! What is wrong with a course.

/// Why a course cannot be followed; lines and points count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CourseError {
    /// Nothing to follow.
    #[error("no line is given; give at least one list of points")]
    NoLine,
    /// A sheet needs two sides.
    #[error(
        "a sheet lies between two lines or more and one is given; add a line, or give a \"radius\", or a \
         \"width\" and \"normal\""
    )]
    OneLine,
    /// A line that is none.
    #[error("line {line} has {found} point(s), at least {wanted} are needed")]
    FewPoints {
        /// The line.
        line: usize,
        /// Its points.
        found: usize,
        /// Two, or three for a closed line.
        wanted: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("point {point} of line {line} is not finite")]
    NotFinite {
        /// The line.
        line: usize,
        /// The point.
        point: usize,
    },
    /// A piece of no length.
    #[error("points {point} and {next} of line {line} are the same; leave one out", next = point + 1)]
    Repeated {
        /// The line.
        line: usize,
        /// The first of the two.
        point: usize,
    },
    /// A cross-section that is none.
    #[error("{what} = {value} m must be above 0")]
    Size {
        /// Which length.
        what: &'static str,
        /// Its value, meters.
        value: f64,
    },
    /// A strap seen along its own line.
    #[error(
        "the normal of the strap points along line {line} at point {point}; give the direction to the skin"
    )]
    Normal {
        /// The line.
        line: usize,
        /// The point.
        point: usize,
    },
    /// More samples than a program can sweep.
    #[error(
        "it is {extent:.3} m across and {finest:e} m at its thinnest: check the units, or make it thicker"
    )]
    TooFine {
        /// Diagonal of the box around all points, meters.
        extent: f64,
        /// The smallest length of its section, meters.
        finest: f64,
    },
    /// Nothing of the course lies in the flesh.
    #[error(
        "it meets no tetrahedron: its points lie around {center:?} m, the flesh from {low:?} to {high:?} m; \
         check units and sides, or move it off the bone"
    )]
    Outside {
        /// The mean of its points, meters.
        center: [f64; 3],
        /// Lowest corner of the flesh, meters.
        low: [f64; 3],
        /// Highest corner of the flesh, meters.
        high: [f64; 3],
    },
}
