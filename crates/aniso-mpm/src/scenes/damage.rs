use super::Deviation;
use super::read::{
    Report, at, list, matrices, node, number, numbers, of_length, relative, vectors,
};
use crate::damage::{
    DamageGrid, DamageParameters, Director, Directors, Gradient, ImplicitOptions, ImplicitSystem,
    RightHandSide, crack_stress, driving_force, explicit_update, geometric_resistance,
    tensile_part,
};
use fem_kinematics::Mat;
use serde_json::Value;

const TOLERANCE: f64 = 1e-11;

pub fn compare<const D: usize>(file: &Value) -> Result<Vec<Deviation>, String> {
    let mut deviations = uniform::<D>(at(file, "uniform_closed_form")?)?;
    for case in list(file, "cases")? {
        deviations.extend(one::<D>(case)?);
    }
    Ok(deviations)
}

fn flat<const D: usize>(m: &[Mat<f64, D>]) -> Vec<f64> {
    m.iter().flat_map(|m| m.0.as_flattened().to_vec()).collect()
}

fn one<const D: usize>(file: &Value) -> Result<Vec<Deviation>, String> {
    let mut case = Case::<D>::read(file)?;
    let force = case.driving_forces()?;
    let h = number(file, "h")?;
    let mut grid = DamageGrid::<D>::new(h);
    let spread = grid.particles_to_grid(&case.x, &case.d);
    spread.map_err(|e| e.to_string())?;
    let places = case.active(&grid)?;
    case.explicit(&grid, &places, &force)?;
    case.implicit(&grid, &places, &force)?;
    Ok(case.report.deviations)
}

/// The particles of a case, and what was found about them so far.
struct Case<'f, const D: usize> {
    file: &'f Value,
    report: Report,
    parameters: DamageParameters,
    x: Vec<[f64; D]>,
    d: Vec<f64>,
    directors: Vec<Directors<D>>,
}

impl<'f, const D: usize> Case<'f, D> {
    fn read(file: &'f Value) -> Result<Self, String> {
        let symmetry = at(file, "symmetry")?.as_str().unwrap_or_default();
        let alpha = numbers(file, "alpha")?;
        let &weight = alpha.first().ok_or("`alpha` is empty")?;
        let a1 = vectors::<D>(file, "a1")?.into_iter();
        let first = a1.map(|direction| Director { direction, weight });
        let directors: Vec<_> = match alpha.get(1) {
            None => first.map(Directors::TransverselyIsotropic).collect(),
            Some(&weight) => {
                let second = vectors::<D>(file, "a2")?.into_iter();
                let second = second.map(|direction| Director { direction, weight });
                let pairs = first.zip(second);
                pairs.map(|(a, b)| Directors::Orthotropic(a, b)).collect()
            }
        };
        let (x, d) = (vectors(file, "x")?, numbers(file, "d")?);
        of_length("d", d.len(), x.len())?;
        of_length("a1 and a2", directors.len(), x.len())?;
        Ok(Self {
            file,
            report: Report {
                prefix: format!("{D}D/{symmetry}"),
                deviations: Vec::new(),
            },
            parameters: DamageParameters {
                length_scale: number(file, "l0")?,
                zeta: number(file, "zeta")?,
                sigma_crit: number(file, "sigma_crit")?,
                eta: number(file, "eta")?,
            },
            x,
            d,
            directors,
        })
    }

    fn check(&mut self, name: &str, ours: &[f64], theirs: &[f64]) {
        self.report.push(name, relative(ours, theirs), TOLERANCE);
    }

    /// Compares what a particle knows alone, and returns its driving force.
    fn driving_forces(&mut self) -> Result<Vec<f64>, String> {
        let file = self.file;
        let (F, sigma) = (matrices::<D>(file, "F")?, matrices::<D>(file, "sigma")?);
        let history = numbers(file, "D_history")?;
        for (key, found) in [
            ("F", F.len()),
            ("sigma", sigma.len()),
            ("D_history", history.len()),
        ] {
            of_length(key, found, self.x.len())?;
        }
        let parameters = self.parameters;
        let tensors = self.directors.iter().zip(&F);
        let A: Vec<_> = tensors.map(|(a, F)| a.structural_tensor(F)).collect();
        let expected = numbers(file, "structural_tensor")?;
        self.check("structural_tensor", &flat(&A), &expected);
        let plus: Vec<_> = sigma.iter().map(tensile_part).collect();
        self.check("sigma_plus", &flat(&plus), &numbers(file, "sigma_plus")?);
        let stresses = A.iter().zip(&plus);
        let Phi: Vec<f64> = stresses
            .map(|(A, plus)| crack_stress(A, plus, parameters.sigma_crit))
            .collect();
        self.check("Phi", &Phi, &numbers(file, "Phi")?);
        let all = self.directors.iter().enumerate();
        let force: Vec<f64> = all
            .map(|(p, a)| driving_force(&parameters, a, &F[p], &sigma[p], history[p]))
            .collect();
        self.check("D_tilde", &force, &numbers(file, "D_tilde")?);
        Ok(force)
    }

