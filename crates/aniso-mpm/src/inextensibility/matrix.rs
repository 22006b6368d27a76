//! B as a sparse matrix: each cell's row has the 4^D nodes around the cell.

use super::matrix_free::FiberGrid;
use crate::binning::NONE;
use crate::blocks::{BLOCK_NODES, block_side};
use crate::kernels::for_each_node;
use fem_kinematics::dot;
use fem_solvers::parallel;

/// B with the cells and the nodes that take part in it, numbered without gaps.
#[derive(Clone, Debug)]
pub struct ConstraintMatrix<const D: usize> {
    /// Place of each row's cell in a cell vector of the grid.
    cells: Vec<u32>,
    /// Place of each column's node in a node vector of the grid.
    nodes: Vec<u32>,
    /// 4^D entries per row.
    values: Vec<[f64; D]>,
    /// The node (number in `nodes`) of every entry, or [`NONE`].
    columns: Vec<u32>,
    /// For each node the cell (number in `cells`) whose entry at this offset meets it, or [`NONE`].
    rows: Vec<u32>,
}

/// Rows or columns of a product that one task makes.
const ROWS: usize = 64;

/// Offsets of a cell's nodes on each axis: −1, 0, 1, 2.
const SPAN: usize = 4;

impl<const D: usize> ConstraintMatrix<D> {
    /// Sums B over the particles of a grid, each cell over its particles in sorted order.
    pub fn assemble(grid: &FiberGrid<D>) -> Self {
        let entries = SPAN.pow(D as u32);
        let blocks = grid.node_blocks();
        // One task per block of cells: it visits the particles that can reach it and adds to its
        // own cells only.
        let per_block: Vec<(Vec<u32>, Vec<[f64; D]>)> =
            parallel::indexed(blocks.len(), |slot| block_rows(grid, slot, entries));
        let mut cells = Vec::new();
        let mut values = Vec::new();
        for (block_cells, block_values) in per_block {
            cells.extend(block_cells);
            values.extend(block_values);
        }
        let mut row_of = vec![NONE; grid.len()];
        for (row, &cell) in cells.iter().enumerate() {
            row_of[cell as usize] = row as u32;
        }
        // Columns: nodes that some row touches with a non-zero entry.
        let mut places = vec![NONE; cells.len() * entries];
        let mut used = vec![false; grid.len()];
        for (row, &cell) in cells.iter().enumerate() {
            let z = blocks.node(cell as usize);
            let mut entry = row * entries;
            for_each_node::<D>(SPAN, |n| {
                if values[entry] != [0.0; D] {
                    let node = core::array::from_fn(|a| z[a] + n[a] as i32 - 1);
                    if let Some(place) = blocks.node_index(node) {
                        places[entry] = place as u32;
                        used[place] = true;
                    }
                }
                entry += 1;
            });
        }
        let mut number = vec![NONE; grid.len()];
        let mut nodes = Vec::new();
        for (place, _) in used.iter().enumerate().filter(|(_, used)| **used) {
            number[place] = nodes.len() as u32;
            nodes.push(place as u32);
        }
        let mut rows = vec![NONE; nodes.len() * entries];
        let mut columns = places;
        for (at, column) in columns.iter_mut().enumerate() {
            if *column != NONE {
                *column = number[*column as usize];
                rows[*column as usize * entries + at % entries] = (at / entries) as u32;
            }
        }
        Self {
            cells,
            nodes,
            values,
            columns,
            rows,
        }
    }

