//! The jaw's hinge.

use super::AffineMap;
use fem_kinematics::Mat;

/// The line that the jaw turns about. A positive angle opens the mouth where the axis points to
/// the subject's left (+x) and +z is forward: the right-hand rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JawHinge {
    point: [f64; 3],
    axis: [f64; 3],
}

/// Why a hinge cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HingeError {
    /// A coordinate is NaN or infinite.
    #[error("the hinge point {0:?} is not finite")]
    Point([f64; 3]),
    /// The axis has no direction.
    #[error("the hinge axis {0:?} has no direction; give a vector along it, like [1, 0, 0]")]
    Axis([f64; 3]),
}

impl JawHinge {
    /// A hinge through `point` (meters) along `axis` (any length but 0).
    ///
    /// # Errors
    /// [`HingeError`] for values that are not finite or an axis of length 0.
    pub fn new(point: [f64; 3], axis: [f64; 3]) -> Result<Self, HingeError> {
        if !point.iter().all(|v| v.is_finite()) {
            return Err(HingeError::Point(point));
        }
        let length = axis.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !(length > 1e-12 && length.is_finite()) {
            return Err(HingeError::Axis(axis));
        }
        Ok(Self {
            point,
            axis: axis.map(|v| v / length),
        })
    }
    /// A hinge through `point` (meters) straight to the subject's left, +x.
    pub const fn sideways(point: [f64; 3]) -> Self {
        Self {
            point,
            axis: [1.0, 0.0, 0.0],
        }
    }
    /// A point on the axis, meters.
    pub fn point(&self) -> [f64; 3] {
        self.point
    }
    /// Direction of the axis, of length 1.
    pub fn axis(&self) -> [f64; 3] {
        self.axis
    }
    /// R(φ) = cos φ I + sin φ [a]ₓ + (1 − cos φ) a aᵀ (Rodrigues), φ in radians.
    fn rotation(&self, angle: f64) -> Mat<f64, 3> {
        let (sin, cos) = angle.sin_cos();
        self.combine(cos, sin, 1.0 - cos)
    }
    /// c I + s [a]ₓ + k a aᵀ.
    fn combine(&self, c: f64, s: f64, k: f64) -> Mat<f64, 3> {
        let a = self.axis;
        let cross = Mat([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]]);
        Mat::from_diagonal([c; 3]) + cross.scale(s) + Mat::outer(a, a).scale(k)
    }
    /// M and t of the jaw turned by `angle` (radians) about the axis and then moved by `slide`
    /// (meters): x ↦ R (x − p) + p + slide.
    pub fn motion(&self, angle: f64, slide: [f64; 3]) -> AffineMap {
        let matrix = self.rotation(angle);
        let turned = matrix.mul_vec(self.point);
        AffineMap {
            matrix: matrix.0,
            translation: std::array::from_fn(|i| self.point[i] - turned[i] + slide[i]),
        }
    }
    /// d(M, t)/dφ of [`JawHinge::motion`]: per radian. The derivative by `slide` is (0, I).
    pub fn motion_by_angle(&self, angle: f64) -> AffineMap {
        let (sin, cos) = angle.sin_cos();
        let matrix = self.combine(-sin, cos, sin);
        let turned = matrix.mul_vec(self.point);
        AffineMap {
            matrix: matrix.0,
            translation: turned.map(|v| -v),
        }
    }
    /// The angle (radians, −π to π) and the slide (meters) whose rigid motion is closest to
    /// `motion`: the angle that maximizes R(φ) : M, the slide that carries the hinge point along.
    pub fn closest(&self, motion: &AffineMap) -> (f64, [f64; 3]) {
        let m = &Mat(motion.matrix);
        // R : M = cos φ (tr M − a·Ma) + sin φ [a]ₓ:M + a·Ma.
        let cosine = self.combine(1.0, 0.0, -1.0).dot(m);
        let sine = self.combine(0.0, 1.0, 0.0).dot(m);
        let carried = motion.apply(self.point);
        (
            sine.atan2(cosine),
            std::array::from_fn(|i| carried[i] - self.point[i]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hinge() -> JawHinge {
        JawHinge::new([0.1, -0.02, 0.03], [2.0, 0.5, -1.0]).expect("a hinge")
    }

    #[test]
    fn points_on_the_axis_stay() {
        let h = hinge();
        let on_axis: [f64; 3] = std::array::from_fn(|i| h.point()[i] + 0.7 * h.axis()[i]);
        let moved = h.motion(0.9, [0.0; 3]).apply(on_axis);
        assert!((0..3).all(|i| (moved[i] - on_axis[i]).abs() < 1e-15));
    }

    #[test]
    fn a_positive_angle_about_x_opens_the_jaw() {
        let h = JawHinge::new([0.0; 3], [1.0, 0.0, 0.0]).expect("a hinge");
        let chin = h.motion(0.3, [0.0; 3]).apply([0.0, -0.05, 0.1]);
        assert!(chin[1] < -0.05 && chin[2] > 0.05);
    }

    #[test]
    fn the_derivative_matches_differences() {
        let (h, angle, step) = (hinge(), 0.4, 1e-6);
        let (plus, minus) = (
            h.motion(angle + step, [0.1; 3]),
            h.motion(angle - step, [0.1; 3]),
        );
        let derivative = h.motion_by_angle(angle);
        for i in 0..3 {
            let slope = (plus.translation[i] - minus.translation[i]) / (2.0 * step);
            assert!((derivative.translation[i] - slope).abs() < 1e-9);
            for j in 0..3 {
                let slope = (plus.matrix[i][j] - minus.matrix[i][j]) / (2.0 * step);
                assert!((derivative.matrix[i][j] - slope).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn angle_and_slide_are_recovered() {
        let (h, slide) = (hinge(), [0.01, -0.02, 0.003]);
        for angle in [-1.2, 0.0, 0.44, 3.0] {
            let (found, moved) = h.closest(&h.motion(angle, slide));
            assert!((found - angle).abs() < 1e-14);
            assert!((0..3).all(|i| (moved[i] - slide[i]).abs() < 1e-15));
        }
    }

    #[test]
    fn a_hinge_needs_a_direction() {
        assert_eq!(
            JawHinge::new([0.0; 3], [0.0; 3]),
            Err(HingeError::Axis([0.0; 3]))
        );
        assert!(JawHinge::new([f64::NAN, 0.0, 0.0], [1.0; 3]).is_err());
        assert!(JawHinge::new([0.0; 3], [f64::NAN, 1.0, 1.0]).is_err());
    }
}
