//! Parts of a body that can move as a whole without any force.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::evaluations::Pass;

/// Nodes that hang together, and how they can move with nothing to stop them.
#[derive(Clone, Debug, PartialEq)]
pub struct FreePart<const D: usize> {
    /// How many free nodes hang together.
    pub nodes: usize,
    /// The first of them, in the mesh's numbering.
    pub first_node: usize,
    /// A node that no term couples to anything: it belongs to no element.
    pub alone: bool,
    /// No term gives it any stiffness, as flesh whose moduli are all 0: then what it is coupled with
    /// does not hold it, and its nodes move apart as freely as together.
    pub limp: bool,
    /// Independent motions; D (D + 1)/2 of a part that nothing holds, D of a single node.
    pub motions: Vec<RigidMotion<D>>,
}

/// A rigid motion to first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidMotion<const D: usize> {
    /// Along a unit vector.
    Translation {
        /// The direction.
        along: [f64; D],
    },
    /// About an axis, with a slide along it where that is not free of itself (a screw).
    Rotation {
        /// Unit vector; in 2D the third axis.
        axis: [f64; 3],
        /// The point of the axis nearest to the middle of the part, meters.
        through: [f64; D],
    },
}

/// Share of a part's constraints or stiffness below which a motion meets none.
const NOTHING: f64 = 1e-12;

/// What the terms with a stiffness do, node by node.
struct Resistance<const D: usize> {
    /// Does a displacement meet any force?
    resisted: Vec<bool>,
    /// ∂E/∂x, newtons.
    forces: Vec<[f64; D]>,
}

/// Translations, then rotations about `middle` over `size`: u = t + ω × (x − middle)/size, of unit size.
struct RigidMotions<const D: usize> {
    middle: [f64; D],
    size: f64,
}

impl<const D: usize> RigidMotions<D> {
    const MOTIONS: usize = D * (D + 1) / 2;

    fn of(points: impl Iterator<Item = [f64; D]> + Clone) -> Self {
        let count = points.clone().count().max(1) as f64;
        let mut middle = [0.0; D];
        for p in points.clone() {
            (0..D).for_each(|k| middle[k] += p[k] / count);
        }
        let distance = |p: [f64; D]| (0..D).map(|k| (p[k] - middle[k]).powi(2)).sum::<f64>();
        let farthest = points.map(distance).fold(0.0, f64::max).sqrt();
        let size = if farthest > 0.0 { farthest } else { 1.0 };
        Self { middle, size }
    }

    /// The axes of rotation `r`, as the pair of coordinates that it turns.
    fn turned(r: usize) -> (usize, usize) {
        [(0, 1), (1, 2), (2, 0)][r % 3]
    }

    fn motion(&self, m: usize, x: &[f64; D]) -> [f64; D] {
        let mut u = [0.0; D];
        if m < D {
            u[m] = 1.0;
        } else {
            let (i, j) = Self::turned(m - D);
            u[i] = -(x[j] - self.middle[j]) / self.size;
            u[j] = (x[i] - self.middle[i]) / self.size;
        }
        u
    }

    /// ω × v of the same combination.
    fn turned_by(&self, weights: &[f64], v: &[f64; D]) -> [f64; D] {
        let mut u = [0.0; D];
        for (r, w) in weights[D..].iter().enumerate() {
            let (i, j) = Self::turned(r);
            u[i] -= w * v[j] / self.size;
            u[j] += w * v[i] / self.size;
        }
        u
    }

    /// Motions that move no point: turning a point, or a line about itself.
    fn idle(&self, points: impl Iterator<Item = [f64; D]>) -> Vec<Vec<f64>> {
        let count = Self::MOTIONS;
        let mut gram = vec![0.0; count * count];
        for x in points {
            for i in 0..count {
                let of_i = self.motion(i, &x);
                for j in 0..count {
                    let of_j = self.motion(j, &x);
                    gram[i * count + j] += (0..D).map(|k| of_i[k] * of_j[k]).sum::<f64>();
                }
            }
        }
        null_space(gram, count, 1.0)
    }

    fn combined(&self, weights: &[f64], x: &[f64; D]) -> [f64; D] {
        let mut u = [0.0; D];
        for (m, w) in weights.iter().enumerate() {
            let one = self.motion(m, x);
            (0..D).for_each(|k| u[k] += w * one[k]);
        }
        u
    }

