//! Where the host enforces inextensible fibers: right after the explicit grid velocity.

use crate::body::Fiber;
use crate::error::MpmError;
use crate::float::Float;
use crate::inextensibility::{CollisionRow, FiberGrid, Projection};
use crate::simulation::Simulation;
use crate::transfer::Scheme;
use fem_kinematics::dot;
use fem_materials::DamageField;
use fem_solvers::PcgParams;

impl<T: Float, S: Scheme, M: DamageField<D>, const D: usize> Simulation<T, S, M, D> {
    /// Replaces the grid velocity by the nearest one that stretches no inextensible fiber and
    /// meets the obstacles.
    pub(crate) fn project_onto_inextensible(&mut self, dt: f64) -> Result<(), MpmError> {
        let particles = &self.particles;
        let (mut x, mut volume, mut a) = (Vec::new(), Vec::new(), Vec::new());
        for p in 0..particles.len() {
            if self.bodies[particles.body[p] as usize].fiber == Fiber::Inextensible {
                x.push(particles.x[p]);
                volume.push(particles.volume[p] * particles.F[p].determinant().abs());
                // a = F e₁: the fiber frame starts along the fiber.
                a.push(particles.F[p].column(0));
            }
        }
        if x.is_empty() {
            return Ok(());
        }
        let h = self.settings.cell_size;
        let grid = FiberGrid::new(h, &x, &volume, &a)?;
        let ours = self.binning.node_blocks();
        let places: Vec<Option<usize>> = (0..grid.len())
            .map(|i| ours.node_index(grid.node_blocks().node(i)))
            .collect();
        let mut inverse_mass = vec![0.0; grid.len()];
        let mut v = vec![[0.0; D]; grid.len()];
        let mut collisions = Vec::new();
        for (node, place) in places.iter().enumerate() {
            let Some(place) = *place else { continue };
            let value = &self.field[place];
            let mass = value[3].to_f64();
            if !(mass > 0.0) {
                continue;
            }
            inverse_mass[node] = dt / mass;
            v[node] = core::array::from_fn(|c| value[c].to_f64());
            let at = grid.node_blocks().node(node).map(|i| f64::from(i) * h);
            for obstacle in &self.obstacles {
                let Some(constraint) = obstacle.constraint(at, self.time + dt) else {
                    continue;
                };
                for normal in constraint.prescribed_directions(&v[node]) {
                    collisions.push(CollisionRow {
                        node,
                        normal,
                        speed: dot(normal, constraint.velocity),
                    });
                }
            }
        }
        let params = PcgParams {
            relative_tolerance: 1e-6,
            max_iterations: 2000,
            stagnation_window: 400,
            ..PcgParams::default()
        };
        let solution = Projection::new(&grid, &inverse_mass, &collisions)?.project(v, &params)?;
        for (node, place) in places.iter().enumerate() {
            if let (Some(place), true) = (*place, inverse_mass[node] > 0.0) {
                for c in 0..D {
                    self.field[place][c] = T::from_f64(solution.v[node][c]);
                }
            }
        }
        Ok(())
    }
}
