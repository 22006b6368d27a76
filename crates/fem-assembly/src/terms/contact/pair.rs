//! The energy of one pair, with its derivatives.
//!
//! A pair has four vertices. What it feels is told by three vectors, u between the two partners and
//! e₁, e₂ along them, and of these by six scalars: e₁·e₁, e₁·e₂, e₂·e₂, u·e₁, u·e₂, u·(e₁×e₂).
//! Dual numbers over six variables give the derivatives of everything that is not a product.

use super::geometry::{Point, cross, dot, sub};
use fem_kinematics::{Dual, HessianProjection, Real, jacobi_eigen};

/// Which partners a pair has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Vertex 0 against the triangle of the vertices 1, 2, 3, counter-clockwise from outside.
    Point,
    /// Edge (0, 1) against edge (2, 3); the second lies along +(e₁×e₂) of the first.
    EdgeAlong,
    /// The same with the second along −(e₁×e₂).
    EdgeAgainst,
}

/// One pair of partners that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    /// Vertices of the surface.
    pub vertices: [u32; 4],
    pub kind: Kind,
    /// Pressure at gap 0 times area, newtons.
    pub force: f64,
    /// The gap at which it begins to feel, meters.
    pub activation: f64,
    /// What the gap is measured in, meters.
    pub length: f64,
}

/// How far a window reaches to both sides of an end, as a share of the height of the triangle or
/// the length of the edge.
pub(crate) const BAND: f64 = 0.15;
/// sin² of the angles between which two edges count as parallel less and less.
const PARALLEL: [f64; 2] = [0.02, 0.1];

/// 0 up to 0, 1 from 1 on, with two continuous derivatives.
fn smooth<T: Real>(z: T) -> T {
    let number = T::from_f64;
    let inside = z * z * z * (number(10.0) + z * (number(6.0) * z - number(15.0)));
    let high = T::select(T::one().le(z), T::one(), inside);
    T::select(z.le(T::zero()), T::zero(), high)
}

/// 0 outside an end, 1 inside, from −[`BAND`] to [`BAND`].
fn window<T: Real>(share: T) -> T {
    smooth((share + T::from_f64(BAND)) * T::from_f64(0.5 / BAND))
}

/// The gap in meters, and the product of the windows.
fn gap_and_weight<T: Real>(kind: Kind, [a, b, c, p, q, v]: [T; 6]) -> (T, T) {
    let one = T::one();
    let area = a * c - b * b;
    let gap = v / area.sqrt();
    if kind == Kind::Point {
        let (second, third) = ((c * p - b * q) / area, (a * q - b * p) / area);
        let weight = window(one - second - third) * window(second) * window(third);
        return (gap, weight);
    }
    let gap = if kind == Kind::EdgeAlong { gap } else { -gap };
    let (s, t) = ((c * p - b * q) / area, (b * p - a * q) / area);
    let [low, high] = PARALLEL;
    let across = (area / (a * c) - T::from_f64(low)) * T::from_f64(1.0 / (high - low));
    let ends = window(s) * window(one - s) * window(t) * window(one - t);
    (gap, ends * smooth(across))
}

impl Pair {
    /// (u, e₁, e₂) as sums over the vertices.
    fn signs(&self) -> [[f64; 4]; 3] {
        match self.kind {
            Kind::Point => [
                [1.0, -1.0, 0.0, 0.0],
                [0.0, -1.0, 1.0, 0.0],
                [0.0, -1.0, 0.0, 1.0],
            ],
            _ => [
                [-1.0, 0.0, 1.0, 0.0],
                [-1.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, -1.0, 1.0],
            ],
        }
    }

    fn at(&self, x: [Point; 4]) -> [Point; 3] {
        match self.kind {
            Kind::Point => [sub(x[0], x[1]), sub(x[2], x[1]), sub(x[3], x[1])],
            _ => [sub(x[2], x[0]), sub(x[1], x[0]), sub(x[3], x[2])],
        }
    }

    /// Gap in meters (negative behind), and how much the pair counts, 0 to 1.
    pub fn gap(&self, x: [Point; 4]) -> (f64, f64) {
        gap_and_weight(self.kind, scalars(self.at(x)))
    }

