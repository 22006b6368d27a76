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

fn one<const D: usize>(file: &Value) -> Result<Vec<Deviation>, String> {
    let case = Case::<D>::read(file)?;
    let fibers = at(file, "fibres")?.as_str().unwrap_or_default();
    let mut report = Report {
        prefix: format!("{D}D/{fibers}"),
        deviations: Vec::new(),
    };
    let inverse_mass = case.masses(&mut report)?;
    let b = case.right_hand_side(&mut report, &inverse_mass)?;
    case.matrix_free(&mut report, &inverse_mass)?;
    let projection = Projection::new(&case.grid, &inverse_mass, &[]).map_err(text)?;
    case.assembled(&mut report, &projection, &inverse_mass)?;
    case.solution(&mut report, &projection, &b, &inverse_mass)?;
    Ok(report.deviations)
}

fn text(error: crate::MpmError) -> String {
    error.to_string()
}

/// The particles of a case on their grid.
struct Case<'f, const D: usize> {
    file: &'f Value,
    grid: FiberGrid<D>,
    /// Where the file's nodes and cells are on the grid.
    nodes: Vec<usize>,
    cells: Vec<usize>,
    dt: f64,
    /// One number for each cell.
    probe: Vec<f64>,
    mass: Vec<f64>,
}

impl<'f, const D: usize> Case<'f, D> {
    fn read(file: &'f Value) -> Result<Self, String> {
        let per_axis = number(file, "nodes_per_axis")? as usize;
        let x = vectors::<D>(file, "x")?;
        let (volume, a) = (numbers(file, "V")?, vectors::<D>(file, "a")?);
        let grid = FiberGrid::new(number(file, "h")?, &x, &volume, &a).map_err(text)?;
        let places = |key: &str| -> Result<Vec<usize>, String> {
            numbers(file, key)?
                .iter()
                .map(|&n| grid.node_blocks().node_index(node(n as usize, per_axis)))
                .collect::<Option<_>>()
                .ok_or_else(|| format!("one of `{key}` is not on the grid"))
        };
        let (nodes, cells) = (places("nodes")?, places("cells")?);
        let mut probe = vec![0.0; grid.len()];
        for (&place, &value) in cells.iter().zip(&numbers(file, "probe_cells")?) {
            probe[place] = value;
        }
        Ok(Self {
            file,
            mass: grid
                .node_mass(&numbers(file, "particle_mass")?)
                .map_err(text)?,
            grid,
            nodes,
            cells,
            dt: number(file, "dt")?,
            probe,
        })
    }

    fn check(
        &self,
        report: &mut Report,
        name: &str,
        ours: &[f64],
        key: &str,
        tolerance: f64,
    ) -> Result<(), String> {
        let error = relative(ours, &numbers(self.file, key)?);
        report.push(name, error, tolerance);
        Ok(())
    }

    fn on_cells(&self, all: &[f64]) -> Vec<f64> {
        self.cells.iter().map(|&c| all[c]).collect()
    }

    /// Δt/m of every node, 0 without mass.
    fn masses(&self, report: &mut Report) -> Result<Vec<f64>, String> {
        let ours: Vec<f64> = self.nodes.iter().map(|&n| self.mass[n]).collect();
        self.check(report, "node_mass", &ours, "node_mass", 1e-12)?;
        let inverse = |&m: &f64| if m > 0.0 { self.dt / m } else { 0.0 };
        Ok(self.mass.iter().map(inverse).collect())
    }

    /// b, and r = B M⁻¹ b.
    fn right_hand_side(
        &self,
        report: &mut Report,
        inverse_mass: &[f64],
    ) -> Result<Vec<[f64; D]>, String> {
        let mut v = vec![[0.0; D]; self.grid.len()];
        for (&place, &value) in self.nodes.iter().zip(&vectors::<D>(self.file, "v_n")?) {
            v[place] = value;
        }
        let sigma = matrices::<D>(self.file, "sigma")?;
        let b = self.grid.right_hand_side(&self.mass, &v, &sigma, self.dt);
        let b = b.map_err(text)?;
        let ours: Vec<f64> = self.nodes.iter().flat_map(|&n| b[n]).collect();
        self.check(report, "b", &ours, "b", 1e-12)?;
        let free = b.iter().zip(inverse_mass);
        let free: Vec<[f64; D]> = free.map(|(b, &m)| b.map(|b| b * m)).collect();
        let r = self.on_cells(&self.grid.apply(&free));
        self.check(report, "r", &r, "r", 1e-11)?;
        Ok(b)
    }

