//! Which coordinates move: the only place that maps (node, axis) to an index of the unknowns.
//!
//! The free nodes x^U are numbered along the longest axis of the rest shape, so that elements and
//! matrix rows which are near in space are near in memory; the prescribed nodes x^C keep no number
//! at all, they are eliminated. The unknown (free node r, axis k) has index D·r + k in vectors of the
//! unknowns. A prescribed axis of a node that is free in another one has a place in them, which keeps
//! its value, and none in the system that is solved: it is eliminated, too.

use crate::error::{AssemblyError, check_length};

/// The index of a free node among the unknowns, or "prescribed".
pub(crate) const PRESCRIBED: u32 = u32::MAX;

/// The split of a mesh's coordinates into prescribed (x^C) and free ones (x^U), document 000, 2.
#[derive(Clone, Debug)]
pub struct Dofs<const D: usize> {
    rank: Vec<u32>,
    free_nodes: Vec<u32>,
    prescribed_axes: Vec<(u32, usize)>,
}

impl<const D: usize> Dofs<D> {
    /// Every coordinate is free.
    ///
    /// # Errors
    /// When there are more than 2³² − 2 nodes.
    pub fn all_free(rest: &[[f64; D]]) -> Result<Self, AssemblyError> {
        Self::new(rest, &[], &[])
    }

    /// Prescribes all coordinates of the nodes in `prescribed_nodes`.
    ///
    /// # Errors
    /// When a node does not exist.
    pub fn with_prescribed_nodes(
        rest: &[[f64; D]],
        prescribed_nodes: &[usize],
    ) -> Result<Self, AssemblyError> {
        Self::new(rest, prescribed_nodes, &[])
    }

    /// Prescribes whole nodes and, for symmetry planes and rollers, single axes (node, axis).
    ///
    /// # Errors
    /// When a node or axis does not exist.
    pub fn new(
        rest: &[[f64; D]],
        prescribed_nodes: &[usize],
        prescribed_axes: &[(usize, usize)],
    ) -> Result<Self, AssemblyError> {
        let count = rest.len();
        if count >= PRESCRIBED as usize {
            return Err(AssemblyError::TooManyNodes { count });
        }
        let mut prescribed = vec![[false; D]; count];
        for &node in prescribed_nodes {
            *prescribed
                .get_mut(node)
                .ok_or(AssemblyError::NoSuchNode { node, count })? = [true; D];
        }
        for &(node, axis) in prescribed_axes {
            let axes = prescribed
                .get_mut(node)
                .ok_or(AssemblyError::NoSuchNode { node, count })?;
            *axes
                .get_mut(axis)
                .ok_or(AssemblyError::NoSuchAxis { axis, dimension: D })? = true;
        }
        let axis = longest_axis(rest);
        let mut free_nodes: Vec<u32> = (0..count as u32)
            .filter(|&n| prescribed[n as usize] != [true; D])
            .collect();
        free_nodes.sort_by(|&a, &b| rest[a as usize][axis].total_cmp(&rest[b as usize][axis]));
        let mut rank = vec![PRESCRIBED; count];
        let mut prescribed_axes = Vec::new();
        for (r, &node) in free_nodes.iter().enumerate() {
            rank[node as usize] = r as u32;
            prescribed_axes.extend(
                (0..D)
                    .filter(|&k| prescribed[node as usize][k])
                    .map(|k| (r as u32, k)),
            );
        }
        Ok(Self {
            rank,
            free_nodes,
            prescribed_axes,
        })
    }

