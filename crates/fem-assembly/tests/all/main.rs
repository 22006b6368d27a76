//! One program: kernels of a model are compiled once for all tests that use it.

mod active;
mod auto;
mod carried_contact;
mod contact;
mod derivatives;
mod evaluations;
mod free_parts;
mod hertz;
mod incompressible;
mod lengths;
mod loads;
mod meaning;
mod multigrid;
mod own_solution;
mod promise;
mod quadratic;
mod rigid_contact;
mod sheared_square;
mod spp_block;
mod steps;
mod stop_rule;
mod symmetry_planes;
mod terms;
mod thresholded;
mod unheld;
