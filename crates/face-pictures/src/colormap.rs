//! Perceptual color maps and nice tick marks.

/// A color map over `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColorMap {
    /// Dark violet over green to yellow, with lightness rising evenly.
    Violet,
    /// Blue over light gray to red, for signed values.
    Diverging,
    /// White over orange to dark red, for densities and weights.
    Heat,
}

/// Anchor colors in CIE Lab. `Violet` goes through the corner hues of the well-known viridis map
/// (S. van der Walt, N. Smith, 2015) with lightness made exactly linear.
const VIOLET: [[f64; 3]; 5] = [
    [15.0, 36.0, -36.0],
    [34.0, 12.0, -33.0],
    [53.0, -28.0, -9.0],
    [72.0, -48.0, 40.0],
    [91.0, -10.0, 84.0],
];
const DIVERGING: [[f64; 3]; 5] = [
    [32.0, 20.0, -58.0],
    [62.0, -4.0, -36.0],
    [92.0, 0.0, 2.0],
    [62.0, 40.0, 30.0],
    [32.0, 56.0, 34.0],
];
const HEAT: [[f64; 3]; 4] = [
    [96.0, 0.0, 6.0],
    [80.0, 20.0, 48.0],
    [56.0, 54.0, 48.0],
    [26.0, 44.0, 26.0],
];

impl ColorMap {
    /// sRGB color, each channel in `[0, 1]`; values outside `[0, 1]` are clamped and a value that
    /// is not a number is gray.
    pub fn color(self, value: f64) -> [f32; 3] {
        if value.is_nan() {
            return [0.55; 3];
        }
        let anchors: &[[f64; 3]] = match self {
            Self::Violet => &VIOLET,
            Self::Diverging => &DIVERGING,
            Self::Heat => &HEAT,
        };
        let s = value.clamp(0.0, 1.0) * (anchors.len() - 1) as f64;
        let i = (s as usize).min(anchors.len() - 2);
        let f = s - i as f64;
        lab_to_srgb([0, 1, 2].map(|k| anchors[i][k] * (1.0 - f) + anchors[i + 1][k] * f))
    }
}

/// CIE Lab (D65) to sRGB, clamped into the gamut (IEC 61966-2-1).
fn lab_to_srgb(lab: [f64; 3]) -> [f32; 3] {
    let fy = (lab[0] + 16.0) / 116.0;
    let inverse = |f: f64| {
        if f > 6.0 / 29.0 {
            f * f * f
        } else {
            3.0 * (6.0f64 / 29.0).powi(2) * (f - 4.0 / 29.0)
        }
    };
    let x = 0.950_47 * inverse(fy + lab[1] / 500.0);
    let y = inverse(fy);
    let z = 1.088_83 * inverse(fy - lab[2] / 200.0);
    [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266_0 * x + 1.876_010_8 * y + 0.041_556_0 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ]
    .map(|c| to_srgb(c as f32))
}

/// Linear light to the sRGB curve, clamped to `[0, 1]`.
pub(super) fn to_srgb(linear: f32) -> f32 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    }
}

/// The sRGB curve to linear light.
pub(super) fn to_linear(srgb: f32) -> f32 {
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// What a color bar says: the range of the values and their unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarBar {
    /// Quantity and unit, for example `distance (mm)`.
    pub label: String,
    /// Values at the two ends.
    pub range: [f64; 2],
    /// The color map.
    pub map: ColorMap,
}

/// About `wanted` round numbers inside `range`, in steps of 1, 2, 2.5 or 5 times a power of ten.
pub(super) fn ticks(range: [f64; 2], wanted: usize) -> Vec<f64> {
    let span = range[1] - range[0];
    if !(span.is_finite() && span > 0.0 && wanted > 0) {
        return if range[0].is_finite() {
            vec![range[0]]
        } else {
            Vec::new()
        };
    }
    let raw = span / wanted as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|&s| s >= raw * (1.0 - 1e-9))
        .unwrap_or(10.0 * power);
    let first = (range[0] / step - 1e-9).ceil() as i64;
    let last = (range[1] / step + 1e-9).floor() as i64;
    if last - first > 100 {
        return Vec::new();
    }
    (first..=last).map(|i| i as f64 * step).collect()
}

/// A short decimal text of a tick value.
pub(super) fn tick_text(value: f64, span: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let size = value.abs().max(span.abs() * 1e-6);
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}");
    }
    let decimals = (2.0 - span.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn violet_gets_lighter_evenly() {
        let light = |c: [f32; 3]| {
            let [r, g, b] = c.map(to_linear);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let l: Vec<f32> = (0..=20)
            .map(|i| light(ColorMap::Violet.color(i as f64 / 20.0)))
            .collect();
        assert!(l.windows(2).all(|w| w[1] > w[0]), "{l:?}");
        assert_eq!(ColorMap::Violet.color(f64::NAN), [0.55; 3]);
        assert_eq!(ColorMap::Heat.color(7.0), ColorMap::Heat.color(1.0));
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks([0.0, 10.0], 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let t = ticks([-0.013, 0.021], 4);
        assert!(
            t.len() >= 3 && t.iter().all(|x| (-0.013..=0.021).contains(x)),
            "{t:?}"
        );
        assert!(ticks([f64::NAN, 1.0], 4).is_empty());
        assert_eq!(tick_text(0.25, 1.0), "0.25");
        assert_eq!(tick_text(1e-7, 1e-6), "1.0e-7");
        assert_eq!(tick_text(40.0, 100.0), "40");
    }
}
