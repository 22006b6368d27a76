use super::Deviation;
use super::read::{Report, at, list, matrices, node, number, numbers, relative, vectors};
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

fn one<const D: usize>(case: &Value) -> Result<Vec<Deviation>, String> {
    let mut report = Report {
        prefix: format!(
            "{D}D/{}",
            at(case, "symmetry")?.as_str().unwrap_or_default()
        ),
        deviations: Vec::new(),
    };
    let (h, per_axis) = (number(case, "h")?, number(case, "nodes_per_axis")? as usize);
    let parameters = DamageParameters {
        length_scale: number(case, "l0")?,
        zeta: number(case, "zeta")?,
        sigma_crit: number(case, "sigma_crit")?,
        eta: number(case, "eta")?,
    };
    let x = vectors::<D>(case, "x")?;
    let (F, sigma) = (matrices::<D>(case, "F")?, matrices::<D>(case, "sigma")?);
    let (volume, d) = (numbers(case, "V")?, numbers(case, "d")?);
    let history = numbers(case, "D_history")?;
    let alpha = numbers(case, "alpha")?;
    let a1 = vectors::<D>(case, "a1")?;
    let a2 = if alpha.len() > 1 {
        vectors::<D>(case, "a2")?
    } else {
        Vec::new()
    };
    let directors = |p: usize| {
        let first = Director {
            direction: a1[p],
            weight: alpha[0],
        };
        match a2.get(p) {
            None => Directors::TransverselyIsotropic(first),
            Some(&direction) => Directors::Orthotropic(
                first,
                Director {
                    direction,
                    weight: alpha[1],
                },
            ),
        }
    };
    let mut check = |name: &str, ours: &[f64], theirs: &[f64]| {
        report.push(name, relative(ours, theirs), TOLERANCE);
    };

    let all = 0..x.len();
    let A: Vec<_> = all
        .clone()
        .map(|p| directors(p).structural_tensor(&F[p]))
        .collect();
    check(
        "structural_tensor",
        &flat(&A),
        &numbers(case, "structural_tensor")?,
    );
    let plus: Vec<_> = sigma.iter().map(tensile_part).collect();
    check("sigma_plus", &flat(&plus), &numbers(case, "sigma_plus")?);
    let Phi: Vec<f64> = all
        .clone()
        .map(|p| crack_stress(&A[p], &plus[p], parameters.sigma_crit))
        .collect();
    check("Phi", &Phi, &numbers(case, "Phi")?);
    let force: Vec<f64> = all
        .clone()
        .map(|p| driving_force(&parameters, &directors(p), &F[p], &sigma[p], history[p]))
        .collect();
    check("D_tilde", &force, &numbers(case, "D_tilde")?);

    let mut grid = DamageGrid::<D>::new(h);
    grid.particles_to_grid(&x, &d).map_err(|e| e.to_string())?;
    let active: Vec<usize> = numbers(case, "active_nodes")?
        .iter()
        .map(|&n| n as usize)
        .collect();
    let places: Vec<usize> = active
        .iter()
        .map(|&n| grid.node_blocks().node_index(node(n, per_axis)))
        .collect::<Option<_>>()
        .ok_or("an active node is not on the grid")?;
    let on_grid = |values: &[f64]| -> Vec<f64> { places.iter().map(|&p| values[p]).collect() };
    check(
        "active nodes",
        &[grid.nodes().count() as f64],
        &[active.len() as f64],
    );
    check(
        "d_grid",
        &on_grid(&grid.values()),
        &numbers(case, "d_grid")?,
    );
    let laplacian = grid.laplacians();
    check("laplacian", &laplacian, &numbers(case, "laplacian")?);
    let resistance: Vec<f64> = all
        .clone()
        .map(|p| geometric_resistance(d[p], laplacian[p], parameters.length_scale))
        .collect();
    check("D_c", &resistance, &numbers(case, "D_c")?);
    let dt = number(case, "dt_explicit")?;
    let explicit: Vec<f64> = all
        .map(|p| explicit_update(&parameters, d[p], force[p], laplacian[p], dt))
        .collect();
    check("d_explicit", &explicit, &numbers(case, "d_explicit")?);

    let implicit = at(case, "implicit")?;
    let dt = number(case, "dt_implicit")?;
    let probe = numbers(implicit, "probe")?;
    let solutions = at(implicit, "solutions")?;
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
            let constants = |_| parameters;
            let system = ImplicitSystem::new(&grid, &volume, &force, &d, dt, &constants, &options)
                .map_err(|e| e.to_string())?;
            check(
                c,
                &on_grid(system.right_hand_side()),
                &numbers(implicit, c)?,
            );
            check(
                "A",
                &on_grid(system.lumped()),
                &numbers(implicit, "A_diagonal")?,
            );
            let diagonal: Vec<f64> = system
                .diagonal()
                .iter()
                .zip(system.lumped())
                .map(|(d, a)| d - a)
                .collect();
            let key = format!("B_{name}_diagonal");
            check(&key, &on_grid(&diagonal), &numbers(implicit, &key)?);
            let mut u = vec![0.0; diagonal.len()];
            for (&place, &value) in places.iter().zip(&probe) {
                u[place] = value;
            }
            let mut product = vec![0.0; u.len()];
            system.apply_laplace(&u, &mut product);
            let key = format!("B_{name}_times_probe");
            check(&key, &on_grid(&product), &numbers(implicit, &key)?);
            if let Some(expected) = solutions.get(format!("{name}/{side}")) {
                let solved = system.solve(options.tolerance).map_err(|e| e.to_string())?;
                let key = format!("{name}/{side}");
                check(
                    &format!("{key}/d_grid"),
                    &on_grid(&solved),
                    &numbers(expected, "d_grid")?,
                );
                check(
                    &format!("{key}/d_particles"),
                    &system.as_printed(&solved),
                    &numbers(expected, "d_particles")?,
                );
            }
        }
    }
    Ok(report.deviations)
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
