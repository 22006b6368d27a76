//! Flesh against flesh.

use super::geometry::{norm, sub};
use super::pair::Pair;
use super::search::Search;
use super::surface::Surface;
use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::evaluations::{StencilCost, StencilKind};
use crate::mesh::SimplexMesh;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

/// How surfaces of flesh push each other away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FleshContactParams {
    /// d̂: the gap below which surfaces push, meters; less where they are nearer at rest.
    pub activation: f64,
    /// The pressure where they just touch, pascals; four times that at a depth of d̂.
    pub pressure: f64,
    /// How deep a point may lie behind a surface to be pushed out, meters.
    pub depth: f64,
    /// How much nearer partners may come before pairs are looked for again, meters.
    pub margin: f64,
    /// Partners within so many edges of the surface are never pushed apart.
    pub neighbors: usize,
}

/// For a face: d̂ = 0.5 mm, 10 kPa, depth 4 mm, margin 2 mm, two edges.
impl Default for FleshContactParams {
    fn default() -> Self {
        Self {
            activation: 0.5e-3,
            pressure: 1e4,
            depth: 4e-3,
            margin: 2e-3,
            neighbors: 2,
        }
    }
}

/// Surfaces of the flesh that push each other away where they come near: lips, lids, folds.
///
/// E = Σ p̂ A ℓ/3 ((d̂ − g)/ℓ)³ w over pairs of a point and a triangle, and of two edges, with
/// g < d̂: p̂ is the pressure at touch, A an area at rest, g the gap along the normal of the triangle
/// (of both edges), negative behind it, and w a product of windows that fade a pair out beyond the
/// ends of its partners. d̂ is the pair's own: what was nearer at rest may be as near again, and
/// ℓ = max(d̂, a quarter of the activation). Twice continuously differentiable; zero at rest.
///
/// Its stencils are the pairs that are near, and change: [`solve_renewing`](crate::solve_renewing)
/// keeps them.
#[derive(Clone, Debug)]
pub struct FleshContact {
    search: Search,
    pairs: Vec<Pair>,
    /// Positions at which the pairs were found, and how far each node may move from there.
    found_at: Vec<[f64; 3]>,
    free_way: Vec<f64>,
}

impl FleshContact {
    /// `triangles` are faces of the mesh's [`boundary`](SimplexMesh::boundary), all or those of the
    /// parts that can touch, seen counter-clockwise from outside.
    ///
    /// # Errors
    /// When a node does not exist or a number is not positive.
    pub fn new(
        mesh: &SimplexMesh<3>,
        triangles: &[[u32; 3]],
        params: FleshContactParams,
    ) -> Result<Self, AssemblyError> {
        for (what, value) in [
            ("activation", params.activation),
            ("pressure", params.pressure),
            ("depth", params.depth),
            ("margin", params.margin),
        ] {
            if !(value > 0.0 && value < f64::INFINITY) {
                return Err(AssemblyError::UnusableContact { what, value });
            }
        }
        let surface = Surface::new(mesh, triangles, params.neighbors)?;
        let mut contact = Self {
            search: Search::new(surface, params),
            pairs: Vec::new(),
            found_at: mesh.nodes().to_vec(),
            free_way: Vec::new(),
        };
        contact.look(mesh.nodes());
        Ok(contact)
    }

    /// Number of pairs that are near.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// The deepest entry of a surface into another, meters; 0 where there is none. Only the pairs at
    /// hand are looked at.
    pub fn deepest(&self, positions: &[[f64; 3]]) -> f64 {
        let depth = |pair: &Pair| match pair.gap(positions) {
            (gap, weight) if weight > 0.5 => -gap,
            _ => 0.0,
        };
        self.pairs.iter().map(depth).fold(0.0, f64::max)
    }

