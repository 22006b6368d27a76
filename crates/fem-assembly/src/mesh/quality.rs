//! How well shaped the tetrahedra are.

use super::simplex::SimplexMesh;
use std::fmt;

/// Spread of one measure over all elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distribution {
    /// Smallest value.
    pub min: f64,
    /// First percentile.
    pub percentile_1: f64,
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub percentile_99: f64,
    /// Largest value.
    pub max: f64,
}

impl Distribution {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Self {
            min: at(0.0),
            percentile_1: at(0.01),
            median: at(0.5),
            percentile_99: at(0.99),
            max: at(1.0),
        }
    }
}

/// Shape and size of all tetrahedra of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// The smallest dihedral angle of each element, degrees (a regular tetrahedron has 70.5).
    pub smallest_dihedral: Distribution,
    /// The largest dihedral angle of each element, degrees.
    pub largest_dihedral: Distribution,
    /// Three times the inscribed over the circumscribed radius: 1 for a regular tetrahedron, 0 for
    /// a flat one.
    pub radius_ratio: Distribution,
    /// Edge lengths, meters; an edge counts once.
    pub edge_length: Distribution,
    /// Element volumes, m³.
    pub element_volume: Distribution,
    /// Sum of the element volumes, m³.
    pub volume: f64,
    /// Elements with a dihedral angle under 10 degrees.
    pub slivers: usize,
    /// The ten elements of smallest radius ratio, worst first.
    pub worst: Vec<u32>,
}

impl Quality {
    /// Measures every element.
    pub fn measure(mesh: &SimplexMesh<3>) -> Self {
        let count = mesh.num_elements();
        let mut smallest = Vec::with_capacity(count);
        let mut largest = Vec::with_capacity(count);
        let mut ratios = Vec::with_capacity(count);
        let mut volumes = Vec::with_capacity(count);
        let mut slivers = 0;
        for tet in mesh.tets() {
            let shape = Shape::of(tet.map(|n| mesh.node(n)));
            let low = shape.dihedrals.into_iter().fold(f64::INFINITY, f64::min);
            smallest.push(low);
            largest.push(shape.dihedrals.into_iter().fold(0.0, f64::max));
            ratios.push(shape.radius_ratio);
            volumes.push(shape.volume);
            slivers += usize::from(low < 10.0);
        }
        let lengths = mesh
            .edges()
            .iter()
            .map(|&[a, b]| norm(sub(mesh.node(a), mesh.node(b))))
            .collect();
        let mut order: Vec<u32> = (0..count as u32).collect();
        let by_ratio = |a: &u32, b: &u32| {
            ratios[*a as usize]
                .total_cmp(&ratios[*b as usize])
                .then(a.cmp(b))
        };
        let kept = count.min(10);
        if kept < count {
            order.select_nth_unstable_by(kept, by_ratio);
            order.truncate(kept);
        }
        order.sort_unstable_by(by_ratio);
        Self {
            volume: volumes.iter().sum(),
            smallest_dihedral: Distribution::of(smallest),
            largest_dihedral: Distribution::of(largest),
            radius_ratio: Distribution::of(ratios),
            edge_length: Distribution::of(lengths),
            element_volume: Distribution::of(volumes),
            slivers,
            worst: order,
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = 1e3;
        let (a, r, l) = (
            &self.smallest_dihedral,
            &self.radius_ratio,
            &self.edge_length,
        );
        writeln!(
            f,
            "dihedral angles {:.1}° … {:.1}° (each element's smallest: 1 % under {:.1}°, median \
             {:.1}°); {} elements under 10°",
            a.min, self.largest_dihedral.max, a.percentile_1, a.median, self.slivers
        )?;
        writeln!(
            f,
            "radius ratio    smallest {:.3}, 1 %: {:.3}, median {:.3}; worst elements {:?}",
            r.min, r.percentile_1, r.median, self.worst
        )?;
        writeln!(
            f,
            "edge length     {:.3} … {:.3} mm, median {:.3} mm",
            l.min * mm,
            l.max * mm,
            l.median * mm
        )?;
        write!(
            f,
            "volume          {:.1} cm³, elements {:.2e} … {:.2e} cm³",
            self.volume * 1e6,
            self.element_volume.min * 1e6,
            self.element_volume.max * 1e6
        )
    }
}

struct Shape {
    dihedrals: [f64; 6],
    radius_ratio: f64,
    volume: f64,
}

impl Shape {
    fn of(x: [[f64; 3]; 4]) -> Self {
        let [u, v, w] = [sub(x[1], x[0]), sub(x[2], x[0]), sub(x[3], x[0])];
        let volume = dot(u, cross(v, w)) / 6.0;
        // Area vectors of the faces opposite nodes 1, 2, 3 (inward) and 0.
        let (a, b, c) = (cross(v, w), cross(w, u), cross(u, v));
        let d: [f64; 3] = std::array::from_fn(|i| -a[i] - b[i] - c[i]);
        let faces = [a, b, c, d];
        let mut dihedrals = [0.0; 6];
        let mut k = 0;
        for j in 1..4 {
            for i in 0..j {
                let (m, n) = (faces[i], faces[j]);
                // atan2 keeps full precision at very small and very large angles.
                dihedrals[k] = norm(cross(m, n)).atan2(-dot(m, n)).to_degrees();
                k += 1;
            }
        }
        let area = 0.5 * faces.iter().map(|&n| norm(n)).sum::<f64>();
        // Circumradius from |u|²(v×w) + |v|²(w×u) + |w|²(u×v) over 12 V.
        let (uu, vv, ww) = (dot(u, u), dot(v, v), dot(w, w));
        let center: [f64; 3] = std::array::from_fn(|i| uu * a[i] + vv * b[i] + ww * c[i]);
        let circumradius = norm(center) / (12.0 * volume);
        let inradius = 3.0 * volume / area;
        Self {
            dihedrals,
            radius_ratio: 3.0 * inradius / circumradius,
            volume,
        }
    }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
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
fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::kuhn_grid;
    use super::*;

    #[test]
    fn a_regular_tetrahedron_is_perfect() {
        let nodes = vec![
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let mesh = SimplexMesh::<3>::new(nodes, vec![0, 2, 1, 3]).expect("regular");
        let quality = Quality::measure(&mesh);
        let angle = (1.0_f64 / 3.0).acos().to_degrees();
        assert!((quality.smallest_dihedral.min - angle).abs() < 1e-12);
        assert!((quality.largest_dihedral.max - angle).abs() < 1e-12);
        assert!((quality.radius_ratio.min - 1.0).abs() < 1e-14);
        assert!((quality.edge_length.max - 8.0_f64.sqrt()).abs() < 1e-14);
        assert!((quality.volume - 8.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn the_kuhn_tetrahedron_has_its_textbook_angles() {
        let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).expect("a grid");
        let quality = Quality::measure(&mesh);
        // Path tetrahedron of the cube: dihedral angles 45, 60 and 90 degrees.
        assert!((quality.smallest_dihedral.min - 45.0).abs() < 1e-12);
        assert!((quality.largest_dihedral.max - 90.0).abs() < 1e-12);
        assert_eq!((quality.worst.len(), quality.slivers), (10, 0));
        // Inradius 1/(2+2√2) for a cube of side 1, circumradius half of its diagonal.
        let expected = 3.0 * (1.0 / (2.0 + 2.0 * 2.0_f64.sqrt())) / (3.0_f64.sqrt() / 2.0);
        assert!((quality.radius_ratio.median - expected).abs() < 1e-12);
    }
}
