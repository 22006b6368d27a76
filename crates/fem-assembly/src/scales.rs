//! How large a force is, node by node.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use fem_materials::HessianProjection;
use fem_solvers::BlockSymmetric;

/// [`Assembly::force_scales`].
pub(crate) fn of<const D: usize>(assembly: &Assembly<D>) -> Option<Vec<f64>> {
    let pattern = assembly.pattern();
    let mut hessian = BlockSymmetric::zeros(pattern.clone());
    let controls = vec![0.0; assembly.controls()];
    let at_rest = Configuration::trusted(assembly.rest(), &controls);
    assembly.hessian(at_rest, HessianProjection::None, &mut hessian);
    let mut scales: Vec<f64> = (0..pattern.blocks())
        .zip(sizes(assembly))
        .map(|(row, size)| {
            let block = hessian.values()[pattern.diagonal(row)];
            size * (0..D).fold(0.0, |m, k| block[k][k].abs().max(m))
        })
        .collect();
    let usable = |s: &f64| *s > 0.0 && *s < f64::INFINITY;
    let mut known: Vec<f64> = scales.iter().copied().filter(usable).collect();
    known.sort_by(f64::total_cmp);
    let median = *known.get(known.len() / 2)?;
    for scale in scales.iter_mut().filter(|s| !usable(s)) {
        *scale = median;
    }
    Some(scales.iter().flat_map(|&s| [s; D]).collect())
}

/// The mean size of the elements at each free node, meters; that of all elements where there is none.
fn sizes<const D: usize>(assembly: &Assembly<D>) -> Vec<f64> {
    let elements = &assembly.elements;
    let mut sums = vec![(0.0, 0_u32); assembly.dofs().free_nodes()];
    for (nodes, volume) in elements
        .nodes
        .chunks_exact(elements.nodes_each)
        .zip(assembly.volumes())
    {
        for &node in nodes {
            if let Some(row) = assembly.dofs().row(node as usize) {
                let (sum, count) = &mut sums[row];
                *sum += volume;
                *count += 1;
            }
        }
    }
    let all = assembly.volumes().sum::<f64>() / elements.len() as f64;
    let mean = |(sum, count): (f64, u32)| match count {
        0 => all,
        _ => sum / f64::from(count),
    };
    sums.into_iter()
        .map(|at| mean(at).powf(1.0 / D as f64))
        .collect()
}
