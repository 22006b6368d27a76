//! The sort of particles by block, run by run, against a plain stable sort.
use super::{Host, lattice};
use aniso_mpm::kernels::locate;
use aniso_mpm::{Binning, Body, Cubic, Float, MpmError, Quadratic, Settings, Spline, block_side};
use fem_materials::QrAnisotropic;

const H: f64 = 0.1;

/// Places on both sides of 0, each a few times in a row near the one before, so that runs of all
/// lengths occur.
fn places<T: Float, const D: usize>(count: usize) -> Vec<[T; D]> {
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let mut at = [0.0; D];
    let mut places = Vec::new();
    for _ in 0..count {
        let far = random() < 0.3;
        for x in &mut at {
            *x = if far {
                6.0 * random() - 3.0
            } else {
                *x + 0.05 * (random() - 0.5)
            };
        }
        places.push(at.map(T::from_f64));
    }
    places
}

fn sorts_as_a_stable_sort_does<K: Spline, T: Float, const D: usize>() {
    let x = places::<T, D>(10_000);
    let side = block_side(D) as i32;
    let block = |p: &u32| {
        let (base, _) = locate::<K, T, D>(&x[*p as usize], T::from_f64(H));
        base.map(|i| i.div_euclid(side))
    };
    let mut expected: Vec<u32> = (0..x.len() as u32).collect();
    expected.sort_by_key(block);
    let mut binning = Binning::<K, D>::new(H);
    // The second time from another state, and back.
    for _ in 0..2 {
        binning.rebuild(&x).unwrap();
        assert!(binning.order() == expected, "another order");
        binning.rebuild(&x[..100]).unwrap();
        assert_eq!(binning.order().len(), 100);
    }
}

#[test]
fn runs_of_particles_are_sorted_as_single_ones_are() {
    sorts_as_a_stable_sort_does::<Quadratic, f64, 2>();
    sorts_as_a_stable_sort_does::<Quadratic, f64, 3>();
    sorts_as_a_stable_sort_does::<Cubic, f32, 2>();
    sorts_as_a_stable_sort_does::<Cubic, f32, 3>();
}

/// Each of them alone and in a row of particles in one block, the one at the origin.
#[test]
fn the_first_place_that_no_block_holds_is_named() {
    for wrong in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e9, -1e12, 1e300] {
        for axis in 0..3 {
            let mut x = vec![[0.1; 3]; 10];
            x[6][axis] = wrong;
            x[8][axis] = wrong;
            match Binning::<Quadratic, 3>::new(H).rebuild(&x) {
                Err(MpmError::ParticleOffGrid { particle: 6, .. }) => {}
                other => panic!("{wrong} on axis {axis}: {other:?}"),
            }
        }
    }
}

/// A step that finds the blocks of the step before again keeps what it knows of them: a simulation
/// that has gone on for a while does what one does that starts with its particles.
#[test]
fn a_body_in_flight_goes_on_as_one_that_starts_there() {
    let mut particles = lattice::<f64, 3>([0.0; 3], [0.5; 3], 0.05, |_| true);
    for v in &mut particles.v {
        *v = [7.0, -3.0, 1.0];
    }
    let law = QrAnisotropic::from_young_poisson(1e3, 0.3, 2e3, 5e2).unwrap();
    let start = |particles| {
        let bodies = vec![Body::elastic(law.degradable(1e-3))];
        Host::<3>::new(Settings::new(H), bodies, vec![], particles).unwrap()
    };
    let mut host = start(particles);
    let (mut moved, mut blocks) = (0, host.active_blocks());
    for _ in 0..60 {
        let mut fresh = start(host.particles().clone());
        host.step(2e-3).unwrap();
        fresh.step(2e-3).unwrap();
        assert_eq!(host.particles(), fresh.particles());
        moved += usize::from(host.active_blocks() != blocks);
        blocks = host.active_blocks();
    }
    assert!(moved > 3, "the body stayed in its blocks");
}
