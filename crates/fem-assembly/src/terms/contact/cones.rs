//! Which way the items of a tree look, so that whole branches that look away are passed over.

use super::geometry::{Point, add, dot, unit};
use super::tree::{BoxTree, Node};

/// Room for rounding in products of normals.
const ROUNDED: f64 = 1e-9;

/// For each node of a tree an axis, and the product with it above which a normal has a product of at least
/// `away` with those of all items below the node; infinite where there is none.
#[derive(Clone, Debug)]
pub(crate) struct Cones(Vec<(Point, f64)>);

impl Cones {
    /// Of items with these unit normals; what looks at products below `away` needs no others.
    pub fn new(tree: &BoxTree, normals: &[Point], away: f64) -> Self {
        let cone = |node: &Node| {
            let items = || tree.order[node.start as usize..node.end as usize].iter();
            let normal = |&item: &u32| normals[item as usize];
            let axis = unit(items().map(normal).fold([0.0; 3], add));
            // Of the widest angle from the axis; a comparison with NaN takes it over, and is no cone.
            let widest = items().map(|item| dot(axis, normal(item)));
            let widest = widest.fold(1.0, |least, cos| if cos >= least { least } else { cos });
            let sine = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
            // Within acos(away) − widest of the axis, nothing below is farther than acos(away).
            let limit = away * widest + sine(away) * sine(widest);
            let closed = widest > away;
            (
                axis,
                if closed {
                    limit + ROUNDED
                } else {
                    f64::INFINITY
                },
            )
        };
        Self(tree.nodes.iter().map(cone).collect())
    }

    /// Has this normal products of at least `away` with all below a node?
    pub fn look_away(&self, node: usize, normal: Point) -> bool {
        let (axis, limit) = self.0[node];
        dot(axis, normal) > limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::contact::geometry::Aabb;

    /// Directions all around, and some that are no direction.
    #[test]
    fn what_is_passed_over_looks_away() {
        let direction = |k: usize| {
            let (turn, height) = (2.4 * k as f64, (k as f64 / 250.0) - 1.0);
            let wide = (1.0 - height * height).sqrt();
            [wide * turn.cos(), wide * turn.sin(), height]
        };
        let mut normals: Vec<Point> = (0..500).map(direction).collect();
        normals[70] = [0.0; 3];
        normals[300] = [f64::NAN; 3];
        // What lies together looks alike.
        let boxes: Vec<Aabb> = (0..500).map(|k| Aabb::around([direction(k)])).collect();
        let tree = BoxTree::new(&boxes);
        for away in [0.2, -0.3] {
            let cones = Cones::new(&tree, &normals, away);
            let mut passed = 0;
            for k in (0..500).step_by(7).filter(|&k| k != 70 && k != 300) {
                for (index, node) in tree.nodes.iter().enumerate() {
                    if cones.look_away(index, normals[k]) {
                        passed += 1;
                        let items = &tree.order[node.start as usize..node.end as usize];
                        let toward = |&item: &u32| dot(normals[item as usize], normals[k]);
                        assert!(items.iter().all(|item| toward(item) >= away));
                    }
                }
            }
            assert!(passed > 2_000, "{passed}");
        }
    }
}
