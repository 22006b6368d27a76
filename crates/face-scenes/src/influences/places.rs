//! Which nodes and faces a scene means.

use super::spec::PlaceSpec;
use crate::defect::PlaceDefect;
use crate::load::Place;
use crate::names::similar;
use crate::{Region, SceneError};
use fem_assembly::mesh::{MeshFile, SimplexMesh};

/// What places are looked up in.
pub(super) struct Body<'a> {
    pub place: &'a Place<'a>,
    pub mesh: &'a SimplexMesh<3>,
    /// None for the face that the program makes.
    pub file: Option<&'a MeshFile>,
    pub regions: &'a [Region],
    pub region_of_tet: &'a [u32],
}

impl Body<'_> {
    /// The nodes that meet every condition, ascending.
    pub fn nodes(&self, field: &str, spec: &PlaceSpec) -> Result<Vec<u32>, SceneError> {
        if spec.seen_from.is_some() {
            let field = format!("{field}.seen_from");
            return Err(self.place.field(field, PlaceDefect::NodesUnseen));
        }
        let meets = self.conditions(field, spec)?;
        let nodes: Vec<u32> = (0..self.mesh.num_nodes() as u32)
            .filter(|&n| meets[n as usize])
            .collect();
        if nodes.is_empty() {
            return Err(self.place.field(field, PlaceDefect::NoNode));
        }
        Ok(nodes)
    }

    /// The faces of the boundary that meet every condition, outward.
    pub fn faces(&self, field: &str, spec: &PlaceSpec) -> Result<Vec<[u32; 3]>, SceneError> {
        let meets = self.conditions(field, spec)?;
        let mut faces = self.mesh.boundary_faces(|n| meets[n as usize]);
        if let Some(eye) = spec.seen_from {
            faces = self.seen(faces, eye.map(|c| c * self.place.scale));
        }
        if faces.is_empty() {
            return Err(self.place.field(field, PlaceDefect::NoFace));
        }
        Ok(faces)
    }

    fn conditions(&self, field: &str, spec: &PlaceSpec) -> Result<Vec<bool>, SceneError> {
        if *spec == PlaceSpec::default() {
            return Err(self.place.field(field, PlaceDefect::NoCondition));
        }
        let scale = self.place.scale;
        let count = self.mesh.num_nodes();
        let mut meets = vec![true; count];
        let mut keep = |test: &dyn Fn(usize, [f64; 3]) -> bool| {
            for (n, (meets, &x)) in meets.iter_mut().zip(self.mesh.nodes()).enumerate() {
                *meets = *meets && test(n, x);
            }
        };
        if let Some(b) = spec.inside_box {
            let inside = |x: f64, k: usize| scale * b.low[k] <= x && x <= scale * b.high[k];
            keep(&|_, x| (0..3).all(|k| inside(x[k], k)));
        }
        if let Some(s) = spec.sphere {
            if !(s.radius > 0.0) {
                let defect = PlaceDefect::Radius { radius: s.radius };
                return Err(self.place.field(format!("{field}.sphere.radius"), defect));
            }
            let square =
                |x: [f64; 3]| -> f64 { (0..3).map(|k| (x[k] - scale * s.center[k]).powi(2)).sum() };
            keep(&|_, x| square(x) <= (scale * s.radius).powi(2));
        }
        if let Some(array) = &spec.array {
            let Some(file) = self.file else {
                let field = format!("{field}.array");
                return Err(self.place.field(field, PlaceDefect::NoArrays));
            };
            let labels = file.point_integers(&array.name)?;
            keep(&|n, _| array.labels.contains(&labels[n]));
        }
        if let Some(name) = &spec.region {
            let inside = self.in_region(field, name)?;
            keep(&|n, _| inside[n]);
        }
        if let Some(nodes) = &spec.nodes {
            if let Some(&node) = nodes.iter().find(|n| **n as usize >= count) {
                let defect = PlaceDefect::UnknownNode { node, count };
                return Err(self.place.field(format!("{field}.nodes"), defect));
            }
            let mut listed = vec![false; count];
            nodes.iter().for_each(|&n| listed[n as usize] = true);
            keep(&|n, _| listed[n]);
        }
        Ok(meets)
    }

    /// Which nodes belong to an element of a region.
    fn in_region(&self, field: &str, name: &str) -> Result<Vec<bool>, SceneError> {
        let index = self.region(&format!("{field}.region"), name)?;
        let mut inside = vec![false; self.mesh.num_nodes()];
        for (tet, region) in self.mesh.tets().zip(self.region_of_tet) {
            if *region as usize == index {
                tet.iter().for_each(|&n| inside[n as usize] = true);
            }
        }
        Ok(inside)
    }

    /// The region of that name.
    pub fn region(&self, field: &str, name: &str) -> Result<usize, SceneError> {
        let found = self.regions.iter().position(|r| r.name == name);
        found.ok_or_else(|| {
            let defect = PlaceDefect::UnknownRegion {
                name: name.to_owned(),
                similar: similar(name, self.regions.iter().map(|r| r.name.as_str())),
            };
            self.place.field(field, defect)
        })
    }

    /// Those that are turned toward a point and not hidden by another face of the boundary.
    fn seen(&self, faces: Vec<[u32; 3]>, eye: [f64; 3]) -> Vec<[u32; 3]> {
        let all = self.mesh.boundary().faces;
        let corners = |face: &[u32; 3]| face.map(|n| self.mesh.node(n));
        let visible = |face: &[u32; 3]| {
            let [a, b, c] = corners(face);
            let middle: [f64; 3] = std::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0);
            let way = less(eye, middle);
            dot(cross(less(b, a), less(c, a)), way) > 0.0
                && !all
                    .iter()
                    .any(|f| f != face && crosses(middle, way, corners(f)))
        };
        faces.into_iter().filter(visible).collect()
    }
}

fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Does the way from `start` to `start + way` go through a triangle (Möller and Trumbore 1997)?
fn crosses(start: [f64; 3], way: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> bool {
    let (ab, ac) = (less(b, a), less(c, a));
    let p = cross(way, ac);
    let det = dot(ab, p);
    if det == 0.0 {
        return false;
    }
    let from = less(start, a);
    let u = dot(from, p) / det;
    let q = cross(from, ab);
    let (v, t) = (dot(way, q) / det, dot(ac, q) / det);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-9 && t < 1.0
}
