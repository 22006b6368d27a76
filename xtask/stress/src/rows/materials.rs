//! Every registered material at deformations that break codes.

use crate::row::Evidence;
use crate::{Expected, Failure, Row};
use fem_kinematics::Mat;
use fem_materials::conformance::Random;
use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
use fem_materials::{HessianProjection, Material, Outlined};

/// A row for each model in each dimension.
pub fn rows() -> Vec<Row> {
    let mut visitor = Trials(Vec::new());
    for_each_model(&mut visitor);
    visitor.0
}

struct Trials(Vec<Row>);

impl ModelVisitor for Trials {
    fn visit<M: Material<D> + 'static, const D: usize>(&mut self, entry: &Entry<M>) {
        let Ok(material) = entry.build(&entry.defaults()) else {
            return;
        };
        let (name, material) = (entry.name, Outlined(material));
        self.0.push(Row::new(
            "materials",
            format!("material-{name}-{D}d"),
            "repeated and nearly repeated singular values, slivers, inversion, collapse, 1e-6 to 1e6, NaN",
            Expected::Property,
            move |settings| all::<D>(name, &material, settings.seed),
        ));
    }
}

/// Diagonal with the last value replaced.
fn squeezed<const D: usize>(last: f64) -> Mat<f64, D> {
    let mut F = Mat::identity();
    F[(D - 1, D - 1)] = last;
    F
}

fn deformations<const D: usize>(seed: u64) -> Vec<Mat<f64, D>> {
    let mut random = Random::new(seed);
    let mut turned = |F: Mat<f64, D>| random.rotation() * F * random.rotation();
    let mut all: Vec<Mat<f64, D>> = (0..4).map(|_| turned(Mat::identity().scale(1.3))).collect();
    let nearly_repeated = [1e-4, 1e-8, 1e-12, 1e-15].map(|gap| 1.0 + gap);
    let slivers = [1e-3, 1e-6, 1e-9, 1e-12];
    let inverted = [-1.0, -1e-3, -1e-9, -3.0];
    for last in nearly_repeated.into_iter().chain(slivers).chain(inverted) {
        all.push(turned(squeezed(last)));
    }
    all.extend([squeezed(0.0), Mat::unit(0, 0), Mat::zeros()]);
    for size in [1e3, 1e6, 1e-3, 1e-6] {
        all.push(turned(Mat::identity().scale(size)));
    }
    all
}

fn all<const D: usize>(
    name: &str,
    material: &impl Material<D>,
    seed: u64,
) -> Result<Evidence, Failure> {
    let mut worst = Evidence::default();
    for F in deformations::<D>(seed) {
        worst = worst.and(at(name, material, &F)?);
    }
    let mut with_nan = Mat::identity();
    with_nan[(0, D - 1)] = f64::NAN;
    let energy = material.energy(&with_nan);
    if energy.is_finite() {
        return Err(Failure::lie(format!(
            "NaN in F, and the energy is {energy:e}"
        )));
    }
    Ok(Evidence {
        note: format!(
            "+∞ at {} of {} deformations",
            worst.steps,
            deformations::<D>(seed).len()
        ),
        steps: 0,
        ..worst
    })
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

/// An energy of +∞ where J ≤ 0 or beyond the model's limit, and nowhere else (counted as a step); a
/// finite energy with a finite stress and a clamped derivative without negative curvature.
fn at<const D: usize>(
    name: &str,
    material: &impl Material<D>,
    F: &Mat<f64, D>,
) -> Result<Evidence, Failure> {
    let energy = material.energy(F);
    let J = F.determinant();
    if energy == f64::INFINITY {
        return if J <= 0.0 || beyond_limit(name, F) {
            Ok(Evidence {
                steps: 1,
                ..Evidence::default()
            })
        } else {
            Err(Failure::lie(format!("energy +∞ with J = {J:e}")))
        };
    }
    if !(energy.is_finite() && material.stress(F).norm_squared().is_finite()) {
        return Err(Failure::lie(format!(
            "energy {energy} or its stress at J = {J:e}"
        )));
    }
    let tensor = material.projected_derivative(F, HessianProjection::Clamp);
    let size: f64 = tensor.0.iter().flatten().map(Mat::norm_squared).sum();
    let mut random = Random::new(11);
    let mut worst = Evidence::default();
    for _ in 0..4 {
        let dF = random.matrix::<D>();
        let curvature = dF.dot(&tensor.apply(&dF));
        worst = worst.and(Evidence {
            left: if curvature >= 0.0 { 0.0 } else { -curvature },
            allowed: 1e-10 * size.sqrt() * dF.norm_squared(),
            ..Evidence::default()
        });
    }
    Ok(worst)
}
