//! Every registered material at deformations that break codes.

use super::{Outcome, Row};
use fem_kinematics::Mat;
use fem_materials::conformance::Random;
use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
use fem_materials::{HessianProjection, Material, Outlined};

/// Every model in every dimension.
pub(super) fn rows() -> Vec<Row> {
    let mut visitor = Trials(Vec::new());
    for_each_model(&mut visitor);
    visitor.0
}

struct Trials(Vec<Row>);

/// Diagonal with the last value replaced.
fn squeezed<const D: usize>(last: f64) -> Mat<f64, D> {
    let mut F = Mat::identity();
    F[(D - 1, D - 1)] = last;
    F
}

fn trials<const D: usize>() -> Vec<(&'static str, Vec<Mat<f64, D>>)> {
    let mut random = Random::new(5);
    let mut turned = |F: Mat<f64, D>| random.rotation() * F * random.rotation();
    let repeated: Vec<_> = (0..4).map(|_| turned(Mat::identity().scale(1.3))).collect();
    let nearly = [1e-4, 1e-8, 1e-12, 1e-15].map(|gap| turned(squeezed(1.0 + gap)));
    let slivers = [1e-3, 1e-6, 1e-9, 1e-12].map(|thin| turned(squeezed(thin)));
    let inverted = [-1.0, -1e-3, -1e-9, -3.0].map(|last| turned(squeezed(last)));
    vec![
        ("repeated singular values", repeated),
        ("nearly repeated", nearly.to_vec()),
        ("slivers, det F → 0+", slivers.to_vec()),
        ("inverted", inverted.to_vec()),
        ("collapsed to a plane", vec![squeezed(0.0)]),
        ("collapsed to a line", vec![Mat::unit(0, 0)]),
        ("collapsed to a point", vec![Mat::zeros()]),
        (
            "huge and tiny",
            [1e3, 1e6, 1e-3, 1e-6]
                .map(|size| turned(Mat::identity().scale(size)))
                .to_vec(),
        ),
    ]
}

impl ModelVisitor for Trials {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        let Ok(material) = entry.build(&entry.defaults()) else {
            return;
        };
        let material = Outlined(material);
        let mut row = |trial, outcome| {
            self.0.push(Row {
                subject: format!("{} {D}D", entry.name),
                trial,
                outcome,
            });
        };
        for (trial, deformations) in trials::<D>() {
            row(
                trial,
                worst(deformations.iter().map(|F| at(entry.name, &material, F))),
            );
        }
        let mut with_nan = Mat::identity();
        with_nan[(0, D - 1)] = f64::NAN;
        let energy = material.energy(&with_nan);
        row(
            "NaN in F",
            if energy.is_finite() {
                Outcome::Fail(format!("a finite energy, {energy:e}"))
            } else {
                Outcome::ClearError(format!("energy {energy}"))
            },
        );
    }
}

/// The worst of several outcomes.
fn worst(outcomes: impl Iterator<Item = Outcome>) -> Outcome {
    let rank = |o: &Outcome| match o {
        Outcome::Right(_) => 0,
        Outcome::ClearError(_) => 1,
        Outcome::Fail(_) => 2,
    };
    outcomes
        .max_by_key(rank)
        .unwrap_or_else(|| Outcome::Right(String::new()))
}

/// Is F beyond what the model, with its default parameters, says that it can bear?
fn beyond_limit<const D: usize>(name: &str, F: &Mat<f64, D>) -> bool {
    match name {
        // J_m = 30 bounds J^(−2/3) tr C − 3.
        "gent" => F.determinant().powf(-2.0 / 3.0) * F.norm_squared() - 3.0 >= 30.0,
        // exp(0.84 (|F a|² − 1)²) is beyond every f64 from |F a| = 5.4 on.
        "hgo" => F.norm_squared() > 29.0,
        _ => false,
    }
}

/// An infinite energy is a clear answer where J ≤ 0 or beyond the model's limit, and nowhere else.
fn infinite<const D: usize>(name: &str, F: &Mat<f64, D>) -> Outcome {
    let J = F.determinant();
    if J <= 0.0 || beyond_limit(name, F) {
        Outcome::ClearError("energy +∞: outside the domain".to_owned())
    } else {
        Outcome::Fail(format!("energy +∞ with J = {J:e}"))
    }
}

/// A finite energy must come with a finite stress and a filtered derivative without NaN or negative
/// curvature.
fn at<const D: usize>(name: &str, material: &impl Material<D>, F: &Mat<f64, D>) -> Outcome {
    let energy = material.energy(F);
    if energy == f64::INFINITY {
        return infinite(name, F);
    }
    if !energy.is_finite() {
        return Outcome::Fail(format!("energy {energy}"));
    }
    let P = material.stress(F);
    if !P.norm_squared().is_finite() {
        return Outcome::Fail("finite energy, stress not finite".to_owned());
    }
    let tensor = material.filtered_derivative(F, HessianProjection::Clamp);
    let mut random = Random::new(11);
    for _ in 0..4 {
        let dF = random.matrix::<D>();
        let curvature = dF.dot(&tensor.apply(&dF));
        let size: f64 = tensor.0.iter().flatten().map(Mat::norm_squared).sum();
        let rounding = 1e-10 * size.sqrt() * dF.norm_squared();
        if curvature.is_nan() || curvature < -rounding {
            return Outcome::Fail(format!("clamped derivative: curvature {curvature:e}"));
        }
    }
    Outcome::Right("finite and definite".to_owned())
}
