//! A small generator of random numbers: the suite needs reproducible draws, not statistics.

use fem_kinematics::Mat;

/// SplitMix64 (Steele, Lea, Flood 2014): 64 bits of state, any seed is good.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// A generator that draws the same numbers for the same seed.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// A matrix with entries uniform in [−1, 1).
    pub fn matrix<const D: usize>(&mut self) -> Mat<f64, D> {
        Mat::from_fn(|_, _| self.uniform(-1.0, 1.0))
    }

    /// A rotation: one random turn in each coordinate plane, twice.
    pub fn rotation<const D: usize>(&mut self) -> Mat<f64, D> {
        let mut Q = Mat::identity();
        for _ in 0..2 {
            for i in 0..D {
                for j in i + 1..D {
                    let (s, c) = self.uniform(0.0, core::f64::consts::TAU).sin_cos();
                    let mut turn = Mat::identity();
                    turn[(i, i)] = c;
                    turn[(j, j)] = c;
                    turn[(i, j)] = -s;
                    turn[(j, i)] = s;
                    Q = Q * turn;
                }
            }
        }
        Q
    }
}

/// A seed from `FEM_SEED` (decimal, or hexadecimal after `0x`) where it is set, else from the clock;
/// in a browser, which has neither, always the same one.
pub fn fresh_seed() -> u64 {
    std::env::var("FEM_SEED")
        .ok()
        .and_then(|text| parse_seed(&text))
        .unwrap_or_else(unasked_seed)
}

#[cfg(not(target_family = "wasm"))]
fn unasked_seed() -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(1, |d| Random::new(d.as_nanos() as u64).bits())
}

/// There is no clock, and asking for one would be a panic.
#[cfg(target_family = "wasm")]
fn unasked_seed() -> u64 {
    Random::new(1).bits()
}

/// Reads a seed as it is printed: decimal, or hexadecimal after `0x`.
pub fn parse_seed(text: &str) -> Option<u64> {
    match text.trim().strip_prefix("0x") {
        Some(hex) => u64::from_str_radix(hex, 16).ok(),
        None => text.trim().parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_rotations() {
        let mut random = Random::new(7);
        for _ in 0..20 {
            let Q = random.rotation::<3>();
            assert!((Q.tr_mul(&Q) - Mat::identity()).norm_squared() < 1e-28);
            assert!((Q.determinant() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_printed_seed_reads_back() {
        assert_eq!(parse_seed(&format!("{:#x}", u64::MAX)), Some(u64::MAX));
        assert_eq!(parse_seed("42"), Some(42));
        assert_eq!(parse_seed("seed"), None);
    }
}
