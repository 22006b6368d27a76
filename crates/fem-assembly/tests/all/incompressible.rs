//! Flesh that keeps its volume: the block of SPP 1748 on a coarse mesh, and what patches must do with
//! volumes exactly.

use crate::promise::Newton;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs, NodalLoads, Quasistatic, VolumePatches};
use fem_solvers::NewtonParams;

use crate::spp_block::{LAMBDA, MU, PRESSURE, Rubber, SIZE, dofs};

/// The quarter of the block, with the dead pressure of 3 MPa on [25, 50]² of its top.
fn block(mesh: &SimplexMesh<3>) -> AssemblyBuilder<3> {
    let faces = mesh.boundary_faces(|n| {
        let [x, y, z] = mesh.node(n);
        z == SIZE && x >= SIZE / 2.0 && y >= SIZE / 2.0
    });
    let loads = NodalLoads::pressure(mesh.nodes(), &faces, PRESSURE).unwrap();
    let dofs = dofs(mesh.nodes()).unwrap();
    let builder = AssemblyBuilder::new(mesh, dofs).unwrap();
    builder.term(loads).unwrap()
}

fn solved(body: &Assembly<3>) -> (Vec<[f64; 3]>, usize) {
    let problem = Quasistatic::new(body, body.rest().to_vec(), vec![]).unwrap();
    let mut x = problem.unknowns();
    let params = NewtonParams::default();
    let info = Newton::new(&problem).solve(&problem, &mut x, &params);
    let info = info.unwrap();
    (problem.positions(&x).unwrap(), info.iterations)
}

fn sinking(mesh: &SimplexMesh<3>, body: &Assembly<3>) -> f64 {
    let corner = mesh.nodes().iter().position(|p| *p == [SIZE; 3]).unwrap();
    SIZE - solved(body).0[corner][2]
}

/// 20.00 mm is the converged value (Schröder et al. 2021).
#[test]
fn a_nearly_incompressible_block_sinks_as_far_as_it_should() {
    let mesh = kuhn_grid(8, 8, 8, [SIZE; 3]).unwrap();
    let locked = block(&mesh)
        .material(Rubber {
            mu: MU,
            lambda: LAMBDA,
        })
        .unwrap();
    let locked = sinking(&mesh, &locked.build().unwrap());
    assert!(locked < 14.0, "{locked}");
    let patches = VolumePatches::around_edges(&mesh);
    let bulk = vec![LAMBDA; mesh.num_elements()];
    let free = block(&mesh)
        .material(Rubber {
            mu: MU,
            lambda: 0.0,
        })
        .unwrap();
    let free = free.mean_volume(&patches, &bulk).unwrap();
    let free = sinking(&mesh, &free.build().unwrap());
    assert!((free - 20.0).abs() < 0.2, "{free}");
}

/// A cube squeezed on two opposite faces: the patches keep their volumes as well as κ says, with
/// pressures that no element feels alone.
#[test]
fn patches_keep_their_volume_and_elements_need_not() {
    let mesh = kuhn_grid(4, 4, 4, [1.0; 3]).unwrap();
    let ends: Vec<usize> = (0..mesh.num_nodes())
        .filter(|&n| mesh.nodes()[n][2] == 0.0 || mesh.nodes()[n][2] == 1.0)
        .collect();
    let patches = VolumePatches::around_edges(&mesh);
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &ends).unwrap();
    let body = AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(Rubber {
            mu: MU,
            lambda: 0.0,
        })
        .unwrap()
        .mean_volume(&patches, &vec![1e4; mesh.num_elements()])
        .unwrap()
        .build()
        .unwrap();
    let pressed = mesh.nodes().iter().map(|&[x, y, z]| [x, y, 0.85 * z]);
    let problem = Quasistatic::new(&body, pressed.collect(), vec![]).unwrap();
    let mut x = problem.unknowns();
    let params = NewtonParams::default();
    Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    let shape = problem.positions(&x).unwrap();
    let ratios = body.volume_ratios(body.positions(&shape).unwrap()).unwrap();
    for patch in patches.lists() {
        let (mut now, mut rest) = (0.0, 0.0);
        for &(e, _) in patch {
            now += ratios[e] * mesh.volume(e);
            rest += mesh.volume(e);
        }
        assert!((now / rest - 1.0).abs() < 2e-3, "{}", now / rest);
    }
    assert!(ratios.iter().any(|j| (j - 1.0).abs() > 0.01));
}

#[test]
fn patches_that_make_no_sense_are_refused() {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
    let builder = || AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes()).unwrap()).unwrap();
    let around = VolumePatches::around_edges(&mesh);
    assert!(builder().mean_volume(&around, &[1.0; 5]).is_err());
    assert!(builder().mean_volume(&around, &[-1.0; 6]).is_err());
    assert!(builder().mean_volume(&around, &[f64::NAN; 6]).is_err());
    let beyond = VolumePatches::disjoint(vec![vec![0, 6]]);
    assert!(builder().mean_volume(&beyond, &[1.0; 6]).is_err());
}
