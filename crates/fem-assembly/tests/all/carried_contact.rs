//! Flesh against flesh with a skin that the mesh carries: points a little outside it, each moved by the
//! nodes of its element.

use crate::contact::{PARAMS, Point, blocks, derivatives_hold, force, lowered, touching};
use fem_assembly::mesh::{EmbeddedPoint, SimplexMesh};
use fem_assembly::{Assembly, FleshContact, FleshContactParams};
use std::collections::BTreeMap;

/// How far outside the blocks the skin lies.
const OUTSIDE: f64 = 0.03;

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// Barycentric coordinates by volumes.
fn weights(mesh: &SimplexMesh<3>, nodes: [u32; 4], p: Point) -> [f64; 4] {
    let x = nodes.map(|n| mesh.node(n));
    let volume = |x: [Point; 4]| {
        let [a, b, c] = [1, 2, 3].map(|k| minus(x[k], x[0]));
        dot(a, cross(b, c))
    };
    std::array::from_fn(|k| {
        let mut moved = x;
        moved[k] = p;
        volume(moved) / volume(x)
    })
}

/// One point above the middle of each face of the boundary and one above each of its nodes, all of
/// them outside and carried by the face's element.
fn skin(mesh: &SimplexMesh<3>) -> (Vec<EmbeddedPoint>, Vec<[u32; 3]>) {
    let faces = mesh.boundary().faces;
    let owner = |f: &[u32; 3]| {
        mesh.tets()
            .find(|t| f.iter().all(|n| t.contains(n)))
            .unwrap()
    };
    let point = |f: &[u32; 3], x: Point| {
        let [a, b, c] = f.map(|n| mesh.node(n));
        let normal = cross(minus(b, a), minus(c, a));
        let size = dot(normal, normal).sqrt();
        let nodes = owner(f);
        let out = std::array::from_fn(|i| x[i] + OUTSIDE * normal[i] / size);
        let weights = weights(mesh, nodes, out);
        EmbeddedPoint { nodes, weights }
    };
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut of_node: BTreeMap<u32, u32> = BTreeMap::new();
    for face in &faces {
        let corners = face.map(|n| {
            *of_node.entry(n).or_insert_with(|| {
                points.push(point(face, mesh.node(n)));
                points.len() as u32 - 1
            })
        });
        let [a, b, c] = face.map(|n| mesh.node(n));
        let middle = points.len() as u32;
        points.push(point(
            face,
            std::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0),
        ));
        let [a, b, c] = corners;
        triangles.extend([[a, b, middle], [b, c, middle], [c, a, middle]]);
    }
    (points, triangles)
}

fn carried(mesh: &SimplexMesh<3>, params: FleshContactParams) -> FleshContact {
    let (points, triangles) = skin(mesh);
    FleshContact::carried(mesh, &points, &triangles, params).unwrap()
}

fn in_skin(mesh: &SimplexMesh<3>, gap: f64, pressure: f64) -> Assembly<3> {
    let params = FleshContactParams { pressure, ..PARAMS };
    touching(mesh, gap, carried(mesh, params))
}

#[test]
fn derivatives_hold_for_points_that_ride_on_elements() {
    let mesh = blocks(0.1);
    derivatives_hold(&mut in_skin(&mesh, 0.1, 1e5), &lowered(&mesh, 0.05));
}

#[test]
fn points_at_nodes_feel_what_nodes_feel() {
    let mesh = blocks(0.1);
    let faces = mesh.boundary().faces;
    let points: Vec<_> = (0..mesh.num_nodes() as u32)
        .map(EmbeddedPoint::node)
        .collect();
    let nodes = FleshContact::new(&mesh, &faces, PARAMS).unwrap();
    let points = FleshContact::carried(&mesh, &points, &faces, PARAMS).unwrap();
    let x = lowered(&mesh, 0.12);
    let [nodes, points] = [nodes, points].map(|contact| {
        let mut body = touching(&mesh, 0.1, contact);
        body.renew(body.configuration(&x, &[]).unwrap()).unwrap();
        force(&body, &x)
    });
    assert!(nodes.iter().any(|f| f.abs() > 1.0));
    assert_eq!(nodes, points);
}

#[test]
fn forces_of_a_carried_skin_add_up_to_nothing() {
    let mesh = blocks(0.1);
    let mut body = in_skin(&mesh, 0.1, 1e5);
    let x = lowered(&mesh, 0.07);
    body.renew(body.configuration(&x, &[]).unwrap()).unwrap();
    let at = body.configuration(&x, &[]).unwrap();
    let forces = body.forces_everywhere(at);
    let largest = forces
        .as_flattened()
        .iter()
        .fold(0.0_f64, |m, f| m.max(f.abs()));
    assert!(largest > 1.0, "{largest}");
    for i in 0..3 {
        let sum: f64 = forces.iter().map(|f| f[i]).sum();
        let torque: f64 = forces.iter().zip(&x).map(|(f, x)| cross(*x, *f)[i]).sum();
        assert!(sum.abs() < 1e-11 * largest && torque.abs() < 1e-11 * largest);
    }
}

#[test]
fn a_carried_skin_is_silent_at_rest_and_far_away() {
    let far = blocks(2.0);
    assert_eq!(carried(&far, PARAMS).pairs(), 0);
    // The skins are 0.01 apart at rest, and then 0.02 inside each other.
    for gap in [0.07, 0.04] {
        let mesh = blocks(gap);
        let near = in_skin(&mesh, gap, 1e5);
        let contact = carried(&mesh, PARAMS);
        assert!(contact.pairs() > 0);
        let forces = force(&near, mesh.nodes());
        assert!(forces.iter().all(|g| g.abs() < 1e-9), "{gap}");
    }
}

#[test]
fn a_point_on_a_node_that_does_not_exist_is_refused() {
    let mesh = blocks(0.1);
    let lost = [EmbeddedPoint::node(mesh.num_nodes() as u32); 3];
    assert!(FleshContact::carried(&mesh, &lost, &[[0, 1, 2]], PARAMS).is_err());
    let (points, _) = skin(&mesh);
    let beyond = [[0, 1, points.len() as u32]];
    assert!(FleshContact::carried(&mesh, &points, &beyond, PARAMS).is_err());
}
