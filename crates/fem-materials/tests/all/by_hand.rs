//! The documents' energies at strains that are not small, in numbers written out. Stresses and
//! stiffnesses are held to the energies by dual numbers (`derivatives.rs`).

use fem_kinematics::Mat;
use fem_materials::curves::{Blemker, PhysBam, TensionCurve};
use fem_materials::field::{At, Local1};
use fem_materials::isotropic::ByStretches;
use fem_materials::{
    CorotatedLinear, FiberLaw, FiberTerm, Linear, Material, MooneyRivlin, Muscle, NeoHookean,
    QrAnisotropic, StVenantKirchhoff, Stretch, Sum, VolumetricLog,
};

const MU: f64 = 3e4;
const LAMBDA: f64 = 7e4;

/// A rotation about the third axis, then one about the first.
fn rotation() -> Mat<f64, 3> {
    let ((s, c), (t, d)) = (0.7_f64.sin_cos(), (-0.4_f64).sin_cos());
    Mat([[1.0, 0.0, 0.0], [0.0, d, -t], [0.0, t, d]])
        * Mat([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
}

/// S, of F = R S.
const S: [[f64; 3]; 3] = [[1.3, 0.2, 0.0], [0.2, 0.9, -0.1], [0.0, -0.1, 1.1]];
/// det S = 1.3 (0.9 · 1.1 − 0.01) − 0.2 · 0.2 · 1.1.
const DET: f64 = 1.3 * 0.98 - 0.044;
/// tr S² = Σ Sᵢⱼ².
const TRACE: f64 = 1.69 + 0.81 + 1.21 + 2.0 * (0.04 + 0.01);

fn turned() -> Mat<f64, 3> {
    rotation() * Mat(S)
}

/// ((tr C)² − tr C²)/2 of C = S²: the sum of squares of the minors of S.
fn second() -> f64 {
    let minor = |i: usize, j: usize, k: usize, l: usize| S[i][k] * S[j][l] - S[i][l] * S[j][k];
    let pairs = [(0, 1), (0, 2), (1, 2)];
    let of = |(i, j)| {
        pairs
            .map(|(k, l)| minor(i, j, k, l).powi(2))
            .iter()
            .sum::<f64>()
    };
    pairs.map(of).iter().sum()
}

fn same(found: f64, expected: f64, what: &str) {
    let off = (found / expected - 1.0).abs();
    assert!(off < 1e-12, "{what}: {found} for {expected}");
}

#[test]
fn isotropic_energies_are_those_of_the_documents() {
    let F = turned();
    let log = DET.ln();
    let neo = NeoHookean {
        mu: MU,
        lambda: LAMBDA,
    };
    let expected = MU / 2.0 * (TRACE - 3.0) - MU * log + LAMBDA / 2.0 * log * log;
    same(neo.energy(&F), expected, "neo-Hookean");
    same(
        VolumetricLog { K: 5e4 }.energy(&F),
        2.5e4 * log * log,
        "volume",
    );
    let flesh = MooneyRivlin { A: 6e4, B: 2e4 };
    let expected = 6e4 * DET.powf(-2.0 / 3.0) * TRACE + 2e4 * DET.powf(-4.0 / 3.0) * second();
    same(flesh.energy(&F), expected, "Mooney-Rivlin");
    // S − I, and E = (S² − I)/2.
    let (trace, squares) = (0.3 - 0.1 + 0.1, 0.09 + 0.01 + 0.01 + 0.08 + 0.02);
    let corotated = ByStretches(CorotatedLinear {
        mu: MU,
        lambda: LAMBDA,
    });
    let expected = MU * squares + LAMBDA / 2.0 * trace * trace;
    same(corotated.energy(&F), expected, "corotated");
    let square = Mat(S) * Mat(S);
    let mut green = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            let E = 0.5 * (square.0[i][j] - f64::from(u8::from(i == j)));
            green += E * E;
        }
    }
    let stvk = StVenantKirchhoff {
        mu: MU,
        lambda: LAMBDA,
    };
    let half = 0.5 * (TRACE - 3.0);
    same(
        stvk.energy(&F),
        MU * green + LAMBDA / 2.0 * half * half,
        "StVK",
    );
    let small = Mat([[1.1, 0.3, 0.0], [-0.1, 0.8, 0.2], [0.0, 0.4, 1.0]]);
    // e: 0.1, −0.2, 0 on the diagonal, 0.1, 0 and 0.3 beside it.
    let squares = 0.01 + 0.04 + 2.0 * (0.01 + 0.09);
    let linear = Linear {
        mu: MU,
        lambda: LAMBDA,
    };
    same(
        linear.energy(&small),
        MU * squares + LAMBDA / 2.0 * 0.01,
        "linear",
    );
}

#[test]
fn plane_energies_subtract_two() {
    let (s, c) = 0.5_f64.sin_cos();
    let F = Mat([[c, -s], [s, c]]) * Mat([[1.2, 0.1], [0.1, 0.7]]);
    let (J, I): (f64, f64) = (0.84 - 0.01, 1.44 + 0.49 + 0.02);
    let neo = NeoHookean {
        mu: MU,
        lambda: LAMBDA,
    };
    let expected = MU / 2.0 * (I - 2.0) - MU * J.ln() + LAMBDA / 2.0 * J.ln().powi(2);
    same(neo.energy(&F), expected, "neo-Hookean");
    let corotated = ByStretches(CorotatedLinear {
        mu: MU,
        lambda: LAMBDA,
    });
    let expected = MU * (0.04 + 0.09 + 0.02) + LAMBDA / 2.0 * 0.01;
    same(corotated.energy(&F), expected, "corotated");
}

