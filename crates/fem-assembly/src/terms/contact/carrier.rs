//! What a surface that may touch itself is made of.

use super::geometry::Point;
use crate::mesh::EmbeddedPoint;
use std::borrow::Cow;

/// The vertices of a surface: nodes of the mesh, or points that ride on it.
#[derive(Clone, Debug)]
pub(crate) enum Carrier {
    Nodes,
    Points(Vec<EmbeddedPoint>),
}

/// The nodes that move the vertices of a pair, and by how much each moves each of the four.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spread {
    pub nodes: Vec<usize>,
    pub shares: Vec<[f64; 4]>,
}

impl Carrier {
    /// Where a vertex is when the nodes are at `x`; of displacements, its displacement.
    pub fn position(&self, vertex: u32, x: &[Point]) -> Point {
        match self {
            Self::Nodes => x[vertex as usize],
            Self::Points(points) => points[vertex as usize].position(x),
        }
    }

    /// All vertices.
    pub fn positions<'a>(&self, x: &'a [Point]) -> Cow<'a, [Point]> {
        match self {
            Self::Nodes => Cow::Borrowed(x),
            Self::Points(points) => Cow::Owned(points.iter().map(|p| p.position(x)).collect()),
        }
    }

    pub fn spread(&self, vertices: [u32; 4]) -> Spread {
        let mut spread = Spread {
            nodes: Vec::new(),
            shares: Vec::new(),
        };
        for (vertex, &index) in vertices.iter().enumerate() {
            match self {
                Self::Nodes => spread.add(index, vertex, 1.0),
                Self::Points(points) => {
                    let EmbeddedPoint { nodes, weights } = points[index as usize];
                    for (node, weight) in nodes.into_iter().zip(weights) {
                        spread.add(node, vertex, weight);
                    }
                }
            }
        }
        spread
    }
}

impl Spread {
    fn add(&mut self, node: u32, vertex: usize, weight: f64) {
        let node = node as usize;
        if weight == 0.0 {
            return;
        }
        let known = self.nodes.iter().position(|&n| n == node);
        let place = known.unwrap_or_else(|| {
            self.nodes.push(node);
            self.shares.push([0.0; 4]);
            self.nodes.len() - 1
        });
        self.shares[place][vertex] += weight;
    }

    /// Σ shares × gradient at the vertices.
    pub fn gradient(&self, k: usize, at_vertices: &[Point; 4]) -> Point {
        let share = self.shares[k];
        std::array::from_fn(|i| (0..4).map(|a| share[a] * at_vertices[a][i]).sum())
    }

    /// Σ shares of a × shares of b × the blocks between vertices.
    pub fn block(&self, [a, b]: [usize; 2], at_vertices: &[[f64; 12]; 12]) -> [[f64; 3]; 3] {
        let mut block = [[0.0; 3]; 3];
        for (v, of_a) in self.shares[a].into_iter().enumerate() {
            for (w, of_b) in self.shares[b].into_iter().enumerate() {
                let share = of_a * of_b;
                if share == 0.0 {
                    continue;
                }
                for i in 0..3 {
                    for j in 0..3 {
                        block[i][j] += share * at_vertices[3 * v + i][3 * w + j];
                    }
                }
            }
        }
        block
    }
}
