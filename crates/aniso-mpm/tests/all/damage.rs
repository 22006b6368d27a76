//! Damage in time: explicit against implicit, irreversibility, and a grid only where it is needed.
use aniso_mpm::damage::{
    Augmentation, DamageGrid, DamageInput, DamageModel, DamageParameters, DamageUpdate, Director,
    Directors, Gradient, ImplicitOptions, ImplicitSystem, RightHandSide, cauchy_stress,
    driving_force, explicit_update, stress_at_stretch, tensile_part,
};
use fem_kinematics::{Mat, cauchy_from_piola};
use fem_materials::{Material, NeoHookean};

const H: f64 = 0.1;

fn model() -> DamageModel<2> {
    DamageModel {
        parameters: DamageParameters::new(H, 1.0, 0.05),
        directors: Directors::Isotropic,
    }
}

/// d after 0.1 s with a constant history of the driving force, in steps of `dt`.
fn run(update: DamageUpdate, dt: f64, d0: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
    let x: Vec<[f64; 2]> = (0..225)
        .map(|i| [0.08 * (i % 15) as f64, 0.08 * (i / 15) as f64])
        .collect();
    let F = vec![Mat::identity(); x.len()];
    let sigma = vec![Mat::zeros(); x.len()];
    let volume = vec![0.0064; x.len()];
    let mut d: Vec<f64> = x.iter().map(|&x| d0(x)).collect();
    let mut history = vec![1.7; x.len()];
    let mut augmentation = Augmentation::new(H, update);
    for _ in 0..(0.1 / dt).round() as usize {
        let input = DamageInput {
            x: &x,
            F: &F,
            sigma: &sigma,
            volume: &volume,
            d: &d,
            history: &history,
        };
        let new = augmentation.step(&input, &|_| Some(model()), dt).unwrap();
        (d, history) = (new.d, new.history);
    }
    d
}

#[test]
fn explicit_and_implicit_agree_to_first_order_in_the_step() {
    let [long, short] = [2e-3, 1e-3].map(|dt| (dt, run(DamageUpdate::Explicit, dt, |_| 0.2)));
    for gradient in [Gradient::MlsMpm, Gradient::BSpline] {
        for right_hand_side in [RightHandSide::GridDamage, RightHandSide::ParticleDamage] {
            let implicit = DamageUpdate::Implicit(ImplicitOptions {
                right_hand_side,
                gradient,
                tolerance: 1e-12,
            });
            let difference = |(dt, explicit): &(f64, Vec<f64>)| {
                run(implicit, *dt, |_| 0.2)
                    .iter()
                    .zip(explicit)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max)
            };
            let (long, short) = (difference(&long), difference(&short));
            let order = (long / short).log2();
            println!("{gradient:?} {right_hand_side:?}: {long:.2e} {short:.2e}, order {order:.3}");
            assert!((order - 1.0).abs() < 0.1);
        }
    }
}

#[test]
fn damage_never_heals_and_stays_below_one() {
    let bump = |x: [f64; 2]| {
        if (x[0] - 0.6).hypot(x[1] - 0.6) < 0.1 {
            1.0
        } else {
            0.0
        }
    };
    let before: Vec<f64> = run(DamageUpdate::Explicit, 1.0, bump);
    for update in [
        DamageUpdate::Explicit,
        DamageUpdate::Implicit(ImplicitOptions::default()),
    ] {
        let after = run(update, 5e-3, bump);
        for (a, b) in after.iter().zip(&before) {
            assert!(*a <= 1.0 && (*b < 1.0 || *a == 1.0));
        }
    }
}

#[test]
fn nothing_happens_where_nothing_can() {
    let x = vec![[0.0; 3]; 50];
    let zero = vec![0.0; 50];
    let input = DamageInput {
        x: &x,
        F: &vec![Mat::identity(); 50],
        sigma: &vec![Mat::zeros(); 50],
        volume: &vec![1.0; 50],
        d: &zero,
        history: &zero,
    };
    let damage = DamageModel {
        parameters: DamageParameters::new(H, 1.0, 0.05),
        directors: Directors::<3>::Isotropic,
    };
    for update in [
        DamageUpdate::Explicit,
        DamageUpdate::Implicit(ImplicitOptions::default()),
    ] {
        let mut augmentation = Augmentation::new(H, update);
        let mut blocks = |d: &[f64], history: &[f64]| {
            let input = DamageInput {
                d,
                history,
                ..input
            };
            let out = augmentation.step(&input, &|_| Some(damage), 0.1).unwrap();
            (augmentation.active_blocks(), out)
        };
        // A grid where something can happen, and none left over from it afterwards.
        let mut one = zero.clone();
        one[7] = 0.5;
        assert!(blocks(&one, &zero).0 > 0);
        assert!(blocks(&zero, &one).0 > 0);
        let (count, out) = blocks(&zero, &zero);
        assert_eq!(count, 0);
        assert_eq!((out.d, out.history), (zero.clone(), zero.clone()));
    }
}

