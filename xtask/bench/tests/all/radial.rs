//! The differential equation of a thick sphere against closed forms.

use bench::scenes::elastic::lame;
use bench::scenes::radial::Shell;

/// Lamé: u = p a³/(E (b³ − a³)) ((1 − 2ν) r + (1 + ν) b³/(2 r²)).
#[test]
fn a_small_pressure_moves_it_as_lame_says() {
    for nu in [0.3, 0.499] {
        let (young, inner, outer) = (1e5, 1.0_f64, 2.0_f64);
        let [mu, lambda] = lame(young, nu);
        let shell = Shell {
            inner,
            outer,
            mu,
            lambda,
        };
        let p = 1e-6 * young;
        let u = |r: f64| {
            let share = p * inner.powi(3) / (young * (outer.powi(3) - inner.powi(3)));
            share * ((1.0 - 2.0 * nu) * r + (1.0 + nu) * outer.powi(3) / (2.0 * r * r))
        };
        let [a, b] = shell.radii(p);
        assert!(((a - inner) / u(inner) - 1.0).abs() < 1e-5, "{nu}: {a}");
        assert!(((b - outer) / u(outer) - 1.0).abs() < 1e-5, "{nu}: {b}");
    }
}

/// Incompressible: p = μ/2 (4/λ_b + 1/λ_b⁴ − 4/λ_a − 1/λ_a⁴), b³ − a³ kept.
#[test]
fn a_large_pressure_widens_rubber_as_its_closed_form_says() {
    let (inner, outer, mu) = (1.0_f64, 2.0_f64, 1e4);
    let shell = Shell {
        inner,
        outer,
        mu,
        lambda: 1e6 * mu,
    };
    let a = 1.3_f64;
    let b = (outer.powi(3) + a.powi(3) - inner.powi(3)).cbrt();
    let term = |l: f64| 4.0 / l + l.powi(-4);
    let pressure = 0.5 * mu * (term(b / outer) - term(a / inner));
    let [found, far] = shell.radii(pressure);
    assert!((found - a).abs() < 1e-5, "{found}");
    assert!((far - b).abs() < 1e-5, "{far}");
}