    /// Coefficients as a motion with a name.
    fn name(&self, weights: &[f64]) -> RigidMotion<D> {
        let mut omega = [0.0; 3];
        for (r, w) in weights[D..].iter().enumerate() {
            // (0, 1) turns about the third axis, (1, 2) about the first, (2, 0) about the second.
            omega[[2, 0, 1][r]] = w / self.size;
        }
        let rate = omega.iter().map(|o| o * o).sum::<f64>().sqrt();
        let speed = weights[..D].iter().map(|w| w * w).sum::<f64>().sqrt();
        if rate * self.size <= 1e-6 * speed {
            return RigidMotion::Translation {
                along: std::array::from_fn(|k| weights[k] / speed),
            };
        }
        let t: [f64; 3] = std::array::from_fn(|k| if k < D { weights[k] } else { 0.0 });
        let [a, b, c] = omega;
        // The nearest point of the axis: middle + ω × t / |ω|².
        let to = [
            b * t[2] - c * t[1],
            c * t[0] - a * t[2],
            a * t[1] - b * t[0],
        ];
        RigidMotion::Rotation {
            axis: omega.map(|o| o / rate),
            through: std::array::from_fn(|k| self.middle[k] + to[k] / (rate * rate)),
        }
    }
}

impl<const D: usize> Assembly<D> {
    /// The parts that can move as a whole at `at`, to first order: neither prescribed coordinates nor
    /// the curvature of any term along the motion stop them, forces within the part turning with it.
    /// Loads do not hold anything, and an obstacle that is not touched does not either.
    ///
    /// Nodes hang together where a term couples them; a prescribed node holds what is coupled to it but
    /// does not pass the hold on. A part without any stiffness is among them wherever it is prescribed.
    pub fn free_motions(&self, at: Configuration<D>) -> Vec<FreePart<D>> {
        let (part_of, anchors) = self.parts();
        let mut nodes: Vec<Vec<usize>> = vec![Vec::new(); self.rest.len()];
        for (node, &part) in part_of.iter().enumerate() {
            if self.dofs.row(node).is_some() {
                nodes[part].push(node);
            }
        }
        let held = self.resistance(at);
        let limp = |nodes: &[usize]| nodes.iter().all(|&n| !held.resisted[n]);
        let parts = nodes.iter().zip(&anchors).filter(|(n, _)| !n.is_empty());
        parts
            .filter_map(|(n, anchors)| self.free_part(at, n, anchors, limp(n), &held.forces))
            .collect()
    }

    /// The part of each node, named by one of its nodes, and the prescribed nodes coupled to each.
    fn parts(&self) -> (Vec<usize>, Vec<Vec<usize>>) {
        let mut parent: Vec<usize> = (0..self.rest.len()).collect();
        let stencils = || {
            self.summands
                .iter()
                .flat_map(|s| (0..s.stencils.count()).map(|k| s.stencils.nodes_of(k)))
        };
        let is_free = |n: &&usize| self.dofs.row(**n).is_some();
        for nodes in stencils() {
            let mut free = nodes.iter().filter(is_free);
            if let Some(&first) = free.next() {
                for &other in free {
                    let (a, b) = (root(&mut parent, first), root(&mut parent, other));
                    parent[a.max(b)] = a.min(b);
                }
            }
        }
        let mut anchors = vec![Vec::new(); self.rest.len()];
        for nodes in stencils() {
            if let Some(&first) = nodes.iter().find(is_free) {
                let part = root(&mut parent, first);
                anchors[part].extend(nodes.iter().filter(|n| !is_free(n)));
            }
        }
        let part_of = (0..parent.len()).map(|n| root(&mut parent, n)).collect();
        (part_of, anchors)
    }