    /// F ℓ/3 ((d̂ − g)/ℓ)³ w, joules: pressure grows with the square of what is missing of d̂.
    fn potential<T: Real>(&self, s: [T; 6]) -> T {
        let (gap, weight) = gap_and_weight(self.kind, s);
        let depth = (T::from_f64(self.activation) - gap) * T::from_f64(1.0 / self.length);
        depth * depth * depth * weight * T::from_f64(self.force * self.length / 3.0)
    }

    /// Nothing is felt; false where a number is NaN.
    fn is_silent(&self, s: [f64; 6]) -> bool {
        let (gap, weight) = gap_and_weight(self.kind, s);
        gap >= self.activation || weight == 0.0
    }

    /// The energy, joules.
    pub fn energy(&self, x: [Point; 4]) -> f64 {
        let s = scalars(self.at(x));
        if self.is_silent(s) {
            0.0
        } else {
            self.potential(s)
        }
    }

    /// Energy and gradient at the four vertices; `None` where nothing is felt.
    pub fn gradient(&self, x: [Point; 4]) -> Option<(f64, [Point; 4])> {
        let vectors = self.at(x);
        let s = scalars(vectors);
        if self.is_silent(s) {
            return None;
        }
        let slope = |i: usize| {
            let dual = std::array::from_fn(|j| Dual::new(s[j], f64::from(u8::from(i == j))));
            self.potential(dual).derivative
        };
        let slopes: [f64; 6] = std::array::from_fn(slope);
        let by_vector = product(&jacobian(vectors), &slopes);
        let share = self.signs();
        let at = |vertex: usize| {
            std::array::from_fn(|i| {
                (0..3)
                    .map(|k| share[k][vertex] * by_vector[3 * k + i])
                    .sum()
            })
        };
        Some((self.potential(s), std::array::from_fn(at)))
    }

    /// The Hessian, vertex by vertex; `None` where nothing is felt.
    pub fn hessian(&self, x: [Point; 4], projection: HessianProjection) -> Option<[[f64; 12]; 12]> {
        let vectors = self.at(x);
        let s = scalars(vectors);
        if self.is_silent(s) {
            return None;
        }
        let (slopes, curvatures) = self.second_order(s);
        let by_vector = chained(vectors, &slopes, &curvatures);
        if projection == HessianProjection::None {
            return Some(spread(&by_vector, &self.signs()));
        }
        // Translations cost nothing: nine of the twelve directions are left.
        let by_shape = spread(&by_vector, &self.signs().map(|row| shapes_of(&row)));
        Some(spread(&projected(by_shape, projection), &SHAPES))
    }

    /// First and second derivatives by the six scalars.
    fn second_order(&self, s: [f64; 6]) -> ([f64; 6], [[f64; 6]; 6]) {
        let (mut slopes, mut curvatures) = ([0.0; 6], [[0.0; 6]; 6]);
        for i in 0..6 {
            for j in 0..=i {
                let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
                let dual = std::array::from_fn(|k| {
                    Dual::new(Dual::new(s[k], delta(k, i)), Dual::new(delta(k, j), 0.0))
                });
                let value = self.potential(dual);
                slopes[i] = value.value.derivative;
                curvatures[i][j] = value.derivative.derivative;
                curvatures[j][i] = curvatures[i][j];
            }
        }
        (slopes, curvatures)
    }
}

fn scalars([u, e, f]: [Point; 3]) -> [f64; 6] {
    [
        dot(e, e),
        dot(e, f),
        dot(f, f),
        dot(u, e),
        dot(u, f),
        dot(u, cross(e, f)),
    ]
}

/// Derivatives of the six scalars by (u, e₁, e₂).
fn jacobian([u, e, f]: [Point; 3]) -> [[f64; 9]; 6] {
    let zero = [0.0; 3];
    let twice = |p: Point| p.map(|c| 2.0 * c);
    let rows = [
        [zero, twice(e), zero],
        [zero, f, e],
        [zero, zero, twice(f)],
        [e, u, zero],
        [f, zero, u],
        [cross(e, f), cross(f, u), cross(u, e)],
    ];
    rows.map(|row| std::array::from_fn(|k| row[k / 3][k % 3]))
}