    /// Cells with a constraint, as places in a cell vector of the grid.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }
    /// Nodes with a coefficient, as places in a node vector of the grid.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    fn entries() -> usize {
        SPAN.pow(D as u32)
    }

    /// y = B v; `v` has one entry per [`nodes`](Self::nodes), y one per [`cells`](Self::cells).
    pub fn apply(&self, v: &[[f64; D]], y: &mut [f64]) {
        let entries = Self::entries();
        let values = self.values.chunks(ROWS * entries);
        let rows = values.zip(self.columns.chunks(ROWS * entries));
        parallel::each(y.chunks_mut(ROWS).zip(rows), |(y, (values, columns))| {
            let rows = values.chunks(entries).zip(columns.chunks(entries));
            for (y, (values, columns)) in y.iter_mut().zip(rows) {
                *y = 0.0;
                for (value, &column) in values.iter().zip(columns) {
                    if column != NONE {
                        *y += dot(*value, v[column as usize]);
                    }
                }
            }
        });
    }

    /// f = Bᵀ λ.
    pub fn apply_transpose(&self, lambda: &[f64], f: &mut [[f64; D]]) {
        let entries = Self::entries();
        let rows = self.rows.chunks(ROWS * entries);
        parallel::each(f.chunks_mut(ROWS).zip(rows), |(f, rows)| {
            for (f, rows) in f.iter_mut().zip(rows.chunks(entries)) {
                *f = [0.0; D];
                for (offset, &row) in rows.iter().enumerate() {
                    if row != NONE {
                        let value = &self.values[row as usize * entries + offset];
                        for a in 0..D {
                            f[a] += value[a] * lambda[row as usize];
                        }
                    }
                }
            }
        });
    }

    /// The diagonal of L = B M⁻¹ Bᵀ for Δt/m_i on [`nodes`](Self::nodes).
    pub fn schur_diagonal(&self, inverse_mass: &[f64]) -> Vec<f64> {
        let entries = Self::entries();
        self.values
            .chunks(entries)
            .zip(self.columns.chunks(entries))
            .map(|(values, columns)| {
                let term = |(value, &column): (&[f64; D], &u32)| {
                    if column == NONE {
                        0.0
                    } else {
                        dot(*value, *value) * inverse_mass[column as usize]
                    }
                };
                values.iter().zip(columns).map(term).sum()
            })
            .collect()
    }

    /// L = B M⁻¹ Bᵀ, assembled: for each row the (column, value) pairs with the columns rising.
    pub fn assemble_schur(&self, inverse_mass: &[f64]) -> Vec<Vec<(u32, f64)>> {
        let entries = Self::entries();
        parallel::indexed(self.cells.len(), |row| {
            let mut sums = std::collections::BTreeMap::new();
            for at in row * entries..(row + 1) * entries {
                let column = self.columns[at];
                if column == NONE {
                    continue;
                }
                let node = column as usize;
                for offset in 0..entries {
                    let other = self.rows[node * entries + offset];
                    if other != NONE {
                        let value = self.values[other as usize * entries + offset];
                        *sums.entry(other).or_insert(0.0) +=
                            dot(self.values[at], value) * inverse_mass[node];
                    }
                }
            }
            sums.into_iter().collect()
        })
    }
}

/// The rows of the cells in one block.
fn block_rows<const D: usize>(
    grid: &FiberGrid<D>,
    slot: usize,
    entries: usize,
) -> (Vec<u32>, Vec<[f64; D]>) {
    let side = block_side(D) as i32;
    let binning = &grid.binning;
    let first = binning.nodes.block(slot).map(|b| b * side);
    let mut row_of = [NONE; BLOCK_NODES];
    let mut cells = Vec::new();
    let mut values = Vec::new();
    for &home in binning.sources[slot].iter().filter(|&&home| home != NONE) {
        let ranks = binning.starts[home as usize]..binning.starts[home as usize + 1];
        for rank in ranks {
            let p = binning.order[rank as usize] as usize;
            let a = grid.a[p];
            let (cell, node) = (grid.cells_of(p), grid.nodes_of(p));
            for_each_node::<D>(2, |z| {
                let mut local = 0;
                let mut inside = true;
                for axis in 0..D {
                    let at = cell.base[axis] + z[axis] as i32 - first[axis];
                    inside &= (0..side).contains(&at);
                    local = local * side + at;
                }
                let weight = grid.volume[p] * cell.weight(z);
                if !inside || !(weight > 0.0) || a == [0.0; D] {
                    return;
                }
                let row = &mut row_of[local as usize];
                if *row == NONE {
                    *row = cells.len() as u32;
                    cells.push((slot * BLOCK_NODES) as u32 + local as u32);
                    values.resize(values.len() + entries, [0.0; D]);
                }
                let start = *row as usize * entries;
                for_each_node::<D>(3, |n| {
                    // ERRATUM: printed K_(c,iα) with Γ_z and N_j is B_(z,iα) with N_i.
                    let mut at = 0;
                    for axis in 0..D {
                        // Node minus cell, from −1.
                        at = at * SPAN + n[axis] + 1 - z[axis];
                    }
                    let coefficient = weight * dot(a, node.gradient(n));
                    for axis in 0..D {
                        values[start + at][axis] += coefficient * a[axis];
                    }
                });
            });
        }
    }
    (cells, values)
}
