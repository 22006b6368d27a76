//! What can be wrong with the input of an assembly.

use fem_solvers::PatternError;

/// Input that no equilibrium problem can be built from.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum AssemblyError {
    /// Node indices are 32 bits wide.
    #[error("{count} nodes are more than 32-bit indices can name; split the mesh")]
    TooManyNodes {
        /// Nodes given.
        count: usize,
    },
    /// A part of a body that can move with nothing to stop it.
    #[error(
        "{part}{}; prescribe what stops them, or add springs",
        match others { 0 => String::new(), n => format!(" (and {n} more such parts)") }
    )]
    Free {
        /// The first such part, and how it can move ([`FreePart`](crate::FreePart)).
        part: String,
        /// How many more there are.
        others: usize,
    },
    /// A node index past the end.
    #[error("node {node} does not exist: the mesh has {count} nodes, counted from 0")]
    NoSuchNode {
        /// The index given.
        node: usize,
        /// Nodes of the mesh.
        count: usize,
    },
    /// An axis past the last.
    #[error("axis {axis} does not exist in {dimension}D; axes count from 0")]
    NoSuchAxis {
        /// The axis given.
        axis: usize,
        /// Dimension D.
        dimension: usize,
    },
    /// An element index past the end.
    #[error("element {element} does not exist: the mesh has {count} elements, counted from 0")]
    NoSuchElement {
        /// The index given.
        element: usize,
        /// Elements of the mesh.
        count: usize,
    },
    /// A list that should have one entry for each node, element or muscle.
    #[error("{what}: {found} values given, {expected} needed")]
    WrongLength {
        /// What the list holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length needed.
        expected: usize,
    },
    /// An element whose rest volume is zero or not a number.
    #[error(
        "element {element} has rest volume {volume:e}; remove it or move its nodes {nodes:?} apart"
    )]
    DegenerateElement {
        /// Its index.
        element: usize,
        /// Its volume (area in 2D).
        volume: f64,
        /// Its nodes.
        nodes: Vec<u32>,
    },
    /// A stiffness that pushes the wrong way.
    #[error("factor {index} of a stiffness is {factor:e}; it must be 0 or greater")]
    NegativeStiffness {
        /// Its place in the list.
        index: usize,
        /// The factor given.
        factor: f64,
    },
    /// NaN or ∞ where a number is needed.
    #[error("{what} {index} is not finite")]
    NotFinite {
        /// What the number belongs to.
        what: &'static str,
        /// Its index.
        index: usize,
    },
    /// A number of a penalty that no contact can be computed with.
    #[error("penalty (term {index}): {what} is {value}; it must be {needed}")]
    UnusablePenalty {
        /// Index among the terms in the order given to the builder.
        index: usize,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it should be.
        needed: &'static str,
    },
    /// A number of a contact that nothing can be computed with.
    #[error("contact: {what} is {value}; it must be finite and greater than 0")]
    UnusableContact {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A fiber whose direction is not of length 1.
    #[error("fiber {index} (element {element}) has length {length}; give a unit vector")]
    NoDirection {
        /// Index in the list of fibers.
        index: usize,
        /// Its element.
        element: usize,
        /// Its length.
        length: f64,
    },
    /// A stencil of a term that names a node twice.
    #[error("stencil {stencil} of term {term} names node {node} twice")]
    RepeatedNode {
        /// Index of the term in the order given to the builder.
        term: usize,
        /// Its stencil.
        stencil: usize,
        /// The node.
        node: usize,
    },
    /// Stencils are counted with 32 bits.
    #[error("{count} stencils are more than 32-bit indices can name; split the mesh")]
    TooManyStencils {
        /// Stencils given.
        count: usize,
    },
    /// A term that reads a control cannot be multiplied by it.
    #[error(
        "a term that reads controls up to {read} cannot be scaled by control {control}: its energy would \
         not be affine in it; scale by one past {read}"
    )]
    ScaledTwice {
        /// The last control that it may read.
        read: usize,
        /// The one to scale by.
        control: usize,
    },
    /// A surface that should enclose something and does not.
    #[error(
        "the surface is open at the edge of nodes {nodes:?}, which only face {faces:?} has: add the \
         missing face, or cap the surface"
    )]
    OpenSurface {
        /// The edge; one node in 2D.
        nodes: Vec<u32>,
        /// The face beside it.
        faces: Vec<usize>,
    },
    /// A surface whose faces are not all seen from one side.
    #[error(
        "faces {faces:?} do not turn the same way around at the edge of nodes {nodes:?}: swap two nodes of \
         those that are seen from the wrong side, and give no face twice"
    )]
    TwistedSurface {
        /// The edge; one node in 2D.
        nodes: Vec<u32>,
        /// The faces around it.
        faces: Vec<usize>,
    },
    /// A face that names a node twice.
    #[error("face {face} names node {node} twice")]
    DegenerateFace {
        /// Its place in the list.
        face: usize,
        /// The node.
        node: u32,
    },
    /// A face of quadratic elements with an edge that no element has.
    #[error("face {face}: no element has an edge between the corners {nodes:?}")]
    NoSuchEdge {
        /// The ends.
        nodes: [u32; 2],
        /// Place of the face in the list.
        face: usize,
    },
    /// The places of the Hessian's blocks are none that a matrix can have.
    #[error("places of the Hessian: {0}")]
    Pattern(#[from] PatternError),
}

/// That a list of `what` is as long as it must be.
pub(crate) fn check_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), AssemblyError> {
    if found == expected {
        return Ok(());
    }
    Err(AssemblyError::WrongLength {
        what,
        found,
        expected,
    })
}
