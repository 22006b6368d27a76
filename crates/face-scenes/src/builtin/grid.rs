//! The structured grid of material coordinates, its slits, and its tets.

use super::form::{BOTTOM, EYES, Form, MOUTH, SIDE, Side, TOP};
use face_rig::anatomy::EmbeddedPoint;

/// Rows, columns and layers of cells; each cell is six tets.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// Material `a >= 0` of the columns of the left half, from the midplane to the cut.
    columns: Vec<f64>,
    /// Material `b`, ascending.
    rows: Vec<f64>,
    layers: usize,
    mouth_row: usize,
    eye_row: usize,
    /// Column (of the left half) of inner canthus, outer canthus and mouth corner.
    canthi: [usize; 2],
    corner: usize,
    /// Number of the second copy of a node column on a slit, by row and column.
    copies: Vec<u32>,
    copy_count: usize,
}

/// Edges along the three local axes of a cell, in the order in which the six tets walk them.
const WALKS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];
const NO_COPY: u32 = u32::MAX;

/// Wanted size of cells relative to those at the mouth, over `a` and over `b`.
fn column_size(a: f64) -> f64 {
    let t = ((a - 48.0) / 45.0).clamp(0.0, 1.0);
    1.0 + 1.1 * t * t * (3.0 - 2.0 * t)
}
fn row_size(b: f64) -> f64 {
    let fine = |center: f64, width: f64| (-((b - center) / width).powi(2)).exp();
    let detail =
        fine(MOUTH, 17.0) + fine(EYES, 14.0) + 0.75 * fine(-8.0, 12.0) + 0.2 * fine(-75.0, 14.0);
    1.75 - 0.95 * detail.min(1.0)
}

/// `cells` intervals from `low` to `high` whose lengths follow `size`.
fn graded(low: f64, high: f64, cells: usize, size: fn(f64) -> f64) -> Vec<f64> {
    const FINE: usize = 400;
    let mut sum = vec![0.0; FINE + 1];
    let x = |i: f64| low + (high - low) * i / FINE as f64;
    for i in 0..FINE {
        sum[i + 1] = sum[i] + 1.0 / size(x(i as f64 + 0.5));
    }
    let mut nodes = vec![low];
    let mut at = 0;
    for c in 1..cells {
        let wanted = sum[FINE] * c as f64 / cells as f64;
        while sum[at + 1] < wanted {
            at += 1;
        }
        nodes.push(x(at as f64 + (wanted - sum[at]) / (sum[at + 1] - sum[at])));
    }
    nodes.push(high);
    nodes
}

/// Number of cells in an interval at a given fineness (cells per millimeter at the mouth).
fn cells(low: f64, high: f64, fineness: f64, size: fn(f64) -> f64) -> usize {
    const FINE: usize = 200;
    let h = (high - low) / FINE as f64;
    let sum: f64 = (0..FINE)
        .map(|i| h / size(low + (i as f64 + 0.5) * h))
        .sum();
    ((sum * fineness).round() as usize).max(1)
}

impl Grid {
    /// The grid whose number of tets is nearest to `target`.
    pub fn with_tets(target: usize, form: &Form) -> Self {
        let layers = ((target as f64 / 100_000.0).cbrt() * 4.0).round().max(2.0) as usize;
        let [inner, outer, corner] = form.corners;
        let stops = [0.0, inner, corner, outer, SIDE];
        let levels = [BOTTOM, MOUTH, EYES, TOP];
        let count = |fineness: f64| -> ([usize; 4], [usize; 3]) {
            let c = [0, 1, 2, 3].map(|i| cells(stops[i], stops[i + 1], fineness, column_size));
            // Rows are a little closer than columns: wrinkles and lips run sideways.
            let r = [0, 1, 2].map(|i| cells(levels[i], levels[i + 1], 1.12 * fineness, row_size));
            (c, r)
        };
        let tets = |(c, r): &([usize; 4], [usize; 3])| {
            12 * layers * c.iter().sum::<usize>() * r.iter().sum::<usize>()
        };
        let mut best = count(0.02);
        let mut fineness = 0.02;
        while fineness < 8.0 {
            let next = count(fineness);
            if tets(&next).abs_diff(target) < tets(&best).abs_diff(target) {
                best = next;
            }
            fineness *= 1.004;
        }
        let (c, r) = best;
        let mut columns = vec![0.0];
        for i in 0..4 {
            columns.extend(&graded(stops[i], stops[i + 1], c[i], column_size)[1..]);
        }
        let mut rows = vec![BOTTOM];
        for i in 0..3 {
            rows.extend(&graded(levels[i], levels[i + 1], r[i], row_size)[1..]);
        }
        let mut grid = Self {
            columns,
            rows,
            layers,
            mouth_row: r[0],
            eye_row: r[0] + r[1],
            canthi: [c[0], c[0] + c[1] + c[2]],
            corner: c[0] + c[1],
            copies: Vec::new(),
            copy_count: 0,
        };
        grid.number_copies();
        grid
    }

