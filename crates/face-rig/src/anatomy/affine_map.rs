//! Affine maps of cranium and jaw.

/// The map X ↦ M X + t: nine numbers and a translation in meters (document 000, 2.2-2.3).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct AffineMap {
    /// M, by rows.
    pub matrix: [[f64; 3]; 3],
    /// t, meters.
    pub translation: [f64; 3],
}

impl Default for AffineMap {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl AffineMap {
    /// X ↦ X.
    pub const IDENTITY: Self = Self {
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };
    /// X ↦ 0: the zero differential.
    pub const ZERO: Self = Self {
        matrix: [[0.0; 3]; 3],
        translation: [0.0; 3],
    };
    /// Numbers in a map.
    pub const PARAMETERS: usize = 12;

    /// M X + t.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.rotate(point);
        std::array::from_fn(|i| turned[i] + self.translation[i])
    }

    /// M v.
    pub fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        self.matrix
            .map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// Mᵀ v.
    pub fn rotate_transposed(&self, v: [f64; 3]) -> [f64; 3] {
        let m = &self.matrix;
        std::array::from_fn(|j| m[0][j] * v[0] + m[1][j] * v[1] + m[2][j] * v[2])
    }

    /// The twelve numbers: M by rows, then t.
    pub fn to_array(&self) -> [f64; 12] {
        std::array::from_fn(|k| {
            if k < 9 {
                self.matrix[k / 3][k % 3]
            } else {
                self.translation[k - 9]
            }
        })
    }

    /// From M by rows and t.
    pub fn from_array(numbers: [f64; 12]) -> Self {
        Self {
            matrix: std::array::from_fn(|i| std::array::from_fn(|j| numbers[3 * i + j])),
            translation: std::array::from_fn(|i| numbers[9 + i]),
        }
    }

    /// The differential with 1 at number `k` of [`AffineMap::to_array`].
    pub fn unit(k: usize) -> Self {
        Self::from_array(std::array::from_fn(|i| f64::from(i == k)))
    }

    /// MᵀM − I, all nine entries by rows: zero exactly for rotations and reflections. Half its
    /// squared norm is the orthogonality energy of document 000, 2.2.
    pub fn orthogonality(&self) -> [f64; 9] {
        let m = &self.matrix;
        std::array::from_fn(|k| {
            let (i, j) = (k / 3, k % 3);
            (0..3).map(|l| m[l][i] * m[l][j]).sum::<f64>() - f64::from(i == j)
        })
    }

    /// The differential of [`AffineMap::orthogonality`] in direction `d`: dMᵀM + MᵀdM.
    pub fn orthogonality_differential(&self, d: &Self) -> [f64; 9] {
        let (m, dm) = (&self.matrix, &d.matrix);
        std::array::from_fn(|k| {
            let (i, j) = (k / 3, k % 3);
            (0..3)
                .map(|l| dm[l][i] * m[l][j] + m[l][i] * dm[l][j])
                .sum()
        })
    }

    /// Are all twelve numbers finite?
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|v| v.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_survive_the_round_trip() {
        let numbers = std::array::from_fn(|k| k as f64 + 0.5);
        assert_eq!(AffineMap::from_array(numbers).to_array(), numbers);
        assert_eq!(
            AffineMap::from_array(numbers).apply([1.0, 0.0, 0.0]),
            [10.0, 14.0, 18.0]
        );
    }

    #[test]
    fn the_orthogonality_differential_agrees_with_differences() {
        let map = AffineMap::from_array(std::array::from_fn(|k| (k as f64 * 1.7).sin()));
        for k in 0..12 {
            let h = 1e-6;
            let shifted = |s: f64| {
                let mut numbers = map.to_array();
                numbers[k] += s;
                AffineMap::from_array(numbers).orthogonality()
            };
            let (high, low) = (shifted(h), shifted(-h));
            let exact = map.orthogonality_differential(&AffineMap::unit(k));
            for e in 0..9 {
                assert!(((high[e] - low[e]) / (2.0 * h) - exact[e]).abs() < 1e-9);
            }
        }
    }
}
