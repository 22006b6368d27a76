//! dx/dθ with contact active, against differences of full re-solves: a ball that moves with the jaw,
//! and flesh of the jaw against flesh of the cranium.

use super::promise::Rig;
use face_rig::rig::{AffineMap, Direction, Parameters, RigParams};
use fem_assembly::mesh::{EmbeddedPoint, SimplexMesh, kuhn_grid};
use fem_assembly::{
    Assembly, AssemblyBuilder, ContactPoint, Dofs, FleshContact, FleshContactParams,
    ImplicitSurface, RigidContact, RigidContactParams, RigidFrame, RigidSurface,
};
use fem_materials::StableNeoHookean;

const FLESH: StableNeoHookean = StableNeoHookean {
    mu: 1e4,
    lambda: 4e4,
};

fn params() -> RigParams {
    let mut params = RigParams::default();
    params.newton.gradient_tolerance = 1e-12;
    params
}

/// Flesh on a fixed plate (z = 0); above it, on the jaw's plate, a ball that touches it.
fn under_a_ball() -> (Assembly<3>, Vec<usize>) {
    let mesh = kuhn_grid(4, 4, 2, [0.04, 0.04, 0.02]).unwrap();
    let mut nodes = mesh.nodes().to_vec();
    // The jaw: one element far above.
    let first = nodes.len() as u32;
    for p in [
        [0.0, 0.0, 0.06],
        [0.04, 0.0, 0.06],
        [0.0, 0.04, 0.06],
        [0.0, 0.0, 0.1],
    ] {
        nodes.push(p);
    }
    let jaw: Vec<usize> = (0..4).map(|k| first as usize + k).collect();
    let faces = mesh.boundary().faces;
    let mut elements = mesh.connectivity().to_vec();
    elements.extend(first..first + 4);
    let mesh = SimplexMesh::new(nodes, elements).unwrap();
    let rest = mesh.nodes();
    let prescribed: Vec<usize> = (0..rest.len())
        .filter(|&n| rest[n][2] == 0.0 || rest[n][2] > 0.05)
        .collect();
    let ball = ImplicitSurface::Sphere {
        center: [0.021, 0.018, 0.0305],
        radius: 0.01,
    };
    let frame = RigidFrame::new(rest, &jaw).unwrap();
    let points = ContactPoint::on_faces(&mesh, &faces);
    let hard = RigidContactParams {
        activation: 1e-3,
        pressure: 1e4,
        depth: 8e-3,
    };
    let contact = RigidContact::new(
        vec![RigidSurface::Implicit(ball)],
        Some(frame),
        points,
        rest,
        hard,
    )
    .unwrap();
    let dofs = Dofs::with_prescribed_nodes(rest, &prescribed).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(FLESH)
        .unwrap();
    let assembly = builder.term(contact).unwrap().build().unwrap();
    (assembly, jaw)
}

/// Two blocks, on the cranium's and on the jaw's plate, 2 mm apart, that touch as `contact` says.
fn between_blocks(
    contact: impl Fn(&SimplexMesh<3>, FleshContactParams) -> FleshContact,
) -> (Assembly<3>, Vec<usize>) {
    let low = kuhn_grid(4, 4, 2, [0.04, 0.04, 0.02]).unwrap();
    let high = kuhn_grid(3, 3, 2, [0.03, 0.03, 0.02]).unwrap();
    let (s, c) = 0.3_f64.sin_cos();
    let moved = high.nodes().iter().map(|p| {
        [
            0.008 + c * p[0] - s * p[1],
            0.001 + s * p[0] + c * p[1],
            0.022 + p[2],
        ]
    });
    let nodes: Vec<[f64; 3]> = low.nodes().iter().copied().chain(moved).collect();
    let first = low.num_nodes() as u32;
    let above = high.connectivity().iter().map(|n| n + first);
    let elements = low.connectivity().iter().copied().chain(above).collect();
    let mesh = SimplexMesh::new(nodes, elements).unwrap();
    let rest = mesh.nodes();
    let jaw: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] > 0.0415).collect();
    let cranium: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][2] == 0.0).collect();
    let soft = FleshContactParams {
        activation: 1e-3,
        pressure: 1e4,
        depth: 6e-3,
        margin: 4e-3,
        neighbors: 2,
        edges: true,
    };
    let contact = contact(&mesh, soft);
    let dofs = Dofs::with_prescribed_nodes(rest, &[cranium, jaw.clone()].concat()).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(FLESH)
        .unwrap();
    let assembly = builder.term(contact).unwrap().build().unwrap();
    (assembly, jaw)
}

