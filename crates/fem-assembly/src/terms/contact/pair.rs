//! The energy of one pair, with its derivatives.
//!
//! A pair has four vertices. What it feels is told by three vectors, u between the two partners and
//! e₁, e₂ along them, and of these by six scalars: e₁·e₁, e₁·e₂, e₂·e₂, u·e₁, u·e₂, u·(e₁×e₂).
//! The energy is a function of what [`Measures`] makes of them.

use super::geometry::{Point, cross, dot, sub};
use super::measures::{Measures, windows};
use fem_kinematics::{HessianProjection, Real, jacobi_eigen};

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
pub(super) const BAND: f64 = 0.15;
/// sin² of the angles between which two edges count as parallel less and less.
pub(super) const PARALLEL: [f64; 2] = [0.02, 0.1];

/// Room for rounding in the square of a gap.
const FARTHER: f64 = 1.0 + 1e-9;

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

    /// F ℓ e((d̂ − g)/ℓ) w, joules, with e of [`push`].
    fn potential<T: Real>(&self, s: [T; 6]) -> T {
        let (gap, weight) = gap_and_weight(self.kind, s);
        let lack = (T::from_f64(self.activation) - gap) * T::from_f64(1.0 / self.length);
        push(lack)[0] * weight * T::from_f64(self.force * self.length)
    }

    /// Nothing is felt; false where a number is NaN.
    pub fn is_silent(&self, x: [Point; 4]) -> bool {
        self.are_silent(scalars(self.at(x)))
    }

    fn are_silent(&self, s: [f64; 6]) -> bool {
        let [a, b, c, _, _, v] = s;
        let farthest = FARTHER * self.activation * self.activation * (a * c - b * b);
        // The gap with neither root nor quotient: most pairs are farther from each other.
        if self.kind == Kind::Point && farthest > 0.0 && v > 0.0 && v * v > farthest {
            return true;
        }
        let (gap, weight) = gap_and_weight(self.kind, s);
        gap >= self.activation || weight == 0.0
    }

    /// The energy, joules.
    pub fn energy(&self, x: [Point; 4]) -> f64 {
        let s = scalars(self.at(x));
        if self.are_silent(s) {
            0.0
        } else {
            self.potential(s)
        }
    }

    /// Energy, joules, and its gradient by [`SHAPES`], newtons; `None` where nothing is felt.
    pub fn gradient(&self, x: [Point; 4]) -> Option<(f64, [Point; 3])> {
        let vectors = self.at(x);
        let s = scalars(vectors);
        if self.are_silent(s) {
            return None;
        }
        let measures = Measures::new(self.kind, &s);
        let outer = self.outer(&measures.values);
        let by_vector = product(&jacobian(vectors), &outer.slopes_by_scalars(&measures));
        let shares = self.vectors_by_shapes();
        let by_shape = |shape: usize| {
            std::array::from_fn(|i| {
                (0..3)
                    .map(|k| shares[k][shape] * by_vector[3 * k + i])
                    .sum()
            })
        };
        // The same number as `energy`, to the last bit.
        Some((self.potential(s), std::array::from_fn(by_shape)))
    }

    /// The Hessian by [`SHAPES`], N/m; `None` where nothing is felt.
    pub fn hessian(&self, x: [Point; 4], projection: HessianProjection) -> Option<[[f64; 9]; 9]> {
        let vectors = self.at(x);
        let s = scalars(vectors);
        if self.are_silent(s) {
            return None;
        }
        let (slopes, curvatures) = self.second_order(&s);
        let by_vector = chained(vectors, &slopes, &curvatures);
        let by_shape = spread(&by_vector, &self.vectors_by_shapes());
        Some(match projection {
            HessianProjection::None => by_shape,
            // Translations cost nothing: nine of the twelve directions are left.
            _ => projected(by_shape, projection),
        })
    }

    /// The three vectors as sums of [`SHAPES`].
    fn vectors_by_shapes(&self) -> [[f64; 3]; 3] {
        self.signs().map(|row| shapes_of(&row))
    }

    /// First and second derivatives by the six scalars.
    fn second_order(&self, s: &[f64; 6]) -> ([f64; 6], [[f64; 6]; 6]) {
        let measures = Measures::new(self.kind, s);
        let outer = self.outer(&measures.values);
        let of_measures = measures.curvatures(self.kind, s);
        let rows = &measures.slopes;
        let half: [[f64; 6]; 4] = std::array::from_fn(|m| {
            std::array::from_fn(|j| (0..4).map(|n| outer.curvatures[m][n] * rows[n][j]).sum())
        });
        let curvature = |i: usize, j: usize| {
            let term = |m: usize| rows[m][i] * half[m][j] + outer.slopes[m] * of_measures[m][i][j];
            (0..4).map(term).sum()
        };
        let curvatures = std::array::from_fn(|i| std::array::from_fn(|j| curvature(i, j)));
        (outer.slopes_by_scalars(&measures), curvatures)
    }

    /// The energy as a function of gap and shares.
    fn outer(&self, measures: &[f64; 4]) -> Outer {
        let windows @ [[f, df, _], [g, dg, _], [h, dh, _]] = windows(self.kind, *measures);
        let [energy, pressure, stiffness] = push((self.activation - measures[0]) / self.length);
        let by_gap = [
            self.force * self.length * energy,
            -self.force * pressure,
            self.force / self.length * stiffness,
        ];
        let weight = f * g * h;
        let others = [g * h, f * h, f * g];
        let by_share: [f64; 3] = std::array::from_fn(|k| windows[k][1] * others[k]);
        let [e, de, dde] = by_gap;
        let mut curvatures = [[0.0; 4]; 4];
        curvatures[0][0] = dde * weight;
        let crossed = [
            [0.0, df * dg * h, df * dh * g],
            [0.0, 0.0, dg * dh * f],
            [0.0; 3],
        ];
        for k in 0..3 {
            curvatures[0][k + 1] = de * by_share[k];
            curvatures[k + 1][0] = de * by_share[k];
            curvatures[k + 1][k + 1] = e * windows[k][2] * others[k];
            for l in k + 1..3 {
                curvatures[k + 1][l + 1] = e * crossed[k][l];
                curvatures[l + 1][k + 1] = e * crossed[k][l];
            }
        }
        Outer {
            slopes: [
                de * weight,
                e * by_share[0],
                e * by_share[1],
                e * by_share[2],
            ],
            curvatures,
        }
    }
}

