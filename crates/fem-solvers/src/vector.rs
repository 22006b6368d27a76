//! Sums over long slices in a fixed order.

use crate::parallel::{each, map};

/// Entries per partial sum; the cut does not depend on the number of threads.
const CHUNK: usize = 4096;
/// Length from which the partial sums are worth a second thread.
const PARALLEL: usize = 200_000;

fn dot_chunk(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a8, a_rest) = a.as_chunks::<8>();
    let (b8, b_rest) = b.as_chunks::<8>();
    for (x, y) in a8.iter().zip(b8) {
        for k in 0..8 {
            lanes[k] += x[k] * y[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5]))
        + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]))
        + rest
}

/// `aᵀ b`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() >= PARALLEL {
        let chunks = a.chunks(CHUNK).zip(b.chunks(CHUNK)).collect();
        let partial: Vec<f64> = map(chunks, |(x, y)| dot_chunk(x, y));
        partial.iter().sum()
    } else {
        a.chunks(CHUNK)
            .zip(b.chunks(CHUNK))
            .map(|(x, y)| dot_chunk(x, y))
            .sum()
    }
}

/// Length from which passes that read and write several vectors are worth a second thread.
const PARALLEL_PASS: usize = 32_768;

/// One step of conjugate gradients, `x += alpha · p / scale`, `r −= alpha · ap`, in one pass; returns `rᵀ r`.
pub(crate) fn step(
    (alpha, scale): (f64, f64),
    (p, ap): (&[f64], &[f64]),
    (x, r): (&mut [f64], &mut [f64]),
) -> f64 {
    let parallel = r.len() >= PARALLEL_PASS;
    let read = p.chunks(CHUNK).zip(ap.chunks(CHUNK));
    let written = x.chunks_mut(CHUNK).zip(r.chunks_mut(CHUNK));
    let parts = read
        .zip(written)
        .map(|((p, ap), (x, r))| Part { p, ap, x, r });
    let pass = |Part { p, ap, x, r }: Part<'_>| {
        if scale == 1.0 {
            axpy(alpha, p, x);
        } else {
            for (x, p) in x.iter_mut().zip(p) {
                *x += alpha * p / scale;
            }
        }
        axpy(-alpha, ap, r);
        dot_chunk(r, r)
    };
    if parallel {
        let partial: Vec<f64> = map(parts.collect(), pass);
        partial.iter().sum()
    } else {
        parts.map(pass).sum()
    }
}

/// What a step reads and writes of one chunk.
struct Part<'a> {
    p: &'a [f64],
    ap: &'a [f64],
    x: &'a mut [f64],
    r: &'a mut [f64],
}

/// `p ← z + beta · p`.
pub(crate) fn turn(beta: f64, z: &[f64], p: &mut [f64]) {
    let pass = |(z, p): (&[f64], &mut [f64])| {
        for (p, z) in p.iter_mut().zip(z) {
            *p = z + beta * *p;
        }
    };
    if p.len() >= PARALLEL_PASS {
        each(z.chunks(CHUNK).zip(p.chunks_mut(CHUNK)), pass);
    } else {
        pass((z, p));
    }
}

/// Euclidean norm.
pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Largest absolute entry; NaN if there is one.
pub(crate) fn norm_inf(a: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (eights, rest) = a.as_chunks::<8>();
    // A comparison that fails for NaN keeps it: whatever is not at most the largest replaces it.
    let larger = |largest: &mut f64, v: f64| {
        let size = v.abs();
        *largest = if size <= *largest || largest.is_nan() {
            *largest
        } else {
            size
        };
    };
    for eight in eights {
        for (largest, v) in lanes.iter_mut().zip(eight) {
            larger(largest, *v);
        }
    }
    let mut largest = 0.0;
    lanes
        .iter()
        .chain(rest)
        .for_each(|v| larger(&mut largest, *v));
    largest
}

/// `y += a x`.
pub(crate) fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Index of the first entry that is not finite.
pub(crate) fn first_non_finite(a: &[f64]) -> Option<usize> {
    a.iter().position(|v| !v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::{PARALLEL_PASS, norm_inf, step, turn};

    #[test]
    fn what_is_no_number_is_larger_than_all() {
        assert_eq!(norm_inf(&[1.0, -3.0, 2.0]), 3.0);
        for place in 0..3 {
            let mut entries = [1.0, -3.0, f64::INFINITY];
            entries[place] = f64::NAN;
            assert!(norm_inf(&entries).is_nan(), "{place}");
        }
    }

    #[test]
    fn passes_of_conjugate_gradients_are_what_they_say_at_every_length() {
        for n in [5, 5_000, PARALLEL_PASS + 777] {
            let wave = |k: usize| (0..n).map(|i| ((k + i) as f64).sin()).collect::<Vec<_>>();
            let (p, ap, z) = (wave(1), wave(2), wave(3));
            for scale in [1.0, 0.125] {
                let (mut x, mut r) = (wave(4), wave(5));
                let squares = step((0.5, scale), (&p, &ap), (&mut x, &mut r));
                let (before, left) = (wave(4), wave(5));
                assert!((0..n).all(|i| x[i] == before[i] + 0.5 * p[i] / scale));
                assert!((0..n).all(|i| r[i] == left[i] - 0.5 * ap[i]));
                let sum: f64 = r.iter().map(|r| r * r).sum();
                assert!((squares - sum).abs() < 1e-12 * sum);
            }
            let mut turned = p.clone();
            turn(0.25, &z, &mut turned);
            assert!((0..n).all(|i| turned[i] == z[i] + 0.25 * p[i]));
        }
    }
}
