//! The numbers of a contact of flesh with flesh.

/// How surfaces of flesh push each other away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FleshContactParams {
    /// d̂: the gap below which surfaces push, meters; less where they are nearer at rest.
    pub activation: f64,
    /// The pressure where they just touch, pascals; four times that at a depth of d̂, and no more than twelve
    /// times that from five d̂ on.
    pub pressure: f64,
    /// How deep a point may lie behind a surface to be pushed out, with the margin on top, meters.
    pub depth: f64,
    /// How much nearer partners may come than a step was meant to bring them before pairs are looked
    /// for again, meters.
    pub margin: f64,
    /// Partners within so many edges of the surface are never pushed apart.
    pub neighbors: usize,
    /// Are there pairs of two edges too? A skin that is finer than the elements that carry it bends
    /// with them, and its points alone keep it apart at a fraction of the pairs.
    pub edges: bool,
}

impl FleshContactParams {
    /// The depth behind which no look finds a partner, meters: the same for every look, whatever margin it
    /// takes on, so that an equilibrium stands with the pairs that any other look at it finds.
    pub(super) fn deepest(&self) -> f64 {
        self.depth + self.margin
    }
}

/// For a face: d̂ = 0.5 mm, 10 kPa, depth 4 mm, margin 2 mm, two edges, pairs of edges too.
impl Default for FleshContactParams {
    fn default() -> Self {
        Self {
            activation: 0.5e-3,
            pressure: 1e4,
            depth: 4e-3,
            margin: 2e-3,
            neighbors: 2,
            edges: true,
        }
    }
}
