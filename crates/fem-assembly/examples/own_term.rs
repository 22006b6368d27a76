//! A term of one's own: a spring k/2 (l − L)² between two nodes, pulled by a load.
use fem_assembly::mesh::kuhn_grid;
use fem_assembly::{AssemblyBuilder, Configuration, Dofs, EnergySink, GradientSink, HessianSink};
use fem_assembly::{NodalLoads, Quasistatic, Stencils, Term};
use fem_kinematics::Mat;
use fem_materials::HessianProjection;
use fem_solvers::{Newton, NewtonParams};
use std::ops::Range;

struct Spring([usize; 2], f64, f64); // nodes, k in N/m, L in m

impl Spring {
    /// Its length, and the unit vector from the first node to the second.
    fn length(&self, at: Configuration<3>) -> (f64, [f64; 3]) {
        let [a, b] = self.0.map(|node| at.positions()[node]);
        let d: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let l = d.iter().map(|c| c * c).sum::<f64>().sqrt();
        (l, d.map(|c| c / l))
    }
}

#[rustfmt::skip]
impl Term<3> for Spring {
    fn stencils(&self) -> Stencils { Stencils::new([self.0]) }
    fn energy(&self, at: Configuration<3>, _: Range<usize>, sink: &mut EnergySink) {
        sink.energy(0, 0.5 * self.1 * (self.length(at).0 - self.2).powi(2));
    }
    fn gradient(&self, at: Configuration<3>, _: Range<usize>, sink: &mut GradientSink<3>) {
        let (l, n) = self.length(at);
        sink.energy(0, 0.5 * self.1 * (l - self.2).powi(2));
        sink.add(0, 0, n.map(|n| -self.1 * (l - self.2) * n));
        sink.add(0, 1, n.map(|n| self.1 * (l - self.2) * n));
    }
    fn hessian(&self, at: Configuration<3>, projection: HessianProjection, _: Range<usize>, sink: &mut HessianSink<3>) {
        let (l, n) = self.length(at);
        let along = Mat::outer(n, n);
        let across = match projection {
            HessianProjection::None => 1.0 - self.2 / l,
            HessianProjection::Clamp => (1.0 - self.2 / l).max(0.0),
            HessianProjection::Absolute => (1.0 - self.2 / l).abs(),
        };
        let block = (along + (Mat::identity() - along).scale(across)).scale(self.1);
        for (a, b, sign) in [(0, 0, 1.0), (1, 1, 1.0), (1, 0, -1.0)] { sink.add(0, a, b, block.scale(sign).0); }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = kuhn_grid(1, 1, 1, [1.0; 3])?;
    let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0, 1, 2, 3, 4, 5, 6])?;
    let pulled = NodalLoads::new(vec![(7, [3.0, 0.0, 4.0])])?; // 5 N stretch 10 N/m by 0.5 m
    let builder = AssemblyBuilder::new(&mesh, dofs)?.term(Spring([0, 7], 10.0, 0.5))?;
    let assembly = builder.term(pulled)?.build()?;
    let problem = Quasistatic::held(&assembly, mesh.nodes().to_vec(), vec![])?;
    let mut x = problem.unknowns();
    Newton::new(&problem).solve(&problem, &mut x, &NewtonParams::default())?;
    let off = (x[0] - 0.6).abs() + x[1].abs() + (x[2] - 0.8).abs();
    assert!(off < 1e-6, "{x:?}");
    Ok(())
}
