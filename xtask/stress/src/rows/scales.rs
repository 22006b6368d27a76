//! Bodies that are hard to balance: nearly incompressible, stiff beside soft, flat elements, sizes and
//! stiffnesses far from one.

use crate::body::{Body, apart};
use crate::named::Named;
use crate::row::{Evidence, Settings};
use crate::{Expected, Failure, Row};
use fem_assembly::mesh::SimplexMesh;
use fem_solvers::{LinearSolver, PreconditionerChoice};

/// The rows.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for nu in [0.45, 0.49, 0.499, 0.4999] {
        for patches in [false, true] {
            let how = if patches { "patches" } else { "elements" };
            rows.push(Row::new(
                "volume",
                format!("volume-{nu}-{how}"),
                format!("twisted by 90° and pulled by a tenth, ν = {nu}, volumes of {how}"),
                Expected::Answer,
                move |settings| nearly_incompressible(nu, patches, settings),
            ));
        }
    }
    for ratio in [1e3, 1e6] {
        for solver in ["direct", "single", "pcg"] {
            rows.push(Row::new(
                "stiffness",
                format!("stiffness-{ratio:.0e}-{solver}"),
                format!(
                    "neighbors {ratio:.0e} apart in stiffness, twisted; linear solver {solver}"
                ),
                Expected::Answer,
                move |settings| neighbors(ratio, solver, settings),
            ));
        }
    }
    for degrees in [1.0, 0.1] {
        for model in ["neo_hookean", "stable_neo_hookean"] {
            rows.push(Row::new(
                "slivers",
                format!("slivers-{degrees}-{model}"),
                format!("a middle layer of tetrahedra with dihedral angles of {degrees}°, pulled"),
                Expected::Answer,
                move |settings| slivers(degrees, model, settings),
            ));
        }
    }
    for size in [1e-3, 1e3] {
        for young in [1.0, 1e12] {
            rows.push(Row::new(
                "scales",
                format!("scale-{size:.0e}m-{young:.0e}Pa"),
                format!(
                    "a block of {size:.0e} m and {young:.0e} Pa, twisted, as one of 1 m and 1e5 Pa"
                ),
                Expected::Answer,
                move |settings| scaled(size, young, settings),
            ));
        }
    }
    rows
}

/// A bar of this length (m), 1/4 as wide, twisted by 90° and pulled by a tenth.
fn twisted(length: f64, cells: usize, material: Named) -> Result<(Body, Vec<[f64; 3]>), Failure> {
    let wide = 0.25 * length;
    let body = Body::block([cells, cells, 4 * cells], [wide, wide, length], material)?;
    let body = body.holding(|p| p[2] == 0.0 || p[2] == length);
    let moved = |p: [f64; 3]| {
        let (s, c) = (90.0 * p[2] / length).to_radians().sin_cos();
        let (x, y) = (p[0] - 0.5 * wide, p[1] - 0.5 * wide);
        [
            0.5 * wide + c * x - s * y,
            0.5 * wide + s * x + c * y,
            1.1 * p[2],
        ]
    };
    let start = body.placed(moved, moved);
    Ok((body, start))
}

fn cells(settings: &Settings) -> usize {
    if settings.quick { 2 } else { 4 }
}

fn nearly_incompressible(nu: f64, patches: bool, settings: &Settings) -> Result<Evidence, Failure> {
    let young = 1e5;
    let mu = young / (2.0 * (1.0 + nu));
    let lambda = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let own = if patches { mu } else { lambda };
    let material = Named::new("neo_hookean", &[("mu", mu), ("lambda", own)]);
    let (mut body, start) = twisted(1.0, cells(settings), material)?;
    if patches {
        body = body.with_patches(lambda - mu);
    }
    Ok(body.solve(start, settings, 200)?.evidence)
}

fn neighbors(ratio: f64, solver: &str, settings: &Settings) -> Result<Evidence, Failure> {
    let soft = Named::elastic("neo_hookean", 1e4, 0.4);
    let hard = Named::elastic("neo_hookean", ratio * 1e4, 0.4);
    let (body, start) = twisted(1.0, cells(settings), soft.clone())?;
    let mesh = body.mesh().clone();
    // Every other cube, like a board for chess.
    let group = move |e: usize| {
        let corners = mesh.tet(e).map(|n| mesh.node(n));
        let cube: usize = (0..3)
            .map(|k| {
                let middle: f64 = corners.iter().map(|c| c[k]).sum::<f64>() / 4.0;
                (middle * 4.0) as usize
            })
            .sum();
        cube % 2
    };
    let body = body.of_groups(group, vec![soft, hard]);
    let mut params = settings.newton(if solver == "pcg" { 600 } else { 400 });
    params.linear_solver = match solver {
        "direct" => LinearSolver::Direct,
        "single" => LinearSolver::DirectSingle,
        _ => LinearSolver::Pcg {
            preconditioner: PreconditionerChoice::BlockIc0,
            max_iterations: 2000,
        },
    };
    Ok(body.solve_with(start, &params)?.evidence)
}

