//! The points of the flesh that a rigid solid is tested with.

use super::geometry::{Aabb, Point, nearest_on_triangle, norm, sub};
use super::tree::BoxTree;
use crate::faces::area;
use crate::mesh::{EmbeddedPoint, SimplexMesh};
use std::collections::BTreeMap;

/// A point of the flesh with its share of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Where it rides.
    pub point: EmbeddedPoint,
    /// Area at rest that presses there, m².
    pub area: f64,
}

impl ContactPoint {
    /// Its place, meters; NaN as [`EmbeddedPoint::position`] is.
    pub fn position(&self, positions: &[[f64; 3]]) -> [f64; 3] {
        self.point.position(positions)
    }

    /// The nodes of its element.
    pub fn nodes(&self) -> [usize; 4] {
        self.point.nodes.map(|n| n as usize)
    }

    /// Corners, edge middles and centers of faces of the boundary, with the shares 1/20, 2/15 and
    /// 9/20 of the faces' areas: ∫ over a flat face is exact for cubic functions. Faces that are none
    /// of the boundary are left out.
    pub fn on_faces(mesh: &SimplexMesh<3>, faces: &[[u32; 3]]) -> Vec<Self> {
        let owners = owners(mesh);
        let mut shares: BTreeMap<Vec<u32>, (usize, f64)> = BTreeMap::new();
        for face in faces {
            let Some(&element) = owners.get(&sorted(*face)) else {
                continue;
            };
            let area = area(face.map(|n| mesh.node(n)));
            let [a, b, c] = sorted(*face);
            let places = [
                vec![a],
                vec![b],
                vec![c],
                vec![a, b],
                vec![a, c],
                vec![b, c],
                vec![a, b, c],
            ];
            for place in places {
                let share = match place.len() {
                    1 => 1.0 / 20.0,
                    2 => 2.0 / 15.0,
                    _ => 9.0 / 20.0,
                };
                shares.entry(place).or_insert((element, 0.0)).1 += share * area;
            }
        }
        let point = |(place, (element, area)): (Vec<u32>, (usize, f64))| {
            let nodes = mesh.tet(element);
            let of = |n: u32| {
                if place.contains(&n) {
                    1.0 / place.len() as f64
                } else {
                    0.0
                }
            };
            let weights = nodes.map(of);
            Self {
                point: EmbeddedPoint { nodes, weights },
                area,
            }
        };
        shares.into_iter().map(point).collect()
    }

    /// Given points on or near these faces: the area of each face is shared by the points that are
    /// nearest to it, faces without any have points of their own.
    pub fn carried(
        mesh: &SimplexMesh<3>,
        faces: &[[u32; 3]],
        points: impl IntoIterator<Item = EmbeddedPoint>,
    ) -> Vec<Self> {
        let corners: Vec<[Point; 3]> = faces.iter().map(|f| f.map(|n| mesh.node(n))).collect();
        let boxes: Vec<Aabb> = corners.iter().map(|t| Aabb::around(*t)).collect();
        let tree = BoxTree::new(&boxes);
        let mut counts = vec![0_usize; faces.len()];
        let mut found = Vec::new();
        for point in points {
            let x = point.position(mesh.nodes());
            // Points lie on the surface but for what the mesh is coarser by.
            let size = point
                .nodes
                .iter()
                .map(|&n| norm(sub(mesh.node(n), x)))
                .fold(0.0, f64::max);
            let away = |&k: &u32| norm(sub(x, nearest_on_triangle(x, corners[k as usize])));
            let near = tree.near(&Aabb::around([x]).grown(size));
            let Some(face) = near.into_iter().min_by(|a, b| away(a).total_cmp(&away(b))) else {
                continue;
            };
            counts[face as usize] += 1;
            let area = area(corners[face as usize]);
            found.push((face, Self { point, area }));
        }
        let shared = |(face, point): &(u32, Self)| Self {
            area: point.area / counts[*face as usize] as f64,
            ..*point
        };
        let mut all: Vec<Self> = found.iter().map(shared).collect();
        let bare = faces.iter().zip(&counts).filter(|(_, count)| **count == 0);
        let bare: Vec<[u32; 3]> = bare.map(|(face, _)| *face).collect();
        all.extend(Self::on_faces(mesh, &bare));
        all
    }
}

fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// The last element of each face.
fn owners(mesh: &SimplexMesh<3>) -> BTreeMap<[u32; 3], usize> {
    let faces = mesh.tets().enumerate().flat_map(|(element, t)| {
        let without = move |k: usize| [t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]];
        (0..4).map(move |k| (sorted(without(k)), element))
    });
    faces.collect()
}
