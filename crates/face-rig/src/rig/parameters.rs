//! θ: what an animator sets and a fit finds.

use crate::anatomy::AffineMap;

/// θ = (muscle activations θ_a; cranium and jaw θ_k), document 000, 2; and controls.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// One activation per muscle; 0 relaxed, 1 fully contracted.
    pub activations: Vec<f64>,
    /// M_c, t_c: moves every node.
    pub cranium: AffineMap,
    /// M_j, t_j: moves the nodes attached to the jaw, in the cranium's frame.
    pub jaw: AffineMap,
    /// One value for each control of the rig ([`Control`](super::Control)), in its own unit.
    pub controls: Vec<f64>,
}

impl Parameters {
    /// Relaxed, at rest, of a rig without controls.
    pub fn rest(muscles: usize) -> Self {
        Self {
            activations: vec![0.0; muscles],
            cranium: AffineMap::IDENTITY,
            jaw: AffineMap::IDENTITY,
            controls: Vec::new(),
        }
    }

    /// The same pose with these controls.
    #[must_use]
    pub fn with_controls(self, controls: Vec<f64>) -> Self {
        Self { controls, ..self }
    }

    /// Activations, then M_c by rows, t_c, M_j by rows, t_j, then the controls.
    pub fn to_vec(&self) -> Vec<f64> {
        let mut theta = self.activations.clone();
        theta.extend(self.cranium.to_array());
        theta.extend(self.jaw.to_array());
        theta.extend(&self.controls);
        theta
    }

    /// The inverse of [`Parameters::to_vec`] without controls; `None` for fewer than 24 numbers.
    pub fn from_slice(theta: &[f64]) -> Option<Self> {
        let (rest, jaw) = theta.split_last_chunk::<12>()?;
        let (activations, cranium) = rest.split_last_chunk::<12>()?;
        Some(Self {
            activations: activations.to_vec(),
            cranium: AffineMap::from_array(*cranium),
            jaw: AffineMap::from_array(*jaw),
            controls: Vec::new(),
        })
    }

    /// (1 − t) self + t other, number by number, as far as both have them: a pose on the way, whose bones
    /// are not rigid in between.
    #[must_use]
    pub fn toward(&self, other: &Self, t: f64) -> Self {
        let mix = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect()
        };
        let map = |a: &AffineMap, b: &AffineMap| {
            let (a, b) = (a.to_array(), b.to_array());
            AffineMap::from_array(std::array::from_fn(|k| a[k] + t * (b[k] - a[k])))
        };
        Self {
            activations: mix(&self.activations, &other.activations),
            cranium: map(&self.cranium, &other.cranium),
            jaw: map(&self.jaw, &other.jaw),
            controls: mix(&self.controls, &other.controls),
        }
    }
}

/// A direction in the space of θ: one column of dx/dθ.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Direction {
    /// dα of one muscle.
    Activation(usize),
    /// (dM_c, dt_c).
    Cranium(AffineMap),
    /// (dM_j, dt_j).
    Jaw(AffineMap),
    /// dc of one control of the rig, in its own unit.
    Control(usize),
}

impl Direction {
    /// The directions of all entries of [`Parameters::to_vec`] without controls, in its order.
    pub fn all(muscles: usize) -> Vec<Self> {
        let units = || (0..AffineMap::PARAMETERS).map(AffineMap::unit);
        (0..muscles)
            .map(Self::Activation)
            .chain(units().map(Self::Cranium))
            .chain(units().map(Self::Jaw))
            .collect()
    }
}
