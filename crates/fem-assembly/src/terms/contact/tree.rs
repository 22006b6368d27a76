//! A tree of boxes: built once, fitted again when what it holds has moved.

use super::geometry::Aabb;

/// Items in a leaf.
const LEAF: usize = 4;

/// The items `order[start..end]` and, unless it is a leaf, two halves: the next node and `right`.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub start: u32,
    pub end: u32,
    pub right: u32,
    pub around: Aabb,
}

/// Boxes, halved again and again at the median of their centers along the longest side.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree {
    pub order: Vec<u32>,
    pub nodes: Vec<Node>,
}

impl BoxTree {
    pub fn new(boxes: &[Aabb]) -> Self {
        let mut tree = Self {
            order: (0..boxes.len() as u32).collect(),
            nodes: Vec::new(),
        };
        if !boxes.is_empty() {
            tree.split(boxes, 0, boxes.len());
        }
        tree.fit(boxes);
        tree
    }

    fn split(&mut self, boxes: &[Aabb], start: usize, end: usize) {
        let items = &mut self.order[start..end];
        let around = Aabb::around(items.iter().map(|&k| boxes[k as usize].center()));
        let index = self.nodes.len();
        self.nodes.push(Node {
            start: start as u32,
            end: end as u32,
            right: 0,
            around,
        });
        if end - start <= LEAF {
            return;
        }
        let extent = |i: &usize| around.high[*i] - around.low[*i];
        let longest = |a: &usize, b: &usize| extent(a).total_cmp(&extent(b));
        let axis = (0..3).max_by(longest).unwrap_or(0);
        let key = |k: u32| boxes[k as usize].center()[axis];
        items.sort_unstable_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        let middle = start.midpoint(end);
        self.split(boxes, start, middle);
        self.nodes[index].right = self.nodes.len() as u32;
        self.split(boxes, middle, end);
    }

    /// Takes new boxes of the same items.
    pub fn fit(&mut self, boxes: &[Aabb]) {
        for index in (0..self.nodes.len()).rev() {
            let node = &self.nodes[index];
            let around = if node.right == 0 {
                let items = &self.order[node.start as usize..node.end as usize];
                let none = Aabb::around([]);
                items
                    .iter()
                    .fold(none, |b, &k| b.joined(&boxes[k as usize]))
            } else {
                let right = &self.nodes[node.right as usize];
                self.nodes[index + 1].around.joined(&right.around)
            };
            self.nodes[index].around = around;
        }
    }

    /// The items of all leaves that a box overlaps, ascending.
    pub fn near(&self, wanted: &Aabb) -> Vec<u32> {
        let mut found = Vec::new();
        self.visit(wanted, &mut |item| found.push(item));
        found.sort_unstable();
        found
    }

    /// The same in the order of the tree.
    pub fn visit(&self, wanted: &Aabb, found: &mut impl FnMut(u32)) {
        self.visit_where(wanted, &|_| true, found);
    }

    /// Below the nodes that are `wanted` too, by their index.
    pub fn visit_where(
        &self,
        around: &Aabb,
        wanted: &impl Fn(usize) -> bool,
        found: &mut impl FnMut(u32),
    ) {
        if !self.nodes.is_empty() {
            self.visit_below(0, around, wanted, found);
        }
    }

    fn visit_below(
        &self,
        index: usize,
        around: &Aabb,
        wanted: &impl Fn(usize) -> bool,
        found: &mut impl FnMut(u32),
    ) {
        let node = &self.nodes[index];
        if !node.around.overlaps(around) || !wanted(index) {
            return;
        }
        if node.right == 0 {
            let items = &self.order[node.start as usize..node.end as usize];
            items.iter().for_each(|&item| found(item));
        } else {
            self.visit_below(index + 1, around, wanted, found);
            self.visit_below(node.right as usize, around, wanted, found);
        }
    }
}
