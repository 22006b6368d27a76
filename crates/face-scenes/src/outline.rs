//! Surfaces of solids as pictures show them.

use crate::builtin::Ornament;
use std::f64::consts::{PI, TAU};

/// Circles of latitude between the poles of a ball, and meridians.
const LATITUDES: usize = 23;
const MERIDIANS: usize = 48;

/// The surface of a solid in its place at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Points, meters.
    pub points: Vec<[f64; 3]>,
    /// Triangles between them, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The coordinate of each point of which [`Ornament::color`] is a function.
    pub coordinates: Vec<[f64; 3]>,
    /// What it is, if that is known: teeth and gums of a file are not told apart.
    pub ornament: Option<Ornament>,
}

impl Outline {
    /// An eyeball that looks along z.
    pub(crate) fn eyeball(center: [f64; 3], radius: f64) -> Self {
        let mut directions = vec![[0.0, 0.0, 1.0]];
        for latitude in 1..=LATITUDES {
            let (across, along) = (PI * latitude as f64 / (LATITUDES + 1) as f64).sin_cos();
            directions.extend((0..MERIDIANS).map(|k| {
                let (y, x) = (TAU * k as f64 / MERIDIANS as f64).sin_cos();
                [across * x, across * y, along]
            }));
        }
        directions.push([0.0, 0.0, -1.0]);
        let at = |latitude: usize, k: usize| (1 + latitude * MERIDIANS + k % MERIDIANS) as u32;
        let last = directions.len() as u32 - 1;
        let mut triangles = Vec::new();
        for k in 0..MERIDIANS {
            triangles.push([0, at(0, k), at(0, k + 1)]);
            triangles.push([last, at(LATITUDES - 1, k + 1), at(LATITUDES - 1, k)]);
            for row in 1..LATITUDES {
                let [a, b] = [at(row - 1, k), at(row - 1, k + 1)];
                let [c, d] = [at(row, k), at(row, k + 1)];
                triangles.extend([[a, c, d], [a, d, b]]);
            }
        }
        let place = |d: &[f64; 3]| [0, 1, 2].map(|i| center[i] + radius * d[i]);
        Self {
            points: directions.iter().map(place).collect(),
            triangles,
            // The pattern is that of what can be seen.
            coordinates: (directions.iter())
                .map(|d| if d[2] > 0.0 { *d } else { [1.0, 0.0, 0.0] })
                .collect(),
            ornament: Some(Ornament::Eyeball),
        }
    }

    /// The points that these triangles join, and no others.
    pub(crate) fn of(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut used: Vec<u32> = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let own = |n: &u32| used.partition_point(|m| m < n) as u32;
        Self {
            triangles: triangles
                .iter()
                .map(|t| [0, 1, 2].map(|i| own(&t[i])))
                .collect(),
            coordinates: vec![[0.0; 3]; used.len()],
            points: used.iter().map(|&n| points[n as usize]).collect(),
            ornament: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume inside, by the corners of each triangle.
    fn volume(outline: &Outline) -> f64 {
        let corner = |t: &[u32; 3], i: usize| outline.points[t[i] as usize];
        let of = |t: &[u32; 3]| {
            let [a, b, c] = [0, 1, 2].map(|i| corner(t, i));
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        };
        outline.triangles.iter().map(of).sum::<f64>() / 6.0
    }

    #[test]
    fn an_eyeball_is_a_closed_ball_that_looks_forward() {
        let ball = Outline::eyeball([0.03, 0.04, 0.05], 0.012);
        let exact = 4.0 / 3.0 * PI * 0.012_f64.powi(3);
        let off = volume(&ball) / exact - 1.0;
        assert!((-0.02..0.0).contains(&off), "{off}");
        // Each edge is that of two triangles, once in each direction.
        let mut edges: Vec<[u32; 2]> = (ball.triangles.iter())
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(
            edges
                .iter()
                .all(|[a, b]| edges.binary_search(&[*b, *a]).is_ok())
        );
        let color = |k: usize| Ornament::Eyeball.color(ball.coordinates[k]);
        let (pupil, side) = (color(0), color(1 + 11 * MERIDIANS));
        assert!(pupil[0] < 0.1 && side[0] > 0.8, "{pupil:?} {side:?}");
    }

    #[test]
    fn only_points_that_are_joined_are_kept() {
        let points = [0.0, 1.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0]);
        let some = Outline::of(&points, &[[4, 0, 2], [2, 3, 4]]);
        assert_eq!(some.points, [0.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0]));
        assert_eq!(some.triangles, [[3, 0, 1], [1, 2, 3]]);
    }
}