/// A bar whose middle layers are so thin that the smallest dihedral angle is the given one.
fn slivers(degrees: f64, model: &str, settings: &Settings) -> Result<Evidence, Failure> {
    let n = cells(settings);
    let material = Named::elastic(model, 1e5, 0.4);
    let grid = Body::block([n, n, 4 * n], [1.0, 1.0, 4.0], material.clone())?;
    // Two layers of cells as wide as 1/n: a height of h leaves angles of h n.
    let layer = 1.0 / n as f64;
    let thin = layer * degrees.to_radians().tan();
    let squeeze = |z: f64| {
        let inside = (z - 2.0).clamp(0.0, 2.0 * layer);
        z - inside + inside / layer * thin
    };
    let nodes = grid.mesh().nodes().iter();
    let nodes = nodes.map(|p| [p[0], p[1], squeeze(p[2])]).collect();
    let mesh = SimplexMesh::new(nodes, grid.mesh().connectivity().to_vec())?;
    let smallest = smallest_angle(&mesh);
    if !(smallest <= 1.001 * degrees) {
        let what = format!("no angle below {degrees}°, the smallest is {smallest}°");
        return Err(Failure::trial(&what));
    }
    let top = squeeze(4.0);
    let body = Body::new(mesh, material).holding(|p| p[2] == 0.0 || p[2] == top);
    let pulled = |p: [f64; 3]| [p[0], p[1], 1.1 * p[2]];
    let evidence = body
        .solve(body.placed(pulled, pulled), settings, 200)?
        .evidence;
    Ok(Evidence {
        note: format!("smallest dihedral angle {smallest:.2}°"),
        ..evidence
    })
}

/// The smallest angle between two faces of one element, degrees.
fn smallest_angle(mesh: &SimplexMesh<3>) -> f64 {
    let mut smallest = f64::INFINITY;
    for tet in mesh.tets() {
        let x = tet.map(|n| mesh.node(n));
        for [i, j, k, l] in [
            [0, 1, 2, 3],
            [0, 2, 3, 1],
            [0, 3, 1, 2],
            [1, 2, 0, 3],
            [1, 3, 2, 0],
            [2, 3, 0, 1],
        ] {
            let minus =
                |a: usize, b: usize| -> [f64; 3] { std::array::from_fn(|c| x[a][c] - x[b][c]) };
            let edge = minus(j, i);
            let length: f64 = edge.iter().map(|c| c * c).sum();
            let off = |a: usize| -> [f64; 3] {
                let way = minus(a, i);
                let along: f64 = (0..3).map(|c| way[c] * edge[c]).sum::<f64>() / length;
                std::array::from_fn(|c| way[c] - along * edge[c])
            };
            let (a, b) = (off(k), off(l));
            let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
            let cosine = dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
            smallest = smallest.min(cosine.clamp(-1.0, 1.0).acos().to_degrees());
        }
    }
    smallest
}

/// The answer must be that of a block of another size and stiffness, magnified.
fn scaled(size: f64, young: f64, settings: &Settings) -> Result<Evidence, Failure> {
    let shape = |size: f64, young: f64| -> Result<_, Failure> {
        let material = Named::elastic("neo_hookean", young, 0.45);
        let (body, start) = twisted(size, cells(settings), material)?;
        body.solve(start, settings, 100)
    };
    let (one, other) = (shape(1.0, 1e5)?, shape(size, young)?);
    let back: Vec<[f64; 3]> = other
        .positions
        .iter()
        .map(|x| x.map(|c| c / size))
        .collect();
    let same = Evidence {
        left: apart(&back, &one.positions),
        allowed: 1e-6,
        note: format!("{:.1e} of its length off", apart(&back, &one.positions)),
        ..Evidence::default()
    };
    Ok(other.evidence.and(one.evidence).and(same))
}
