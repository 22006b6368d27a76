//! An undirected graph in compressed rows.

use crate::block_matrix::BlockPattern;

/// Neighbors of every vertex, without the vertex itself, ascending.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    pub start: Vec<usize>,
    pub neighbors: Vec<u32>,
}

impl Graph {
    /// The graph of a symmetric pattern.
    pub fn of_pattern(pattern: &BlockPattern) -> Self {
        let n = pattern.blocks();
        let mut start = vec![0; n + 1];
        for i in 0..n {
            for &j in pattern.row(i) {
                if (j as usize) < i {
                    start[i + 1] += 1;
                    start[j as usize + 1] += 1;
                }
            }
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut neighbors = vec![0; start[n]];
        // Row by row, each vertex meets its smaller neighbors in its own row before any larger one.
        for i in 0..n {
            for &j in pattern.row(i) {
                let j = j as usize;
                if j < i {
                    neighbors[next[i]] = j as u32;
                    next[i] += 1;
                    neighbors[next[j]] = i as u32;
                    next[j] += 1;
                }
            }
        }
        Self { start, neighbors }
    }

    /// The graph without the edges of some vertices.
    pub fn isolating(self, vertices: &[usize]) -> Self {
        if vertices.is_empty() {
            return self;
        }
        let mut alone = vec![false; self.len()];
        vertices.iter().for_each(|&v| alone[v] = true);
        let mut start = Vec::with_capacity(self.start.len());
        let mut neighbors = Vec::with_capacity(self.neighbors.len());
        start.push(0);
        for v in 0..self.len() {
            if !alone[v] {
                neighbors.extend(self.of(v).iter().filter(|w| !alone[**w as usize]));
            }
            start.push(neighbors.len());
        }
        Self { start, neighbors }
    }

    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub fn of(&self, v: usize) -> &[u32] {
        &self.neighbors[self.start[v]..self.start[v + 1]]
    }

    /// The graph induced on `vertices` (ascending); vertex `k` of the result is `vertices[k]`.
    pub fn induced(&self, vertices: &[u32], local: &mut [u32]) -> Self {
        for (k, &v) in vertices.iter().enumerate() {
            local[v as usize] = k as u32;
        }
        let mut start = Vec::with_capacity(vertices.len() + 1);
        let mut neighbors = Vec::new();
        start.push(0);
        for &v in vertices {
            neighbors.extend(
                self.of(v as usize)
                    .iter()
                    .map(|&w| local[w as usize])
                    .filter(|&w| w != u32::MAX),
            );
            start.push(neighbors.len());
        }
        for &v in vertices {
            local[v as usize] = u32::MAX;
        }
        Self { start, neighbors }
    }

    /// Breadth-first distance from `root`; `u32::MAX` where it does not reach. The last vertex
    /// reached is returned too.
    pub fn distances(&self, root: usize) -> (Vec<u32>, usize) {
        let mut distance = vec![u32::MAX; self.len()];
        let mut queue = Vec::with_capacity(self.len());
        distance[root] = 0;
        queue.push(root as u32);
        let mut head = 0;
        while head < queue.len() {
            let v = queue[head] as usize;
            head += 1;
            for &w in self.of(v) {
                if distance[w as usize] == u32::MAX {
                    distance[w as usize] = distance[v] + 1;
                    queue.push(w);
                }
            }
        }
        (distance, queue[queue.len() - 1] as usize)
    }

    /// Connected components, each ascending.
    pub fn components(&self) -> Vec<Vec<u32>> {
        let mut label = vec![u32::MAX; self.len()];
        let mut count = 0;
        let mut stack = Vec::new();
        for root in 0..self.len() {
            if label[root] != u32::MAX {
                continue;
            }
            label[root] = count;
            stack.push(root);
            while let Some(v) = stack.pop() {
                for &w in self.of(v) {
                    if label[w as usize] == u32::MAX {
                        label[w as usize] = count;
                        stack.push(w as usize);
                    }
                }
            }
            count += 1;
        }
        let mut components = vec![Vec::new(); count as usize];
        for (v, &c) in label.iter().enumerate() {
            components[c as usize].push(v as u32);
        }
        components
    }
}
