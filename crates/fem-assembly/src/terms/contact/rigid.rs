//! Flesh against rigid solids: teeth, bones, eyeballs.

use super::distance::{Jet, SampledDistance};
use super::frame::{Placed, RigidFrame};
use super::geometry::{add, dot, norm, scale, sub};
use super::points::ContactPoint;
use crate::active::felt;
use crate::configuration::{Configuration, Positions};
use crate::direction::UNIT_TOLERANCE;
use crate::error::{AssemblyError, check_length};
use crate::evaluations::{StencilCost, StencilKind};
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::{ImplicitSurface, Mat, UnusableSurface};
use fem_materials::HessianProjection;
use std::ops::Range;
use std::sync::Arc;

/// Looks at the distance along one step.
const MOST_ADVANCES: usize = 200;

/// What flesh may not enter, in its place at rest.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RigidSurface {
    /// A sphere, capsule, box or half-space.
    Implicit(ImplicitSurface<3>),
    /// A surface of triangles.
    Sampled(Arc<SampledDistance>),
}

/// How hard a rigid solid pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidContactParams {
    /// d̂: the gap below which it pushes, meters; less where flesh is nearer at rest.
    pub activation: f64,
    /// The pressure at touch, pascals, and four times that at a depth of d̂, for flesh that has d̂ of room at
    /// rest. With less room it grows with depth as much faster, up to three times: flesh that touches at
    /// rest feels this pressure d̂/3 deeper.
    pub pressure: f64,
    /// How much deeper than at rest a point may be, meters: beyond it the energy is +∞, so that no
    /// step leads through a thin solid. ∞ for starts from deep inside; a point that starts past the
    /// middle of a solid then stays on the far side, for a distance knows no way back: start before
    /// the solid and walk ([`crate::solve_walking`]).
    pub depth: f64,
}

impl RigidContactParams {
    fn check(&self) -> Result<(), AssemblyError> {
        let finite = |value: f64| value > 0.0 && value < f64::INFINITY;
        for (what, value, usable) in [
            ("activation", self.activation, finite(self.activation)),
            ("pressure", self.pressure, finite(self.pressure)),
            ("depth", self.depth, self.depth > 0.0),
        ] {
            if !usable {
                return Err(AssemblyError::UnusableContact { what, value });
            }
        }
        Ok(())
    }
}

/// For a face: d̂ = 0.5 mm, 100 kPa, depth 1.5 mm.
impl Default for RigidContactParams {
    fn default() -> Self {
        Self {
            activation: 0.5e-3,
            pressure: 1e5,
            depth: 1.5e-3,
        }
    }
}

/// Rigid solids, fixed or moved with one bone, that push points of the flesh out.
///
/// E = Σ p̂ A ℓ/3 ((d − g)/ℓ)³ over solids and points with a gap g = φ(X) < d, where X is where the point would
/// be at rest if it moved with the bone ([`RigidFrame`]), d = min(d̂, g at rest) and ℓ = max(d, d̂/3): nothing
/// pushes at rest, not even where flesh lies inside the solid (g < 0) there, and what has d̂/3 of room
/// or more is pushed with p̂ at touch. Twice continuously differentiable where φ is. The bone's nodes are part of the stencils, so a motion of the bone acts
/// on the flesh through them, and derivatives by it need nothing else.
///
/// A projection acts on what couples the flesh and leaves out what couples it with the bone's nodes.
#[derive(Clone, Debug)]
pub struct RigidContact {
    surfaces: Vec<RigidSurface>,
    frame: Option<RigidFrame>,
    points: Vec<ContactPoint>,
    /// Of the mesh.
    nodes: usize,
    /// Of each point.
    clear: Vec<Clear>,
    /// Of each point and each solid.
    nearness: Vec<Nearness>,
    params: RigidContactParams,
}

/// Where a point of the flesh is at rest, and how far around no solid can push it, meters.
#[derive(Clone, Copy, Debug)]
struct Clear {
    center: [f64; 3],
    radius: f64,
}

/// A solid as a point of the flesh knows it, meters.
#[derive(Clone, Copy, Debug)]
struct Nearness {
    /// d.
    distance: f64,
    /// ℓ.
    length: f64,
    /// How far around its place at rest the solid cannot push the point.
    clear: f64,
}

/// The least length over which the pressure grows, in d̂.
const SHORTEST: f64 = 1.0 / 3.0;
/// Room for rounding in what is clear.
const CLEARLY: f64 = 1.0 - 1e-9;