/// Up to so many lengths of what is missing of d̂ the pressure grows with their square;
const SHALLOW: f64 = 2.0;
/// over so many more it grows less and less, to a² + a w = 12 p̂.
const BENDS: f64 = 4.0;

/// e(x) with its two derivatives, of which the first is the pressure in p̂: x³/3 as long as little is missing.
///
/// A point deep behind a triangle enters and leaves the triangle's windows by the energy of its depth. Energies
/// of x³ are walls there, a hundredth of a millimeter wide, that no step of a solve gets past.
fn push<T: Real>(x: T) -> [T; 3] {
    let number = T::from_f64;
    let third = number(1.0 / 3.0);
    let shallow = [x * x * x * third, x * x, number(2.0) * x];
    let (a, w) = (SHALLOW, BENDS);
    // The slope falls from 2a to 0 over w.
    let bent = |z: T| {
        let rest = z * number(a / w);
        [
            number(a * a * a / 3.0) + z * (number(a * a) + z * (number(a) - rest * third)),
            number(a * a) + z * (number(2.0 * a) - rest),
            number(2.0 * a) - number(2.0) * rest,
        ]
    };
    let z = x - number(a);
    let [energy, pressure, _] = bent(number(w));
    let deep = [energy + pressure * (z - number(w)), pressure, T::zero()];
    let bent = bent(z);
    std::array::from_fn(|order| {
        let beyond = T::select(z.le(number(w)), bent[order], deep[order]);
        T::select(x.le(number(a)), shallow[order], beyond)
    })
}

/// The energy by gap and shares.
struct Outer {
    slopes: [f64; 4],
    curvatures: [[f64; 4]; 4],
}