    /// Where the active nodes of the file are on the grid.
    fn active(&mut self, grid: &DamageGrid<D>) -> Result<Vec<usize>, String> {
        let per_axis = number(self.file, "nodes_per_axis")? as usize;
        let active = numbers(self.file, "active_nodes")?;
        let place = |n: &f64| grid.node_blocks().node_index(node(*n as usize, per_axis));
        let places: Option<Vec<usize>> = active.iter().map(place).collect();
        let count = grid.nodes().count() as f64;
        self.check("active nodes", &[count], &[active.len() as f64]);
        places.ok_or_else(|| "an active node is not on the grid".into())
    }

    fn explicit(
        &mut self,
        grid: &DamageGrid<D>,
        places: &[usize],
        force: &[f64],
    ) -> Result<(), String> {
        let (file, parameters) = (self.file, self.parameters);
        let on_grid = pick(places, &grid.values());
        self.check("d_grid", &on_grid, &numbers(file, "d_grid")?);
        let laplacian = grid.laplacians();
        self.check("laplacian", &laplacian, &numbers(file, "laplacian")?);
        let all = || self.d.iter().zip(&laplacian);
        let resistance: Vec<f64> = all()
            .map(|(&d, &l)| geometric_resistance(d, l, parameters.length_scale))
            .collect();
        let dt = number(file, "dt_explicit")?;
        let updated: Vec<f64> = all()
            .zip(force)
            .map(|((&d, &l), &force)| explicit_update(&parameters, d, force, l, dt))
            .collect();
        self.check("D_c", &resistance, &numbers(file, "D_c")?);
        self.check("d_explicit", &updated, &numbers(file, "d_explicit")?);
        Ok(())
    }

    fn implicit(
        &mut self,
        grid: &DamageGrid<D>,
        places: &[usize],
        force: &[f64],
    ) -> Result<(), String> {
        let (volume, dt) = (numbers(self.file, "V")?, number(self.file, "dt_implicit")?);
        let parameters = self.parameters;
        let constants = |_| parameters;
        for (gradient, name) in [(Gradient::MlsMpm, "mls"), (Gradient::BSpline, "bspline")] {
            for (right_hand_side, side, c) in [
                (RightHandSide::GridDamage, "grid_d", "c"),
                (RightHandSide::ParticleDamage, "particle_d", "c_particle_d"),
            ] {
                let options = ImplicitOptions {
                    right_hand_side,
                    gradient,
                    tolerance: 1e-13,
                };
                let d = self.d.clone();
                let system =
                    ImplicitSystem::new(grid, &volume, force, &d, dt, &constants, &options)
                        .map_err(|e| e.to_string())?;
                let at_hand = at(self.file, "implicit")?;
                let expected = numbers(at_hand, c)?;
                self.check(c, &pick(places, system.right_hand_side()), &expected);
                self.operator(&system, places, name)?;
                self.solution(&system, places, &format!("{name}/{side}"))?;
            }
        }
        Ok(())
    }

    /// A and B of A + B, and B times a vector.
    fn operator(
        &mut self,
        system: &ImplicitSystem<D>,
        places: &[usize],
        name: &str,
    ) -> Result<(), String> {
        let file = at(self.file, "implicit")?;
        let lumped = system.lumped();
        let expected = numbers(file, "A_diagonal")?;
        self.check("A", &pick(places, lumped), &expected);
        let both = system.diagonal();
        let diagonal: Vec<f64> = both.iter().zip(lumped).map(|(d, a)| d - a).collect();
        let key = format!("B_{name}_diagonal");
        self.check(&key, &pick(places, &diagonal), &numbers(file, &key)?);
        let mut u = vec![0.0; diagonal.len()];
        for (&place, &value) in places.iter().zip(&numbers(file, "probe")?) {
            u[place] = value;
        }
        let mut product = vec![0.0; u.len()];
        system.apply_laplace(&u, &mut product);
        let key = format!("B_{name}_times_probe");
        self.check(&key, &pick(places, &product), &numbers(file, &key)?);
        Ok(())
    }

