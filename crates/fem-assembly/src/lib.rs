//! Simplex meshes, nodal forces, sparse Hessians, constraints and penalties for quasistatic finite elements

pub mod mesh;