/// Does a way of this length that starts `off` the center stay within the radius? Not from NaN.
#[inline]
fn within(radius: f64, off: [f64; 3], way: f64) -> bool {
    let left = radius - way;
    left > 0.0 && dot(off, off) < left * left
}

impl RigidSurface {
    fn check(&self) -> Result<(), AssemblyError> {
        let Self::Implicit(surface) = self else {
            return Ok(());
        };
        let unusable =
            |UnusableSurface { what, value, .. }| AssemblyError::UnusableContact { what, value };
        surface.check(UNIT_TOLERANCE).map_err(unusable)
    }
    /// How far from x at least nothing has φ < d, meters.
    fn clear_way(&self, x: [f64; 3], d: f64) -> f64 {
        match self {
            // |∇φ| = 1.
            Self::Implicit(surface) => surface.distance(&x) - d,
            Self::Sampled(sampled) => sampled.clear_way(x, d),
        }
    }
    fn distance(&self, x: [f64; 3]) -> f64 {
        match self {
            Self::Implicit(surface) => surface.distance(&x),
            Self::Sampled(_) if x.iter().any(|c| c.is_nan()) => f64::NAN,
            Self::Sampled(sampled) => sampled.value(x).unwrap_or(f64::INFINITY),
        }
    }
    fn jet(&self, x: [f64; 3]) -> Option<Jet> {
        match self {
            Self::Implicit(surface) => Some(Jet {
                value: surface.distance(&x),
                gradient: surface.normal(&x),
                hessian: surface.curvature(&x),
            }),
            Self::Sampled(sampled) => sampled.jet(x),
        }
    }
}

/// What one point feels.
struct Pressed {
    energy: f64,
    /// ψ'(φ), newtons.
    slope: f64,
    /// ψ''(φ), N/m.
    stiffness: f64,
    jet: Jet,
    /// −bₖ of the bone's nodes.
    bone: [f64; 4],
}