fn rig((assembly, jaw): (Assembly<3>, Vec<usize>)) -> Rig {
    Rig::new(assembly, &jaw, params()).unwrap()
}

fn pose(down: f64) -> Parameters {
    let mut pose = Parameters::rest(0);
    pose.jaw.translation = [0.0004, -0.0003, -down];
    pose.jaw.matrix[0][1] = 0.02;
    pose
}

fn columns_hold(body: impl Fn() -> (Assembly<3>, Vec<usize>), at: &Parameters) {
    let rig = &mut rig(body());
    let x = rig.solve(at).unwrap().positions();
    rig.check_afresh(body().0);
    let moved = x
        .iter()
        .zip(rig.assembly().rest())
        .map(|(x, r)| (x[2] - r[2]).abs());
    let free = |n: &usize| rig.assembly().dofs().row(*n).is_some();
    let largest = moved
        .enumerate()
        .filter(|(n, _)| free(n))
        .map(|(_, d)| d)
        .fold(0.0, f64::max);
    assert!(largest > 5e-4, "nothing touches: {largest}");
    let directions: Vec<Direction> = [2, 6, 11]
        .map(|k| Direction::Jaw(AffineMap::unit(k)))
        .to_vec();
    let columns = rig.sensitivity().unwrap().columns(&directions).unwrap();
    for (direction, column) in directions.iter().zip(&columns) {
        let Direction::Jaw(d) = direction else {
            continue;
        };
        // The curvature of a touch is continuous, its slope is not: a pair that comes in between the two
        // poses is an error of first order.
        let h = 2e-7;
        let mut solve = |t: f64| {
            let (a, b) = (at.jaw.to_array(), d.to_array());
            let mut shifted = at.clone();
            shifted.jaw = AffineMap::from_array(std::array::from_fn(|k| a[k] + t * b[k]));
            rig.solve(&shifted).unwrap().positions()
        };
        let (high, low) = (solve(h), solve(-h));
        let top = column
            .as_flattened()
            .iter()
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(top > 0.01, "{top}");
        for n in 0..x.len() {
            for i in 0..3 {
                let slope = (high[n][i] - low[n][i]) / (2.0 * h);
                assert!(
                    (slope - column[n][i]).abs() < 1e-6 * top,
                    "{slope} {}",
                    column[n][i]
                );
            }
        }
    }
}

#[test]
fn columns_hold_under_a_ball_that_moves_with_the_jaw() {
    columns_hold(under_a_ball, &pose(0.003));
}

#[test]
fn columns_hold_where_flesh_presses_flesh() {
    let with_faces = |mesh: &SimplexMesh<3>, params| {
        FleshContact::new(mesh, &mesh.boundary().faces, params).unwrap()
    };
    columns_hold(|| between_blocks(with_faces), &pose(0.004));
}

#[test]
fn a_pose_from_rest_does_not_depend_on_what_touched_before() {
    let with_faces = |mesh: &SimplexMesh<3>, params| {
        FleshContact::new(mesh, &mesh.boundary().faces, params).unwrap()
    };
    let (fresh, visited) = (
        &mut rig(between_blocks(with_faces)),
        &mut rig(between_blocks(with_faces)),
    );
    let rest = visited.equilibrium().clone();
    visited.solve(&pose(0.004)).unwrap();
    visited.start_from(rest).unwrap();
    let at = pose(0.003);
    let alone = fresh.solve(&at).unwrap().clone();
    assert_eq!(visited.solve(&at).unwrap(), &alone);
}

#[test]
fn columns_hold_where_a_carried_skin_presses_itself() {
    // A tenth of the way beyond each node, seen from the middle of the other three of an element.
    let beyond = |mesh: &SimplexMesh<3>, n: u32| {
        let nodes = mesh.tets().find(|t| t.contains(&n)).unwrap();
        let weights = nodes.map(|m| if m == n { 1.1 } else { -0.1 / 3.0 });
        EmbeddedPoint { nodes, weights }
    };
    let with_skin = |mesh: &SimplexMesh<3>, params| {
        let points: Vec<_> = (0..mesh.num_nodes() as u32)
            .map(|n| beyond(mesh, n))
            .collect();
        // As scenes have it.
        let params = FleshContactParams {
            edges: false,
            ..params
        };
        FleshContact::carried(mesh, &points, &mesh.boundary().faces, params).unwrap()
    };
    columns_hold(|| between_blocks(with_skin), &pose(0.003));
}
