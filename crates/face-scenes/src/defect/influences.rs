//! Places, loads and other influences.

use crate::names::DidYouMean;

/// What is wrong with a choice of nodes or faces.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceDefect {
    /// Nodes by sight.
    #[error("only faces can be seen; leave it out, or give a box or a sphere")]
    NodesUnseen,
    /// Nothing chosen.
    #[error("no node meets these conditions; check the unit of lengths (\"scale\")")]
    NoNode,
    /// Nothing chosen.
    #[error("no face of the boundary meets these conditions with all three nodes")]
    NoFace,
    /// No choice.
    #[error("give a condition: box, sphere, array, region, nodes, or for faces seen_from")]
    NoCondition,
    /// A sphere without inside.
    #[error("{radius} is no radius; it must be above 0")]
    Radius {
        /// What was given.
        radius: f64,
    },
    /// Arrays of a face that the program makes.
    #[error("the built-in face has no arrays; give a box or a sphere")]
    NoArrays,
    /// A node that does not exist.
    #[error("node {node} does not exist; the mesh has {count}, from 0")]
    UnknownNode {
        /// The node.
        node: u32,
        /// Nodes of the mesh.
        count: usize,
    },
    /// A region that does not exist.
    #[error("there is no region \"{name}\"{}", DidYouMean(similar))]
    UnknownRegion {
        /// The name.
        name: String,
        /// A name that is almost the same.
        similar: Option<String>,
    },
}

/// What is wrong with a load, a cavity, a motion, a strength or a stiffness.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InfluenceDefect {
    /// A name that cannot be set.
    #[error("\"{name}\": names are unique, not empty and without \"=\"")]
    Name {
        /// The name.
        name: String,
    },
    /// A range that is none.
    #[error("[{low}, {high}] must be two finite numbers, the lower first, around {neutral}")]
    Range {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// The value unless set.
        neutral: f64,
    },
    /// A value that is no number.
    #[error("{value} is not finite")]
    NotFinite {
        /// The value.
        value: f64,
    },
    /// Two that change the same muscle or region.
    #[error("changes what {first} changes already; give one of them")]
    Twice {
        /// The field of the first.
        first: String,
    },
    /// A weight without mass.
    #[error("the density must be above 0, and all numbers finite")]
    Gravity,
    /// A spring that pushes away.
    #[error("the stiffness must be 0 or more, and all numbers finite")]
    Springs,
    /// A penalty that does not push.
    #[error("{stiffness} must be newtons per meter of depth, finite and above 0")]
    Penalty {
        /// What was given.
        stiffness: f64,
    },
    /// A penalty that could pull.
    #[error(
        "a penalty with a factor below 0 pulls flesh in, without end; begin the range at 0 or above"
    )]
    Pulls,
    /// Springs that push away from where they end.
    #[error(
        "springs with a factor below 0 push away from their ends, without end; begin the range at 0 or above"
    )]
    Pushes,
    /// A penalty against nothing.
    #[error("names no eyeball, so the penalty pushes nothing")]
    NoObstacle,
    /// A penalty against triangles.
    #[error(
        "a penalty takes a sphere, capsule, box, half_space or eyeballs; triangles are a solid of \"contact\""
    )]
    Triangles,
    /// A pressure of 0 that no fit may vary.
    #[error("a pressure of 0 without a range does nothing; give \"pascals\" or \"range\"")]
    NoPressure,
    /// A motion of what bones move.
    #[error("all of these nodes hang on a bone and move with it")]
    OnBone,
    /// Axes that are none.
    #[error("\"{axes}\": some of x, y and z in this order")]
    Axes {
        /// What was given.
        axes: String,
    },
    /// A motion that is no number.
    #[error("the numbers must be finite")]
    Way,
    /// A motion along an axis that is free.
    #[error("moves along {axis}, which is not among \"axes\"")]
    FreeAxis {
        /// x, y or z.
        axis: char,
    },
    /// A muscle that does not exist.
    #[error("there is no muscle \"{name}\"{}", DidYouMean(similar))]
    UnknownMuscle {
        /// The name.
        name: String,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// A relative change that turns the sign.
    #[error("a change of {lowest} is below −1, which leaves nothing")]
    BelowNothing {
        /// The lowest value that it may take.
        lowest: f64,
    },
}
