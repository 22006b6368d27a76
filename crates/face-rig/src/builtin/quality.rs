//! How well shaped the tets are.

/// Extremes of the shape of a mesh's tets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TetQuality {
    /// Smallest volume, m^3.
    pub min_volume: f64,
    /// Sum of the volumes, m^3.
    pub volume: f64,
    /// Smallest dihedral angle, degrees.
    pub min_dihedral: f64,
    /// Largest dihedral angle, degrees.
    pub max_dihedral: f64,
    /// Median over the tets of their smallest dihedral angle, degrees.
    pub median_min_dihedral: f64,
    /// Smallest ratio 3 r / R of the inscribed to the circumscribed radius; 1 is a regular tet.
    pub min_radius_ratio: f64,
}

/// Measures a mesh; positions in metres, positively oriented tets.
///
/// # Panics
/// If a tet names a node out of range.
pub fn tet_quality(nodes: &[[f64; 3]], tets: &[[u32; 4]]) -> TetQuality {
    let mut worst = TetQuality {
        min_volume: f64::INFINITY,
        volume: 0.0,
        min_dihedral: 180.0,
        max_dihedral: 0.0,
        median_min_dihedral: 0.0,
        min_radius_ratio: 1.0,
    };
    let mut smallest = Vec::with_capacity(tets.len());
    for tet in tets {
        let p = tet.map(|n| nodes[n as usize]);
        let e = |i: usize, j: usize| [0, 1, 2].map(|k| p[j][k] - p[i][k]);
        let volume = dot(e(0, 1), cross(e(0, 2), e(0, 3))) / 6.0;
        worst.min_volume = worst.min_volume.min(volume);
        worst.volume += volume;
        // Outward area vectors; face k is opposite to corner k.
        let faces = [
            cross(e(1, 2), e(1, 3)),
            cross(e(0, 3), e(0, 2)),
            cross(e(0, 1), e(0, 3)),
            cross(e(0, 2), e(0, 1)),
        ]
        .map(|f| f.map(|x| 0.5 * x));
        let areas = faces.map(|f| dot(f, f).sqrt());
        let mut least: f64 = 180.0;
        for i in 0..4 {
            for j in i + 1..4 {
                let c = -dot(faces[i], faces[j]) / (areas[i] * areas[j]);
                let angle = c.clamp(-1.0, 1.0).acos().to_degrees();
                least = least.min(angle);
                worst.max_dihedral = worst.max_dihedral.max(angle);
            }
        }
        smallest.push(least);
        worst.min_dihedral = worst.min_dihedral.min(least);
        let inscribed = 3.0 * volume / areas.iter().sum::<f64>();
        // Circumradius from the products of opposite edges (Crelle's formula).
        let product = |i: usize, j: usize, k: usize, l: usize| {
            (dot(e(i, j), e(i, j)) * dot(e(k, l), e(k, l))).sqrt()
        };
        let (a, b, c) = (
            product(0, 1, 2, 3),
            product(0, 2, 1, 3),
            product(0, 3, 1, 2),
        );
        let area2 = (a + b + c) * (a + b - c) * (a - b + c) * (b + c - a);
        let circumscribed = area2.max(0.0).sqrt() / (24.0 * volume);
        worst.min_radius_ratio = worst.min_radius_ratio.min(3.0 * inscribed / circumscribed);
    }
    smallest.sort_by(f64::total_cmp);
    worst.median_min_dihedral = smallest.get(smallest.len() / 2).copied().unwrap_or(0.0);
    worst
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_tet_is_perfect() {
        let nodes = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]];
        let q = tet_quality(&nodes, &[[0, 1, 2, 3]]);
        assert!((q.volume.abs() - 8.0 / 3.0).abs() < 1e-14);
        let q = tet_quality(
            &nodes,
            &[if q.volume > 0.0 {
                [0, 1, 2, 3]
            } else {
                [0, 2, 1, 3]
            }],
        );
        let angle = (1.0f64 / 3.0).acos().to_degrees();
        assert!((q.min_dihedral - angle).abs() < 1e-10 && (q.max_dihedral - angle).abs() < 1e-10);
        assert!((q.min_radius_ratio - 1.0).abs() < 1e-12);
    }
}
