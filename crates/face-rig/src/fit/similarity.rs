//! Motion with scale that lays one set of points over another.

use crate::anatomy::AffineMap;
use fem_kinematics::{Mat, signed_svd};

/// x ↦ s R x + t with a rotation R.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Similarity {
    /// s.
    pub scale: f64,
    /// s R and t.
    pub map: AffineMap,
}

impl Similarity {
    /// Nothing moves.
    pub const IDENTITY: Self = Self {
        scale: 1.0,
        map: AffineMap::IDENTITY,
    };
    /// Rounds of weights; each makes far points count less.
    const ROUNDS: usize = 30;

    /// The one that minimizes Σ w |s R x + t − y|² (Umeyama, 1991); `None` for points that leave it
    /// undetermined: fewer than three, all on a line, or not finite; and for lists of different lengths.
    pub fn between(from: &[[f64; 3]], to: &[[f64; 3]], weights: &[f64]) -> Option<Self> {
        if from.len() != to.len() || from.len() != weights.len() {
            return None;
        }
        let total: f64 = weights.iter().sum();
        let mean = |points: &[[f64; 3]]| -> [f64; 3] {
            let sum = |i| -> f64 { points.iter().zip(weights).map(|(p, w)| w * p[i]).sum() };
            std::array::from_fn(|i| sum(i) / total)
        };
        let (a, b) = (mean(from), mean(to));
        let mut cross = Mat::<f64, 3>::zeros();
        let (mut own, mut other) = (0.0, 0.0);
        for ((x, y), w) in from.iter().zip(to).zip(weights) {
            let (x, y) = (sub(*x, a), sub(*y, b));
            cross += Mat::from_fn(|i, j| w * y[i] * x[j]);
            own += w * square(x);
            other += w * square(y);
        }
        let svd = signed_svd(&cross);
        let scale = svd.sigma.iter().sum::<f64>() / own;
        // On a line the second singular value is 0, and no turn about the line is better than another.
        let turns = svd.sigma[1] > 1e-9 * (own * other).sqrt();
        if !(turns && scale > 0.0 && scale < f64::INFINITY) {
            return None;
        }
        let rotation = svd.compose([1.0; 3]);
        let matrix = rotation.0.map(|row| row.map(|r| scale * r));
        let turned = AffineMap {
            matrix,
            translation: [0.0; 3],
        };
        let map = AffineMap {
            matrix,
            translation: sub(b, turned.apply(a)),
        };
        map.is_finite().then_some(Self { scale, map })
    }

    /// As [`between`](Self::between) with weights of its own, 1 / (1 + (r/m)²) for a point that is r
    /// away where half of all are nearer than m: lips that open and brows that rise turn no head.
    pub fn robustly_between(from: &[[f64; 3]], to: &[[f64; 3]]) -> Option<Self> {
        let mut found = Self::between(from, to, &vec![1.0; from.len()])?;
        for _ in 0..Self::ROUNDS {
            let distances = found.distances(from, to);
            let mut sorted = distances.clone();
            sorted.sort_by(f64::total_cmp);
            let median = sorted[sorted.len() / 2];
            let size = distances.iter().fold(0.0_f64, |m, &d| m.max(d));
            if !(median > 1e-12 * size) {
                break;
            }
            let weight = |d: &f64| 1.0 / (1.0 + (d / median).powi(2));
            let weights: Vec<f64> = distances.iter().map(weight).collect();
            found = Self::between(from, to, &weights)?;
        }
        Some(found)
    }

    /// Root-mean-square distance that it leaves, in the unit of `to`; NaN where there is not one of `to` for
    /// each of `from`, or none at all.
    pub fn rms(&self, from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
        if from.len() != to.len() {
            return f64::NAN;
        }
        let squares = self.distances(from, to).into_iter().map(|d| d * d);
        (squares.sum::<f64>() / from.len() as f64).sqrt()
    }

