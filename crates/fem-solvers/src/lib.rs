//! Newton, preconditioned conjugate gradients, sparse Cholesky and Gauss-Newton on slices; knows no mesh
