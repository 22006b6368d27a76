//! The Hessian of the incremental potential where the material's own is indefinite.

use super::*;
use crate::kernels::Quadratic;
use crate::particles::Particle;
use crate::simulation::Settings;
use crate::transfer::MlsMpm;
use fem_materials::StVenantKirchhoff;

const H: f64 = 0.1;
const DT: f64 = 0.05;

type Host = Simulation<f64, MlsMpm<Quadratic>, StVenantKirchhoff, 2>;

/// Six by six particles, all deformed by `F`, on a grid that knows them.
fn host(F: Mat<f64, 2>) -> Host {
    let mut particles = Particles::new();
    for k in 0..36 {
        let particle = Particle {
            x: [f64::from(k % 6), f64::from(k / 6)].map(|i| 1.0 + 0.5 * H * i),
            v: [0.0; 2],
            F,
            mass: 1e-3,
            volume: 0.25 * H * H,
            damage: 0.0,
            body: 0,
        };
        particles.push(&particle).unwrap();
    }
    let material = StVenantKirchhoff {
        mu: 400.0,
        lambda: 1e3,
    };
    let body = Body::elastic(material);
    let mut host = Host::new(Settings::new(H), vec![body], vec![], particles).unwrap();
    host.binning.rebuild(&host.particles.x).unwrap();
    host.particles_to_grid(0.0, None);
    host.grid_velocity(DT);
    host
}

/// Δxᵀ H Δx without the masses' part, over Δxᵀ Δx, for many Δx: the least and the largest.
fn curvatures(host: &Host, projection: HessianProjection) -> (f64, f64) {
    let potential = host.potential(DT, None);
    let v = potential.target.as_flattened().to_vec();
    let mut seed = 1_u64;
    let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..200 {
        let x: Vec<f64> = (0..v.len())
            .map(|i| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let free = potential.mass[i / 2] > 0.0;
                f64::from(u8::from(free)) * ((seed >> 40) as f64 / f64::from(1 << 24) - 0.5)
            })
            .collect();
        let mut y = vec![0.0; x.len()];
        potential.hessian_vector(&v, projection, &x, &mut y);
        let (mut along, mut squares) = (0.0, 0.0);
        for i in 0..x.len() {
            along += x[i] * (y[i] - potential.mass[i / 2] * x[i]);
            squares += x[i] * x[i];
        }
        least = least.min(along / squares);
        largest = largest.max(along / squares);
    }
    (least, largest)
}

#[test]
fn the_projected_hessian_curves_upwards_where_the_exact_one_does_not() {
    let crushed = host(Mat([[0.73, 0.0], [0.0, 0.73]]));
    let (exact, _) = curvatures(&crushed, HessianProjection::None);
    assert!(exact < 0.0, "{exact}");
    for projection in [HessianProjection::Clamp, HessianProjection::Absolute] {
        let (least, largest) = curvatures(&crushed, projection);
        assert!(least >= 0.0 && largest > 0.0, "{least} {largest}");
    }
}

#[test]
fn nothing_is_projected_where_the_exact_hessian_is_definite() {
    let stretched = host(Mat([[1.02, 0.0], [0.0, 1.01]]));
    let exact = curvatures(&stretched, HessianProjection::None);
    let clamped = curvatures(&stretched, HessianProjection::Clamp);
    assert!(exact.0 > 0.0);
    assert!((clamped.0 / exact.0 - 1.0).abs() < 1e-12);
    assert!((clamped.1 / exact.1 - 1.0).abs() < 1e-12);
}