    /// Finds pairs; true when there are others than before.
    fn look(&mut self, positions: &[[f64; 3]]) -> bool {
        let margin = self.search.params.margin;
        let found = self.search.pairs(positions, margin);
        let known = includes(&self.pairs, &found) && !self.leans_on_others(&found, positions);
        if !known {
            self.pairs = found;
        }
        self.found_at = positions.to_vec();
        self.free_way = vec![0.5 * margin; positions.len()];
        !known
    }

    /// Does a pair push that is none of those a fresh look has found? Which partners face each other
    /// is decided by a look, so that pairs outlive their reason.
    fn leans_on_others(&self, found: &[Pair], positions: &[[f64; 3]]) -> bool {
        let pushes = |pair: &&Pair| pair.energy(positions) > 0.0;
        self.pairs
            .iter()
            .filter(pushes)
            .any(|pair| !has(found, pair))
    }
}

/// Is every pair of `few`, sorted alike, in `many`?
fn includes(many: &[Pair], few: &[Pair]) -> bool {
    few.len() <= many.len() && few.iter().all(|pair| has(many, pair))
}

fn has(sorted: &[Pair], pair: &Pair) -> bool {
    let key = |p: &Pair| (p.kind, p.nodes);
    sorted.binary_search_by_key(&key(pair), key).is_ok()
}

impl Term<3> for FleshContact {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.pairs.iter().map(|p| p.nodes.map(|n| n as usize)))
    }
    fn cost(&self) -> StencilCost {
        StencilCost {
            kind: StencilKind::Contact,
            ..StencilCost::default()
        }
    }
    fn energy(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            sink.energy(s, self.pairs[s].energy(at.positions()));
        }
    }
    fn gradient(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        for s in stencils {
            if let Some((energy, gradient)) = self.pairs[s].gradient(at.positions()) {
                sink.energy(s, energy);
                for (vertex, g) in gradient.into_iter().enumerate() {
                    sink.add(s, vertex, g);
                }
            }
        }
    }
    fn hessian(
        &self,
        at: Configuration<3>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<3>,
    ) {
        for s in stencils {
            let Some(hessian) = self.pairs[s].hessian(at.positions(), projection) else {
                continue;
            };
            for a in 0..4 {
                for b in 0..=a {
                    let entry = |i: usize, j: usize| hessian[3 * a + i][3 * b + j];
                    let block = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
                    sink.add(s, a, b, block);
                }
            }
        }
    }
    fn changes(&self) -> bool {
        true
    }
    fn renew(&mut self, at: Configuration<3>) -> bool {
        let near = self.search.pairs(at.positions(), 0.0);
        let moved = |&n: &u32| {
            let n = n as usize;
            2.0 * norm(sub(at.positions()[n], self.found_at[n])) > self.free_way[n]
        };
        let settled = includes(&self.pairs, &near) && !self.leans_on_others(&near, at.positions());
        if settled && !self.search.surface.points.iter().any(moved) {
            return false;
        }
        self.look(at.positions())
    }
    /// No node may leave the ball in which everything near it was found.
    fn covered_step(&self, at: Configuration<3>, displacement: &[[f64; 3]]) -> f64 {
        let of = |&n: &u32| {
            let n = n as usize;
            let (from, d) = (sub(at.positions()[n], self.found_at[n]), displacement[n]);
            leaves_ball(from, d, self.free_way[n])
        };
        let points = self.search.surface.points.iter();
        points.map(of).fold(f64::INFINITY, f64::min)
    }
}

/// The t ≥ 0 at which from + t d has the given length; 0 when it is outside.
fn leaves_ball(from: [f64; 3], d: [f64; 3], radius: f64) -> f64 {
    let dot = super::geometry::dot;
    let (a, b, c) = (dot(d, d), dot(from, d), dot(from, from) - radius * radius);
    if !(c < 0.0) {
        return 0.0;
    }
    if a > 0.0 {
        -c / (b + (b * b - a * c).sqrt())
    } else {
        f64::INFINITY
    }
}