    fn free_part(
        &self,
        at: Configuration<D>,
        nodes: &[usize],
        anchors: &[usize],
        limp: bool,
        forces: &[[f64; D]],
    ) -> Option<FreePart<D>> {
        let x = at.positions();
        let anchors = if limp { &[] } else { anchors };
        let rigid = RigidMotions::of(nodes.iter().chain(anchors).map(|&n| x[n]));
        let prescribed = self.prescribed_axes(nodes, anchors);
        let count = RigidMotions::<D>::MOTIONS;
        let mut gram = vec![0.0; count * count];
        for &(node, axis) in &prescribed {
            let of: Vec<f64> = (0..count)
                .map(|m| rigid.motion(m, &x[node])[axis])
                .collect();
            for i in 0..count {
                (0..count).for_each(|j| gram[i * count + j] += of[i] * of[j]);
            }
        }
        for idle in rigid.idle(nodes.iter().map(|&n| x[n])) {
            for i in 0..count {
                (0..count).for_each(|j| gram[i * count + j] += idle[i] * idle[j]);
            }
        }
        let kept = null_space(gram, count, 1.0);
        let free = self.without_stiffness(at, nodes, &rigid, kept, forces);
        let coupled = |s: &crate::plan::Summand<D>| s.stencils.nodes.contains(&nodes[0]);
        let alone = nodes.len() == 1 && !self.summands.iter().any(coupled);
        (limp || !free.is_empty()).then(|| FreePart {
            nodes: nodes.len(),
            first_node: nodes[0],
            alone,
            limp: limp && !alone,
            motions: free.iter().map(|w| rigid.name(w)).collect(),
        })
    }

    /// Where uneven displacements of all free nodes meet a force: no sum of stiffnesses that are not 0
    /// cancels for them, so only a part without any meets nothing. What meets none in a single term is a
    /// load there, whose force is left out.
    fn resistance(&self, at: Configuration<D>) -> Resistance<D> {
        let uneven = |k: usize| (0.618_033_988_749_895 * (k + 1) as f64).fract() - 0.5;
        let of = |node: usize| match self.dofs.row(node) {
            Some(_) => std::array::from_fn(|axis| uneven(node * D + axis)),
            None => [0.0; D],
        };
        let u: Vec<[f64; D]> = (0..self.rest.len()).map(of).collect();
        self.count(Pass::Product, |summand| summand.all(at.controls()));
        self.count(Pass::Gradient, |summand| summand.all(at.controls()));
        let mut held = Resistance {
            resisted: vec![false; u.len()],
            forces: vec![[0.0; D]; u.len()],
        };
        for summand in &self.summands {
            let (met, pulls) = self.everywhere_of(summand, at, &u);
            for (node, pull) in pulls.iter().enumerate() {
                if met[node] != [0.0; D] {
                    held.resisted[node] = true;
                    (0..D).for_each(|k| held.forces[node][k] += pull[k]);
                }
            }
        }
        held
    }

    /// (node, axis) of every prescribed coordinate that a part feels.
    fn prescribed_axes(&self, nodes: &[usize], anchors: &[usize]) -> Vec<(usize, usize)> {
        let mut prescribed: Vec<(usize, usize)> = anchors
            .iter()
            .flat_map(|&n| (0..D).map(move |k| (n, k)))
            .collect();
        let axes = self.dofs.prescribed_axes();
        for &node in nodes {
            let row = self.dofs.rank()[node];
            let first = axes.partition_point(|(r, _)| *r < row);
            prescribed.extend(
                axes[first..]
                    .iter()
                    .take_while(|(r, _)| *r == row)
                    .map(|(_, k)| (node, *k)),
            );
        }
        prescribed
    }

    /// Combinations of `motions` along which no term has any curvature: the second derivatives of the
    /// energy by rigid motions, u_a · K u_b + f · ½ (ω_a × u_b + ω_b × u_a), are 0 there. The second part
    /// belongs to the way around, which is no straight one; without it stresses hold what turns.
    fn without_stiffness(
        &self,
        at: Configuration<D>,
        nodes: &[usize],
        rigid: &RigidMotions<D>,
        motions: Vec<Vec<f64>>,
        forces: &[[f64; D]],
    ) -> Vec<Vec<f64>> {
        let (n, x) = (motions.len(), at.positions());
        let mut curvature = vec![0.0; n * n];
        let mut scale = 0.0_f64;
        for (b, of_b) in motions.iter().enumerate() {
            let mut u = vec![[0.0; D]; x.len()];
            for &node in nodes {
                u[node] = rigid.combined(of_b, &x[node]);
            }
            let met = self.trusted_hessian_vector_everywhere(at, &u);
            for (a, of_a) in motions.iter().enumerate() {
                let work = nodes.iter().map(|&node| {
                    let along = rigid.combined(of_a, &x[node]);
                    let [ab, ba] =
                        [(of_a, &u[node]), (of_b, &along)].map(|(w, v)| rigid.turned_by(w, v));
                    let around = |k: usize| 0.5 * (ab[k] + ba[k]) * forces[node][k];
                    (0..D)
                        .map(|k| along[k] * met[node][k] + around(k))
                        .sum::<f64>()
                });
                curvature[a * n + b] = work.sum();
            }
            // What single nodes would feel: the sums above are what is left of that.
            for (k, &node) in nodes.iter().enumerate() {
                u[node] = u[node].map(|u| if k % 2 == 0 { u } else { -u });
            }
            let apart = self.trusted_hessian_vector_everywhere(at, &u);
            let sizes = nodes.iter().flat_map(|&node| apart[node]);
            scale = sizes.fold(scale, |m, f| m.max(f.abs()));
        }
        let scale = scale * nodes.len() as f64;
        let found = null_space(curvature, n, scale);
        let whole = |w: Vec<f64>| {
            let mut sum = vec![0.0; RigidMotions::<D>::MOTIONS];
            for (w, motion) in w.iter().zip(&motions) {
                sum.iter_mut().zip(motion).for_each(|(s, m)| *s += w * m);
            }
            sum
        };
        simplified(found.into_iter().map(whole).collect(), D)
    }
}

fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

/// Orthonormal eigenvectors of a symmetric matrix with |eigenvalue| ≤ [`NOTHING`] · scale, by Jacobi's
/// rotations. `scale` is the size of what was summed in an entry, or the largest entry if that is more.
fn null_space(mut a: Vec<f64>, n: usize, scale: f64) -> Vec<Vec<f64>> {
    let scale = a.iter().fold(scale, |m, v| m.max(v.abs()));
    let mut vectors: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for _ in 0..30 {
        for (p, q) in (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q))) {
            let off = a[p * n + q];
            if off.abs() <= f64::MIN_POSITIVE {
                continue;
            }
            let theta = 0.5 * (a[q * n + q] - a[p * n + p]) / off;
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for k in 0..n {
                let (x, y) = (a[k * n + p], a[k * n + q]);
                (a[k * n + p], a[k * n + q]) = (c * x - s * y, s * x + c * y);
            }
            for k in 0..n {
                let (x, y) = (a[p * n + k], a[q * n + k]);
                (a[p * n + k], a[q * n + k]) = (c * x - s * y, s * x + c * y);
            }
            for k in 0..n {
                let (x, y) = (vectors[p][k], vectors[q][k]);
                (vectors[p][k], vectors[q][k]) = (c * x - s * y, s * x + c * y);
            }
        }
    }
    let nothing = |i: &usize| a[i * n + i].abs() <= NOTHING * scale;
    (0..n).filter(nothing).map(|i| vectors[i].clone()).collect()
}

/// The same space in reduced form, rotations first: translations come out pure where they are free.
fn simplified(mut rows: Vec<Vec<f64>>, dimension: usize) -> Vec<Vec<f64>> {
    let columns = rows.first().map_or(0, Vec::len);
    let mut done = 0;
    for column in (dimension..columns).chain(0..dimension.min(columns)) {
        let size = |r: &usize| rows[*r][column].abs();
        let best = (done..rows.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(best) = best.filter(|b| size(b) > 1e-6) else {
            continue;
        };
        rows.swap(done, best);
        let pivot: Vec<f64> = rows[done].iter().map(|v| v / rows[done][column]).collect();
        for (r, row) in rows.iter_mut().enumerate() {
            let factor = if r == done { 0.0 } else { row[column] };
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(v, p)| *v -= factor * p);
        }
        rows[done] = pivot;
        done += 1;
    }
    rows
}

/// "812 nodes from node 5 on, held by nothing: 6 free motions".
impl<const D: usize> std::fmt::Display for FreePart<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            nodes,
            first_node,
            alone,
            limp,
            motions,
        } = self;
        let count = motions.len();
        if *alone {
            return write!(
                f,
                "node {first_node} belongs to no element, and nothing holds it"
            );
        }
        if *limp {
            return write!(
                f,
                "component of {nodes} nodes (node {first_node} among them) has no stiffness at all, as \
                 where all moduli are 0: nothing holds it"
            );
        }
        write!(
            f,
            "component of {nodes} nodes (node {first_node} among them), held by "
        )?;
        if count == RigidMotions::<D>::MOTIONS {
            return write!(f, "nothing: {count} free motions");
        }
        write!(f, "too little: {count} free motions")?;
        for motion in motions {
            match motion {
                RigidMotion::Translation { along } => write!(f, "; along {along:?}")?,
                RigidMotion::Rotation { axis, through } => {
                    write!(f, "; about the axis {axis:?} through {through:?} m")?;
                }
            }
        }
        Ok(())
    }
}
