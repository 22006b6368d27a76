//! The nearly incompressible block of SPP 1748 (Schröder et al. 2021): a quarter of a block, pressed
//! on part of its top. Linear tetrahedra lock, means over patches and quadratic tetrahedra do not.
//!
//! `cargo run --release -p fem-assembly --example incompressible_block -- [cells along an edge]`

use fem_assembly::mesh::{QuadraticMesh, SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, NodalLoads, Quasistatic, VolumePatches};
use fem_solvers::{LinearSolver, Newton, NewtonParams};
use std::error::Error;
use std::time::Instant;

#[path = "../tests/all/spp_block.rs"]
mod spp_block;
use spp_block::{LAMBDA, MU, PRESSURE, Rubber, SIZE, dofs};

/// The faces of [25, 50]² of the top.
fn loaded(mesh: &SimplexMesh<3>) -> Vec<[u32; 3]> {
    mesh.boundary_faces(|n| {
        let [x, y, z] = mesh.node(n);
        z == SIZE && x >= SIZE / 2.0 && y >= SIZE / 2.0
    })
}

fn report(name: &str, body: &Assembly<3>) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let problem = Quasistatic::held(body, body.rest().to_vec(), vec![])?;
    let mut x = problem.unknowns();
    let params = NewtonParams {
        linear_solver: LinearSolver::Direct,
        max_iterations: 200,
        ..NewtonParams::default()
    };
    let info = Newton::new(&problem).solve(&problem, &mut x, &params);
    let seconds = start.elapsed().as_secs_f64();
    let shape = problem.positions(&x)?;
    let last = body
        .rest()
        .iter()
        .position(|p| *p == [SIZE; 3])
        .ok_or("no corner")?;
    let least = body
        .volume_ratios(body.positions(&shape)?)?
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    println!(
        "{name:>28}: {:>7} unknowns  |u_z| {:.3} mm  least J {least:.3}  {} steps  {seconds:.2} s",
        body.dofs().unknowns(),
        SIZE - shape[last][2],
        info.map_or_else(|e| e.to_string(), |info| info.iterations.to_string()),
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let n: usize = std::env::args().nth(1).map_or(Ok(8), |n| n.parse())?;
    let mesh = kuhn_grid(n, n, n, [SIZE; 3])?;
    let linear = || -> Result<_, Box<dyn Error>> {
        let loads = NodalLoads::pressure(mesh.nodes(), &loaded(&mesh), PRESSURE)?;
        Ok(AssemblyBuilder::new(&mesh, dofs(mesh.nodes())?)?.term(loads)?)
    };
    let whole = Rubber {
        mu: MU,
        lambda: LAMBDA,
    };
    report("linear", &linear()?.material(whole)?.build()?)?;
    for share in [0.0, 1.0] {
        let soft = Rubber {
            mu: MU,
            lambda: share * MU,
        };
        let bulk = vec![LAMBDA - soft.lambda; mesh.num_elements()];
        let nodal = VolumePatches::around_nodes(&mesh);
        let edges = VolumePatches::around_edges(&mesh);
        // Means around nodes couple so many nodes that a factorization of a fine mesh takes minutes.
        let choices = if n <= 12 { 2 } else { 1 };
        for (name, patches) in [("around edges", &edges), ("around nodes", &nodal)]
            .into_iter()
            .take(choices)
        {
            let body = linear()?
                .material(soft)?
                .mean_volume(patches, &bulk)?
                .build()?;
            report(&format!("{name}, λ = {share} µ outside"), &body)?;
        }
    }
    if n <= 16 {
        let mesh = QuadraticMesh::from_linear(&kuhn_grid(n / 2, n / 2, n / 2, [SIZE; 3])?)?;
        let loads = NodalLoads::quadratic_pressure(&mesh, &loaded(mesh.corners()), PRESSURE)?;
        let builder = AssemblyBuilder::quadratic(&mesh, dofs(mesh.nodes())?)?;
        report("quadratic", &builder.term(loads)?.material(whole)?.build()?)?;
    }
    Ok(())
}
