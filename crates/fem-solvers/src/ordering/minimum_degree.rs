//! Minimum degree on a small set of vertices.

use super::Graph;

/// Orders `leaf` so that each next vertex has the fewest neighbors left, counting those outside
/// the leaf (which are eliminated later) as neighbors that stay.
pub(super) fn order_leaf(graph: &Graph, leaf: &[u32], local: &mut [u32], out: &mut [u32]) {
    let inner = leaf.len();
    for (k, &v) in leaf.iter().enumerate() {
        local[v as usize] = k as u32;
    }
    let mut halo = Vec::new();
    for &v in leaf {
        for &w in graph.of(v as usize) {
            if local[w as usize] == u32::MAX {
                local[w as usize] = (inner + halo.len()) as u32;
                halo.push(w);
            }
        }
    }
    let words = (inner + halo.len()).div_ceil(64);
    let mut rows = vec![0u64; inner * words];
    for (k, &v) in leaf.iter().enumerate() {
        for &w in graph.of(v as usize) {
            let w = local[w as usize] as usize;
            rows[k * words + w / 64] |= 1 << (w % 64);
        }
    }
    for &v in leaf.iter().chain(&halo) {
        local[v as usize] = u32::MAX;
    }

    let degree = |row: &[u64]| row.iter().map(|w| w.count_ones()).sum::<u32>();
    let mut degrees: Vec<u32> = rows.chunks(words.max(1)).map(degree).collect();
    let mut alive = vec![true; inner];
    for slot in out.iter_mut() {
        let Some(v) = (0..inner).filter(|&v| alive[v]).min_by_key(|&v| degrees[v]) else {
            break;
        };
        alive[v] = false;
        *slot = leaf[v];
        let row: Vec<u64> = rows[v * words..(v + 1) * words].to_vec();
        for w in 0..inner {
            if alive[w] && row[w / 64] >> (w % 64) & 1 == 1 {
                let other = &mut rows[w * words..(w + 1) * words];
                for (a, b) in other.iter_mut().zip(&row) {
                    *a |= b;
                }
                other[v / 64] &= !(1 << (v % 64));
                other[w / 64] &= !(1 << (w % 64));
                degrees[w] = degree(other);
            }
        }
    }
}
