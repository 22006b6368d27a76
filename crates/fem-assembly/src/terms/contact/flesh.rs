//! Flesh against flesh.

use super::carrier::{Carrier, Spread};
use super::geometry::Point;
use super::pair::Pair;
use super::params::FleshContactParams;
use super::search::{Search, Stay, has, key};
use super::surface::Surface;
use super::way::Way;
use crate::active::felt;
use crate::configuration::{Configuration, Positions};
use crate::error::{AssemblyError, check_length};
use crate::evaluations::{StencilCost, StencilKind};
use crate::mesh::{EmbeddedPoint, SimplexMesh};
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

/// The longest way along which pairs are looked for, in margins.
const LONGEST: f64 = 8.0;

/// From how many disputes on a pair is kept, or held.
const KEPT_FROM: usize = 3;
const HELD_FROM: usize = 8;

/// When pairs are looked for.
#[derive(Clone, Copy, PartialEq)]
enum Occasion {
    /// Anywhere: those that are found stay.
    Place,
    /// Where a step is to begin, which finds what is near here too.
    Step,
    /// The same where those that push stay as well, so that the energy there stays as it is.
    LateStep,
    /// Where an equilibrium was found: pairs that come or go with a push are disputed.
    Equilibrium,
}

/// Surfaces of the flesh that push each other away where they come near: lips, lids, folds.
///
/// E = Σ p̂ A ℓ e((d̂ − g)/ℓ) w over pairs of a point and a triangle, and of two edges
/// ([`FleshContactParams::edges`]), with
/// g < d̂: e(x) is x³/3 up to x = 2 and bends from there into a line, so that the pressure is that of x² and
/// 12 p̂ from x = 6 on; p̂ is the pressure at touch, A an area at rest, g the gap along the normal of the triangle
/// (of both edges), negative behind it, and w a product of windows that fade a pair out beyond the
/// ends of its partners. d̂ is the pair's own: what was nearer at rest may be as near again, and
/// ℓ = max(d̂, a quarter of the activation). Twice continuously differentiable; zero at rest.
///
/// The vertices of the surface are nodes, or points that the mesh carries: the skin that is looked at
/// where the mesh is coarser. Each is moved by the nodes of its element, so a stencil is all nodes that
/// move the four vertices of a pair.
///
/// Its stencils are the pairs that are near, and change: [`solve_renewing`](crate::solve_renewing)
/// keeps them.
#[derive(Clone, Debug)]
pub struct FleshContact {
    search: Search,
    carrier: Carrier,
    /// Of the mesh.
    nodes: usize,
    pairs: Vec<Pair>,
    spreads: Vec<Spread>,
    /// The way of the vertices along which the pairs were found.
    found: Way,
    /// Where the pairs were last seen to be all that is near, and all that pushes: a derivative asks again
    /// where its equilibrium was found.
    settled: Option<Vec<Point>>,
    /// Must the next look know no earlier pairs?
    forgets: bool,
    /// How often pairs came or went with a push at an equilibrium, since they last settled; sorted, as
    /// the next two.
    disputes: Vec<(Pair, usize)>,
    /// Pairs that looks disagree about. Two equilibria, one with the pair and one without, would call
    /// for each other without end: it stays until it clearly faces away.
    kept: Vec<Pair>,
    /// Those that even so come and go: they stay as long as they are near.
    held: Vec<Pair>,
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
        Self::carried_by(mesh, Carrier::Nodes, triangles, params)
    }

    /// `triangles` join `points`, seen counter-clockwise from outside; points without a triangle are
    /// no matter.
    ///
    /// # Errors
    /// When a point or a node does not exist or a number is not positive.
    pub fn carried(
        mesh: &SimplexMesh<3>,
        points: &[EmbeddedPoint],
        triangles: &[[u32; 3]],
        params: FleshContactParams,
    ) -> Result<Self, AssemblyError> {
        let count = mesh.num_nodes();
        let mut nodes = points.iter().flat_map(|p| p.nodes).map(|n| n as usize);
        if let Some(node) = nodes.find(|&n| n >= count) {
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        let known = points.len();
        let mut named = triangles.as_flattened().iter();
        if let Some(&node) = named.find(|&&p| p as usize >= known) {
            let node = node as usize;
            return Err(AssemblyError::NoSuchNode { node, count: known });
        }
        let (points, triangles) = of_triangles(points, triangles);
        Self::carried_by(mesh, Carrier::Points(points), &triangles, params)
    }

    fn carried_by(
        mesh: &SimplexMesh<3>,
        carrier: Carrier,
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
        let surface = Surface::new(mesh, &carrier, triangles, params.neighbors)?;
        let mut contact = Self {
            search: Search::new(surface, params),
            carrier,
            nodes: mesh.num_nodes(),
            pairs: Vec::new(),
            spreads: Vec::new(),
            found: Way::at(Vec::new()),
            settled: None,
            forgets: false,
            disputes: Vec::new(),
            kept: Vec::new(),
            held: Vec::new(),
        };
        let rest = contact.carrier.positions(mesh.nodes()).into_owned();
        contact.look(Way::at(rest), Occasion::Place);
        Ok(contact)
    }

    /// Number of pairs that are near.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// The deepest entry of a surface into another, meters; 0 where there is none. Only the pairs at
    /// hand are looked at.
    ///
    /// # Errors
    /// When there is not one position for each node.
    pub fn deepest(&self, positions: &[[f64; 3]]) -> Result<f64, AssemblyError> {
        check_length("positions", positions.len(), self.nodes)?;
        let depth = |pair: &Pair| match pair.gap(self.at(pair, positions)) {
            (gap, weight) if weight > 0.5 => -gap,
            _ => 0.0,
        };
        Ok(self.pairs.iter().map(depth).fold(0.0, f64::max))
    }

    fn points(&self) -> &[u32] {
        &self.search.surface.points
    }

    /// How far a vertex may be from the way along which pairs were found.
    fn free_way(&self) -> f64 {
        0.5 * self.search.params.margin
    }

    /// The vertices of a pair.
    fn at(&self, pair: &Pair, positions: &[Point]) -> [Point; 4] {
        pair.vertices.map(|v| self.carrier.position(v, positions))
    }

    fn way(&self, at: Configuration<3>, displacement: &[[f64; 3]]) -> Way {
        let from = self.carrier.positions(at.positions()).into_owned();
        let step = self.carrier.positions(displacement);
        let longest = LONGEST * self.search.params.margin;
        Way::along(from, &step, self.points(), longest)
    }

    /// Finds pairs; true when there are others than before.
    fn look(&mut self, way: Way, occasion: Occasion) -> bool {
        let margin = self.search.params.margin;
        if std::mem::take(&mut self.forgets) {
            self.disputes.clear();
            self.kept.clear();
            self.held.clear();
            let found = self.search.pairs(&way, margin, Stay::default());
            let others = found != self.pairs;
            self.set(found, way);
            return others;
        }
        let mut found = self.found_near(&way, margin);
        let others = self.others_that_push(&found, &way.from);
        let late = occasion == Occasion::LateStep;
        let known = includes(&self.pairs, &found) && (late || others.is_empty());
        if !known {
            if occasion == Occasion::Equilibrium {
                self.dispute(self.newcomers_that_push(&found, &way.from));
                self.dispute(others);
            } else if late {
                insert(&mut found, others);
            }
            self.set(found, way);
        } else {
            self.found = way;
        }
        !known
    }

    fn renewed(&mut self, at: Configuration<3>, occasion: Occasion) -> bool {
        let here = Way::at(self.carrier.positions(at.positions()).into_owned());
        if self.forgets {
            return self.look(here, occasion);
        }
        !self.is_settled(&here) && self.look(here, occasion)
    }

    /// Does what was found hold all that is near here, with room to move, and nothing else that pushes?
    fn is_settled(&mut self, here: &Way) -> bool {
        let room = 0.5 * self.free_way();
        if !self.found.holds(&here.from, self.points(), room) {
            return false;
        }
        if self.settled.as_ref() == Some(&here.from) {
            return true;
        }
        let near = self.found_near(here, 0.0);
        let settled =
            includes(&self.pairs, &near) && self.others_that_push(&near, &here.from).is_empty();
        self.settled = settled.then(|| here.from.clone());
        settled
    }

    fn found_near(&mut self, way: &Way, margin: f64) -> Vec<Pair> {
        let stay = Stay {
            kept: &self.kept,
            held: &self.held,
        };
        self.search.pairs(way, margin, stay)
    }

    fn set(&mut self, pairs: Vec<Pair>, way: Way) {
        let spread = |pair: &Pair| self.carrier.spread(pair.vertices);
        self.spreads = pairs.iter().map(spread).collect();
        self.settled = None;
        self.pairs = pairs;
        self.found = way;
    }

    /// Takes note of pairs that come or go with a push.
    fn dispute(&mut self, pairs: Vec<Pair>) {
        for pair in pairs {
            let place = self
                .disputes
                .binary_search_by_key(&key(&pair), |(p, _)| key(p));
            let place = place.unwrap_or_else(|place| {
                self.disputes.insert(place, (pair, 0));
                place
            });
            let times = &mut self.disputes[place].1;
            *times += 1;
            match *times {
                KEPT_FROM => insert(&mut self.kept, vec![pair]),
                HELD_FROM => insert(&mut self.held, vec![pair]),
                _ => {}
            }
        }
    }

    /// Pairs that were not there before and begin with a push.
    fn newcomers_that_push(&self, found: &[Pair], vertices: &[Point]) -> Vec<Pair> {
        let pushes = |pair: &Pair| pair.energy(pair.vertices.map(|v| vertices[v as usize])) > 0.0;
        let new = found.iter().filter(|pair| !has(&self.pairs, pair));
        new.filter(|pair| pushes(pair)).copied().collect()
    }

    /// Pairs that push and are none of those a fresh look has found. Which partners face each other is
    /// decided by a look, so that pairs outlive their reason.
    fn others_that_push(&self, found: &[Pair], vertices: &[Point]) -> Vec<Pair> {
        let at = |pair: &Pair| pair.vertices.map(|v| vertices[v as usize]);
        let pushes = |pair: &&Pair| pair.energy(at(pair)) > 0.0;
        let pushing = self.pairs.iter().filter(pushes);
        pushing.filter(|pair| !has(found, pair)).copied().collect()
    }
}

