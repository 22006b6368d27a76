//! What a surface that may touch itself is made of.

use super::geometry::Point;
use super::pair::shapes_of;
use crate::mesh::EmbeddedPoint;
use std::borrow::Cow;

/// The vertices of a surface: nodes of the mesh, or points that ride on it.
#[derive(Clone, Debug)]
pub(crate) enum Carrier {
    Nodes,
    Points(Vec<EmbeddedPoint>),
}

/// The nodes that move the vertices of a pair, and by how much each moves the three shapes that the four
/// have beside their translation ([`shapes_of`]).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spread {
    pub nodes: Vec<usize>,
    pub shares: Vec<[f64; 3]>,
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
            self.shares.push([0.0; 3]);
            self.nodes.len() - 1
        });
        let mut moved = [0.0; 4];
        moved[vertex] = weight;
        for (share, by) in self.shares[place].iter_mut().zip(shapes_of(&moved)) {
            *share += by;
        }
    }

    /// Σ shares × gradient by shapes.
    pub fn gradient(&self, k: usize, by_shape: &[Point; 3]) -> Point {
        let share = self.shares[k];
        std::array::from_fn(|i| (0..3).map(|s| share[s] * by_shape[s][i]).sum())
    }

    /// Σ shares of a × the rows of a Hessian by shapes.
    pub fn rows(&self, a: usize, by_shape: &[[f64; 9]; 9]) -> [[f64; 9]; 3] {
        let [p, q, r] = self.shares[a];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                p * by_shape[i][j] + q * by_shape[3 + i][j] + r * by_shape[6 + i][j]
            })
        })
    }

    /// Σ shares of b × the columns of [`Spread::rows`] of a: their block.
    pub fn block(&self, b: usize, rows: &[[f64; 9]; 3]) -> [[f64; 3]; 3] {
        let [p, q, r] = self.shares[b];
        rows.map(|row| std::array::from_fn(|j| p * row[j] + q * row[3 + j] + r * row[6 + j]))
    }
}
