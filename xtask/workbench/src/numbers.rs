//! Numbers of the reference tables: every one is text, so that `str::parse::<f64>`, which rounds
//! correctly, reads it.

use fem_kinematics::{Mat, Tensor4};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// A string of numbers separated by white space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers(pub Vec<f64>);

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<S: Deserializer<'de>>(deserializer: S) -> Result<Self, S::Error> {
        let text = std::borrow::Cow::<str>::deserialize(deserializer)?;
        text.split_whitespace()
            .map(|word| {
                word.parse()
                    .map_err(|_| S::Error::custom(format!("`{word}` is no number")))
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// A string that holds one number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Number(pub f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<S: Deserializer<'de>>(deserializer: S) -> Result<Self, S::Error> {
        let numbers = Numbers::deserialize(deserializer)?.0;
        match numbers[..] {
            [one] => Ok(Self(one)),
            _ => Err(S::Error::custom(format!(
                "one number expected, {} found",
                numbers.len()
            ))),
        }
    }
}

impl Numbers {
    /// As a matrix by rows.
    pub fn matrix<const D: usize>(&self) -> Mat<f64, D> {
        Mat::from_fn(|i, j| self.0[D * i + j])
    }

    /// As vectors one after the other.
    pub fn vectors<const D: usize>(&self) -> Vec<[f64; D]> {
        self.0
            .chunks_exact(D)
            .map(|c| core::array::from_fn(|i| c[i]))
            .collect()
    }
}

/// ∂Pᵢⱼ/∂Fₖₗ at row D i + j, column D k + l.
pub fn by_rows<const D: usize>(tensor: &Tensor4<f64, D>) -> Vec<f64> {
    let mut rows = Vec::with_capacity(D * D * D * D);
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                for l in 0..D {
                    rows.push(tensor.get(i, j, k, l));
                }
            }
        }
    }
    rows
}

/// The entries of a matrix by rows.
pub fn entries<const D: usize>(m: &Mat<f64, D>) -> Vec<f64> {
    m.0.iter().flatten().copied().collect()
}

/// The larger of two sizes or errors; NaN, once seen, stays.
pub fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// Euclidean norm.
pub fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Euclidean distance; NaN for different lengths.
pub fn distance(x: &[f64], y: &[f64]) -> f64 {
    if x.len() != y.len() {
        return f64::NAN;
    }
    x.iter()
        .zip(y)
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_to_the_last_bit() {
        let read: Numbers = serde_json::from_str("\"0.1 -5e-324 inf\"").unwrap();
        assert_eq!(read.0, [0.1, -5e-324, f64::INFINITY]);
        assert!(serde_json::from_str::<Number>("\"1 2\"").is_err());
        assert!(serde_json::from_str::<Numbers>("\"1 two\"").is_err());
    }
}
