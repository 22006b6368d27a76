//! Newton steps where the flesh follows its bones to first order.

use crate::promise::{Newton, solve_walking};
use crate::sheared_square::{moved, square};
use fem_assembly::Quasistatic;
use fem_materials::{Lame, NeoHookean, Space};
use fem_solvers::{ContinuationParams, NewtonParams};

#[test]
fn a_sheared_square_takes_few_steps_on_coarse_and_finer_meshes() {
    let Lame { lambda, mu } = Lame::from_young_poisson(100.0, 0.45, Space::Solid).unwrap();
    let steps = |n: usize| {
        let mut body = square(n, NeoHookean { mu, lambda });
        let (rest, moved) = (body.rest().to_vec(), moved(&body));
        let mut newton = Newton::new(&Quasistatic::new(&body, rest.clone(), vec![]).unwrap());
        let (params, walk) = (NewtonParams::default(), ContinuationParams::default());
        let there = solve_walking(&mut body, &mut newton, rest, &moved, &[], &params, &walk);
        let there = there.unwrap();
        assert_eq!((there.walk.steps, there.walk.failures), (1, 0), "n = {n}");
        there.iterations
    };
    let counts = [10, 30, 90].map(steps);
    println!("{counts:?}");
    assert!(counts.iter().all(|&c| c <= 9), "{counts:?}");
}