#[test]
fn structural_tensor_turns_with_the_material_and_survives_collapse() {
    let (s, c) = 0.7f64.sin_cos();
    let turn = Mat([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]);
    let stretch = Mat::from_diagonal([1.4, 0.8, 1.1]);
    let directors = Directors::Orthotropic(
        Director {
            direction: [1.0, 0.0, 0.0],
            weight: -1.0,
        },
        Director {
            direction: [0.0, 1.0, 0.0],
            weight: 0.5,
        },
    );
    let A = directors.structural_tensor(&(turn * stretch));
    let expected = turn * Mat::from_diagonal([0.0, 1.5, 1.0]) * turn.transpose();
    assert!((A - expected).norm_squared().sqrt() < 1e-14);
    for F in [Mat::zeros(), Mat::from_diagonal([0.0, 1.0, -1.0])] {
        let A: Mat<f64, 3> = directors.structural_tensor(&F);
        // The eigenvalues are those of the reference, however F looks.
        assert!((A.trace() - 2.5).abs() < 1e-12);
    }
}

#[test]
fn tensile_part_and_starting_value_of_the_critical_stress() {
    let sigma: Mat<f64, 2> = Mat([[1.0, 2.0], [2.0, 1.0]]);
    // Eigenvalues 3 and −1.
    let plus = tensile_part(&sigma);
    assert!((plus - Mat([[1.5, 1.5], [1.5, 1.5]])).norm_squared().sqrt() < 1e-15);
    let law = NeoHookean {
        mu: 2.0,
        lambda: 3.0,
    };
    // σ = μ (s² − 1)/s + λ ln s/s for F = diag(s, 1).
    let s: f64 = 1.3;
    let expected = (2.0 * (s * s - 1.0) + 3.0 * s.ln()) / s;
    assert!((stress_at_stretch(&law, [0.0, 1.0], s) - expected).abs() < 1e-14);
}

#[test]
fn cauchy_stress_is_that_of_the_definition_and_nothing_at_no_volume() {
    let law = NeoHookean {
        mu: 2.0,
        lambda: 3.0,
    };
    let F: Mat<f64, 3> = Mat([[1.2, 0.3, 0.1], [-0.2, 0.9, 0.4], [0.0, 0.1, 1.3]]);
    let P = law.stress(&F);
    let expected = cauchy_from_piola(&F, &P);
    assert!(expected.norm_squared() > 0.1);
    assert!((cauchy_stress(&P, &F) - expected).norm_squared().sqrt() < 1e-14);
    // By hand, inverted: σ = P Fᵀ/J with J = −2.
    let F = Mat([[2.0, 0.0], [0.0, -1.0]]);
    let P = Mat([[3.0, 1.0], [-2.0, 5.0]]);
    assert_eq!(cauchy_stress(&P, &F), Mat([[-3.0, 1.25], [1.25, 2.5]]));
    let flat = Mat([[1.0, 2.0], [2.0, 4.0]]);
    assert_eq!(cauchy_stress(&P, &flat), Mat::zeros());
    assert!(cauchy_stress(&P, &flat.scale(f64::NAN)).0[0][0].is_nan());
}

#[test]
fn defaults_of_the_document() {
    let parameters = DamageParameters::new(0.3, 7.0, 0.2);
    assert_eq!(parameters.length_scale, 0.15);
    assert_eq!(parameters.zeta, 1.0);
    assert_eq!((parameters.sigma_crit, parameters.eta), (7.0, 0.2));
}

/// ζ ⟨(σ/σ_c)² − 1⟩ of a stress along one axis; what presses across it tears nothing.
#[test]
fn the_driving_force_begins_at_the_critical_stress_and_never_falls() {
    let parameters = DamageParameters {
        zeta: 1.5,
        ..DamageParameters::new(H, 2.0, 0.05)
    };
    let force = |stress: f64, history: f64| {
        let (F, sigma) = (Mat::identity(), Mat::from_diagonal([stress, -7.0]));
        driving_force(&parameters, &Directors::<2>::Isotropic, &F, &sigma, history)
    };
    for (stress, expected) in [(4.0, 4.5), (3.0, 1.875), (2.0, 0.0), (1.0, 0.0)] {
        let found = force(stress, 0.0);
        assert!((found - expected).abs() < 1e-14, "{stress}: {found}");
        assert_eq!(force(stress, 5.0), 5.0);
    }
}

