//! Which elements a course fills.

use super::sweep::Sample;
use super::{Course, CourseError};
use crate::anatomy::TetLocator;
use fem_assembly::mesh::SimplexMesh;
use fem_kinematics::{Mat, symmetric_eigen};
use std::collections::BTreeMap;

/// Samples are at most this share of the side of a cube as large as the smaller elements on the way.
const SHARE_OF_ELEMENT: f64 = 0.2;
/// At most so many samples.
const MOST_SAMPLES: f64 = 2e5;
/// An element is left out that holds less than this share of itself,
const LEAST_WEIGHT: f64 = 1e-3;
/// and less than this share of the course.
const LEAST_PART: f64 = 1e-4;

/// How much of an element a course fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The element.
    pub tet: u32,
    /// Share of its volume, above 0, at most 1.
    pub weight: f64,
    /// The line's direction there, of length 1; the sign means nothing.
    pub direction: [f64; 3],
}

/// A course in a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Filling {
    /// The elements, ascending.
    pub shares: Vec<Share>,
    /// Length times cross-section, m³.
    pub volume: f64,
    /// What of it lies in elements, m³.
    pub inside: f64,
}

/// What has fallen into an element.
#[derive(Clone, Copy, Default)]
struct Moments {
    volume: f64,
    /// Σ v t tᵀ.
    moment: [[f64; 3]; 3],
}

impl Course {
    /// The elements that the course fills, and the direction in each: the principal axis of the
    /// tangents in it.
    ///
    /// Samples lie a fifth of the smaller elements apart, so a weight is good to a few hundredths, and
    /// the sum of all to rounding but for full elements, which hold no more than themselves.
    ///
    /// # Errors
    /// As [`Course::check`]; [`CourseError::Outside`] where no element is met.
    pub fn fill(
        &self,
        mesh: &SimplexMesh<3>,
        locator: &TetLocator,
    ) -> Result<Filling, CourseError> {
        self.check()?;
        let coarse = 0.5 * self.section.finest();
        let (first, volume) = self.moments(mesh, locator, coarse);
        let mut sizes: Vec<f64> = first.keys().map(|&t| mesh.volume(t as usize)).collect();
        if sizes.is_empty() {
            return Err(self.outside(mesh));
        }
        sizes.sort_by(f64::total_cmp);
        let small = sizes[sizes.len() / 10].cbrt();
        let least = (volume / MOST_SAMPLES).cbrt();
        let spacing = (SHARE_OF_ELEMENT * small).min(coarse).max(least);
        let (of_elements, volume) = self.moments(mesh, locator, spacing);
        let inside = of_elements.values().map(|moments| moments.volume).sum();
        let share = |(&tet, moments): (&u32, &Moments)| {
            let weight = moments.volume / mesh.volume(tet as usize);
            let counts = weight >= LEAST_WEIGHT || moments.volume >= LEAST_PART * volume;
            counts.then(|| Share {
                tet,
                weight: weight.min(1.0),
                direction: principal_axis(&moments.moment),
            })
        };
        let shares: Vec<Share> = of_elements.iter().filter_map(share).collect();
        match shares.is_empty() {
            true => Err(self.outside(mesh)),
            false => Ok(Filling {
                shares,
                volume,
                inside,
            }),
        }
    }

    /// What falls into each element, and the volume of all samples.
    fn moments(
        &self,
        mesh: &SimplexMesh<3>,
        locator: &TetLocator,
        spacing: f64,
    ) -> (BTreeMap<u32, Moments>, f64) {
        let (mut of_elements, mut volume) = (BTreeMap::<u32, Moments>::new(), 0.0);
        let mut last: Option<(u32, Mat<f64, 3>)> = None;
        self.sweep(spacing, &mut |sample: Sample| {
            volume += sample.volume;
            let x = sample.position;
            let same = last.filter(|(tet, inverse)| inside(mesh, *tet, inverse, x));
            let found = same.map(|(tet, _)| tet);
            let found = found.or_else(|| locator.containing(x));
            let Some(tet) = found else { return };
            if last.is_none_or(|(before, _)| before != tet) {
                last = Some((tet, mesh.rest_edges(tet as usize).inverse()));
            }
            let moments = of_elements.entry(tet).or_default();
            moments.volume += sample.volume;
            for (row, along) in moments.moment.iter_mut().zip(sample.tangent) {
                for (entry, across) in row.iter_mut().zip(sample.tangent) {
                    *entry += sample.volume * along * across;
                }
            }
        });
        (of_elements, volume)
    }

    fn outside(&self, mesh: &SimplexMesh<3>) -> CourseError {
        let count: usize = self.lines.iter().map(Vec::len).sum();
        let sum = |i: usize| -> f64 { self.lines.iter().flatten().map(|p| p[i]).sum() };
        let (low, high) = mesh.bounding_box();
        CourseError::Outside {
            center: std::array::from_fn(|i| sum(i) / count as f64),
            low,
            high,
        }
    }
}

/// Well inside, so that a point on a face goes to the element that the locator prefers.
fn inside(mesh: &SimplexMesh<3>, tet: u32, inverse: &Mat<f64, 3>, x: [f64; 3]) -> bool {
    let origin = mesh.node(mesh.tet(tet as usize)[0]);
    let w = inverse.mul_vec(std::array::from_fn(|i| x[i] - origin[i]));
    let first = 1.0 - w[0] - w[1] - w[2];
    [first, w[0], w[1], w[2]].iter().all(|&w| w > 1e-9)
}

/// The eigenvector of the greatest eigenvalue of a positive semidefinite matrix.
fn principal_axis(moment: &[[f64; 3]; 3]) -> [f64; 3] {
    let vectors = symmetric_eigen(&Mat(*moment)).vectors;
    super::line::unit(std::array::from_fn(|i| vectors[(i, 0)]))
}
