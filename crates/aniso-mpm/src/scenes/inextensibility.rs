use super::Deviation;
use super::read::{Report, at, list, matrices, node, number, numbers, relative, vectors};
use crate::float::worse;
use crate::inextensibility::{FiberGrid, Projection};
use fem_solvers::PcgParams;
use serde_json::Value;

pub fn compare<const D: usize>(file: &Value) -> Result<Vec<Deviation>, String> {
    let mut deviations = Vec::new();
    for case in list(file, "cases")? {
        deviations.extend(one::<D>(case)?);
    }
    Ok(deviations)
}

fn one<const D: usize>(case: &Value) -> Result<Vec<Deviation>, String> {
    let text = |e: crate::MpmError| e.to_string();
    let mut report = Report {
        prefix: format!("{D}D/{}", at(case, "fibres")?.as_str().unwrap_or_default()),
        deviations: Vec::new(),
    };
    let (h, dt) = (number(case, "h")?, number(case, "dt")?);
    let per_axis = number(case, "nodes_per_axis")? as usize;
    let x = vectors::<D>(case, "x")?;
    let (volume, a) = (numbers(case, "V")?, vectors::<D>(case, "a")?);
    let grid = FiberGrid::new(h, &x, &volume, &a).map_err(text)?;
    let places = |key: &str| -> Result<Vec<usize>, String> {
        numbers(case, key)?
            .iter()
            .map(|&n| grid.node_blocks().node_index(node(n as usize, per_axis)))
            .collect::<Option<_>>()
            .ok_or_else(|| format!("one of `{key}` is not on the grid"))
    };
    let (nodes, cells) = (places("nodes")?, places("cells")?);

    // Coefficients.
    let mass = grid
        .node_mass(&numbers(case, "particle_mass")?)
        .map_err(text)?;
    let node_mass = numbers(case, "node_mass")?;
    let ours: Vec<f64> = nodes.iter().map(|&n| mass[n]).collect();
    report.push("node_mass", relative(&ours, &node_mass), 1e-12);
    let mut v = vec![[0.0; D]; grid.len()];
    for (&place, &value) in nodes.iter().zip(&vectors::<D>(case, "v_n")?) {
        v[place] = value;
    }
    let sigma = matrices::<D>(case, "sigma")?;
    let b = grid.right_hand_side(&mass, &v, &sigma, dt).map_err(text)?;
    let ours: Vec<f64> = nodes.iter().flat_map(|&n| b[n]).collect();
    report.push("b", relative(&ours, &numbers(case, "b")?), 1e-12);
    let inverse_mass: Vec<f64> = mass
        .iter()
        .map(|&m| if m > 0.0 { dt / m } else { 0.0 })
        .collect();

    // B by particles and as a matrix.
    let mut probe = vec![0.0; grid.len()];
    for (&place, &value) in cells.iter().zip(&numbers(case, "probe_cells")?) {
        probe[place] = value;
    }
    let force = grid.apply_transpose(&probe);
    let ours: Vec<f64> = nodes.iter().flat_map(|&n| force[n]).collect();
    report.push(
        "Bt_times_probe",
        relative(&ours, &numbers(case, "Bt_times_probe")?),
        1e-12,
    );
    let product = grid.apply_schur(&inverse_mass, &probe);
    let ours: Vec<f64> = cells.iter().map(|&c| product[c]).collect();
    let expected = numbers(case, "L_times_probe")?;
    report.push(
        "L_times_probe, matrix-free",
        relative(&ours, &expected),
        1e-11,
    );

    let projection = Projection::new(&grid, &inverse_mass, &[]).map_err(text)?;
    let matrix = projection.matrix();
    let count = matrix.cells().len() as f64;
    report.push("cells", relative(&[count], &[cells.len() as f64]), 0.0);
    let on_nodes: Vec<f64> = matrix
        .nodes()
        .iter()
        .map(|&n| inverse_mass[n as usize])
        .collect();
    let schur = matrix.assemble_schur(&on_nodes);
    let mut ours = vec![0.0; grid.len()];
    let mut diagonal = vec![0.0; grid.len()];
    for (row, entries) in schur.iter().enumerate() {
        let place = matrix.cells()[row] as usize;
        for &(column, value) in entries {
            ours[place] += value * probe[matrix.cells()[column as usize] as usize];
            if column as usize == row {
                diagonal[place] = value;
            }
        }
    }
    let pick = |all: &[f64]| -> Vec<f64> { cells.iter().map(|&c| all[c]).collect() };
    report.push(
        "L_times_probe, assembled",
        relative(&pick(&ours), &expected),
        1e-11,
    );
    let expected = numbers(case, "L_diagonal")?;
    report.push("L_diagonal", relative(&pick(&diagonal), &expected), 1e-11);

    // r = B M⁻¹ b and the solve.
    let free: Vec<[f64; D]> = b
        .iter()
        .zip(&inverse_mass)
        .map(|(b, &m)| b.map(|b| b * m))
        .collect();
    let r = grid.apply(&free);
    report.push("r", relative(&pick(&r), &numbers(case, "r")?), 1e-11);
    let params = PcgParams {
        relative_tolerance: 1e-14,
        max_iterations: 4000,
        stagnation_window: 1000,
        ..PcgParams::default()
    };
    let solution = projection.solve(&b, &inverse_mass, &params).map_err(text)?;
    let expected = vectors::<D>(case, "v")?;
    let (mut error, mut size) = (0.0, 0.0);
    for ((&place, expected), m) in nodes.iter().zip(&expected).zip(&node_mass) {
        for axis in 0..D {
            error += m * (solution.v[place][axis] - expected[axis]).powi(2);
            size += m * expected[axis].powi(2);
        }
    }
    report.push("v in the mass norm", (error / size).sqrt(), 1e-8);
    let mut lambda = vec![0.0; grid.len()];
    for (&place, &value) in matrix.cells().iter().zip(&solution.lambda) {
        lambda[place as usize] = value;
    }
    let ours = pick(&grid.apply_schur(&inverse_mass, &lambda));
    report.push("L lambda = r", relative(&ours, &numbers(case, "r")?), 1e-8);
    let largest = |r: &[f64]| r.iter().fold(0.0, |m, b| worse(m, b.abs()));
    let left = largest(&grid.apply(&solution.v));
    report.push("B v", left / largest(&r), 1e-8);
    Ok(report.deviations)
}