impl RigidContact {
    /// The solids move with `frame`, or not at all. Points that come with the solids at rest are no
    /// matter; those of `points` that can never reach one cost a look at their place each.
    ///
    /// # Errors
    /// When a number is not positive or not finite, a solid makes no sense, or a node of a point or of the
    /// frame does not exist.
    /// An element of a point that holds a node of the frame is refused where the term is added.
    pub fn new(
        surfaces: Vec<RigidSurface>,
        frame: Option<RigidFrame>,
        points: Vec<ContactPoint>,
        rest: &[[f64; 3]],
        params: RigidContactParams,
    ) -> Result<Self, AssemblyError> {
        params.check()?;
        for surface in &surfaces {
            surface.check()?;
        }
        let count = rest.len();
        let of_frame = frame.iter().flat_map(RigidFrame::nodes);
        let mut named = points.iter().flat_map(ContactPoint::nodes).chain(of_frame);
        if let Some(node) = named.find(|&n| n >= count) {
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        let (mut clear, mut nearness) = (Vec::new(), Vec::new());
        for point in &points {
            let center = point.position(rest);
            let of = |surface: &RigidSurface| {
                let distance = params.activation.min(surface.distance(center));
                let clear = CLEARLY * surface.clear_way(center, distance);
                let length = distance.max(SHORTEST * params.activation);
                Nearness {
                    distance,
                    length,
                    clear,
                }
            };
            let first = nearness.len();
            nearness.extend(surfaces.iter().map(of));
            let radii = nearness[first..].iter().map(|near| near.clear);
            let radius = radii.fold(f64::INFINITY, f64::min);
            clear.push(Clear { center, radius });
        }
        Ok(Self {
            surfaces,
            frame,
            points,
            nodes: count,
            clear,
            nearness,
            params,
        })
    }

    /// How much deeper points are in a solid than at rest, at most; meters, 0 where none is.
    ///
    /// # Errors
    /// When there is not one position for each node.
    pub fn deepest(&self, positions: &[[f64; 3]]) -> Result<f64, AssemblyError> {
        check_length("positions", positions.len(), self.nodes)?;
        let placed = self.placed(positions);
        let depth = |(s, p): (usize, &ContactPoint)| {
            let x = placed.at_rest(p.position(positions));
            let solids = self.surfaces.iter().zip(self.nearness_of(s));
            let deep = solids.map(|(surface, near)| near.distance.min(0.0) - surface.distance(x));
            deep.fold(0.0, f64::max)
        };
        let depths = self.points.iter().enumerate().map(depth);
        Ok(depths.fold(0.0, f64::max))
    }

    fn placed(&self, positions: &[[f64; 3]]) -> Placed {
        self.frame
            .map_or(Placed::FIXED, |frame| frame.placed(positions))
    }

    fn nearness_of(&self, s: usize) -> &[Nearness] {
        let solids = self.surfaces.len();
        &self.nearness[s * solids..(s + 1) * solids]
    }

    /// The solids that a point may leave its clear surroundings of on a way from x (at rest).
    fn reachable(
        &self,
        s: usize,
        x: [f64; 3],
        way: f64,
    ) -> impl Iterator<Item = (&RigidSurface, &Nearness)> {
        let Clear { center, radius } = self.clear[s];
        let off = sub(x, center);
        let solids = if within(radius, off, way) {
            0
        } else {
            self.surfaces.len()
        };
        let all = self.surfaces.iter().zip(self.nearness_of(s)).take(solids);
        all.filter(move |(_, near)| !within(near.clear, off, way))
    }

    /// The solids that a point whose place at rest would be x feels, with (d − g)/ℓ; NaN is felt.
    fn felt(&self, s: usize, x: [f64; 3]) -> impl Iterator<Item = (&RigidSurface, &Nearness, f64)> {
        self.reachable(s, x, 0.0)
            .filter_map(move |(surface, near)| {
                let lack = (near.distance - surface.distance(x)) / near.length;
                (!(lack <= 0.0)).then_some((surface, near, lack))
            })
    }

    /// The gap below which nothing may come.
    fn least_gap(&self, near: &Nearness) -> f64 {
        near.distance.min(0.0) - self.params.depth
    }

    fn energy_of(&self, s: usize, near: &Nearness, lack: f64) -> f64 {
        if near.distance - near.length * lack < self.least_gap(near) {
            return f64::INFINITY;
        }
        self.params.pressure * self.points[s].area * near.length / 3.0 * lack * lack * lack
    }

    /// The t up to which a point that starts at x (at rest) and moves by `way` does not come too deep;
    /// ∞ where that is after t = 1. φ changes by no more than the way, so steps of the room that is
    /// left never jump over a solid (conservative advancement; Mirtich 1996), but one thinner than the
    /// shortest step, a hundredth of the depth. 0 for a point that is too deep already.
    fn reaches(&self, surface: &RigidSurface, x: [f64; 3], way: [f64; 3], least: f64) -> f64 {
        let length = norm(way);
        let shortest = 0.01 * self.params.depth;
        let (mut t, mut before) = (0.0, 0.0);
        for _ in 0..MOST_ADVANCES {
            let gap = surface.distance(add(x, scale(way, t)));
            // Nothing is known farther away than what is sampled, but that it is not near.
            let room = if gap == f64::INFINITY {
                self.params.activation
            } else {
                gap - least
            };
            if !(room > 0.0) {
                // The energy tells how much of the first advance is too much.
                return if before > 0.0 { before } else { 0.5 * t };
            }
            before = t;
            // A point near its limit may slide along it or leave it.
            t += (0.9 * room).max(shortest) / length;
            if t >= 1.0 {
                return f64::INFINITY;
            }
        }
        t
    }

    /// What a point feels of each solid, and its place at rest.
    fn pressed<'a>(
        &'a self,
        placed: &'a Placed,
        positions: &[[f64; 3]],
        s: usize,
    ) -> impl Iterator<Item = Pressed> + 'a {
        let x = placed.at_rest(self.points[s].position(positions));
        let force = self.params.pressure * self.points[s].area;
        self.felt(s, x).filter_map(move |(surface, near, lack)| {
            Some(Pressed {
                energy: self.energy_of(s, near, lack),
                slope: -force * lack * lack,
                stiffness: 2.0 * force * lack / near.length,
                jet: surface.jet(x)?,
                bone: placed.barycentric(x).map(|b| -b),
            })
        })
    }

    fn vertices(&self) -> usize {
        if self.frame.is_some() { 8 } else { 4 }
    }

    /// How much vertex k of a stencil moves its point against the bone.
    fn share(&self, s: usize, pressed: &Pressed, k: usize) -> f64 {
        if k < 4 {
            self.points[s].point.weights[k]
        } else {
            pressed.bone[k - 4]
        }
    }
}

