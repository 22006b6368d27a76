//! Muscle fibers: a family of lines in the rest shape that pull (document 000, 4.2, 4.3.3, 4.5.2).
//!
//! # The tension T and its two meanings
//! Here T is always dF₂/dλ, in pascals. Document 000 writes T for two things: in 4.3.3 and in
//! equations 13-15 (isochoric stretch) its T is F₂′(λ)/λ, in the form without determinant, in
//! 4.5.2 and in equation 45 it is F₂′(λ). Exchanging them is wrong by a factor λ.
// ERRATUM: document 000, 4.3.3 uses one symbol for both.

use crate::curves::TensionCurve;
use crate::field::{LocalParameters, MaterialField};
use crate::material::Evaluation;
use crate::near_rest::inverse_cube_root;
use crate::tensor_terms::Terms;
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4, Vector, dot, vector};

/// Which stretch a fiber feels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stretch {
    /// λ = |F a₀|, what PhysBAM runs. Defined for every F, and its stiffness has a closed-form
    /// definite part; the default.
    #[default]
    Total,
    /// λ = J^(−1/3) |F a₀|, document 000 section 4.2: a pure change of volume does not stretch
    /// it. Needs det F > 0.
    Isochoric,
}

/// What all fibers of a body share: the shape of the tension curve and the kind of stretch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FiberLaw<C> {
    /// Tension as a function of the normalized stretch.
    pub curve: C,
    /// Which stretch.
    pub stretch: Stretch,
}

/// One muscle in one element; with lanes, in one element per lane.
///
/// ψ = σ (α F_a(l) + F_p(l)) with l = λ/λ_ofl, so that the tension is
/// dψ/dλ = σ/λ_ofl (α f_a(l) + f_p(l)). Add one term for each muscle that runs through an
/// element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiberTerm<T> {
    /// a₀: direction in the rest shape, of length 1 (used as given).
    pub direction: [T; 3],
    /// σ_max times the muscle's share of the element, Pa.
    pub max_isometric_stress: T,
    /// Activation α, 0 to 1.
    pub activation: T,
    /// λ_ofl: the stretch at which the active tension peaks.
    pub optimal_stretch: T,
}

/// The tension and its relatives at one F.
#[derive(Clone, Copy)]
struct Pull<T> {
    /// ψ, Pa.
    energy: T,
    /// T = dψ/dλ, Pa.
    tension: T,
    /// T′, Pa.
    stiffness: T,
    /// ∂T/∂α, Pa.
    by_activation: T,
    /// λ.
    lambda: T,
    /// F a₀/|F a₀|, 0 where that is 0/0.
    u: [T; 3],
    /// 1/|F a₀|, huge but finite for F a₀ = 0.
    inverse_length: T,
    /// J^(−1/3), or 1.
    shrink: T,
}

impl<T: Real> FiberTerm<T> {
    /// ψ, Pa; +∞ for an isochoric stretch of an element that is flat or inverted.
    #[inline(always)]
    pub fn energy<C: TensionCurve>(&self, law: &FiberLaw<C>, F: &Mat<T, 3>) -> T {
        self.guarded(law, F, self.pull(law, F).energy)
    }

    /// P = ∂ψ/∂F, Pa.
    #[inline(always)]
    pub fn stress<C: TensionCurve>(&self, law: &FiberLaw<C>, F: &Mat<T, 3>) -> Mat<T, 3> {
        let pull = self.pull(law, F);
        self.gradient(law, F, &pull).scale(pull.tension)
    }

