//! Where points of the flesh should be.

use super::{FitParams, Fitter, Parametrization};
use crate::anatomy::EmbeddedPoint;
use crate::rig::EmbeddedPoints;

/// A point of the flesh, where it should be, and how much that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The point.
    pub point: EmbeddedPoint,
    /// Where it should be, meters.
    pub position: [f64; 3],
    /// How much its squared distance counts, 0 or more; at 0 it counts nowhere.
    pub weight: f64,
}

/// Goals as a fit reads them: g, g* and the weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Goals {
    points: EmbeddedPoints,
    positions: Vec<f64>,
    weights: Vec<f64>,
}

impl FromIterator<Goal> for Goals {
    fn from_iter<I: IntoIterator<Item = Goal>>(goals: I) -> Self {
        let mut all = Self::default();
        for goal in goals {
            all.points.0.push(goal.point);
            all.positions.extend(goal.position);
            all.weights.push(goal.weight);
        }
        all
    }
}

impl Goals {
    /// A fit to these goals.
    pub fn fitter<'a>(
        &'a self,
        parametrization: &'a Parametrization,
        params: &'a FitParams,
    ) -> Fitter<'a> {
        Fitter {
            observation: &self.points,
            target: &self.positions,
            weights: &self.weights,
            parametrization,
            params,
        }
    }

    /// How many count.
    pub fn counted(&self) -> usize {
        self.weights.iter().filter(|w| **w > 0.0).count()
    }

    /// Root-mean-square distance of the points that count when the nodes are at `x`, meters; NaN where
    /// a point has a node that `x` has no place for.
    pub fn rms(&self, x: &[[f64; 3]]) -> f64 {
        let sum: f64 = self.squares(x).sum();
        (sum / self.counted().max(1) as f64).sqrt()
    }

    /// The largest distance of a point that counts when the nodes are at `x`, meters; NaN as
    /// [`Goals::rms`] is.
    pub fn largest(&self, x: &[[f64; 3]]) -> f64 {
        let larger = |most: f64, one: f64| {
            if one <= most || most.is_nan() {
                most
            } else {
                one
            }
        };
        self.squares(x).fold(0.0, larger).sqrt()
    }

    fn squares(&self, x: &[[f64; 3]]) -> impl Iterator<Item = f64> {
        let positions = self.positions.as_chunks::<3>().0;
        let all = self.points.0.iter().zip(positions).zip(&self.weights);
        let counted = all.filter(|(_, weight)| **weight > 0.0);
        counted.map(move |((point, goal), _)| {
            let at = point.position(x);
            (0..3).map(|i| (at[i] - goal[i]).powi(2)).sum()
        })
    }
}
