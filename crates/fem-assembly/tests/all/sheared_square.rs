//! A unit square of n × n cells, its lower edge prescribed and its upper one sheared by 0.8 of its height.

use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{Assembly, AssemblyBuilder, Dofs};
use fem_materials::Material;

pub fn square(n: usize, material: impl Material<2> + 'static) -> Assembly<2> {
    let at = |i: usize| i as f64 / n as f64;
    let rest: Vec<[f64; 2]> = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| [at(i), at(j)]))
        .collect();
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (j * (n + 1) + i) as u32));
    let (right, up) = (1, n as u32 + 1);
    let halves = |a: u32| [a, a + right, a + right + up, a, a + right + up, a + up];
    let mesh = SimplexMesh::new(rest.clone(), cells.flat_map(halves).collect()).unwrap();
    let on_edge = |k: &usize| rest[*k][1] == 0.0 || rest[*k][1] == 1.0;
    let prescribed: Vec<usize> = (0..rest.len()).filter(on_edge).collect();
    let dofs = Dofs::with_prescribed_nodes(&rest, &prescribed).unwrap();
    let builder = AssemblyBuilder::new(&mesh, dofs).unwrap();
    builder.material(material).unwrap().build().unwrap()
}

/// Where the prescribed nodes go.
pub fn moved(body: &Assembly<2>) -> Vec<[f64; 2]> {
    let sheared = |p: &[f64; 2]| [p[0] + 0.8 * p[1].floor(), p[1]];
    body.rest().iter().map(sheared).collect()
}