/// ∫ 1 − 25/6 e² from 1 on, and P₁ (e^{P₂e} − P₂e − 1) integrated, within the parabola and the toe.
fn integrals(e: f64) -> (f64, f64) {
    let passive = if e > 0.0 {
        let x = 6.6 * e;
        0.05 / 6.6 * (x.exp() - 1.0 - x - x * x / 2.0)
    } else {
        0.0
    };
    (e - 25.0 / 18.0 * e.powi(3), passive)
}

#[test]
fn a_fiber_stores_what_its_curves_integrate_to_in_either_stretch() {
    let direction = [0.6, 0.0, 0.8];
    let (stress, activation, optimal) = (3e5, 0.4, 1.25);
    let F = turned();
    // S a₀, whose length is the stretch.
    let along = [1.3 * 0.6, 0.2 * 0.6 - 0.1 * 0.8, 1.1 * 0.8];
    let length = along.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
    let term = FiberTerm {
        direction,
        max_isometric_stress: stress,
        activation,
        optimal_stretch: optimal,
    };
    let flesh = Sum(MooneyRivlin { A: 6e4, B: 2e4 }, VolumetricLog { K: 5e4 });
    let energies = [Stretch::Total, Stretch::Isochoric].map(|stretch| {
        let shrink = match stretch {
            Stretch::Total => 1.0,
            Stretch::Isochoric => DET.powf(-1.0 / 3.0),
        };
        let (active, passive) = integrals(shrink * length / optimal - 1.0);
        // dψ/dλ is the tension σ/λ_ofl (α f_a + f_p).
        let expected = stress * (activation * active + passive);
        let curve = PhysBam::default();
        let fiber = At {
            field: FiberLaw { curve, stretch },
            local: term,
        };
        same(fiber.energy(&F), expected, "fiber");
        let muscle: Muscle<PhysBam> = Sum(flesh, fiber);
        let log = DET.ln();
        let passive = 6e4 * DET.powf(-2.0 / 3.0) * TRACE + 2e4 * DET.powf(-4.0 / 3.0) * second();
        same(
            muscle.energy(&F),
            passive + 2.5e4 * log * log + expected,
            "muscle",
        );
        expected
    });
    assert!((energies[0] / energies[1] - 1.0).abs() > 1e-2);
    // Another curve is another energy: 9 (l − 0.4)² rises from 0.4 to 0.6.
    let short = Mat::from_diagonal([0.5; 3]);
    let one = FiberTerm {
        optimal_stretch: 1.0,
        activation: 1.0,
        ..term
    };
    let law = FiberLaw {
        curve: Blemker::default(),
        stretch: Stretch::Total,
    };
    let tension = one.stress(&law, &short).mul_vec(direction);
    let tension = (0..3).map(|k| tension[k] * direction[k]).sum::<f64>();
    same(tension, stress * 9.0 * 0.01, "tension of Blemker's curve");
    assert!((Blemker::default().active(0.5).value - 0.09_f64).abs() < 1e-15);
}

/// F = Q R with R known; d breaks what is stretched.
#[test]
fn qr_energies_are_those_of_their_triangles() {
    let law = QrAnisotropic {
        mu: 1e4,
        lambda: 4e4,
        kx: 5e4,
        ky: 2e4,
    };
    let F = rotation() * Mat([[1.2, 0.3, -0.2], [0.0, 0.9, 0.1], [0.0, 0.0, 1.1]]);
    let J = 1.2 * 0.9 * 1.1;
    let squares = 1.44 + 0.09 + 0.04 + 0.81 + 0.01 + 1.21;
    let isotropic = 5e3 * (squares - 3.0) - 1e4 * (J - 1.0);
    let volume = 2e4 * (J - 1.0_f64).powi(2);
    let second = (0.09_f64 + 0.81).sqrt() - 1.0;
    let fibers = 2.5e4 * 0.04 + 1e4 * second * second;
    same(law.energy(&F), isotropic + volume + fibers, "3D");
    let g = 0.99 * 0.36 + 0.01;
    let torn = law.degradable(0.01).at(Local1(0.4));
    same(
        torn.energy(&F),
        g * (isotropic + volume) + fibers,
        "3D, d = 0.4",
    );
    let (s, c) = 1.1_f64.sin_cos();
    let turn = Mat([[c, -s], [s, c]]);
    let F = turn * Mat([[0.8, 0.3], [0.0, 1.1]]);
    let J = 0.88;
    let isotropic = 5e3 * (0.64 + 0.09 + 1.21 - 2.0) - 1e4 * (J - 1.0);
    let (volume, fibers) = (2e4 * 0.0144, 2.5e4 * 0.04);
    same(law.energy(&F), isotropic + volume + fibers, "2D");
    // Pressed: the term of the volume stays whole.
    same(
        torn.energy(&F),
        g * isotropic + volume + fibers,
        "2D, d = 0.4",
    );
}
