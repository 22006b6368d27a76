//! A surface that may touch itself: its points, triangles and edges with what stays as it is at rest.

use super::carrier::Carrier;
use super::geometry::{Aabb, Point, add, cross, norm, scale, sub, unit};
use super::solid::Solid;
use super::way::Way;
use crate::error::AssemblyError;
use crate::faces;
use crate::mesh::SimplexMesh;
use fem_solvers::parallel::map;

/// An edge of the surface.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    pub nodes: [u32; 2],
    /// The triangles beside it; the same twice at the surface's rim.
    pub triangles: [u32; 2],
}

/// Triangles seen counter-clockwise from outside, and what belongs to them. Vertices are the nodes of
/// the mesh, or points carried by it.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub rest: Vec<Point>,
    pub triangles: Vec<[u32; 3]>,
    pub edges: Vec<Edge>,
    /// Its vertices, ascending.
    pub points: Vec<u32>,
    /// Of each vertex: a third of the triangles around it at rest, m².
    pub area: Vec<f64>,
    /// Of each edge: a third of the triangles beside it at rest, m².
    pub edge_area: Vec<f64>,
    /// Of each vertex: the vertices within a few edges, ascending.
    near: Vec<Vec<u32>>,
    /// Of each vertex: does it lie inside other flesh at rest?
    pub buried: Vec<bool>,
}

/// Outward unit normals in some configuration.
#[derive(Clone, Debug)]
pub(crate) struct Normals {
    pub triangles: Vec<Point>,
    /// Of every vertex; 0 where it has no triangle.
    pub nodes: Vec<Point>,
    pub edges: Vec<Point>,
}

impl Surface {
    pub fn new(
        mesh: &SimplexMesh<3>,
        carrier: &Carrier,
        triangles: &[[u32; 3]],
        neighbors: usize,
    ) -> Result<Self, AssemblyError> {
        let rest = carrier.positions(mesh.nodes()).into_owned();
        let count = rest.len();
        let named = triangles.as_flattened().iter();
        if let Some(&node) = named.clone().find(|&&n| n as usize >= count) {
            let node = node as usize;
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        let mut points: Vec<u32> = named.copied().collect();
        points.sort_unstable();
        points.dedup();
        let edges = edges_of(triangles);
        let mut area = vec![0.0; count];
        let third = |t: &[u32; 3]| faces::area(t.map(|n| rest[n as usize])) / 3.0;
        let third: Vec<f64> = triangles.iter().map(third).collect();
        for (triangle, third) in triangles.iter().zip(&third) {
            triangle.iter().for_each(|&n| area[n as usize] += third);
        }
        let beside = |e: &Edge| match e.triangles {
            [a, b] if a == b => third[a as usize],
            [a, b] => third[a as usize] + third[b as usize],
        };
        let mut surface = Self {
            edge_area: edges.iter().map(beside).collect(),
            near: rings(count, &edges, neighbors),
            buried: vec![false; count],
            rest,
            triangles: triangles.to_vec(),
            edges,
            points,
            area,
        };
        surface.buried = surface.buried_vertices(mesh, carrier);
        Ok(surface)
    }

    /// The winding number of the whole boundary says it: about ½ on a surface, 1 more inside. Points
    /// that are carried lie a little on either side of it.
    fn buried_vertices(&self, mesh: &SimplexMesh<3>, carrier: &Carrier) -> Vec<bool> {
        let mut buried = vec![false; self.rest.len()];
        let faces = mesh.boundary().faces;
        let most = match carrier {
            Carrier::Nodes => 1.0,
            Carrier::Points(_) => 1.5,
        };
        // A corner of a face sees nothing of it.
        let whole = Solid::new(mesh.nodes(), &faces, f64::INFINITY);
        let winding = |&vertex: &u32| whole.winding(self.rest[vertex as usize]);
        let windings: Vec<f64> = map(self.points.iter().collect(), winding);
        for (&vertex, winding) in self.points.iter().zip(windings) {
            buried[vertex as usize] = winding > most;
        }
        buried
    }

    /// No pairs of edges: nothing of them is moved, boxed or looked at.
    pub fn drop_edges(&mut self) {
        self.edges.clear();
        self.edge_area.clear();
    }

    pub fn corners(&self, positions: &[Point], triangle: &[u32; 3]) -> [Point; 3] {
        triangle.map(|n| positions[n as usize])
    }

    /// Is some node of `others` a few edges from the node at most?
    pub fn are_neighbors(&self, node: u32, others: &[u32]) -> bool {
        let near = &self.near[node as usize];
        others.iter().any(|n| near.binary_search(n).is_ok())
    }

    pub fn normals(&self, positions: &[Point]) -> Normals {
        let mut nodes = vec![[0.0; 3]; positions.len()];
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = self.corners(positions, triangle);
            let normal = cross(sub(b, a), sub(c, a));
            triangles.push(unit(normal));
            for &n in triangle {
                nodes[n as usize] = add(nodes[n as usize], normal);
            }
        }
        let of_edge = |e: &Edge| {
            let [a, b] = e.triangles.map(|t| triangles[t as usize]);
            unit(add(a, b))
        };
        Normals {
            edges: self.edges.iter().map(of_edge).collect(),
            nodes: nodes.into_iter().map(unit).collect(),
            triangles,
        }
    }

    /// Boxes of the triangles on their way, with the bands around them.
    pub fn triangle_boxes(&self, way: &Way) -> Vec<Aabb> {
        self.triangles.iter().map(|t| around(t, way)).collect()
    }

    /// Boxes of the edges on their way, with the bands at their ends.
    pub fn edge_boxes(&self, way: &Way) -> Vec<Aabb> {
        self.edges.iter().map(|e| around(&e.nodes, way)).collect()
    }

    /// The middle of an edge.
    pub fn middle(&self, positions: &[Point], edge: usize) -> Point {
        let [a, b] = self.edges[edge].nodes.map(|n| positions[n as usize]);
        scale(add(a, b), 0.5)
    }
}

fn around(vertices: &[u32], way: &Way) -> Aabb {
    let around = Aabb::around(vertices.iter().flat_map(|&v| way.ends(v)));
    around.grown(super::pair::BAND * norm(sub(around.high, around.low)))
}

/// In lexical order of their nodes.
fn edges_of(triangles: &[[u32; 3]]) -> Vec<Edge> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (index, t) in triangles.iter().enumerate() {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            sides.push(([a.min(b), a.max(b)], index as u32));
        }
    }
    sides.sort_unstable();
    let edge = |equal: &[([u32; 2], u32)]| Edge {
        nodes: equal[0].0,
        triangles: [equal[0].1, equal[equal.len() - 1].1],
    };
    sides.chunk_by(|a, b| a.0 == b.0).map(edge).collect()
}

/// The nodes within so many edges of each node, itself included.
fn rings(count: usize, edges: &[Edge], steps: usize) -> Vec<Vec<u32>> {
    let mut beside = vec![Vec::new(); count];
    for Edge { nodes: [a, b], .. } in edges {
        beside[*a as usize].push(*b);
        beside[*b as usize].push(*a);
    }
    let of = |node: usize| {
        let mut near = vec![node as u32];
        for _ in 0..steps {
            let next = near
                .iter()
                .flat_map(|&n| beside[n as usize].iter().copied());
            let mut wider: Vec<u32> = next.chain(near.iter().copied()).collect();
            wider.sort_unstable();
            wider.dedup();
            near = wider;
        }
        near
    };
    map((0..count).collect(), of)
}
