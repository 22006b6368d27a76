//! Why a pose could not be solved.

use fem_assembly::AssemblyError;
use fem_solvers::{ContinuationError, NewtonError, NewtonFailure};

/// A pose without an equilibrium, or without a derivative there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// θ does not fit the rig.
    #[error("{what}: {found} given, the rig has {expected}")]
    WrongLength {
        /// What was counted.
        what: &'static str,
        /// How many were given.
        found: usize,
        /// How many the rig has.
        expected: usize,
    },
    /// θ holds NaN or ∞.
    #[error("parameter {index} is not finite")]
    NotFinite {
        /// Its place in θ.
        index: usize,
    },
    /// The jaw can only move nodes that are prescribed.
    #[error("jaw node {node} does not exist or is not among the prescribed nodes")]
    JawNodeNotPrescribed {
        /// The node.
        node: usize,
    },
    /// A motion can only move what is prescribed.
    #[error(
        "control {control} moves axis {axis} of node {node}: it must exist, be prescribed and hang on no \
         jaw, and the meters be finite"
    )]
    MotionNotPrescribed {
        /// The control.
        control: usize,
        /// The node.
        node: usize,
        /// The axis.
        axis: usize,
    },
    /// A unit that nothing can be measured in.
    #[error("the unit of control {control} is {unit}; it must be finite and above 0")]
    ControlUnit {
        /// The control.
        control: usize,
        /// Its unit.
        unit: f64,
    },
    /// An element that the bones alone move leaves the domain of its material: no flesh can give way.
    #[error(
        "element {element} has infinite energy there (det F {ratio:.3}): all its nodes hang on bones \
         ({jaw:?} on the jaw, {cranium:?} on the cranium), which alone move it; move the jaw less, or \
         refine or remove the element"
    )]
    MovedOutOfDomain {
        /// The element.
        element: usize,
        /// Its smallest det F.
        ratio: f64,
        /// Its nodes on the jaw.
        jaw: Vec<u32>,
        /// Its nodes on the cranium.
        cranium: Vec<u32>,
    },
    /// No equilibrium was found on the way from the last pose to this one.
    #[error(
        "no equilibrium: stuck {percent:.1} % of the way from the last solved pose to this one \
         ({steps} part-way poses solved){element}: {source}"
    )]
    NoEquilibrium {
        /// How far the walk came, per cent.
        percent: f64,
        /// Part-way poses solved.
        steps: usize,
        /// Names an element that the pose turns inside out, if there is one.
        element: String,
        /// What Newton's method said last.
        source: Box<NewtonError>,
    },
    /// The steps of the way to a pose make no sense.
    #[error("the way to the pose: {0}")]
    Walk(Box<ContinuationError<NewtonError>>),
    /// The stiffness at an equilibrium is not positive definite: the pose is at a fold, where
    /// dx/dθ does not exist.
    #[error("the equilibrium is not stable, dx/dθ does not exist here: {0}")]
    Unstable(#[from] NewtonFailure),
    /// The derivative was asked for before any stiffness was factored.
    #[error("no stiffness has been factored at this pose")]
    NoTangent,
    /// The mesh side refused its input.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}