    /// Bᵀ and L = B M⁻¹ Bᵀ by particles.
    fn matrix_free(&self, report: &mut Report, inverse_mass: &[f64]) -> Result<(), String> {
        let force = self.grid.apply_transpose(&self.probe);
        let ours: Vec<f64> = self.nodes.iter().flat_map(|&n| force[n]).collect();
        self.check(report, "Bt_times_probe", &ours, "Bt_times_probe", 1e-12)?;
        let product = self.grid.apply_schur(inverse_mass, &self.probe);
        let ours = self.on_cells(&product);
        let name = "L_times_probe, matrix-free";
        self.check(report, name, &ours, "L_times_probe", 1e-11)
    }

    /// L as a matrix.
    fn assembled(
        &self,
        report: &mut Report,
        projection: &Projection<D>,
        inverse_mass: &[f64],
    ) -> Result<(), String> {
        let matrix = projection.matrix();
        let (count, expected) = (matrix.cells().len() as f64, self.cells.len() as f64);
        let error = relative(&[count], &[expected]);
        report.push("cells", error, 0.0);
        let on_nodes = matrix.nodes().iter().map(|&n| inverse_mass[n as usize]);
        let schur = matrix.assemble_schur(&on_nodes.collect::<Vec<f64>>());
        let mut product = vec![0.0; self.grid.len()];
        let mut diagonal = vec![0.0; self.grid.len()];
        for (row, entries) in schur.iter().enumerate() {
            let place = matrix.cells()[row] as usize;
            for &(column, value) in entries {
                product[place] += value * self.probe[matrix.cells()[column as usize] as usize];
                if column as usize == row {
                    diagonal[place] = value;
                }
            }
        }
        let name = "L_times_probe, assembled";
        let product = self.on_cells(&product);
        self.check(report, name, &product, "L_times_probe", 1e-11)?;
        let diagonal = self.on_cells(&diagonal);
        self.check(report, "L_diagonal", &diagonal, "L_diagonal", 1e-11)
    }

    fn solution(
        &self,
        report: &mut Report,
        projection: &Projection<D>,
        b: &[[f64; D]],
        inverse_mass: &[f64],
    ) -> Result<(), String> {
        let params = PcgParams {
            relative_tolerance: 1e-14,
            max_iterations: 4000,
            stagnation_window: 1000,
            ..PcgParams::default()
        };
        let solution = projection.solve(b, inverse_mass, &params).map_err(text)?;
        let expected = vectors::<D>(self.file, "v")?;
        let node_mass = numbers(self.file, "node_mass")?;
        let (mut error, mut size) = (0.0, 0.0);
        for ((&place, expected), m) in self.nodes.iter().zip(&expected).zip(&node_mass) {
            for axis in 0..D {
                error += m * (solution.v[place][axis] - expected[axis]).powi(2);
                size += m * expected[axis].powi(2);
            }
        }
        let error = (error / size).sqrt();
        report.push("v in the mass norm", error, 1e-8);
        let mut lambda = vec![0.0; self.grid.len()];
        let cells = projection.matrix().cells().iter();
        for (&place, &value) in cells.zip(&solution.lambda) {
            lambda[place as usize] = value;
        }
        let ours = self.on_cells(&self.grid.apply_schur(inverse_mass, &lambda));
        self.check(report, "L lambda = r", &ours, "r", 1e-8)?;
        let largest = |r: &[f64]| r.iter().fold(0.0, |m, b| worse(m, b.abs()));
        let left = largest(&self.grid.apply(&solution.v));
        let before = b.iter().zip(inverse_mass);
        let before: Vec<[f64; D]> = before.map(|(b, &m)| b.map(|b| b * m)).collect();
        let error = left / largest(&self.grid.apply(&before));
        report.push("B v", error, 1e-8);
        Ok(())
    }
}