impl Term<3> for RigidContact {
    fn stencils(&self) -> Stencils {
        let own = self.points.iter().map(ContactPoint::nodes);
        match self.frame {
            None => Stencils::new(own),
            Some(frame) => Stencils::new(own.map(|[a, b, c, d]| {
                let [e, f, g, h] = frame.nodes();
                [a, b, c, d, e, f, g, h]
            })),
        }
    }
    fn cost(&self) -> StencilCost {
        StencilCost {
            kind: StencilKind::Contact,
            ..StencilCost::default()
        }
    }
    /// Most points are far from every solid.
    fn active(&self, at: Positions<3>) -> Option<Vec<usize>> {
        let placed = self.placed(at.as_slice());
        let speaks = |s: usize| {
            let x = placed.at_rest(self.points[s].position(at.as_slice()));
            self.felt(s, x).next().is_some()
        };
        Some(felt(self.points.len(), speaks))
    }
    fn energy(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut EnergySink) {
        let placed = self.placed(at.positions());
        for s in stencils {
            let x = placed.at_rest(self.points[s].position(at.positions()));
            let felt = self.felt(s, x);
            sink.energy(
                s,
                felt.map(|(_, near, lack)| self.energy_of(s, near, lack))
                    .sum(),
            );
        }
    }
    fn gradient(&self, at: Configuration<3>, stencils: Range<usize>, sink: &mut GradientSink<3>) {
        let placed = self.placed(at.positions());
        for s in stencils {
            let mut energy = 0.0;
            for pressed in self.pressed(&placed, at.positions(), s) {
                energy += pressed.energy;
                let pull = placed
                    .inverse
                    .tr_mul_vec(pressed.jet.gradient)
                    .map(|g| pressed.slope * g);
                for k in 0..self.vertices() {
                    let share = self.share(s, &pressed, k);
                    sink.add(s, k, pull.map(|f| share * f));
                }
            }
            if energy != 0.0 {
                sink.energy(s, energy);
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
        let placed = self.placed(at.positions());
        let gradients = placed.moved_gradients();
        let pressed = |s| {
            self.pressed(&placed, at.positions(), s)
                .map(move |t| (s, t))
        };
        for (s, pressed) in stencils.flat_map(pressed) {
            let normal = placed.inverse.tr_mul_vec(pressed.jet.gradient);
            let bent = pressed.jet.hessian * placed.inverse;
            let curved = placed.inverse.tr_mul(&bent).scale(pressed.slope);
            let own = Mat::outer(normal, normal).scale(pressed.stiffness) + curved;
            let own = projection.matrix(&own);
            // ∂²X = −M⁻¹ (∂M ∂X + ∂M ∂X): the bone's nodes turn what a motion means.
            let pull = normal.map(|n| pressed.slope * n);
            let turned = |k: usize| (k >= 4).then(|| Mat::outer(pull, gradients[k - 4]));
            for a in 0..self.vertices() {
                for b in 0..=a {
                    let (of_a, of_b) = (self.share(s, &pressed, a), self.share(s, &pressed, b));
                    let mut block = own.scale(of_a * of_b);
                    if projection == HessianProjection::None {
                        if let Some(turned) = turned(a) {
                            block -= turned.scale(of_b);
                        }
                        if let Some(turned) = turned(b) {
                            block -= turned.transpose().scale(of_a);
                        }
                    }
                    sink.add(s, a, b, block.0);
                }
            }
        }
    }
    fn one_sided(&self) -> bool {
        true
    }
    fn deepest_contact(&self, positions: &[[f64; 3]]) -> Option<f64> {
        self.deepest(positions).ok()
    }
    fn largest_step(
        &self,
        at: Configuration<3>,
        displacement: &[[f64; 3]],
        stencils: Range<usize>,
    ) -> f64 {
        if self.params.depth == f64::INFINITY {
            return f64::INFINITY;
        }
        let placed = self.placed(at.positions());
        let mut least = f64::INFINITY;
        for s in stencils {
            let point = &self.points[s];
            let x = placed.at_rest(point.position(at.positions()));
            let mut way = point.position(displacement);
            if let Some(frame) = self.frame {
                for (node, share) in frame.nodes().into_iter().zip(placed.barycentric(x)) {
                    way = sub(way, scale(displacement[node], share));
                }
            }
            let way = placed.inverse.mul_vec(way);
            for (surface, near) in self.reachable(s, x, norm(way)) {
                least = least.min(self.reaches(surface, x, way, self.least_gap(near)));
            }
        }
        least
    }
}