    /// ∂P/∂α, Pa: the stress of the fully active muscle less its passive part.
    #[inline(always)]
    pub fn stress_by_activation<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
    ) -> Mat<T, 3> {
        let pull = self.pull(law, F);
        self.gradient(law, F, &pull).scale(pull.by_activation)
    }

    /// dP = ∂P/∂F : dF (document 000, eq. 45 for the plain stretch).
    #[inline(always)]
    pub fn stress_differential<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
        dF: &Mat<T, 3>,
    ) -> Mat<T, 3> {
        let pull = self.pull(law, F);
        match law.stretch {
            Stretch::Total => {
                let kernel = pull.kernel(HessianProjection::None);
                Mat::outer(kernel.mul_vec(dF.mul_vec(self.direction)), self.direction)
            }
            Stretch::Isochoric => {
                let g = self.gradient(law, F, &pull);
                let H = F.cofactor().scale(F.determinant().recip());
                let third = T::from_f64(1.0 / 3.0);
                let w = dF.mul_vec(self.direction);
                let along = dot(pull.u, w);
                let volume = H.dot(dF);
                let d_lambda = g.dot(dF);
                let du: Vector<T, 3> = vector(|i| {
                    (w[i] - pull.u[i] * along) * pull.inverse_length - third * volume * pull.u[i]
                });
                let dH = H * dF.tr_mul(&H);
                let dg = Mat::outer(du, self.direction).scale(pull.shrink)
                    - (H.scale(d_lambda) - dH.scale(pull.lambda)).scale(third);
                g.scale(pull.stiffness * d_lambda) + dg.scale(pull.tension)
            }
        }
    }

    /// ∂P/∂F, Pa.
    #[inline(always)]
    pub fn stress_derivative<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
    ) -> Tensor4<T, 3> {
        self.derivative(law, F, &self.pull(law, F), HessianProjection::None)
    }

    /// ∂P/∂F with its negative eigenvalues projected.
    ///
    /// For the plain stretch the eigenvalues are T′ (once, along F a₀), T/λ (twice, across it)
    /// and 0 (six times), all times |a₀|², so projecting the two numbers is exact; this answers
    /// the open question of document 000, 5.6. The isochoric stretch has no such form and goes
    /// through the 9×9 matrix.
    #[inline(always)]
    pub fn projected_derivative<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Tensor4<T, 3> {
        self.derivative(law, F, &self.pull(law, F), projection)
    }

    /// The 3×3 matrix k of the plain stretch with dP = (k dF a₀) a₀ᵀ: T/λ across the fiber, T′
    /// along it. With the area normals b of a simplex the fiber's stiffness block is
    /// (a₀·b_m)(a₀·b_n) V k.
    #[inline(always)]
    pub fn plain_kernel<C: TensionCurve>(
        &self,
        curve: &C,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Mat<T, 3> {
        let law = FiberLaw {
            curve,
            stretch: Stretch::Total,
        };
        self.pull(&law, F).kernel(projection)
    }

    /// ψ and P together.
    #[inline(always)]
    pub fn energy_and_stress<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
    ) -> (T, Mat<T, 3>) {
        let pull = self.pull(law, F);
        let stress = self.gradient(law, F, &pull).scale(pull.tension);
        (self.guarded(law, F, pull.energy), stress)
    }

    /// ψ, P and dP/dF together.
    #[inline(always)]
    pub fn evaluate<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Evaluation<T, 3> {
        let pull = self.pull(law, F);
        Evaluation {
            energy: self.guarded(law, F, pull.energy),
            stress: self.gradient(law, F, &pull).scale(pull.tension),
            derivative: self.derivative(law, F, &pull, projection),
        }
    }

    /// The normalized stretch l = λ/λ_ofl.
    #[inline(always)]
    pub fn normalized_stretch<C: TensionCurve>(&self, law: &FiberLaw<C>, F: &Mat<T, 3>) -> T {
        self.pull(law, F).lambda / self.optimal_stretch
    }

    #[inline(always)]
    fn pull<C: TensionCurve>(&self, law: &FiberLaw<C>, F: &Mat<T, 3>) -> Pull<T> {
        let v = F.mul_vec(self.direction);
        // Large enough for f32; F a0 = 0 then gives u = 0 instead of 0/0.
        let (square, tiny) = (dot(v, v), T::from_f64(1e-36));
        let length = T::select(square.lt(tiny), tiny, square).sqrt();
        let inverse_length = length.recip();
        let shrink = match law.stretch {
            Stretch::Total => T::one(),
            Stretch::Isochoric => inverse_cube_root(F.determinant()),
        };
        let lambda = shrink * length;
        let per_stretch = self.optimal_stretch.recip();
        let l = lambda * per_stretch;
        let (active, passive) = (law.curve.active(l), law.curve.passive(l));
        let slope = self.max_isometric_stress * per_stretch;
        Pull {
            energy: self.max_isometric_stress
                * (self.activation * active.integral + passive.integral),
            tension: slope * (self.activation * active.value + passive.value),
            stiffness: slope * per_stretch * (self.activation * active.slope + passive.slope),
            by_activation: slope * active.value,
            lambda,
            u: vector(|i| v[i] * inverse_length),
            inverse_length,
            shrink,
        }
    }

    /// ∂λ/∂F.
    #[inline(always)]
    fn gradient<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
        pull: &Pull<T>,
    ) -> Mat<T, 3> {
        let along = Mat::outer(pull.u, self.direction);
        match law.stretch {
            Stretch::Total => along,
            Stretch::Isochoric => {
                let H = F.cofactor().scale(F.determinant().recip());
                along.scale(pull.shrink) - H.scale(T::from_f64(1.0 / 3.0) * pull.lambda)
            }
        }
    }

    #[inline(always)]
    fn derivative<C: TensionCurve>(
        &self,
        law: &FiberLaw<C>,
        F: &Mat<T, 3>,
        pull: &Pull<T>,
        projection: HessianProjection,
    ) -> Tensor4<T, 3> {
        let a = self.direction;
        match law.stretch {
            Stretch::Total => {
                let kernel = pull.kernel(projection);
                let mut derivative = Tensor4::zeros();
                for j in 0..3 {
                    for l in 0..3 {
                        derivative.0[j][l] = kernel.scale(a[j] * a[l]);
                    }
                }
                derivative
            }
            Stretch::Isochoric => {
                // T' g (g:dF) + T dg with g = ∂λ/∂F, and the across-fiber part block by block.
                let H = F.cofactor().scale(F.determinant().recip());
                let g = self.gradient(law, F, pull);
                let third = T::from_f64(1.0 / 3.0) * pull.tension;
                let along = Mat::outer(pull.u, a).scale(third * pull.shrink);
                let mut terms = Terms::new()
                    .outer(pull.stiffness, &g, &g)
                    .outer(-T::one(), &along, &H)
                    .outer(-third, &H, &g)
                    .transposed(third * pull.lambda, &H, &H);
                let across = pull
                    .across()
                    .scale(pull.tension * pull.shrink * pull.inverse_length);
                for j in 0..3 {
                    for l in 0..3 {
                        terms.0.0[j][l] += across.scale(a[j] * a[l]);
                    }
                }
                projection.apply(&terms.0)
            }
        }
    }

    /// +∞ outside the domain of the isochoric stretch.
    #[inline(always)]
    fn guarded<C: TensionCurve>(&self, law: &FiberLaw<C>, F: &Mat<T, 3>, energy: T) -> T {
        match law.stretch {
            Stretch::Total => energy,
            Stretch::Isochoric => T::select(
                T::zero().lt(F.determinant()),
                energy,
                T::from_f64(f64::INFINITY),
            ),
        }
    }
}