    fn number_copies(&mut self) {
        let across = self.across();
        self.copies = vec![NO_COPY; (across + 1) * self.rows.len()];
        for j in [self.mouth_row, self.eye_row] {
            for i in 0..=across {
                let half = i.abs_diff(across / 2);
                let open = if j == self.mouth_row {
                    half < self.corner
                } else {
                    self.canthi[0] < half && half < self.canthi[1]
                };
                if open {
                    self.copies[j * (across + 1) + i] = self.copy_count as u32;
                    self.copy_count += 1;
                }
            }
        }
    }

    /// Cells from one side to the other.
    pub fn across(&self) -> usize {
        2 * (self.columns.len() - 1)
    }

    /// Cells from the neck to the forehead.
    pub fn along(&self) -> usize {
        self.rows.len() - 1
    }

    /// Cells from the bone to the skin.
    pub fn layers(&self) -> usize {
        self.layers
    }

    /// Material `a` of a column of nodes.
    pub fn a(&self, i: usize) -> f64 {
        let middle = self.columns.len() - 1;
        if i >= middle {
            self.columns[i - middle]
        } else {
            -self.columns[middle - i]
        }
    }

    pub fn b(&self, j: usize) -> f64 {
        self.rows[j]
    }

    pub fn w(&self, k: usize) -> f64 {
        k as f64 / self.layers as f64
    }

    pub fn node_count(&self) -> usize {
        ((self.across() + 1) * self.rows.len() + self.copy_count) * (self.layers + 1)
    }

    /// Number of a node; the lower lip and lid keep the regular number.
    pub fn node(&self, i: usize, j: usize, k: usize, side: Side) -> u32 {
        let regular = j * (self.across() + 1) + i;
        let column = match (side, self.copies[regular]) {
            (Side::Lower, _) | (_, NO_COPY) => regular,
            (Side::Upper, copy) => (self.across() + 1) * self.rows.len() + copy as usize,
        };
        (column * (self.layers + 1) + k) as u32
    }

    /// Material coordinates and side of every node.
    pub fn material(&self) -> Vec<([f64; 3], Side)> {
        let mut all = vec![([0.0; 3], Side::Lower); self.node_count()];
        for j in 0..self.rows.len() {
            for i in 0..=self.across() {
                for side in [Side::Lower, Side::Upper] {
                    for k in 0..=self.layers {
                        // Without a copy both sides name one node; the side has no meaning there.
                        let node = self.node(i, j, k, side) as usize;
                        all[node] = ([self.a(i), self.b(j), self.w(k)], side);
                    }
                }
            }
        }
        all
    }

    fn cell(&self, i: usize, j: usize, k: usize) -> usize {
        (j * self.across() + i) * self.layers + k
    }

    /// Nodes of the tet that walks the edges of cell `(i, j, k)` in the order of `WALKS[walk]`.
    ///
    /// Cells of the right half are mirror images of those of the left half, tets included.
    fn tet(&self, i: usize, j: usize, k: usize, walk: usize) -> [u32; 4] {
        let left = i >= self.across() / 2;
        let corner = |at: [usize; 3]| {
            let column = if left { i + at[0] } else { i + 1 - at[0] };
            let side = if at[1] == 0 { Side::Upper } else { Side::Lower };
            self.node(column, j + at[1], k + at[2], side)
        };
        let mut at = [0; 3];
        let mut tet = [corner(at); 4];
        for (step, &axis) in WALKS[walk].iter().enumerate() {
            at[axis] = 1;
            tet[step + 1] = corner(at);
        }
        if self.swapped(i, walk) {
            tet.swap(2, 3);
        }
        tet
    }

