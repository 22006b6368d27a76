//! Muscles divided into bundles of fibers.

/// How far two pieces one behind the other along the fibers are apart, as a share of how far they would be
/// side by side.
const ALONG: f64 = 0.2;
/// Most rounds; a few dozen settle a muscle.
const ROUNDS: usize = 100;

/// One piece of a muscle: an element's share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where it is, meters.
    pub center: [f64; 3],
    /// Its fibers, of length 1.
    pub direction: [f64; 3],
}

impl Piece {
    /// |d|² − (1 − s²)(f·d)²: the square of the distance to a point, lengths along the fibers scaled by s.
    fn square_to(&self, point: [f64; 3]) -> f64 {
        let d: [f64; 3] = std::array::from_fn(|i| self.center[i] - point[i]);
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        let along = dot(self.direction, d);
        dot(d, d) - (1.0 - ALONG * ALONG) * along * along
    }
}

/// The bundle of every piece, numbered from 0: at most `count`, none of them empty. Fibers contract
/// together with those before and behind them, so what is near is measured with lengths along them a fifth
/// as long: a strap is cut lengthwise, a broad sheet of long fibers two by two, a ring into sectors. The
/// same pieces give the same bundles.
///
/// Lloyd's rounds from starts that are as far from each other as can be.
pub fn bundles(pieces: &[Piece], count: usize) -> Vec<usize> {
    let mut own = vec![0; pieces.len()];
    if count < 2 || pieces.len() < 2 {
        return own;
    }
    let mut centers = vec![farthest(pieces, &[mean(pieces.iter())])];
    while centers.len() < count.min(pieces.len()) {
        centers.push(farthest(pieces, &centers));
    }
    for _ in 0..ROUNDS {
        let nearest: Vec<usize> = pieces.iter().map(|p| nearest(p, &centers)).collect();
        let settled = nearest == own;
        own = nearest;
        if settled {
            break;
        }
        for (bundle, center) in centers.iter_mut().enumerate() {
            let mut of_bundle = (pieces.iter().zip(&own).filter(|(_, b)| **b == bundle)).peekable();
            if of_bundle.peek().is_some() {
                *center = mean(of_bundle.map(|(piece, _)| piece));
            }
        }
    }
    without_gaps(own, &order(&centers))
}

fn mean<'a>(pieces: impl Iterator<Item = &'a Piece>) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for piece in pieces {
        (0..3).for_each(|i| sum[i] += piece.center[i]);
        count += 1.0;
    }
    sum.map(|s| s / count)
}

/// The piece that is farthest from all of the points.
fn farthest(pieces: &[Piece], from: &[[f64; 3]]) -> [f64; 3] {
    let apart = |p: &Piece| (from.iter().map(|c| p.square_to(*c))).fold(f64::INFINITY, f64::min);
    let most = pieces.iter().max_by(|a, b| apart(a).total_cmp(&apart(b)));
    most.map_or([0.0; 3], |piece| piece.center)
}

fn nearest(piece: &Piece, centers: &[[f64; 3]]) -> usize {
    let by = |a: &usize, b: &usize| {
        let square = |c: usize| piece.square_to(centers[c]);
        square(*a).total_cmp(&square(*b))
    };
    (0..centers.len()).min_by(by).unwrap_or(0)
}

/// The places in the order of the axis along which they lie farthest apart.
fn order(centers: &[[f64; 3]]) -> Vec<usize> {
    let along = |axis: usize| centers.iter().map(move |c| c[axis]);
    let spread = |axis: &usize| {
        let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
        along(*axis).fold(high, f64::max) - along(*axis).fold(low, f64::min)
    };
    let widest = (0..3).max_by(|a, b| spread(a).total_cmp(&spread(b)));
    let axis = widest.unwrap_or(0);
    let mut order: Vec<usize> = (0..centers.len()).collect();
    order.sort_by(|a, b| centers[*a][axis].total_cmp(&centers[*b][axis]));
    order
}

/// Numbers those that have a piece by their place in `order`.
fn without_gaps(own: Vec<usize>, order: &[usize]) -> Vec<usize> {
    let used = order.iter().filter(|bundle| own.contains(bundle));
    let mut number = vec![0; order.len()];
    (used.enumerate()).for_each(|(new, &bundle)| number[bundle] = new);
    own.into_iter().map(|bundle| number[bundle]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strap along z, `wide` pieces beside each other, `long` behind each other, 1 mm apart.
    fn strap(wide: usize, long: usize) -> Vec<Piece> {
        let piece = |k: usize| Piece {
            center: [1e-3 * (k % wide) as f64, 0.0, 1e-3 * (k / wide) as f64],
            direction: [0.0, 0.0, 1.0],
        };
        (0..wide * long).map(piece).collect()
    }

    #[test]
    fn a_strap_is_cut_lengthwise() {
        // Twice as long as wide: by plain distances it would be cut across.
        let own = bundles(&strap(6, 12), 3);
        for (k, bundle) in own.iter().enumerate() {
            assert_eq!(*bundle, (k % 6) / 2, "piece {k}");
        }
    }

    #[test]
    fn a_ring_falls_into_sectors() {
        let piece = |k: usize| {
            let angle = std::f64::consts::TAU * (k as f64 + 0.5) / 40.0;
            Piece {
                center: [0.02 * angle.cos(), 0.02 * angle.sin(), 0.0],
                direction: [-angle.sin(), angle.cos(), 0.0],
            }
        };
        let pieces: Vec<Piece> = (0..40).map(piece).collect();
        let own = bundles(&pieces, 4);
        // Each bundle is one run of the ring.
        let changes = (0..40).filter(|&k| own[k] != own[(k + 1) % 40]).count();
        assert_eq!(changes, 4, "{own:?}");
        (0..4).for_each(|b| assert!(own.contains(&b)));
    }

    #[test]
    fn no_bundle_is_empty_and_none_are_asked_for_in_vain() {
        assert_eq!(bundles(&strap(3, 2), 1), [0; 6]);
        assert_eq!(bundles(&[], 4), [0; 0]);
        // Two places for four bundles.
        let twice = [strap(2, 1), strap(2, 1)].concat();
        assert_eq!(bundles(&twice, 4), [0, 1, 0, 1]);
    }
}