#[test]
fn a_step_ends_at_one_however_much_drives_it() {
    let parameters = DamageParameters::new(H, 1.0, 0.05);
    // d + Δt/η ((1 − d) D̃ − d) with no Laplacian: 0.9 + 20 (0.1 · 50 − 0.9) = 82.9.
    assert_eq!(explicit_update(&parameters, 0.9, 50.0, 0.0, 1.0), 1.0);
    let short = explicit_update(&parameters, 0.9, 50.0, 0.0, 1e-4);
    assert!((short - (0.9 + 1e-4 / 0.05 * 4.1)).abs() < 1e-15);
}

/// The system by hand: nothing heals and nothing goes beyond 1, whoever calls it.
#[test]
fn a_direct_caller_gets_no_damage_above_one_and_none_that_heals() {
    let x: Vec<[f64; 2]> = (0..64)
        .map(|i| [0.05 * (i % 8) as f64, 0.05 * (i / 8) as f64])
        .collect();
    let old: Vec<f64> = (0..64).map(|i| if i == 27 { 0.8 } else { 0.1 }).collect();
    let mut grid = DamageGrid::new(H);
    grid.particles_to_grid(&x, &old).unwrap();
    let (volume, force) = ([0.0025; 64], [0.0; 64]);
    let constants = |_| DamageParameters::new(H, 1.0, 0.05);
    let options = ImplicitOptions::default();
    let system =
        ImplicitSystem::new(&grid, &volume, &force, &old, 0.1, &constants, &options).unwrap();
    let solved = system.solve(1e-10).unwrap();
    // Nothing drives it, so that diffusion and the resistance alone would lower every number.
    assert!(solved.iter().all(|d| *d < 0.8));
    assert_eq!(system.grid_to_particles(&solved), old);
    let large = vec![3.0; solved.len()];
    assert_eq!(system.grid_to_particles(&large), [1.0; 64]);
    let unknown = vec![f64::NAN; solved.len()];
    assert!(
        system
            .grid_to_particles(&unknown)
            .iter()
            .all(|d| d.is_nan())
    );
}

/// Where nothing can happen no grid is made: what is left out of it would have changed by less than
/// rounding shows. A history that is hardly more than nothing puts every particle on the grid.
#[test]
fn what_is_left_out_of_the_grid_changes_nothing() {
    // A row of 24 cells, damaged in one cell, in places that lie differently in their blocks.
    let x: Vec<[f64; 3]> = (0..192)
        .map(|i| [i / 4, i / 2 % 2, i % 2].map(|k| 0.5 * H * (k as f64 + 0.5)))
        .collect();
    let damage = DamageModel {
        parameters: DamageParameters::new(H, 1.0, 0.05),
        directors: Directors::<3>::Isotropic,
    };
    let (F, sigma) = (vec![Mat::identity(); 192], vec![Mat::zeros(); 192]);
    let volume = vec![0.125 * H * H * H; 192];
    for update in [
        DamageUpdate::Explicit,
        DamageUpdate::Implicit(ImplicitOptions::default()),
    ] {
        for cell in [0, 3, 4, 7, 12, 23] {
            let d: Vec<f64> = (0..192)
                .map(|i| if i / 8 == cell { 0.8 } else { 0.0 })
                .collect();
            let after = |history: f64| {
                let input = DamageInput {
                    x: &x,
                    F: &F,
                    sigma: &sigma,
                    volume: &volume,
                    d: &d,
                    history: &vec![history; 192],
                };
                let mut augmentation = Augmentation::new(H, update);
                let new = augmentation.step(&input, &|_| Some(damage), 0.05).unwrap();
                (new.d, augmentation.active_blocks())
            };
            let ((near, few), (all, many)) = (after(0.0), after(f64::MIN_POSITIVE));
            let apart = near.iter().zip(&all).map(|(a, b)| (a - b).abs());
            let apart = apart.fold(0.0, f64::max);
            assert!(apart < 1e-9, "{update:?}, cell {cell}: {apart:e}");
            // At an end of the row it does not reach the other, in the middle it may.
            assert!(few <= many && (few < many || (1..23).contains(&cell)));
            let spread = near.iter().zip(&d).filter(|(a, b)| a > b).count();
            assert!(spread > 0, "{update:?}, cell {cell}");
        }
    }
}