    /// Number of nodes of the mesh.
    pub fn nodes(&self) -> usize {
        self.rank.len()
    }
    /// Number of nodes with at least one free axis: the block rows of the Hessian.
    pub fn free_nodes(&self) -> usize {
        self.free_nodes.len()
    }
    /// Length of vectors of the unknowns, D for each free node, places of prescribed axes included.
    pub fn vector_len(&self) -> usize {
        D * self.free_nodes.len()
    }
    /// Number of coordinates that are free: the scalar unknowns of the system that is solved.
    pub fn unknowns(&self) -> usize {
        self.vector_len() - self.prescribed_axes.len()
    }
    /// The block row of a node, `None` where it is prescribed or does not exist.
    pub fn row(&self, node: usize) -> Option<usize> {
        let rank = *self.rank.get(node)?;
        (rank != PRESCRIBED).then_some(rank as usize)
    }
    /// Is this coordinate prescribed? False for a node or axis that does not exist.
    pub fn is_prescribed(&self, node: usize, axis: usize) -> bool {
        match self.rank.get(node) {
            Some(&PRESCRIBED) => axis < D,
            Some(&row) => self.prescribed_axes.binary_search(&(row, axis)).is_ok(),
            None => false,
        }
    }
    /// The node of each block row.
    pub fn node_of_row(&self) -> &[u32] {
        &self.free_nodes
    }
    /// (block row, axis) of each prescribed axis of a node that is free in another axis.
    pub(crate) fn prescribed_axes(&self) -> &[(u32, usize)] {
        &self.prescribed_axes
    }
    pub(crate) fn rank(&self) -> &[u32] {
        &self.rank
    }
    /// Reads the unknowns out of all positions.
    ///
    /// # Errors
    /// When there is not one for each node.
    pub fn gather(&self, all: &[[f64; D]]) -> Result<Vec<f64>, AssemblyError> {
        check_length("positions", all.len(), self.nodes())?;
        Ok(self.trusted_gather(all))
    }
    pub(crate) fn trusted_gather(&self, all: &[[f64; D]]) -> Vec<f64> {
        self.free_nodes
            .iter()
            .flat_map(|&n| all[n as usize])
            .collect()
    }
    /// Writes the unknowns into all positions; prescribed axes keep their value.
    ///
    /// # Errors
    /// When a list is not of the length [`Dofs::vector_len`] or [`Dofs::nodes`]; nothing is written then.
    pub fn scatter(&self, unknowns: &[f64], all: &mut [[f64; D]]) -> Result<(), AssemblyError> {
        check_length("unknowns", unknowns.len(), self.vector_len())?;
        check_length("positions", all.len(), self.nodes())?;
        self.trusted_scatter(unknowns, all);
        Ok(())
    }
    pub(crate) fn trusted_scatter(&self, unknowns: &[f64], all: &mut [[f64; D]]) {
        let kept: Vec<f64> = self
            .prescribed_axes
            .iter()
            .map(|&(r, k)| all[self.free_nodes[r as usize] as usize][k])
            .collect();
        for (&node, value) in self.free_nodes.iter().zip(unknowns.chunks_exact(D)) {
            all[node as usize].copy_from_slice(value);
        }
        for (&(r, k), value) in self.prescribed_axes.iter().zip(kept) {
            all[self.free_nodes[r as usize] as usize][k] = value;
        }
    }
}

fn longest_axis<const D: usize>(points: &[[f64; D]]) -> usize {
    let extent = |k: usize| {
        let (low, high) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| {
                (l.min(p[k]), h.max(p[k]))
            });
        high - low
    };
    (0..D)
        .max_by(|&a, &b| extent(a).total_cmp(&extent(b)))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_then_gather_returns_the_unknowns_and_keeps_prescribed_axes() {
        let rest = [[0.0, 0.0], [3.0, 0.0], [1.0, 1.0], [2.0, 1.0]];
        let dofs = Dofs::new(&rest, &[0], &[(2, 1)]).unwrap();
        assert_eq!(dofs.node_of_row(), [2, 3, 1]);
        assert_eq!((dofs.vector_len(), dofs.unknowns()), (6, 5));
        let prescribed: Vec<(usize, usize)> = (0..5)
            .flat_map(|n| (0..3).map(move |k| (n, k)))
            .filter(|&(n, k)| dofs.is_prescribed(n, k))
            .collect();
        assert_eq!(prescribed, [(0, 0), (0, 1), (2, 1)]);
        let mut all = rest;
        let mut unknowns = dofs.gather(&all).unwrap();
        unknowns.iter_mut().for_each(|u| *u += 10.0);
        dofs.scatter(&unknowns, &mut all).unwrap();
        assert_eq!(all, [[0.0, 0.0], [13.0, 10.0], [11.0, 1.0], [12.0, 11.0]]);
    }

    #[test]
    fn lists_of_another_length_are_refused_and_left_as_they_are() {
        let rest = [[0.0, 0.0], [3.0, 0.0], [1.0, 1.0]];
        let dofs = Dofs::with_prescribed_nodes(&rest, &[1]).unwrap();
        let wrong = |what, found, expected| AssemblyError::WrongLength {
            what,
            found,
            expected,
        };
        for count in [2, 4] {
            let mut all = vec![[7.0; 2]; count];
            let error = wrong("positions", count, 3);
            assert_eq!(dofs.gather(&all), Err(error.clone()));
            assert_eq!(dofs.scatter(&[1.0; 4], &mut all), Err(error));
            assert_eq!(all, vec![[7.0; 2]; count]);
        }
        for count in [3, 5] {
            let mut all = rest;
            let error = wrong("unknowns", count, 4);
            assert_eq!(dofs.scatter(&vec![1.0; count], &mut all), Err(error));
            assert_eq!(all, rest);
        }
        assert_eq!(
            (dofs.row(2), dofs.row(1), dofs.row(3)),
            (Some(1), None, None)
        );
    }

    #[test]
    fn a_node_or_axis_that_does_not_exist_is_refused() {
        let rest = [[0.0, 0.0]];
        assert!(matches!(
            Dofs::with_prescribed_nodes(&rest, &[1]),
            Err(AssemblyError::NoSuchNode { node: 1, count: 1 })
        ));
        assert!(matches!(
            Dofs::new(&rest, &[], &[(0, 2)]),
            Err(AssemblyError::NoSuchAxis {
                axis: 2,
                dimension: 2
            })
        ));
    }
}