/// The points that have a triangle, in their order, and the triangles in their numbers.
fn of_triangles(
    points: &[EmbeddedPoint],
    triangles: &[[u32; 3]],
) -> (Vec<EmbeddedPoint>, Vec<[u32; 3]>) {
    let mut used = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let mut number = vec![0; points.len()];
    for (new, &old) in (0..).zip(&used) {
        number[old as usize] = new;
    }
    let corner = |p: u32| number[p as usize];
    (
        used.iter().map(|&p| points[p as usize]).collect(),
        triangles.iter().map(|t| t.map(corner)).collect(),
    )
}

/// Is every pair of `few`, sorted alike, in `many`?
fn includes(many: &[Pair], few: &[Pair]) -> bool {
    few.len() <= many.len() && few.iter().all(|pair| has(many, pair))
}

/// Puts pairs into a sorted list that may have some of them.
fn insert(sorted: &mut Vec<Pair>, pairs: Vec<Pair>) {
    if !pairs.is_empty() {
        sorted.extend(pairs);
        sorted.sort_unstable_by_key(key);
        sorted.dedup_by_key(|pair| key(pair));
    }
}

impl Term<3> for FleshContact {
    fn stencils(&self) -> Stencils {
        Stencils::of_sizes(self.spreads.iter().map(|s| s.nodes.as_slice()))
    }
    fn nodes(&self) -> usize {
        self.nodes
    }
    fn cost(&self) -> StencilCost {
        StencilCost {
            kind: StencilKind::Contact,
            ..StencilCost::default()
        }
    }
    fn energy(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            let pair = &self.pairs[s];
            sink.energy(s, pair.energy(self.at(pair, at.positions())));
        }
    }
    fn gradient(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        for s in stencils {
            let (pair, spread) = (&self.pairs[s], &self.spreads[s]);
            if let Some((energy, gradient)) = pair.gradient(self.at(pair, at.positions())) {
                sink.energy(s, energy);
                for node in 0..spread.nodes.len() {
                    sink.add(s, node, spread.gradient(node, &gradient));
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
            let (pair, spread) = (&self.pairs[s], &self.spreads[s]);
            let Some(hessian) = pair.hessian(self.at(pair, at.positions()), projection) else {
                continue;
            };
            for a in 0..spread.nodes.len() {
                let rows = spread.rows(a, &hessian);
                for b in 0..=a {
                    sink.add(s, a, b, spread.block(b, &rows));
                }
            }
        }
    }
    /// Most pairs are only near.
    fn active(&self, at: Positions<3>) -> Option<Vec<usize>> {
        let vertices = self.carrier.positions(at.as_slice());
        let speaks = |stencil: usize| {
            let pair = &self.pairs[stencil];
            !pair.is_silent(pair.vertices.map(|v| vertices[v as usize]))
        };
        Some(felt(self.pairs.len(), speaks))
    }
    fn changes(&self) -> bool {
        true
    }
    fn deepest_contact(&self, positions: &[[f64; 3]]) -> Option<f64> {
        self.deepest(positions).ok()
    }
    fn forget(&mut self) {
        self.forgets = true;
    }
    fn renew(&mut self, at: Configuration<3>) -> bool {
        self.renewed(at, Occasion::Place)
    }
    fn renew_at_equilibrium(&mut self, at: Configuration<3>) -> bool {
        let changed = self.renewed(at, Occasion::Equilibrium);
        if !changed {
            self.disputes.clear();
        }
        changed
    }
    fn renew_along(&mut self, at: Configuration<3>, displacement: &[[f64; 3]]) -> bool {
        let way = self.way(at, displacement);
        self.look(way, Occasion::LateStep)
    }
    fn renew_for_step(&mut self, at: Configuration<3>, displacement: &[[f64; 3]]) -> bool {
        let way = self.way(at, displacement);
        self.look(way, Occasion::Step)
    }
    /// No vertex may leave the tube in which everything near it was found.
    fn covered_step(&self, at: Configuration<3>, displacement: &[[f64; 3]]) -> f64 {
        let from = self.carrier.positions(at.positions());
        let step = self.carrier.positions(displacement);
        self.found
            .left_after(&from, &step, self.points(), self.free_way())
    }
    fn one_sided(&self) -> bool {
        true
    }
}
