//! D²×D² matrices of ∂P/∂F in the orders that the documents use.

use crate::scalar::Real;
use crate::tensor4::Tensor4;

/// 11, 22, 33, 12, 21, 13, 31, 23, 32: the order in which ∂P/∂F of an isotropic model at a
/// diagonal F̂ is block diagonal: one 3×3 block, three 2×2 blocks (document 000, section 4.5).
pub const BLOCK_ORDER_3D: [(usize, usize); 9] = [
    (0, 0),
    (1, 1),
    (2, 2),
    (0, 1),
    (1, 0),
    (0, 2),
    (2, 0),
    (1, 2),
    (2, 1),
];
/// 11, 22, 12, 21.
pub const BLOCK_ORDER_2D: [(usize, usize); 4] = [(0, 0), (1, 1), (0, 1), (1, 0)];
/// 11, 12, 13, 21, …: entry (i, j) at 3 i + j (Teran et al., Vega FEM).
pub const ROW_MAJOR_3D: [(usize, usize); 9] = [
    (0, 0),
    (0, 1),
    (0, 2),
    (1, 0),
    (1, 1),
    (1, 2),
    (2, 0),
    (2, 1),
    (2, 2),
];
/// 11, 12, 21, 22.
pub const ROW_MAJOR_2D: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

/// ∂P/∂F as an N×N matrix (N = D²): rows by the (i, j) of P, columns by the (k, l) of F.
#[inline(always)]
pub fn to_flat<T: Real, const D: usize, const N: usize>(
    tensor: &Tensor4<T, D>,
    order: &[(usize, usize); N],
) -> [[T; N]; N] {
    let mut flat = [[T::zero(); N]; N];
    for (row, &(i, j)) in flat.iter_mut().zip(order) {
        for (entry, &(k, l)) in row.iter_mut().zip(order) {
            *entry = tensor.get(i, j, k, l);
        }
    }
    flat
}

/// The tensor of an N×N matrix in the given order: the inverse of [`to_flat`].
#[inline(always)]
pub fn from_flat<T: Real, const D: usize, const N: usize>(
    flat: &[[T; N]; N],
    order: &[(usize, usize); N],
) -> Tensor4<T, D> {
    let mut tensor = Tensor4::zeros();
    for (row, &(i, j)) in flat.iter().zip(order) {
        for (&entry, &(k, l)) in row.iter().zip(order) {
            *tensor.entry_mut(i, j, k, l) = entry;
        }
    }
    tensor
}
