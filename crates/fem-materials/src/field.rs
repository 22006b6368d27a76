//! Materials whose parameters differ from element to element.

use crate::material::{Evaluation, Material, Symmetry};
use fem_kinematics::{HessianProjection, Mat, Real, Tensor4, vector};

/// Most numbers that the local parameters of one element may have.
pub const MAX_LOCAL_NUMBERS: usize = 12;

/// The parameters of one element, or with lanes of several side by side.
///
/// They are a short row of numbers, which is how an assembly stores them: eight elements to a
/// register.
pub trait LocalParameters<T>: Copy + Send + Sync {
    /// How many numbers, at most [`MAX_LOCAL_NUMBERS`].
    const COUNT: usize;
    /// From the first [`LocalParameters::COUNT`] of these numbers.
    fn from_numbers(numbers: &[T]) -> Self;
    /// Writes the first [`LocalParameters::COUNT`] of these numbers.
    fn write(&self, numbers: &mut [T]);
}

impl<T> LocalParameters<T> for () {
    const COUNT: usize = 0;
    #[inline(always)]
    fn from_numbers(_: &[T]) -> Self {}
    #[inline(always)]
    fn write(&self, _: &mut [T]) {}
}

/// One number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Local1<T>(pub T);

impl<T: Real> LocalParameters<T> for Local1<T> {
    const COUNT: usize = 1;
    #[inline(always)]
    fn from_numbers(numbers: &[T]) -> Self {
        Self(numbers[0])
    }
    #[inline(always)]
    fn write(&self, numbers: &mut [T]) {
        numbers[0] = self.0;
    }
}

/// A hyperelastic model with parameters of its own in every element: ψ(F; p), p local.
///
/// Every [`Material`] is one with no local parameters. [`ScaledMaterial`] gives any of them a stiffness of
/// its own in each element; the fibers of a muscle ([`FiberLaw`](crate::FiberLaw)) have directions,
/// strength and activation. [`At`] goes back: a field with the parameters of one point is a
/// [`Material`].
pub trait MaterialField<const D: usize>: Clone + Send + Sync {
    /// The parameters of an element.
    type Local<T: Real>: LocalParameters<T>;

    /// The place among the local numbers that a control sets, if any: a muscle's activation. ψ is
    /// affine in that number.
    const CONTROL: Option<usize> = None;

    /// Does ψ depend on the number that [`MaterialField::CONTROL`] names? Where it does not, its
    /// derivative by it is 0 and not evaluated.
    fn listens(&self) -> bool {
        Self::CONTROL.is_some()
    }

    /// Is ψ 0 for every F where that number is 0? Such elements are then not evaluated.
    fn vanishes_at_zero(&self) -> bool {
        false
    }

    /// Whether every evaluation decomposes F into rotations and stretches.
    const DECOMPOSES: bool = false;

    /// Whether a projected derivative does.
    const PROJECTION_DECOMPOSES: bool = false;

    /// ψ(F; p), joules per cubic meter of rest volume (per square meter in 2D).
    fn energy<T: Real>(&self, local: &Self::Local<T>, F: &Mat<T, D>) -> T;

    /// First Piola-Kirchhoff stress P = ∂ψ/∂F, pascals.
    fn stress<T: Real>(&self, local: &Self::Local<T>, F: &Mat<T, D>) -> Mat<T, D>;

    /// dP = ∂P/∂F : dF.
    fn stress_differential<T: Real>(
        &self,
        local: &Self::Local<T>,
        F: &Mat<T, D>,
        dF: &Mat<T, D>,
    ) -> Mat<T, D>;

    /// ∂P/∂F, pascals.
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, local: &Self::Local<T>, F: &Mat<T, D>) -> Tensor4<T, D> {
        Tensor4::from_linear_map(|dF| self.stress_differential(local, F, dF))
    }

    /// ∂P/∂F with its negative eigenvalues treated as `projection` says.
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        local: &Self::Local<T>,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        projection.apply(&self.stress_derivative(local, F))
    }

    /// ψ and P together.
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, local: &Self::Local<T>, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        (self.energy(local, F), self.stress(local, F))
    }

    /// ψ, P and the projected ∂P/∂F together.
    #[inline(always)]
    fn evaluate<T: Real>(
        &self,
        local: &Self::Local<T>,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Evaluation<T, D> {
        let (energy, stress) = self.energy_and_stress(local, F);
        Evaluation {
            energy,
            stress,
            derivative: self.projected_derivative(local, F, projection),
        }
    }

    /// ∂P/∂c, c being the number that [`MaterialField::CONTROL`] names, pascals; independent of c.
    #[inline(always)]
    fn stress_by_control<T: Real>(&self, _local: &Self::Local<T>, _F: &Mat<T, D>) -> Mat<T, D> {
        Mat::zeros()
    }
}

