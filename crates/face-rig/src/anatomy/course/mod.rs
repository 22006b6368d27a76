//! Muscles, ligaments and cartilage as they are drawn in an atlas: lines with a cross-section, and
//! the elements that they fill.
//!
//! A [`Course`] is swept by samples of equal cross-section, each of which gives its volume to the
//! element that it lies in. So the weights times the volumes of the elements sum to the length times
//! the cross-section on any mesh, up to what lies outside of it.

mod error;
mod fill;
mod line;
mod sweep;

#[cfg(test)]
mod course_tests;

pub use error::CourseError;
pub use fill::{Filling, Share};
pub use line::{resampled, smoothed, wrapped};

use line::{cross, norm, sub};

/// Lines that fibers follow, and how much flesh lies around them.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// The lines, each a list of points, meters.
    pub lines: Vec<Vec<[f64; 3]>>,
    /// Does every line end where it starts? The first point need not be repeated.
    pub closed: bool,
    /// What lies around them.
    pub section: Section,
}

/// The flesh around the lines of a [`Course`]; lengths in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Section {
    /// Each line is the axis of a bundle: π r² across.
    Round {
        /// r.
        radius: f64,
    },
    /// Each line is the middle of a strap: width × thickness.
    Strap {
        /// Across the line and the normal.
        width: f64,
        /// Along the normal.
        thickness: f64,
        /// The side that the strap turns to; only its part across the line counts.
        normal: [f64; 3],
    },
    /// A sheet is ruled between each line and the next: area × thickness.
    Sheet {
        /// Across the sheet.
        thickness: f64,
        /// Do half bundles go along the first and the last line? Then the sheet holds all points that
        /// are nearer to it than half its thickness, but those beyond its ends.
        rounded: bool,
    },
}

/// At most so many cubes of the smallest length of its section fill a course: a sheet 200 mm square of
/// 0.2 mm takes these.
const MOST_CUBES: f64 = 1e6;

impl Section {
    /// The smallest length of the section, and its name.
    fn sizes(&self) -> [(&'static str, f64); 2] {
        match *self {
            Self::Round { radius } => [("radius", radius), ("radius", radius)],
            Self::Strap {
                width, thickness, ..
            } => [("width", width), ("thickness", thickness)],
            Self::Sheet { thickness, .. } => [("thickness", thickness), ("thickness", thickness)],
        }
    }
    /// How fine samples must be at least to show it.
    fn finest(&self) -> f64 {
        let [(_, a), (_, b)] = self.sizes();
        a.min(b)
    }
}

impl Course {
    /// Is there something to sweep?
    ///
    /// # Errors
    /// [`CourseError`] with the line and point that no muscle can follow.
    pub fn check(&self) -> Result<(), CourseError> {
        if self.lines.is_empty() {
            return Err(CourseError::NoLine);
        }
        for (what, value) in self.section.sizes() {
            if !(value > 0.0 && value.is_finite()) {
                return Err(CourseError::Size { what, value });
            }
        }
        let lines = self.lines.len();
        if matches!(self.section, Section::Sheet { .. }) && lines < 2 {
            return Err(CourseError::OneLine);
        }
        let wanted = if self.closed { 3 } else { 2 };
        for (line, points) in self.lines.iter().enumerate() {
            let found = points.len();
            if let Some(point) = points.iter().flatten().position(|v| !v.is_finite()) {
                let point = point / 3;
                return Err(CourseError::NotFinite { line, point });
            }
            if found < wanted {
                return Err(CourseError::FewPoints {
                    line,
                    found,
                    wanted,
                });
            }
            if let Some(point) = points.windows(2).position(|w| w[0] == w[1]) {
                return Err(CourseError::Repeated { line, point });
            }
            if let Section::Strap { normal, .. } = self.section {
                let along = |w: &[[f64; 3]]| {
                    let t = sub(w[1], w[0]);
                    !(norm(cross(t, normal)) > 1e-6 * norm(t) * norm(normal))
                };
                if let Some(point) = points.windows(2).position(along) {
                    return Err(CourseError::Normal { line, point });
                }
            }
        }
        self.check_samples()
    }

    /// Lines of a size that their own thickness can fill.
    fn check_samples(&self) -> Result<(), CourseError> {
        let points = || self.lines.iter().flatten();
        let range = |i: usize| {
            let (low, high) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| {
                (p[i].min(l), p[i].max(h))
            });
            high - low
        };
        let extent = norm(std::array::from_fn(range));
        let length: f64 = (self.lines.iter())
            .flat_map(|line| line.windows(2))
            .map(|w| norm(sub(w[1], w[0])))
            .sum();
        let finest = self.section.finest();
        // In multiples of the finest length: its cube may be 0.
        let area = match self.section {
            Section::Round { .. } => 1.0,
            Section::Strap {
                width, thickness, ..
            } => (width / finest) * (thickness / finest),
            Section::Sheet { .. } => extent / finest,
        };
        match (length / finest) * area <= MOST_CUBES {
            true => Ok(()),
            false => Err(CourseError::TooFine { extent, finest }),
        }
    }

    /// The lines with their first point at the end where they are closed.
    fn whole_lines(&self) -> Vec<Vec<[f64; 3]>> {
        let close = |line: &Vec<[f64; 3]>| {
            let mut line = line.clone();
            if self.closed && line.first() != line.last() {
                line.extend(line.first().copied());
            }
            line
        };
        self.lines.iter().map(close).collect()
    }
}