fn product(jacobian: &[[f64; 9]; 6], slopes: &[f64; 6]) -> [f64; 9] {
    std::array::from_fn(|k| (0..6).map(|i| jacobian[i][k] * slopes[i]).sum())
}

/// Second derivatives by (u, e₁, e₂) from those by the six scalars.
fn chained([u, e, f]: [Point; 3], slopes: &[f64; 6], curvatures: &[[f64; 6]; 6]) -> [[f64; 9]; 9] {
    let jacobian = jacobian([u, e, f]);
    let half: [[f64; 9]; 6] = curvatures.map(|row| product(&jacobian, &row));
    let mut hessian: [[f64; 9]; 9] = std::array::from_fn(|k| {
        std::array::from_fn(|l| (0..6).map(|i| jacobian[i][k] * half[i][l]).sum())
    });
    let mut add = |k: usize, l: usize, identity: f64, volume: Point| {
        // [volume]ₓ
        let [x, y, z] = volume;
        let turn = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        for i in 0..3 {
            for j in 0..3 {
                let value = turn[i][j] + if i == j { identity } else { 0.0 };
                hessian[3 * k + i][3 * l + j] += value;
                if k != l {
                    hessian[3 * l + j][3 * k + i] += value;
                }
            }
        }
    };
    let [a, b, c, p, q, v] = *slopes;
    let times = |w: Point, s: f64| w.map(|x| s * x);
    add(1, 1, 2.0 * a, [0.0; 3]);
    add(2, 2, 2.0 * c, [0.0; 3]);
    add(1, 2, b, times(u, -v));
    add(0, 1, p, times(f, -v));
    add(0, 2, q, times(e, v));
    hessian
}

/// Three orthonormal combinations of four vertices that no translation changes.
const SHAPES: [[f64; 4]; 3] = [
    [0.5, 0.5, -0.5, -0.5],
    [0.5, -0.5, 0.5, -0.5],
    [0.5, -0.5, -0.5, 0.5],
];

/// Shares of the four vertices as shares of [`SHAPES`].
fn shapes_of(shares: &[f64; 4]) -> [f64; 3] {
    SHAPES.map(|shape| (0..4).map(|v| shape[v] * shares[v]).sum())
}

/// (Sᵀ ⊗ 1) H (S ⊗ 1): a Hessian by three vectors, each a sum with these shares, by what they are
/// sums of.
fn spread<const N: usize, const M: usize>(
    by_vector: &[[f64; 9]; 9],
    shares: &[[f64; N]; 3],
) -> [[f64; M]; M] {
    let mut half = [[0.0; M]; 9];
    for (row, line) in half.iter_mut().enumerate() {
        for (column, entry) in line.iter_mut().enumerate() {
            let (b, j) = (column / 3, column % 3);
            *entry = (0..3)
                .map(|l| by_vector[row][3 * l + j] * shares[l][b])
                .sum();
        }
    }
    let mut spread = [[0.0; M]; M];
    for (row, line) in spread.iter_mut().enumerate() {
        let (a, i) = (row / 3, row % 3);
        for (column, entry) in line.iter_mut().enumerate() {
            *entry = (0..3).map(|k| shares[k][a] * half[3 * k + i][column]).sum();
        }
    }
    spread
}

fn projected(hessian: [[f64; 9]; 9], projection: HessianProjection) -> [[f64; 9]; 9] {
    let largest = hessian
        .as_flattened()
        .iter()
        .fold(0.0_f64, |m, h| m.max(h.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return hessian;
    }
    let (values, vectors) = jacobi_eigen(&hessian.map(|row| row.map(|h| h / largest)));
    let values = values.map(|value| largest * projection.eigenvalue(value));
    let entry = |i: usize, j: usize| {
        let of = |k: usize| vectors[i][k] * values[k] * vectors[j][k];
        (0..9).map(of).sum()
    };
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}