    /// The angle of R, radians.
    pub fn angle(&self) -> f64 {
        let trace = (0..3).map(|i| self.map.matrix[i][i]).sum::<f64>() / self.scale;
        (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
    }

    fn distances(&self, from: &[[f64; 3]], to: &[[f64; 3]]) -> Vec<f64> {
        let pairs = from.iter().zip(to);
        let of = |(x, y): (&[f64; 3], &[f64; 3])| square(sub(self.map.apply(*x), *y)).sqrt();
        pairs.map(of).collect()
    }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn square(a: [f64; 3]) -> f64 {
    a.iter().map(|v| v * v).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of no symmetry.
    fn cloud(count: usize) -> Vec<[f64; 3]> {
        let at = |k: usize, f: f64| (f * (k as f64 + 1.0)).sin();
        (0..count)
            .map(|k| [at(k, 1.7), 0.8 * at(k, 2.9), 0.5 * at(k, 4.3)])
            .collect()
    }

    fn known() -> Similarity {
        let (s, c) = 0.7_f64.sin_cos();
        let rotation = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        Similarity {
            scale: 0.001,
            map: AffineMap {
                matrix: rotation.map(|row| row.map(|r| 0.001 * r)),
                translation: [0.3, -2.0, 1.1],
            },
        }
    }

    fn apart(a: &Similarity, b: &Similarity) -> f64 {
        let pairs = a.map.to_array().into_iter().zip(b.map.to_array());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_known_motion_with_scale_is_found() {
        let (from, known) = (cloud(20), known());
        let to: Vec<[f64; 3]> = from.iter().map(|&x| known.map.apply(x)).collect();
        let found = Similarity::between(&from, &to, &[1.0; 20]).expect("determined");
        assert!(apart(&found, &known) < 1e-14, "{found:?}");
        assert!((found.angle() - 0.7).abs() < 1e-12 && (found.scale - 0.001).abs() < 1e-15);
        assert!(found.rms(&from, &to) < 1e-15);
    }

    #[test]
    fn points_that_move_by_themselves_turn_nothing() {
        let (from, known) = (cloud(20), known());
        let mut to: Vec<[f64; 3]> = from.iter().map(|&x| known.map.apply(x)).collect();
        for place in &mut to[..7] {
            place[1] -= 2e-4;
        }
        let plain = Similarity::between(&from, &to, &[1.0; 20]).expect("determined");
        let robust = Similarity::robustly_between(&from, &to).expect("determined");
        let moved = apart(&plain, &known);
        assert!(
            moved > 1e-5 && apart(&robust, &known) < 1e-3 * moved,
            "{robust:?}"
        );
    }

    #[test]
    fn a_mirrored_set_is_no_turned_one() {
        let from = cloud(20);
        let to: Vec<[f64; 3]> = from.iter().map(|x| [-x[0], x[1], x[2]]).collect();
        let found = Similarity::between(&from, &to, &[1.0; 20]).expect("determined");
        let matrix = Mat(found.map.matrix);
        assert!(matrix.determinant() > 0.0 && found.rms(&from, &to) > 0.1);
    }

    #[test]
    fn what_determines_nothing_is_none() {
        let line: Vec<[f64; 3]> = (0..5).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        assert_eq!(Similarity::between(&line, &line, &[1.0; 5]), None);
        assert_eq!(
            Similarity::between(&[[1.0; 3]; 4], &[[1.0; 3]; 4], &[1.0; 4]),
            None
        );
        assert_eq!(Similarity::between(&[], &[], &[]), None);
        let (points, known) = (cloud(5), known());
        assert!(Similarity::between(&points, &points, &[1.0; 5]).is_some());
        assert_eq!(Similarity::between(&points[..4], &points, &[1.0; 5]), None);
        assert_eq!(Similarity::between(&points, &points[..4], &[1.0; 4]), None);
        assert_eq!(Similarity::between(&points, &points, &[1.0; 6]), None);
        assert_eq!(Similarity::robustly_between(&points, &points[..4]), None);
        assert!(known.rms(&points, &points[..4]).is_nan());
        assert!(known.rms(&points[..4], &points).is_nan());
        let mut broken = cloud(5);
        broken[2][1] = f64::NAN;
        assert_eq!(Similarity::between(&broken, &cloud(5), &[1.0; 5]), None);
        assert_eq!(Similarity::robustly_between(&broken, &cloud(5)), None);
    }
}