    /// The solution, where the file has it.
    fn solution(
        &mut self,
        system: &ImplicitSystem<D>,
        places: &[usize],
        key: &str,
    ) -> Result<(), String> {
        let solutions = at(at(self.file, "implicit")?, "solutions")?;
        let Some(expected) = solutions.get(key) else {
            return Ok(());
        };
        let solved = system.solve(1e-13).map_err(|e| e.to_string())?;
        let on_grid = numbers(expected, "d_grid")?;
        self.check(&format!("{key}/d_grid"), &pick(places, &solved), &on_grid);
        let (ours, theirs) = (
            system.as_printed(&solved),
            numbers(expected, "d_particles")?,
        );
        self.check(&format!("{key}/d_particles"), &ours, &theirs);
        Ok(())
    }
}

fn pick(places: &[usize], values: &[f64]) -> Vec<f64> {
    places.iter().map(|&p| values[p]).collect()
}

/// All particles equal: the answer does not depend on kernels.
fn uniform<const D: usize>(file: &Value) -> Result<Vec<Deviation>, String> {
    let mut report = Report {
        prefix: format!("{D}D/uniform"),
        deviations: Vec::new(),
    };
    let parameters = DamageParameters {
        length_scale: 0.05,
        zeta: 1.0,
        sigma_crit: 1.0,
        eta: number(file, "eta")?,
    };
    let (d, force) = (number(file, "d")?, number(file, "D_tilde")?);
    let count = 200;
    let x: Vec<[f64; D]> = (0..count)
        .map(|i| core::array::from_fn(|a| 0.1 * ((i * (3 + 2 * a)) % 17) as f64 / 3.0))
        .collect();
    let (d_all, force_all, volume) = (vec![d; count], vec![force; count], vec![1e-3; count]);
    let mut grid = DamageGrid::<D>::new(0.1);
    grid.particles_to_grid(&x, &d_all)
        .map_err(|e| e.to_string())?;
    let options = ImplicitOptions {
        tolerance: 1e-13,
        ..ImplicitOptions::default()
    };
    let (constants, dt) = (|_| parameters, number(file, "dt")?);
    let system = ImplicitSystem::new(&grid, &volume, &force_all, &d_all, dt, &constants, &options)
        .map_err(|e| e.to_string())?;
    let solved = system.solve(1e-13).map_err(|e| e.to_string())?;
    let expected = vec![number(file, "d_new")?; count];
    let ours = system.as_printed(&solved);
    report.push("d_new", relative(&ours, &expected), TOLERANCE);
    let dt = number(file, "dt_explicit")?;
    let explicit: Vec<f64> = grid
        .laplacians()
        .iter()
        .map(|&l| explicit_update(&parameters, d, force, l, dt))
        .collect();
    let expected = vec![number(file, "explicit_d_new")?; count];
    report.push("explicit_d_new", relative(&explicit, &expected), TOLERANCE);
    Ok(report.deviations)
}

#[cfg(test)]
mod tests {
    use super::uniform;
    use serde_json::json;

    /// Equal particles feel no Laplacian: d + Δt/η ((1 − d) D̃ − d), and implicitly
    /// (d + Δt/η D̃)/(1 + Δt/η (1 + D̃)).
    #[test]
    fn the_steps_are_those_of_the_file() {
        let (d, force, eta) = (0.15_f64, 2.5_f64, 0.4_f64);
        for (explicit, implicit) in [(0.002, 0.3), (0.013, 0.04)] {
            let rate = implicit / eta;
            let file = json!({
                "eta": eta, "d": d, "D_tilde": force, "dt": implicit, "dt_explicit": explicit,
                "d_new": (d + rate * force) / (1.0 + rate * (1.0 + force)),
                "explicit_d_new": d + explicit / eta * ((1.0 - d) * force - d),
            });
            let deviations = uniform::<2>(&file).unwrap();
            assert_eq!(deviations.len(), 2);
            assert!(deviations.iter().all(|d| d.is_good()), "{deviations:?}");
        }
    }
}