impl Outer {
    fn slopes_by_scalars(&self, measures: &Measures) -> [f64; 6] {
        std::array::from_fn(|i| (0..4).map(|m| self.slopes[m] * measures.slopes[m][i]).sum())
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
pub(super) const SHAPES: [[f64; 4]; 3] = [
    [0.5, 0.5, -0.5, -0.5],
    [0.5, -0.5, 0.5, -0.5],
    [0.5, -0.5, -0.5, 0.5],
];

/// Shares of the four vertices as shares of [`SHAPES`].
pub(super) fn shapes_of(shares: &[f64; 4]) -> [f64; 3] {
    SHAPES.map(|shape| (0..4).map(|v| shape[v] * shares[v]).sum())
}

/// (Sᵀ ⊗ 1) H (S ⊗ 1): a Hessian by three vectors, each a sum with these shares, by what they are
/// sums of.
fn spread(by_vector: &[[f64; 9]; 9], shares: &[[f64; 3]; 3]) -> [[f64; 9]; 9] {
    let mut half = [[0.0; 9]; 9];
    for (row, line) in half.iter_mut().enumerate() {
        for (column, entry) in line.iter_mut().enumerate() {
            let (b, j) = (column / 3, column % 3);
            *entry = (0..3)
                .map(|l| by_vector[row][3 * l + j] * shares[l][b])
                .sum();
        }
    }
    let mut spread = [[0.0; 9]; 9];
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

#[cfg(test)]
mod tests {
    use super::*;
    use fem_kinematics::Dual;

    const KINDS: [Kind; 3] = [Kind::Point, Kind::EdgeAlong, Kind::EdgeAgainst];

    fn pair(kind: Kind) -> Pair {
        Pair {
            vertices: [0, 1, 2, 3],
            kind,
            force: 3.0,
            activation: 0.8,
            length: 0.6,
        }
    }

    /// The same for which as much is missing in lengths as in a pair three or twelve times as deep.
    fn pairs(kind: Kind) -> [Pair; 3] {
        [0.6, 0.2, 0.05].map(|length| Pair {
            length,
            ..pair(kind)
        })
    }

    /// Places of four vertices that differ with k, in and beside each other's windows; every other two
    /// edges are nearly parallel.
    fn places(kind: Kind, k: usize) -> [Point; 4] {
        let parallel = kind != Kind::Point && k % 2 == 1;
        let size = if parallel { 0.02 } else { 0.4 };
        let noise = |n: usize| size * (17.3 * (12 * k + n) as f64 + 0.7).sin();
        let rough: [Point; 4] = std::array::from_fn(|v| std::array::from_fn(|i| noise(3 * v + i)));
        let base = match kind {
            Kind::Point => [[0.3, 0.3, 0.3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            _ if parallel => [
                [-0.5, 0.0, 0.0],
                [0.5, 0.0, 0.0],
                [-0.5, -0.12, 0.3],
                [0.5, 0.12, 0.3],
            ],
            _ => [
                [-0.5, 0.0, 0.0],
                [0.5, 0.0, 0.0],
                [0.0, -0.5, 0.3],
                [0.0, 0.5, 0.3],
            ],
        };
        std::array::from_fn(|v| std::array::from_fn(|i| base[v][i] + rough[v][i]))
    }

    /// Dual numbers through the formula of the energy, against the closed forms.
    #[test]
    fn closed_forms_are_what_dual_numbers_give() {
        let (mut felt, mut parallel, mut deep) = (0, 0, [0; 3]);
        for pair in KINDS.into_iter().flat_map(pairs) {
            let kind = pair.kind;
            for k in 0..60 {
                let s = scalars(pair.at(places(kind, k)));
                if pair.are_silent(s) {
                    continue;
                }
                felt += 1;
                let lack = (pair.activation - pair.gap(places(kind, k)).0) / pair.length;
                deep[usize::from(lack > SHALLOW) + usize::from(lack > SHALLOW + BENDS)] += 1;
                let [.., [_, slope, _]] = windows(kind, Measures::new(kind, &s).values);
                parallel += usize::from(kind != Kind::Point && slope > 0.0);
                let (slopes, curvatures) = pair.second_order(&s);
                let size = slopes.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                for i in 0..6 {
                    for j in 0..6 {
                        let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
                        let dual = std::array::from_fn(|n| {
                            Dual::new(Dual::new(s[n], delta(n, i)), Dual::new(delta(n, j), 0.0))
                        });
                        let value: Dual<Dual<f64>> = pair.potential(dual);
                        let slope = value.value.derivative;
                        assert!(
                            (slopes[i] - slope).abs() <= 1e-11 * size,
                            "{kind:?} {k} {i}"
                        );
                        let curvature = value.derivative.derivative;
                        let scale = 1e-10 * size.max(curvature.abs());
                        let off = (curvatures[i][j] - curvature).abs();
                        assert!(
                            off <= scale,
                            "{kind:?} {k} {i} {j}: {off:e} of {curvature:e}"
                        );
                    }
                }
            }
        }
        assert!(felt > 180 && parallel > 60, "{felt}, {parallel}");
        assert!(deep.iter().all(|&n| n > 30), "{deep:?}");
    }

    /// Twice continuously: 0, 0, 0 at touch, and the same from both sides where the law changes.
    #[test]
    fn pressure_grows_with_the_square_and_then_no_more() {
        assert_eq!(push(0.0), [0.0; 3]);
        assert_eq!(push(1.0), [1.0 / 3.0, 1.0, 2.0]);
        for x in [SHALLOW, SHALLOW + BENDS] {
            let ([e, p, k], [f, q, l]) = (push(x - 1e-9), push(x + 1e-9));
            assert!((f - e - 2e-9 * p).abs() < 1e-13 && (q - p - 2e-9 * k).abs() < 1e-13);
            assert!((l - k).abs() < 1e-8, "{k} {l}");
        }
        let [e, p, k] = push(7.0);
        let [f, q, _] = push(8.5);
        assert!((p - 12.0).abs() < 1e-13 && (q, k) == (p, 0.0), "{p} {k}");
        assert!((f - e - 18.0).abs() < 1e-12);
    }

    #[test]
    fn far_pairs_are_told_without_a_root() {
        for k in 0..200 {
            for kind in KINDS {
                let (pair, x) = (pair(kind), places(kind, k));
                let (gap, weight) = pair.gap(x);
                let silent = gap >= pair.activation || weight == 0.0;
                assert_eq!(pair.is_silent(x), silent, "{kind:?} {k}: {gap}");
            }
        }
    }
}
