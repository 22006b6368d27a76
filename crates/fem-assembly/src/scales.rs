//! How large a force is, node by node.

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use fem_materials::HessianProjection;
use fem_solvers::BlockSymmetric;

impl<const D: usize> Assembly<D> {
    /// For each unknown the force that strains by one at rest, newtons: the stiffness of its node times
    /// the mean size of the elements there. Where a node has no stiffness at rest, or no element, it is
    /// the median of the others; `None` where nothing is stiff.
    pub fn force_scales(&self) -> Option<&[f64]> {
        self.force_scales.get_or_init(|| at_rest(self)).as_deref()
    }
}

fn at_rest<const D: usize>(assembly: &Assembly<D>) -> Option<Vec<f64>> {
    let pattern = assembly.pattern();
    let mut hessian = BlockSymmetric::zeros(pattern.clone());
    let controls = vec![0.0; assembly.controls()];
    let rest = Configuration::trusted(assembly.rest(), &controls);
    assembly.hessian(rest, HessianProjection::None, &mut hessian);
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
