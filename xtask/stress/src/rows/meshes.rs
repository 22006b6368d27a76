//! Poisoned meshes, and bodies that look odd but are fine.

use crate::body::{Body, apart};
use crate::named::Named;
use crate::row::{Evidence, Settings};
use crate::{Expected, Failure, Row};
use fem_assembly::mesh::{Orientation, Orphans, SimplexMesh, kuhn_grid};
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};

type Points = Vec<[f64; 3]>;

const TET: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The rows.
pub fn rows() -> Vec<Row> {
    refused().into_iter().chain(bodies()).collect()
}

/// Meshes that are refused.
fn refused() -> Vec<Row> {
    let row = |name: &str, what: &str, kind, nodes: Points, tets: Vec<u32>| {
        Row::new("input", name, what, Expected::Error(kind), move |_| {
            SimplexMesh::<3>::new(nodes.clone(), tets.clone())?;
            Ok(Evidence::default())
        })
    };
    let with = |n: usize, p: [f64; 3]| {
        let mut nodes = TET.to_vec();
        nodes[n] = p;
        nodes
    };
    let more = |p: [f64; 3]| [TET.to_vec(), vec![p]].concat();
    let tet = || vec![0, 1, 2, 3];
    vec![
        row(
            "input-empty-mesh",
            "a mesh without elements",
            "MeshError::Empty",
            TET.to_vec(),
            vec![],
        ),
        row(
            "input-no-nodes",
            "an element and no nodes",
            "MeshError::IndexOutOfRange",
            vec![],
            tet(),
        ),
        row(
            "input-ragged",
            "five node indices",
            "MeshError::RaggedConnectivity",
            more([1.0; 3]),
            vec![0, 1, 2, 3, 4],
        ),
        row(
            "input-nan-node",
            "a coordinate that is NaN",
            "MeshError::NotFinite",
            with(1, [f64::NAN, 0.0, 0.0]),
            tet(),
        ),
        row(
            "input-infinite-node",
            "a coordinate that is infinite",
            "MeshError::NotFinite",
            with(1, [f64::INFINITY, 0.0, 0.0]),
            tet(),
        ),
        row(
            "input-node-twice-in-element",
            "an element that names a node twice",
            "MeshError::RepeatedNode",
            TET.to_vec(),
            vec![0, 1, 2, 2],
        ),
        row(
            "input-element-twice",
            "an element twice",
            "MeshError::Duplicate",
            TET.to_vec(),
            vec![0, 1, 2, 3, 0, 1, 2, 3],
        ),
        row(
            "input-node-in-place-of-another",
            "two nodes in one place",
            "MeshError::ZeroVolume",
            with(3, TET[0]),
            tet(),
        ),
        row(
            "input-unused-node",
            "a node of no element",
            "MeshError::Orphan",
            more([2.0; 3]),
            tet(),
        ),
        row(
            "input-inverted-rest",
            "an element inside out at rest",
            "MeshError::NegativeVolume",
            TET.to_vec(),
            vec![0, 2, 1, 3],
        ),
        row(
            "input-denormal-size",
            "an element of 1e-310 m",
            "MeshError::ZeroVolume",
            TET.map(|p| p.map(|c| 1e-310 * c)).to_vec(),
            tet(),
        ),
        row(
            "input-huge-size",
            "an element of 1e160 m",
            "MeshError::ZeroVolume",
            TET.map(|p| p.map(|c| 1e160 * c)).to_vec(),
            tet(),
        ),
    ]
}

