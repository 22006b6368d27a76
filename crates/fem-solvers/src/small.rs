//! D×D blocks on the stack.

/// `C -= A Bᵀ`.
pub(crate) fn subtract_product_transposed<const D: usize>(
    out: &mut [[f64; D]; D],
    a: &[[f64; D]; D],
    b: &[[f64; D]; D],
) {
    for r in 0..D {
        for c in 0..D {
            let mut sum = 0.0;
            for k in 0..D {
                sum += a[r][k] * b[c][k];
            }
            out[r][c] -= sum;
        }
    }
}

/// Lower Cholesky factor of the lower half of `a`, `None` unless every pivot is positive and finite.
pub(crate) fn cholesky<const D: usize>(a: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
    let mut l = [[0.0; D]; D];
    for j in 0..D {
        for i in j..D {
            let mut sum = a[i][j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                if !(sum > 0.0 && sum.is_finite()) {
                    return None;
                }
                l[j][j] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    Some(l)
}

/// Inverse of a lower triangle with non-zero diagonal.
pub(crate) fn lower_inverse<const D: usize>(l: &[[f64; D]; D]) -> [[f64; D]; D] {
    let mut inverse = [[0.0; D]; D];
    for j in 0..D {
        inverse[j][j] = 1.0 / l[j][j];
        for i in j + 1..D {
            let mut sum = 0.0;
            for k in j..i {
                sum += l[i][k] * inverse[k][j];
            }
            inverse[i][j] = -sum / l[i][i];
        }
    }
    inverse
}

/// `A⁻¹ = L⁻ᵀ L⁻¹` of a symmetric positive definite block, `None` otherwise.
pub(crate) fn inverse_positive_definite<const D: usize>(
    a: &[[f64; D]; D],
) -> Option<[[f64; D]; D]> {
    let li = lower_inverse(&cholesky(a)?);
    let mut inverse = [[0.0; D]; D];
    for r in 0..D {
        for c in 0..D {
            inverse[r][c] = (r.max(c)..D).map(|k| li[k][r] * li[k][c]).sum();
        }
    }
    Some(inverse)
}

/// The `N` numbers from a place on.
///
/// # Panics
/// If there are fewer.
#[inline(always)]
pub(crate) fn numbers<T, const N: usize>(values: &[T], from: usize) -> &[T; N] {
    match values[from..].first_chunk() {
        Some(found) => found,
        None => unreachable!("what is read in whole registers has a block behind it"),
    }
}
