//! The problem that most tests of Newton's method minimize.

use crate::promise::Summed;
use fem_solvers::{BlockPattern, BlockSymmetric, HessianProjection, NonlinearProblem};
use std::sync::Arc;

/// `Σ_i (1 − x_{2i})² + 100 (x_{2i+1} − x_{2i}²)²`, coupled along the chain by `½ c (x_{2i+1} − x_{2i+2})²`.
pub struct Rosenbrock {
    pub pattern: Arc<BlockPattern>,
    coupling: f64,
}

impl Rosenbrock {
    pub fn new(blocks: usize, coupling: f64) -> Self {
        let pattern =
            BlockPattern::from_adjacency(blocks, (1..blocks).map(|i| (i - 1, i))).unwrap();
        Self {
            pattern: Arc::new(pattern),
            coupling,
        }
    }
}

impl NonlinearProblem<2> for Rosenbrock {
    fn blocks(&self) -> usize {
        self.pattern.blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let own: f64 = x
            .chunks(2)
            .map(|p| (1.0 - p[0]).powi(2) + 100.0 * (p[1] - p[0] * p[0]).powi(2))
            .sum();
        let links: f64 = (1..self.blocks())
            .map(|i| (x[2 * i - 1] - x[2 * i]).powi(2))
            .sum();
        own + 0.5 * self.coupling * links
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        for (p, g) in x.chunks(2).zip(g.chunks_mut(2)) {
            let gap = p[1] - p[0] * p[0];
            g[0] = -2.0 * (1.0 - p[0]) - 400.0 * gap * p[0];
            g[1] = 200.0 * gap;
        }
        for i in 1..self.blocks() {
            let pull = self.coupling * (x[2 * i - 1] - x[2 * i]);
            g[2 * i - 1] += pull;
            g[2 * i] -= pull;
        }
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<2>) {
        let pattern = self.pattern.clone();
        out.values_mut().fill([[0.0; 2]; 2]);
        for i in 0..self.blocks() {
            let (a, b) = (x[2 * i], x[2 * i + 1]);
            let full = 2.0 - 400.0 * (b - a * a) + 800.0 * a * a;
            // Without the indefinite part: the Gauss-Newton matrix of the two squares.
            let h = if projection == HessianProjection::None {
                full
            } else {
                2.0 + 800.0 * a * a
            };
            out.values_mut()[pattern.diagonal(i)] = [[h, -400.0 * a], [-400.0 * a, 200.0]];
        }
        for i in 1..self.blocks() {
            let (d0, d1, off) = (
                pattern.diagonal(i - 1),
                pattern.diagonal(i),
                pattern.find(i, i - 1).unwrap(),
            );
            out.values_mut()[d0][1][1] += self.coupling;
            out.values_mut()[d1][0][0] += self.coupling;
            out.values_mut()[off][0][1] -= self.coupling;
        }
    }
}

impl Summed<2> for Rosenbrock {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut terms: Vec<Vec<f64>> = Vec::new();
        for p in x.chunks(2) {
            let (a, b) = (p[0], p[1]);
            terms.push(vec![-2.0, 2.0 * a, -400.0 * a * b, 400.0 * a * a * a]);
            terms.push(vec![200.0 * b, -200.0 * a * a]);
        }
        for i in 1..self.blocks() {
            let [before, after] = [2 * i - 1, 2 * i].map(|k| self.coupling * x[k]);
            terms[2 * i - 1].extend([before, -after]);
            terms[2 * i].extend([-before, after]);
        }
        terms
    }
}
