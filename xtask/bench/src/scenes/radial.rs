//! A thick sphere under pressure from within: one unknown, r(R), as an ordinary differential equation.
//!
//! With the stretches λ_r = r′ and λ_θ = r/R the first Piola stresses are P_r = ∂ψ/∂λ_r and
//! 2 P_θ = ∂ψ/∂λ_θ, equilibrium is (R² P_r)′ = 2 R P_θ, the inner side carries P_r = −p λ_θ²,
//! the outer side nothing.

/// ψ = μ/2 (λ_r² + 2 λ_θ² − 3) − μ ln J + λ/2 (ln J)², J = λ_r λ_θ².
#[derive(Clone, Copy, Debug)]
pub struct Shell {
    /// Inner radius at rest, m.
    pub inner: f64,
    /// Outer radius at rest, m.
    pub outer: f64,
    /// μ, Pa.
    pub mu: f64,
    /// λ, Pa.
    pub lambda: f64,
}

/// Steps of the integration; with fourth order they leave 1e-12.
const STEPS: usize = 2_000;

impl Shell {
    fn radial_stress(&self, [r, t]: [f64; 2]) -> f64 {
        let log = (r * t * t).ln();
        self.mu * r + (self.lambda * log - self.mu) / r
    }

    fn hoop_stress(&self, [r, t]: [f64; 2]) -> f64 {
        let log = (r * t * t).ln();
        self.mu * t + (self.lambda * log - self.mu) / t
    }

    /// λ_r with this radial stress at this λ_θ: P_r grows with λ_r.
    fn radial_stretch(&self, stress: f64, hoop: f64) -> f64 {
        let mut r = 1.0 / (hoop * hoop);
        for _ in 0..100 {
            let log = (r * hoop * hoop).ln();
            let slope = self.mu + (self.lambda * (1.0 - log) + self.mu) / (r * r);
            let step = (self.radial_stress([r, hoop]) - stress) / slope;
            r = (r - step).max(0.5 * r);
            if step.abs() <= 1e-15 * r {
                break;
            }
        }
        r
    }

    /// (r, P_r) at the outer side when the inner one lies at `start`.
    fn integrate(&self, pressure: f64, start: f64) -> [f64; 2] {
        let slope = |R: f64, [r, P]: [f64; 2]| {
            let hoop = r / R;
            let radial = self.radial_stretch(P, hoop);
            let growth = 2.0 * (self.hoop_stress([radial, hoop]) - P) / R;
            [radial, growth]
        };
        let h = (self.outer - self.inner) / STEPS as f64;
        let along = |y: [f64; 2], k: [f64; 2], t: f64| [y[0] + t * k[0], y[1] + t * k[1]];
        let hoop = start / self.inner;
        let mut y = [start, -pressure * hoop * hoop];
        for i in 0..STEPS {
            let R = self.inner + i as f64 * h;
            let a = slope(R, y);
            let b = slope(R + 0.5 * h, along(y, a, 0.5 * h));
            let c = slope(R + 0.5 * h, along(y, b, 0.5 * h));
            let d = slope(R + h, along(y, c, h));
            for k in 0..2 {
                y[k] += h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]);
            }
        }
        y
    }

    /// Where the inner and the outer side come to lie, m: by bisection of the stress that is left at
    /// the outer side, which grows with the inner radius as long as pressure does.
    pub fn radii(&self, pressure: f64) -> [f64; 2] {
        let left = |start: f64| self.integrate(pressure, start)[1];
        let (mut low, mut high) = (self.inner, 2.0 * self.inner);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match left(middle) < 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        let inner = 0.5 * (low + high);
        [inner, self.integrate(pressure, inner)[0]]
    }
}
