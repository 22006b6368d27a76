//! Deformation gradients, signed decompositions, strains and invariants with exact derivatives, in 2D and 3D
