//! Why a pose could not be solved.

use super::equilibrium::Equilibrium;
use fem_assembly::{AssemblyError, FreePart, RenewingError};
use fem_solvers::{ContinuationError, NewtonError, NewtonFailure, PcgError, PreconditionerError};

/// A pose without an equilibrium, or without a derivative there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
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
    /// A part of the flesh that no bone and no term holds, or without any stiffness: it has no
    /// equilibrium to find.
    #[error("{0}; {cure}, or take it out of the mesh", cure = cure(.0))]
    Free(FreePart<3>),
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
         ({steps} part-way poses solved){}: {source}",
        element.map_or_else(String::new, |e| format!(
            ", element {e} would be turned inside out by moving the bones"
        ))
    )]
    NoEquilibrium {
        /// How far the walk came, per cent.
        percent: f64,
        /// Part-way poses solved.
        steps: usize,
        /// The first element that the pose turns inside out, if there is one.
        element: Option<usize>,
        /// The last pose that was solved, part-way ones included.
        last: Box<Equilibrium>,
        /// What ended the way.
        source: Box<PartError>,
    },
    /// The steps of the way to a pose make no sense.
    #[error("the way to the pose: {0}")]
    Walk(Box<ContinuationError<PartError>>),
    /// The stiffness at an equilibrium is not positive definite: the pose is at a fold, where
    /// dx/dθ does not exist.
    #[error("the equilibrium is not stable, dx/dθ does not exist here: {0}")]
    Unstable(#[from] NewtonFailure),
    /// No multigrid hierarchy could be made of the stiffness, and no factor was allowed to decide why: the
    /// pose is at a fold or beyond it, or a level is singular to its precision.
    #[error(
        "no multigrid hierarchy can be made of the stiffness here; factor with `MultigridUse::Never`, \
         which also tells whether dx/dθ exists: {0}"
    )]
    Hierarchy(PreconditionerError),
    /// Conjugate gradients did not bring dx/dθ to [`RigParams::derivative_tolerance`].
    ///
    /// [`RigParams::derivative_tolerance`]: super::RigParams::derivative_tolerance
    #[error(
        "dx/dθ was not found to its tolerance by multigrid; take a looser one \
         (`RigParams::derivative_tolerance`), or factor with `MultigridUse::Never`: {0}"
    )]
    Derivative(PcgError),
    /// Conjugate gradients for dx/dθ met a residual whose product with that of a cycle is not positive:
    /// the hierarchy, in its own precision, stands for no stiffness. Whether the true one is stable it
    /// does not say.
    #[error(
        "the multigrid hierarchy does not precondition the stiffness here; factor with \
         `MultigridUse::Never`, which also tells whether dx/dθ exists: {0}"
    )]
    Preconditioner(PcgError),
    /// The derivative was asked for before any stiffness was factored.
    #[error("no stiffness has been factored at this pose")]
    NoTangent,
    /// The mesh side refused its input.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}

/// Why a pose on the way has no equilibrium.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// Newton's method failed.
    #[error(transparent)]
    Newton(#[from] NewtonError),
    /// The guess, or the pose, is no input for the assembly.
    #[error("the guess for the pose: {0}")]
    Guess(#[from] AssemblyError),
    /// All forces vanish there, but an element is inside out ([`RigParams::refuses_inverted`]).
    ///
    /// [`RigParams::refuses_inverted`]: super::RigParams::refuses_inverted
    #[error("the forces vanish with element {element} inside out (det F {ratio:.3})")]
    Inverted {
        /// The element.
        element: usize,
        /// Its det F.
        ratio: f64,
    },
    /// Contacts that do not come to rest.
    #[error(transparent)]
    Renewing(Box<RenewingError<3>>),
}

impl RigError {
    /// Did a [`Watch`](fem_solvers::Watch) end it?
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::NoEquilibrium { source, .. } if source.is_cancelled())
    }
}

impl PartError {
    /// Did a [`Watch`](fem_solvers::Watch) end it?
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Newton(error) if error.reason == NewtonFailure::Cancelled)
    }
}

impl From<RenewingError<3>> for PartError {
    fn from(error: RenewingError<3>) -> Self {
        match error {
            RenewingError::Assembly(error) => Self::Guess(error),
            RenewingError::Newton { source, .. } => Self::Newton(*source),
            error => Self::Renewing(Box::new(error)),
        }
    }
}

fn cure(part: &FreePart<3>) -> &'static str {
    if part.limp {
        "give it a modulus above 0 Pa"
    } else {
        "fix it to a bone"
    }
}
