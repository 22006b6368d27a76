//! Lists of another length than the assembly's are refused, shorter and longer ones alike.

use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{
    Assembly, AssemblyBuilder, AssemblyError, Cavity, ContactPoint, Dofs, FleshContact,
    FleshContactParams, Quasistatic, RigidContact, RigidContactParams, RigidFrame, Scaled, Springs,
};
use fem_materials::NeoHookean;

/// A bar of `n` cubes that is held at one end, with one control.
fn bar(n: usize) -> Assembly<3> {
    let mesh = kuhn_grid(n, 1, 1, [n as f64, 1.0, 1.0]).unwrap();
    let held: Vec<usize> = (0..mesh.nodes().len())
        .filter(|&k| mesh.nodes()[k][0] == 0.0)
        .collect();
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &held).unwrap();
    let flesh = NeoHookean {
        mu: 1e4,
        lambda: 1e5,
    };
    let springs = Springs::at_nodes([(held[0] + 1, [1.0, 0.0, 0.0])], 10.0).unwrap();
    AssemblyBuilder::new(&mesh, dofs)
        .unwrap()
        .material(flesh)
        .unwrap()
        .term(Scaled::new(springs, 0).unwrap())
        .unwrap()
        .build()
        .unwrap()
}

#[track_caller]
fn refused<T>(result: Result<T, AssemblyError>, found: usize, expected: usize) {
    match result.err() {
        Some(AssemblyError::WrongLength {
            found: f,
            expected: e,
            ..
        }) => assert_eq!((f, e), (found, expected)),
        other => panic!("{other:?} for {found} of {expected}"),
    }
}

#[test]
fn displacements_and_unknowns_of_another_length_are_refused() {
    let mut body = bar(2);
    let (rest, free) = (body.rest().to_vec(), body.dofs().vector_len());
    let n = rest.len();
    let at = body.configuration(&rest, &[1.0]).unwrap();
    let still = vec![[0.0; 3]; n];
    for count in [n - 1, n + 1] {
        let moved = vec![[0.0; 3]; count];
        let mut rows = vec![0.0; free];
        refused(body.hessian_vector(at, &moved, &mut rows), count, n);
        refused(body.hessian_vector_everywhere(at, &moved), count, n);
        refused(body.largest_step(at, &moved), count, n);
        refused(body.covered_step(at, &moved), count, n);
        refused(body.renew_along(at, &moved), count, n);
    }
    for count in [free - 1, free + 3] {
        let mut rows = vec![7.0; count];
        refused(body.gradient(at, &mut rows), count, free);
        refused(body.hessian_vector(at, &still, &mut rows), count, free);
        refused(body.control_gradient(at, 0, &mut rows), count, free);
        assert_eq!(rows, vec![7.0; count], "written before it was refused");
        let problem = Quasistatic::new(&body, rest.clone(), vec![1.0]).unwrap();
        refused(problem.positions(&rows), count, free);
    }
}

#[test]
fn what_another_assembly_checked_is_refused() {
    let (mut body, shorter, longer) = (bar(2), bar(1), bar(3));
    let n = body.rest().len();
    for other in [shorter, longer] {
        let x = other.rest().to_vec();
        let (found, positions) = (x.len(), other.positions(&x).unwrap());
        let at = other.configuration(&x, &[1.0]).unwrap();
        refused(body.volume_ratios(positions), found, n);
        refused(body.volume_ratios(at), found, n);
        refused(body.deformation_gradients(0, at).map(|_| ()), found, n);
        let mut rows = vec![0.0; body.dofs().vector_len()];
        refused(body.gradient(at, &mut rows), found, n);
        refused(body.control_gradient(at, 0, &mut rows), found, n);
        refused(body.largest_step(at, &vec![[0.0; 3]; n]), found, n);
        refused(body.renew(at), found, n);
    }
    let x = body.rest().to_vec();
    let count = body.volumes().len();
    let there = body.positions(&x).unwrap();
    let error = body.deformation_gradients(count, there).err();
    let element = count;
    assert_eq!(error, Some(AssemblyError::NoSuchElement { element, count }));
}

#[test]
fn what_asks_for_positions_without_an_assembly_refuses_others() {
    let (short, mesh, long) = (
        kuhn_grid(1, 1, 1, [1.0; 3]).unwrap(),
        kuhn_grid(2, 1, 1, [2.0, 1.0, 1.0]).unwrap(),
        kuhn_grid(3, 1, 1, [3.0, 1.0, 1.0]).unwrap(),
    );
    let (n, faces) = (mesh.nodes().len(), mesh.boundary().faces);
    let params = FleshContactParams {
        activation: 0.1,
        pressure: 1e4,
        depth: 0.1,
        margin: 0.1,
        neighbors: 1,
        edges: true,
    };
    let flesh = FleshContact::new(&mesh, &faces, params).unwrap();
    let points = ContactPoint::on_faces(&mesh, &faces);
    let solids = RigidContactParams {
        activation: 0.1,
        pressure: 1e4,
        depth: 0.1,
    };
    let solid = |frame| RigidContact::new(Vec::new(), frame, points.clone(), mesh.nodes(), solids);
    let rigid = solid(None).unwrap();
    assert_eq!(flesh.deepest(mesh.nodes()), Ok(0.0));
    assert_eq!(rigid.deepest(mesh.nodes()), Ok(0.0));
    for other in [&short, &long] {
        let count = other.nodes().len();
        refused(flesh.deepest(other.nodes()), count, n);
        refused(rigid.deepest(other.nodes()), count, n);
    }
    let all: Vec<usize> = (0..long.nodes().len()).collect();
    let frame = RigidFrame::new(long.nodes(), &all).unwrap();
    let node = *frame.nodes().iter().find(|&&node| node >= n).unwrap();
    let error = solid(Some(frame)).err();
    assert_eq!(error, Some(AssemblyError::NoSuchNode { node, count: n }));
    let cavity = Cavity::closed(faces, 1.0).unwrap();
    assert!((cavity.volume(mesh.nodes()).unwrap() - 2.0).abs() < 1e-12);
    let error = cavity.volume(short.nodes());
    assert!(
        matches!(error, Err(AssemblyError::NoSuchNode { node, count: 8 }) if node >= 8),
        "{error:?}"
    );
}

#[test]
fn contact_of_a_larger_mesh_is_refused_before_it_finds_its_pairs() {
    let [small, large] = [1, 2].map(|n| kuhn_grid(n, 1, 1, [n as f64, 1.0, 1.0]).unwrap());
    let touching = FleshContactParams::default();
    let contact = FleshContact::new(&large, &large.boundary().faces, touching).unwrap();
    assert_eq!(contact.pairs(), 0);
    let last = large.num_nodes() - 1;
    let body = |contact: FleshContact| {
        let builder = || {
            let dofs = Dofs::all_free(small.nodes()).unwrap();
            AssemblyBuilder::new(&small, dofs).unwrap()
        };
        let scaled = Scaled::new(contact.clone(), 0).unwrap();
        [builder().term(contact).err(), builder().term(scaled).err()]
    };
    let count = small.num_nodes();
    let refused = Some(AssemblyError::NoSuchNode { node: last, count });
    assert_eq!(body(contact), [refused.clone(), refused]);
    let faces = &small.boundary().faces;
    let own = FleshContact::new(&small, faces, touching).unwrap();
    assert_eq!(body(own), [None, None]);
}
