//! What is seen of a face: the map g from node positions to observed numbers (document 000, 1).

use crate::anatomy::EmbeddedPoint;
use fem_assembly::AssemblyError;

/// g(x) with its derivative, both ways.
pub trait Observation: Sync {
    /// Observed numbers.
    fn dim(&self) -> usize;
    /// Asked before all else with the number of nodes that positions will be given for.
    ///
    /// # Errors
    /// When it observes other nodes.
    fn check(&self, _nodes: usize) -> Result<(), AssemblyError> {
        Ok(())
    }
    /// g(x).
    fn value(&self, x: &[[f64; 3]], out: &mut [f64]);
    /// (∂g/∂x) dx.
    fn differential(&self, x: &[[f64; 3]], dx: &[[f64; 3]], out: &mut [f64]);
    /// Adds (∂g/∂x)ᵀ w to a field over the nodes.
    fn add_adjoint(&self, x: &[[f64; 3]], w: &[f64], out: &mut [[f64; 3]]);
    /// Adds (∂g_k/∂x)ᵀ for one observed number, for Jacobians built row by row.
    fn add_row(&self, x: &[[f64; 3]], k: usize, out: &mut [[f64; 3]]) {
        let mut w = vec![0.0; self.dim()];
        w[k] = 1.0;
        self.add_adjoint(x, &w, out);
    }
}

/// g = identity: every node of a target with the same topology is seen (document 000, eq. 1).
#[derive(Clone, Copy, Debug)]
pub struct AllNodes {
    /// Number of nodes.
    pub nodes: usize,
}

impl Observation for AllNodes {
    fn dim(&self) -> usize {
        3 * self.nodes
    }
    fn check(&self, nodes: usize) -> Result<(), AssemblyError> {
        if nodes == self.nodes {
            return Ok(());
        }
        Err(AssemblyError::WrongLength {
            what: "observed nodes",
            found: self.nodes,
            expected: nodes,
        })
    }
    fn value(&self, x: &[[f64; 3]], out: &mut [f64]) {
        out.copy_from_slice(x.as_flattened());
    }
    fn differential(&self, _: &[[f64; 3]], dx: &[[f64; 3]], out: &mut [f64]) {
        out.copy_from_slice(dx.as_flattened());
    }
    fn add_adjoint(&self, _: &[[f64; 3]], w: &[f64], out: &mut [[f64; 3]]) {
        for (o, w) in out.as_flattened_mut().iter_mut().zip(w) {
            *o += w;
        }
    }
}

/// Landmarks and other points inside tets, by barycentric weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmbeddedPoints(pub Vec<EmbeddedPoint>);

impl Observation for EmbeddedPoints {
    fn dim(&self) -> usize {
        3 * self.0.len()
    }
    fn check(&self, nodes: usize) -> Result<(), AssemblyError> {
        let mut named = self.0.iter().flat_map(|p| p.nodes).map(|n| n as usize);
        match named.find(|&node| node >= nodes) {
            Some(node) => Err(AssemblyError::NoSuchNode { node, count: nodes }),
            None => Ok(()),
        }
    }
    fn value(&self, x: &[[f64; 3]], out: &mut [f64]) {
        for (point, out) in self.0.iter().zip(out.as_chunks_mut::<3>().0) {
            *out = point.position(x);
        }
    }
    fn differential(&self, _: &[[f64; 3]], dx: &[[f64; 3]], out: &mut [f64]) {
        self.value(dx, out);
    }
    fn add_adjoint(&self, _: &[[f64; 3]], w: &[f64], out: &mut [[f64; 3]]) {
        for (point, w) in self.0.iter().zip(w.as_chunks::<3>().0) {
            for k in 0..4 {
                for i in 0..3 {
                    out[point.nodes[k] as usize][i] += point.weights[k] * w[i];
                }
            }
        }
    }
    fn add_row(&self, _: &[[f64; 3]], k: usize, out: &mut [[f64; 3]]) {
        let point = &self.0[k / 3];
        for n in 0..4 {
            out[point.nodes[n] as usize][k % 3] += point.weights[n];
        }
    }
}
