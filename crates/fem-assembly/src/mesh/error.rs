//! What can be wrong with a mesh.

use std::fmt;

/// The first few of a list of ids, and how many there are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ids {
    /// At most eight ids, ascending.
    pub first: Vec<usize>,
    /// How many there are in all.
    pub count: usize,
}

impl Ids {
    /// `None` where there is no id.
    pub fn of(ids: impl IntoIterator<Item = usize>) -> Option<Self> {
        let mut first = Vec::new();
        let mut count = 0;
        for id in ids {
            if first.len() < 8 {
                first.push(id);
            }
            count += 1;
        }
        (count > 0).then_some(Self { first, count })
    }
}

impl fmt::Display for Ids {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of them: ", self.count)?;
        for (k, id) in self.first.iter().enumerate() {
            write!(f, "{}{id}", if k == 0 { "" } else { ", " })?;
        }
        if self.count > self.first.len() {
            write!(f, ", …")?;
        }
        Ok(())
    }
}

/// A mesh that elasticity cannot use. Every message lists the first ids and names the cure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No element at all.
    #[error("the mesh has no elements; give at least one simplex")]
    Empty,
    /// The flat list of node indices is no multiple of the nodes per element.
    #[error(
        "{length} node indices are no multiple of {nodes_per_element}, the nodes of one element"
    )]
    RaggedConnectivity {
        /// Indices given.
        length: usize,
        /// D + 1.
        nodes_per_element: usize,
    },
    /// More nodes than 32-bit indices can name.
    #[error("{0} nodes are more than 32-bit indices can name")]
    TooManyNodes(usize),
    /// A grid with no boxes, or a size that is not positive.
    #[error("a grid needs at least one box and a positive, finite size along every axis")]
    EmptyGrid,
    /// A coordinate that is NaN or infinite.
    #[error("nodes with a NaN or infinite coordinate ({0}); repair them in the mesh file")]
    NotFinite(Ids),
    /// An element names a node that does not exist.
    #[error(
        "elements that name a node beyond the last of {nodes} ({ids}); are the indices 0-based?"
    )]
    IndexOutOfRange {
        /// The elements.
        ids: Ids,
        /// Nodes of the mesh.
        nodes: usize,
    },
    /// An element names one node twice.
    #[error("elements that name a node twice ({0}); remove them")]
    RepeatedNode(Ids),
    /// An element whose volume is less than 1e-10 of its longest edge to the power D.
    #[error("elements of zero volume ({0}); remove them or remesh there")]
    ZeroVolume(Ids),
    /// An element with (x₁−x₀)·((x₂−x₀)×(x₃−x₀)) < 0.
    #[error(
        "elements of negative volume ({0}); swap two of their nodes, or have them repaired (`Orientation::Repair`; in a scene file \"inverted\": \"repair\")"
    )]
    NegativeVolume(Ids),
    /// Two elements with the same nodes.
    #[error("elements that repeat an earlier one ({0}); remove them")]
    Duplicate(Ids),
    /// A node that belongs to no element.
    #[error("nodes that belong to no element ({0}); remove them, or read with `Orphans::Allow`")]
    Orphan(Ids),
    /// A quadratic element with a midside node off the middle of its edge.
    #[error(
        "quadratic elements with a midside node off the middle of its straight edge ({0}); only \
         straight edges are supported, in VTK's order 01, 12, 02, 03, 13, 23: straighten them, or \
         start from `QuadraticMesh::from_linear`"
    )]
    NotMidpoint(Ids),
    /// Quadratic elements that have an edge in common, but not its midside node.
    #[error(
        "quadratic elements that share an edge with another one, but not its midside node ({0}); \
         merge the nodes that lie on one another"
    )]
    SplitEdge(Ids),
    /// A node in the middle of one edge that is also a corner or the middle of another one.
    #[error(
        "nodes in the middle of an edge that are also a corner or the middle of another edge ({0}); \
         remesh there"
    )]
    MidsideTwice(Ids),
}
