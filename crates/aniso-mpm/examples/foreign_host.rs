//! The damage augmentation inside a program that knows nothing of this crate's host: a rod of
//! particles stretched by a prescribed motion. The augmentation itself is the few lines between
//! the two rulers; a real host calls them just before it computes its grid velocities.
//!
//! `cargo run --release -p aniso-mpm --example foreign_host`
#![allow(non_snake_case)]
use aniso_mpm::damage::{
    Augmentation, DamageInput, DamageModel, DamageParameters, DamageUpdate, Directors,
    cauchy_stress,
};

use fem_kinematics::Mat;
use fem_materials::QrAnisotropic;
use fem_materials::field::{Local1, MaterialField};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The foreign host's own state.
    let h = 0.1;
    let rest: Vec<[f64; 2]> = (0..400)
        .map(|i| [0.05 * (i % 40) as f64, 0.05 * (i / 40) as f64])
        .collect();
    let (mut damage, mut history) = (vec![0.0; 400], vec![0.0; 400]);
    let material = QrAnisotropic::from_young_poisson(1e5, 0.3, 0.0, 0.0)?.degradable(1e-3);
    let dt = 1e-3;

    // --------------------------------------------------------------------------------------
    let model = DamageModel {
        parameters: DamageParameters::new(h, 8e3, 5e-3),
        directors: Directors::fiber(0.5),
    };
    let mut augmentation = Augmentation::new(h, DamageUpdate::Explicit);
    // --------------------------------------------------------------------------------------

    for step in 0..100 {
        // The host moves: stretched along the first axis, most in the middle.
        let grow = 0.2 * f64::from(step) / 100.0;
        let slope = |X: &[f64; 2]| grow * (-8.0 * (X[0] - 1.0).powi(2)).exp();
        let F: Vec<_> = rest
            .iter()
            .map(|X| Mat([[1.0 + slope(X), 0.0], [0.0, 1.0]]))
            .collect();
        let x = rest.clone();

        // ----------------------------------------------------------------------------------
        let sigma: Vec<_> = F
            .iter()
            .map(|F| cauchy_stress(&material.stress(&Local1(0.0), F), F))
            .collect();
        let volume: Vec<_> = F.iter().map(|F| 0.05 * 0.05 * F.determinant()).collect();
        let input = DamageInput {
            x: &x,
            F: &F,
            sigma: &sigma,
            volume: &volume,
            d: &damage,
            history: &history,
        };
        let new = augmentation.step(&input, &|_| Some(model), dt)?;
        (damage, history) = (new.d, new.history);
        // ----------------------------------------------------------------------------------

        // The host goes on: grid velocities from material.stress(&Local1(damage[p]), &F[p]), and so on.
    }
    let middle = damage[20];
    let end = damage[0];
    println!("damage in the middle {middle:.3}, at the end {end:.3}");
    assert!(middle > 0.5 && end < 1e-3);
    Ok(())
}
