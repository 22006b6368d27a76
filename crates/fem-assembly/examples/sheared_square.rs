//! Why Newton's steps grow with the mesh: a square whose upper edge is sheared by 0.8 of its height.
//!
//! `cargo run --release -p fem-assembly --example sheared_square -- [cells along an edge]…`

use fem_assembly::{Assembly, Quasistatic, solve_walking};
use fem_materials::{Lame, Linear, NeoHookean, Space};
use fem_solvers::{ContinuationParams, Newton, NewtonParams, ProjectionPolicy};
use std::error::Error;

#[path = "../tests/all/sheared_square.rs"]
mod sheared_square;
use sheared_square::{moved, square};

type Failure = Box<dyn Error>;

/// Steps, and the shape.
fn sheared(
    mut body: Assembly<2>,
    projection: ProjectionPolicy,
) -> Result<(usize, Vec<[f64; 2]>), Failure> {
    let rest = body.rest().to_vec();
    let moved = moved(&body);
    let mut newton = Newton::new(&Quasistatic::held(&body, rest.clone(), vec![])?);
    let params = NewtonParams {
        projection,
        max_iterations: 200,
        ..NewtonParams::default()
    };
    let walk = ContinuationParams::default();
    let there = solve_walking(&mut body, &mut newton, rest, &moved, &[], &params, &walk)?;
    Ok((there.iterations, there.positions))
}

fn main() -> Result<(), Failure> {
    let given: Result<Vec<usize>, _> = std::env::args().skip(1).map(|a| a.parse()).collect();
    let sizes = match given? {
        none if none.is_empty() => vec![10, 30, 100],
        sizes => sizes,
    };
    let Lame { lambda, mu } = Lame::from_young_poisson(100.0, 0.45, Space::Solid)?;
    println!(
        "cells  inside out by the tangent, least det F   steps (blended)   least det F at the end"
    );
    for n in sizes {
        // The solution of the linear problem is where the tangent at rest leads.
        let linear = square(n, Linear { mu, lambda });
        let (_, tangent) = sheared(linear, ProjectionPolicy::ExactFirst)?;
        let body = || square(n, NeoHookean { mu, lambda });
        let least = |x: &[[f64; 2]]| -> Result<(f64, usize), Failure> {
            let body = body();
            let ratios = body.volume_ratios(body.configuration(x, &[])?)?;
            let inverted = ratios.iter().filter(|&&ratio| !(ratio > 0.0)).count();
            Ok((
                ratios.iter().copied().fold(f64::INFINITY, f64::min),
                inverted,
            ))
        };
        let (by_tangent, inverted) = least(&tangent)?;
        let (steps, end) = sheared(body(), ProjectionPolicy::ExactFirst)?;
        let (blended, _) = sheared(body(), ProjectionPolicy::ExactThenBlended)?;
        let (at_end, _) = least(&end)?;
        println!("{n:5} {inverted:20} {by_tangent:19.3} {steps:10} ({blended}) {at_end:20.3}");
    }
    Ok(())
}
