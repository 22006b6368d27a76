//! A bar of n × n × 4n cubes, 1 m wide, twisted or bent, and the places where its shape is compared.

use super::elastic::{self, Kind, NONE, flesh, lame};
use crate::body::{Body, Linear, to};
use crate::failure::Failure;
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{AssemblyBuilder, Dofs};
use std::collections::BTreeMap;

/// Young's modulus, Pa.
const YOUNG: f64 = 1e5;
/// Length, m; the width is 1 m.
const LENGTH: f64 = 4.0;

/// What is done to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// The upper end is turned by 60° and lifted by a tenth of the length.
    Twist,
    /// The upper end is pushed aside by 30 % of the length, free to sink and to turn.
    Bend,
}

impl Load {
    fn place(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let share = z / LENGTH;
        match self {
            Self::Twist => {
                let (sin, cos) = (60.0 * share).to_radians().sin_cos();
                let (x, y) = (x - 0.5, y - 0.5);
                [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y, 1.1 * z]
            }
            Self::Bend => [x + 0.3 * LENGTH * share * share, y, z],
        }
    }

    fn dofs(self, nodes: &[[f64; 3]]) -> Result<Dofs<3>, Failure> {
        let at = |z: f64| (0..nodes.len()).filter(move |&n| nodes[n][2] == z);
        Ok(match self {
            Self::Twist => {
                let ends: Vec<usize> = at(0.0).chain(at(LENGTH)).collect();
                Dofs::with_prescribed_nodes(nodes, &ends)?
            }
            Self::Bend => {
                let prescribed: Vec<usize> = at(0.0).collect();
                let pushed: Vec<(usize, usize)> = at(LENGTH).map(|n| (n, 0)).collect();
                Dofs::new(nodes, &prescribed, &pushed)?
            }
        })
    }
}

/// A bar that can be solved.
pub struct Bar {
    /// The body.
    pub body: Body,
    rest: Vec<[f64; 3]>,
}

fn mesh(n: usize) -> Result<SimplexMesh<3>, Failure> {
    Ok(kuhn_grid(n, n, 4 * n, [1.0, 1.0, LENGTH])?)
}

impl Bar {
    /// Of neo-Hookean flesh, E = 100 kPa.
    ///
    /// # Errors
    /// If `n` is zero.
    pub fn new(load: Load, n: usize, kind: Kind, poisson: f64) -> Result<Self, Failure> {
        let mesh = mesh(n)?;
        let rest = elastic::nodes(&mesh, kind)?;
        let dofs = load.dofs(&rest)?;
        let assembly = flesh(&mesh, kind, lame(YOUNG, poisson), dofs, NONE)?;
        Ok(Self::of(load, assembly, rest))
    }

    /// Of linear tetrahedra of another model with the same constants.
    ///
    /// # Errors
    /// If `n` is zero, or no model has this name and these constants.
    pub fn of_model(load: Load, n: usize, model: &str, poisson: f64) -> Result<Self, Failure> {
        let mesh = mesh(n)?;
        let builder = AssemblyBuilder::new(&mesh, load.dofs(mesh.nodes())?)?;
        let builder = elastic::named(builder, &mesh, model, lame(YOUNG, poisson))?;
        Ok(Self::of(load, builder.build()?, mesh.nodes().to_vec()))
    }

    fn of(load: Load, assembly: fem_assembly::Assembly<3>, rest: Vec<[f64; 3]>) -> Self {
        let body = Body {
            assembly,
            start: rest.iter().map(|&p| load.place(p)).collect(),
            controls: vec![],
        };
        Self { body, rest }
    }

    /// Where the corners of the four cubes of 1 m are: every grid has them.
    pub fn probes(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut found = BTreeMap::new();
        for (rest, &x) in self.rest.iter().zip(positions) {
            let place = *rest;
            if place.iter().all(|c| (c - c.round()).abs() < 1e-6) {
                found.insert(place.map(|c| c.round() as i64), x);
            }
        }
        found.into_values().collect()
    }
}

/// Where the probes of a bar of quadratic elements are: what other bars are compared with.
///
/// # Errors
/// If it does not converge.
pub fn truth(load: Load, n: usize, poisson: f64, how: Linear) -> Result<Vec<[f64; 3]>, Failure> {
    let bar = Bar::new(load, n, Kind::Quadratic, poisson)?;
    let solved = bar.body.solve(how, &to(1e-10))?;
    Ok(bar.probes(&solved.positions))
}
