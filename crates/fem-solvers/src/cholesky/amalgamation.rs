//! Supernodes: runs of columns with (nearly) the same rows, treated as one dense panel.

use super::elimination_tree::NO_PARENT;

/// A panel: its columns in the numbering of the elimination tree, ascending.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub columns: Vec<u32>,
    pub parent: u32,
}

/// Groups postordered columns into panels, children before parents.
///
/// First maximal supernodes (same rows, no zeros stored), then children are merged into parents
/// while few explicit zeros result (Ashcraft & Grimes 1989): small panels cost more in overhead
/// than zeros cost in arithmetic.
pub(super) fn panels(parent: &[u32], count: &[u32], block_size: usize) -> Vec<Panel> {
    let Supernodes {
        owner,
        width,
        below,
        up,
    } = Supernodes::maximal(parent, count);
    let (n, m) = (parent.len(), width.len());
    let merged_into = merge(width, &below, &up, block_size);
    let root_of = |mut s: usize| {
        while merged_into[s] != NO_PARENT {
            s = merged_into[s] as usize;
        }
        s
    };
    let mut columns: Vec<Vec<u32>> = vec![Vec::new(); m];
    for j in 0..n {
        columns[root_of(owner[j] as usize)].push(j as u32);
    }
    // Renumber the survivors; parents still come after children.
    let alive: Vec<usize> = (0..m).filter(|&s| merged_into[s] == NO_PARENT).collect();
    let mut number = vec![NO_PARENT; m];
    for (k, &s) in alive.iter().enumerate() {
        number[s] = k as u32;
    }
    alive
        .iter()
        .map(|&s| Panel {
            columns: std::mem::take(&mut columns[s]),
            parent: if up[s] == NO_PARENT {
                NO_PARENT
            } else {
                number[root_of(up[s] as usize)]
            },
        })
        .collect()
}

/// Columns with the same rows, no zeros stored.
struct Supernodes {
    /// The supernode of each column.
    owner: Vec<u32>,
    /// Columns.
    width: Vec<usize>,
    /// Rows below the diagonal block.
    below: Vec<usize>,
    /// The parent.
    up: Vec<u32>,
}

impl Supernodes {
    fn maximal(parent: &[u32], count: &[u32]) -> Self {
        let n = parent.len();
        let mut first = Vec::new();
        let mut owner = vec![0u32; n];
        for j in 0..n {
            let continues = j > 0 && parent[j - 1] as usize == j && count[j - 1] == count[j] + 1;
            if !continues {
                first.push(j);
            }
            owner[j] = first.len() as u32 - 1;
        }
        let m = first.len();
        let mut width = vec![0usize; m];
        let mut below = vec![0usize; m];
        let mut up = vec![NO_PARENT; m];
        for s in 0..m {
            let end = first.get(s + 1).copied().unwrap_or(n);
            width[s] = end - first[s];
            below[s] = count[end - 1] as usize - 1;
            if parent[end - 1] != NO_PARENT {
                up[s] = owner[parent[end - 1] as usize];
            }
        }
        Self {
            owner,
            width,
            below,
            up,
        }
    }
}

/// Which parent each supernode is merged into, if any.
fn merge(mut width: Vec<usize>, below: &[usize], up: &[u32], block_size: usize) -> Vec<u32> {
    let m = width.len();
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); m];
    for s in 0..m {
        if up[s] != NO_PARENT {
            children[up[s] as usize].push(s as u32);
        }
    }
    let mut merged_into = vec![NO_PARENT; m];
    let mut zeros = vec![0usize; m];
    for p in 0..m {
        // The child that costs the fewest zeros first; stop at the first that costs too many.
        let mut candidates = std::mem::take(&mut children[p]);
        let mut kept = Vec::new();
        loop {
            let cost = |c: u32| {
                let c = c as usize;
                zeros[c] + width[c] * (width[p] + below[p] - below[c])
            };
            let Some(at) = (0..candidates.len()).min_by_key(|&k| cost(candidates[k])) else {
                break;
            };
            let c = candidates.remove(at);
            let total_zeros = zeros[p] + cost(c);
            let c = c as usize;
            let columns = width[c] + width[p];
            let stored = columns * (columns + 1) / 2 + columns * below[p];
            if !worth_merging(columns * block_size, total_zeros as f64 / stored as f64) {
                kept.push(c as u32);
                kept.append(&mut candidates);
                break;
            }
            merged_into[c] = p as u32;
            width[p] = columns;
            zeros[p] = total_zeros;
            kept.append(&mut children[c]);
        }
        children[p] = kept;
    }
    merged_into
}

/// Share of explicit zeros allowed in a panel of so many scalar columns.
fn worth_merging(columns: usize, zeros: f64) -> bool {
    let allowed = match columns {
        0..=12 => 1.0,
        13..=36 => 0.5,
        37..=96 => 0.15,
        _ => 0.05,
    };
    zeros <= allowed
}
