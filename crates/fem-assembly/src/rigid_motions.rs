//! The motions that strain nothing.

use crate::dofs::Dofs;
use fem_solvers::NearKernel;

/// The translations along each axis and the infinitesimal rotations in each plane of axes, about the
/// mean and in units of the largest distance from it, as vectors of the unknowns; zero at prescribed axes.
pub(crate) fn rigid_motions<const D: usize>(dofs: &Dofs<D>, x: &[f64]) -> NearKernel {
    let (points, _) = x.as_chunks::<D>();
    let count = points.len().max(1) as f64;
    let center: [f64; D] =
        std::array::from_fn(|a| points.iter().map(|p| p[a]).sum::<f64>() / count);
    let offset = |p: &[f64; D], a: usize| p[a] - center[a];
    let largest = points
        .iter()
        .flat_map(|p| (0..D).map(move |a| offset(p, a).abs()))
        .fold(0.0, f64::max);
    let unit = if largest > 0.0 { largest } else { 1.0 };
    let field = |motion: &dyn Fn(&[f64; D]) -> [f64; D]| {
        let mut field: Vec<f64> = points.iter().flat_map(motion).collect();
        for &(row, axis) in dofs.prescribed_axes() {
            field[D * row as usize + axis] = 0.0;
        }
        field
    };
    let mut fields = Vec::new();
    for a in 0..D {
        fields.push(field(&|_| {
            std::array::from_fn(|c| f64::from(u8::from(c == a)))
        }));
    }
    for a in 0..D {
        for b in a + 1..D {
            fields.push(field(&|p| {
                let mut turned = [0.0; D];
                turned[a] = -offset(p, b) / unit;
                turned[b] = offset(p, a) / unit;
                turned
            }));
        }
    }
    NearKernel::new(fields)
}