impl<const D: usize, M: Material<D>> MaterialField<D> for M {
    type Local<T: Real> = ();
    const DECOMPOSES: bool = M::DECOMPOSES;
    const PROJECTION_DECOMPOSES: bool = M::DECOMPOSES || matches!(M::SYMMETRY, Symmetry::Isotropic);

    #[inline(always)]
    fn energy<T: Real>(&self, (): &(), F: &Mat<T, D>) -> T {
        Material::energy(self, F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, (): &(), F: &Mat<T, D>) -> Mat<T, D> {
        Material::stress(self, F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, (): &(), F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        Material::stress_differential(self, F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, (): &(), F: &Mat<T, D>) -> Tensor4<T, D> {
        Material::stress_derivative(self, F)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        (): &(),
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        Material::projected_derivative(self, F, projection)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, (): &(), F: &Mat<T, D>) -> (T, Mat<T, D>) {
        Material::energy_and_stress(self, F)
    }
    #[inline(always)]
    fn evaluate<T: Real>(
        &self,
        (): &(),
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Evaluation<T, D> {
        Material::evaluate(self, F, projection)
    }
}

/// ψ = s ψ₀(F) with a factor s of each element: a field of stiffness.
///
/// Every modulus of ψ₀ is multiplied, so with ψ₀ at E = 1 Pa the factor is Young's modulus.
///
/// ```
/// use fem_kinematics::Mat;
/// use fem_materials::field::{Local1, MaterialField, ScaledMaterial};
/// use fem_materials::{Material, NeoHookean};
/// let soft = NeoHookean { mu: 1e3, lambda: 1e4 };
/// let F = Mat([[1.1, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, 0.2, 1.0]]);
/// let twice = ScaledMaterial(soft).energy(&Local1(2.0), &F);
/// assert_eq!(twice, 2.0 * Material::energy(&soft, &F));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaledMaterial<M>(pub M);

impl<const D: usize, M: Material<D>> MaterialField<D> for ScaledMaterial<M> {
    type Local<T: Real> = Local1<T>;
    const DECOMPOSES: bool = M::DECOMPOSES;
    const PROJECTION_DECOMPOSES: bool = <M as MaterialField<D>>::PROJECTION_DECOMPOSES;

    #[inline(always)]
    fn energy<T: Real>(&self, s: &Local1<T>, F: &Mat<T, D>) -> T {
        s.0 * Material::energy(&self.0, F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, s: &Local1<T>, F: &Mat<T, D>) -> Mat<T, D> {
        Material::stress(&self.0, F).scale(s.0)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(
        &self,
        s: &Local1<T>,
        F: &Mat<T, D>,
        dF: &Mat<T, D>,
    ) -> Mat<T, D> {
        Material::stress_differential(&self.0, F, dF).scale(s.0)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, s: &Local1<T>, F: &Mat<T, D>) -> Tensor4<T, D> {
        Material::stress_derivative(&self.0, F).scale(s.0)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        s: &Local1<T>,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        // s ≥ 0: the eigenvalues keep their signs.
        Material::projected_derivative(&self.0, F, projection).scale(s.0)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, s: &Local1<T>, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        let (psi, P) = Material::energy_and_stress(&self.0, F);
        (s.0 * psi, P.scale(s.0))
    }
}

/// A field with the parameters of one point, which makes it a [`Material`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct At<M, P> {
    /// What all points share.
    pub field: M,
    /// The parameters of this one.
    pub local: P,
}

impl<M, P: LocalParameters<f64>> At<M, P> {
    /// The parameters in every lane.
    #[inline(always)]
    fn splat<T: Real, Q: LocalParameters<T>>(&self) -> Q {
        let mut numbers = [0.0; MAX_LOCAL_NUMBERS];
        self.local.write(&mut numbers);
        let numbers: [T; MAX_LOCAL_NUMBERS] = vector(|k| T::from_f64(numbers[k]));
        Q::from_numbers(&numbers)
    }
}

impl<const D: usize, M, P> Material<D> for At<M, P>
where
    M: MaterialField<D, Local<f64> = P> + Copy,
    P: LocalParameters<f64>,
{
    const DECOMPOSES: bool = M::DECOMPOSES;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.field.energy(&self.splat::<T, _>(), F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.field.stress(&self.splat::<T, _>(), F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        self.field.stress_differential(&self.splat::<T, _>(), F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        self.field.stress_derivative(&self.splat::<T, _>(), F)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        self.field
            .projected_derivative(&self.splat::<T, _>(), F, projection)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        self.field.energy_and_stress(&self.splat::<T, _>(), F)
    }
    #[inline(always)]
    fn evaluate<T: Real>(&self, F: &Mat<T, D>, projection: HessianProjection) -> Evaluation<T, D> {
        self.field.evaluate(&self.splat::<T, _>(), F, projection)
    }
}
