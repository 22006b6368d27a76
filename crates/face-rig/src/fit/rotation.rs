//! Rotation vectors and their derivative.

/// R = exp([w]ₓ): a turn by |w| radians about w. Also ∂R/∂w_k for each k.
///
/// With s = sin θ/θ and c = (1 − cos θ)/θ², R = I + s [w]ₓ + c [w]ₓ². Near 0 both are summed as
/// series, where the quotients would be 0/0.
pub(super) fn rotation_with_derivative(w: [f64; 3]) -> ([[f64; 3]; 3], [[[f64; 3]; 3]; 3]) {
    let square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    let angle = square.sqrt();
    // s, c and their derivatives by θ²/2
    let (s, c, ds, dc) = if angle < 1e-2 {
        let q = square;
        (
            1.0 - q / 6.0 + q * q / 120.0,
            0.5 - q / 24.0 + q * q / 720.0,
            -1.0 / 3.0 + q / 30.0 - q * q / 840.0,
            -1.0 / 12.0 + q / 180.0 - q * q / 6720.0,
        )
    } else {
        let s = angle.sin() / angle;
        let half = (0.5 * angle).sin() / (0.5 * angle);
        let c = 0.5 * half * half;
        (s, c, (angle.cos() - s) / square, (s - 2.0 * c) / square)
    };
    let cross = skew(w);
    let cross_squared = multiply(&cross, &cross);
    let matrix = std::array::from_fn(|i| {
        std::array::from_fn(|j| f64::from(i == j) + s * cross[i][j] + c * cross_squared[i][j])
    });
    let derivative = std::array::from_fn(|k| {
        let unit = skew(std::array::from_fn(|i| f64::from(i == k)));
        let (left, right) = (multiply(&unit, &cross), multiply(&cross, &unit));
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                w[k] * (ds * cross[i][j] + dc * cross_squared[i][j])
                    + s * unit[i][j]
                    + c * (left[i][j] + right[i][j])
            })
        })
    });
    (matrix, derivative)
}

fn skew(w: [f64; 3]) -> [[f64; 3]; 3] {
    [[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]]
}

fn multiply(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_rotation_and_its_derivative_agrees_with_differences() {
        for scale in [0.0, 1e-9, 1e-3, 0.99e-2, 1.01e-2, 0.5, 2.0, 3.0] {
            let w = [0.6 * scale, -0.64 * scale, 0.48 * scale];
            let (r, dr) = rotation_with_derivative(w);
            for i in 0..3 {
                for j in 0..3 {
                    let product: f64 = (0..3).map(|k| r[i][k] * r[j][k]).sum();
                    assert!((product - f64::from(i == j)).abs() < 1e-14, "scale {scale}");
                }
            }
            for k in 0..3 {
                let h = 1e-5;
                let shifted = |t: f64| {
                    let mut w = w;
                    w[k] += t;
                    rotation_with_derivative(w).0
                };
                let (high, low) = (shifted(h), shifted(-h));
                for i in 0..3 {
                    for j in 0..3 {
                        let difference = (high[i][j] - low[i][j]) / (2.0 * h);
                        assert!((difference - dr[k][i][j]).abs() < 1e-9, "scale {scale}");
                    }
                }
            }
        }
    }
}