impl<T: Real> LocalParameters<T> for FiberTerm<T> {
    const COUNT: usize = 6;
    #[inline(always)]
    fn from_numbers(numbers: &[T]) -> Self {
        Self {
            direction: [numbers[0], numbers[1], numbers[2]],
            max_isometric_stress: numbers[3],
            optimal_stretch: numbers[4],
            activation: numbers[5],
        }
    }
    #[inline(always)]
    fn write(&self, numbers: &mut [T]) {
        let [x, y, z] = self.direction;
        let all = [
            x,
            y,
            z,
            self.max_isometric_stress,
            self.optimal_stretch,
            self.activation,
        ];
        numbers[..6].copy_from_slice(&all);
    }
}

/// A fiber in each element, its activation a control.
impl<C: TensionCurve + Clone> MaterialField<3> for FiberLaw<C> {
    type Local<T: Real> = FiberTerm<T>;
    const CONTROL: Option<usize> = Some(5);

    fn listens(&self) -> bool {
        self.curve.has_active()
    }
    /// Not of the isochoric stretch, whose energy is +∞ where det F ≤ 0.
    fn vanishes_at_zero(&self) -> bool {
        self.stretch == Stretch::Total && !self.curve.has_passive()
    }

    #[inline(always)]
    fn energy<T: Real>(&self, fiber: &FiberTerm<T>, F: &Mat<T, 3>) -> T {
        fiber.energy(self, F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, fiber: &FiberTerm<T>, F: &Mat<T, 3>) -> Mat<T, 3> {
        fiber.stress(self, F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(
        &self,
        fiber: &FiberTerm<T>,
        F: &Mat<T, 3>,
        dF: &Mat<T, 3>,
    ) -> Mat<T, 3> {
        fiber.stress_differential(self, F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, fiber: &FiberTerm<T>, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        fiber.stress_derivative(self, F)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        fiber: &FiberTerm<T>,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Tensor4<T, 3> {
        fiber.projected_derivative(self, F, projection)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, fiber: &FiberTerm<T>, F: &Mat<T, 3>) -> (T, Mat<T, 3>) {
        fiber.energy_and_stress(self, F)
    }
    #[inline(always)]
    fn evaluate<T: Real>(
        &self,
        fiber: &FiberTerm<T>,
        F: &Mat<T, 3>,
        projection: HessianProjection,
    ) -> Evaluation<T, 3> {
        fiber.evaluate(self, F, projection)
    }
    #[inline(always)]
    fn stress_by_control<T: Real>(&self, fiber: &FiberTerm<T>, F: &Mat<T, 3>) -> Mat<T, 3> {
        fiber.stress_by_activation(self, F)
    }
}

impl<T: Real> Pull<T> {
    /// I − u uᵀ.
    #[inline(always)]
    fn across(&self) -> Mat<T, 3> {
        Mat::identity() - Mat::outer(self.u, self.u)
    }
    /// T/λ (I − u uᵀ) + T′ u uᵀ for the plain stretch.
    #[inline(always)]
    fn kernel(&self, projection: HessianProjection) -> Mat<T, 3> {
        let across = projection.eigenvalue(self.tension * self.inverse_length);
        let along = projection.eigenvalue(self.stiffness);
        let mut k = Mat::outer(self.u, self.u).scale(along - across);
        for i in 0..3 {
            k.0[i][i] += across;
        }
        k
    }
}