    /// Odd walks, or even ones in the mirrored half, are negatively oriented as walked.
    fn swapped(&self, i: usize, walk: usize) -> bool {
        (walk >= 3) == (i >= self.across() / 2)
    }

    /// All tets, cell by cell.
    pub fn tets(&self) -> Vec<[u32; 4]> {
        let mut tets = Vec::with_capacity(6 * self.across() * self.along() * self.layers);
        for j in 0..self.along() {
            for i in 0..self.across() {
                for k in 0..self.layers {
                    tets.extend((0..6).map(|walk| self.tet(i, j, k, walk)));
                }
            }
        }
        tets
    }

    /// The mirror image of a tet.
    pub fn mirror_tet(&self, tet: usize) -> usize {
        let (cell, walk) = (tet / 6, tet % 6);
        let (row, k) = (cell / self.layers, cell % self.layers);
        let (j, i) = (row / self.across(), row % self.across());
        6 * self.cell(self.across() - 1 - i, j, k) + walk
    }

    /// The material point in the tet that holds it; points outside are moved to the nearest material
    /// coordinate.
    pub fn locate(&self, a: f64, b: f64, w: f64, side: Side) -> EmbeddedPoint {
        let find = |knots: &[f64], x: f64| {
            let i = knots[1..knots.len() - 1].partition_point(|&q| q <= x);
            (
                i,
                ((x - knots[i]) / (knots[i + 1] - knots[i])).clamp(0.0, 1.0),
            )
        };
        let (half, u) = find(&self.columns, a.abs());
        let (mut j, mut v) = find(&self.rows, b);
        if v == 0.0 && side == Side::Lower && j > 0 {
            (j, v) = (j - 1, 1.0);
        }
        let s = w.clamp(0.0, 1.0) * self.layers as f64;
        let k = (s as usize).min(self.layers - 1);
        let middle = self.across() / 2;
        let i = if a >= 0.0 {
            middle + half
        } else {
            middle - 1 - half
        };
        let local = [u, v, s - k as f64];
        // In a cell cut along its diagonal the tet is the order of the local coordinates, and the
        // weights are their differences.
        let mut order = [0, 1, 2];
        order.sort_by(|&p, &q| local[q].total_cmp(&local[p]));
        let walk = WALKS.iter().position(|w| *w == order).unwrap_or(0);
        let [p, q, r] = order.map(|axis| local[axis]);
        let mut weights = [1.0 - p, p - q, q - r, r];
        if self.swapped(i, walk) {
            weights.swap(2, 3);
        }
        EmbeddedPoint {
            nodes: self.tet(i, j, k, walk),
            weights,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_is_near_the_target_and_the_grid_is_graded() {
        let form = Form::new();
        for target in [5_000, 20_000, 100_000, 1_000_000] {
            let grid = Grid::with_tets(target, &form);
            let count = 6 * grid.across() * grid.along() * grid.layers();
            let off = count.abs_diff(target) as f64 / target as f64;
            assert!(off < 0.08, "{count} tets for {target}");
            assert!(grid.columns.windows(2).all(|p| p[1] > p[0]));
            assert!(grid.rows.windows(2).all(|p| p[1] > p[0]));
            assert_eq!(grid.rows[grid.mouth_row], MOUTH);
            assert_eq!(grid.rows[grid.eye_row], EYES);
        }
    }

    #[test]
    fn locating_a_node_gives_the_node_and_material_is_reproduced() {
        let form = Form::new();
        let grid = Grid::with_tets(6_000, &form);
        let tets = grid.tets();
        let material = grid.material();
        for &([a, b, w], side) in &material {
            for side in [side, Side::Upper] {
                let e = grid.locate(a, b, w, side);
                let mut sum = [0.0; 3];
                for (n, weight) in e.nodes.iter().zip(e.weights) {
                    assert!((0.0..=1.0).contains(&weight));
                    for k in 0..3 {
                        sum[k] += weight * material[*n as usize].0[k];
                    }
                }
                for (s, x) in sum.iter().zip([a, b, w]) {
                    assert!((s - x).abs() < 1e-9, "{sum:?} for {a} {b} {w}");
                }
            }
        }
        for t in 0..tets.len() {
            assert_eq!(grid.mirror_tet(grid.mirror_tet(t)), t);
        }
    }
}