/// Bodies that are odd.
fn bodies() -> Vec<Row> {
    let answer = Expected::Answer;
    vec![
        Row::new(
            "input",
            "input-one-tet",
            "a body of one element, one node free",
            answer,
            |settings| {
                let mesh = SimplexMesh::new(TET.to_vec(), vec![0, 1, 2, 3])?;
                let body = Body::new(mesh, Named::elastic("neo_hookean", 1e4, 0.4));
                let body = body.holding(|p| p[2] == 0.0);
                back(&body, body.placed(|p| p, |_| [0.3, -0.2, 1.7]), settings)
            },
        ),
        Row::new(
            "input",
            "input-one-tet-all-held",
            "a body without unknowns",
            answer,
            |settings| {
                let mesh = SimplexMesh::new(TET.to_vec(), vec![0, 1, 2, 3])?;
                let body = Body::new(mesh, Named::elastic("neo_hookean", 1e4, 0.4));
                let body = body.holding(|_| true);
                back(&body, TET.to_vec(), settings)
            },
        ),
        Row::new(
            "input",
            "input-two-bodies",
            "two blocks that nothing joins, both held",
            answer,
            |settings| {
                let body = two_blocks()?.holding(|p| p[2] == 0.0);
                back(
                    &body,
                    body.placed(|p| p, |p| [p[0], p[1], 1.2 * p[2]]),
                    settings,
                )
            },
        ),
        Row::new(
            "input",
            "input-two-bodies-one-held",
            "two blocks that nothing joins, one held: named before a solve",
            Expected::Property,
            |_| {
                let body = two_blocks()?.holding(|p| p[2] == 0.0 && p[0] <= 1.0);
                let assembly = body.assembly()?;
                let parts =
                    assembly.free_motions(assembly.configuration(body.mesh().nodes(), &[])?);
                match parts.as_slice() {
                    [part] if part.motions.len() == 6 => Ok(Evidence::holds(part.to_string())),
                    parts => Err(Failure::lie(format!("{parts:?}"))),
                }
            },
        ),
        Row::new(
            "input",
            "input-unused-node-held",
            "a node of no element that was allowed, and held",
            answer,
            |settings| {
                let nodes = [TET.to_vec(), vec![[5.0, 5.0, 0.0]]].concat();
                let (mesh, _) = SimplexMesh::with_repairs(
                    nodes,
                    vec![0, 1, 2, 3],
                    Orientation::Refuse,
                    Orphans::Allow,
                )?;
                let body = Body::new(mesh, Named::elastic("neo_hookean", 1e4, 0.4))
                    .holding(|p| p[2] == 0.0);
                back(&body, body.placed(|p| p, |_| [0.3, -0.2, 1.7]), settings)
            },
        ),
        Row::new(
            "input",
            "input-inverted-rest-repaired",
            "an element inside out at rest, repaired where that was asked",
            answer,
            |settings| {
                let (mesh, _) = SimplexMesh::with_repairs(
                    TET.to_vec(),
                    vec![0, 2, 1, 3],
                    Orientation::Repair,
                    Orphans::Refuse,
                )?;
                let body = Body::new(mesh, Named::elastic("neo_hookean", 1e4, 0.4))
                    .holding(|p| p[2] == 0.0);
                back(&body, body.placed(|p| p, |_| [0.3, -0.2, 1.7]), settings)
            },
        ),
        Row::new(
            "input",
            "input-free-body",
            "a block that nothing holds, turned and moved: rest is rest anywhere",
            answer,
            |settings| {
                let body = Body::block([2; 3], [1.0; 3], Named::elastic("neo_hookean", 1e4, 0.4))?;
                Ok(body
                    .solve(
                        body.placed(|p| p, |p| [3.0 - p[1], p[0], p[2] + 7.0]),
                        settings,
                        100,
                    )?
                    .evidence)
            },
        ),
        Row::new(
            "input",
            "input-wrong-length",
            "positions of another mesh",
            Expected::Error("AssemblyError::WrongLength"),
            |_| {
                let mesh = kuhn_grid(1, 1, 1, [1.0; 3])?;
                let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0])?;
                let assembly = AssemblyBuilder::new(&mesh, dofs)?.build()?;
                Quasistatic::new(&assembly, TET.to_vec(), vec![])?;
                Ok(Evidence::default())
            },
        ),
    ]
}

fn two_blocks() -> Result<Body, Failure> {
    let one = kuhn_grid(2, 2, 2, [1.0; 3])?;
    let shifted = one.nodes().iter().map(|p| [p[0] + 3.0, p[1], p[2]]);
    let nodes: Points = one.nodes().iter().copied().chain(shifted).collect();
    let first = one.num_nodes() as u32;
    let tets = one.connectivity().iter().copied();
    let tets = tets.chain(one.connectivity().iter().map(|n| n + first));
    let mesh = SimplexMesh::new(nodes, tets.collect())?;
    Ok(Body::new(mesh, Named::elastic("neo_hookean", 1e4, 0.4)))
}

/// Solves, and must come back to rest.
pub fn back(body: &Body, from: Points, settings: &Settings) -> Result<Evidence, Failure> {
    let solved = body.solve(from, settings, 100)?;
    let off = apart(&solved.positions, body.mesh().nodes());
    Ok(solved.evidence.and(Evidence {
        left: off,
        allowed: 1e-6,
        note: format!("{off:.1e} m from rest"),
        ..Evidence::default()
    }))
}
