//! Perceptual color maps and nice tick marks.

/// A color map over `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColorMap {
    /// Dark violet over green to yellow, with lightness rising evenly: viridis.
    Violet,
    /// Blue over near white to red, for signed values: ColorBrewer's RdBu.
    Diverging,
    /// White over orange to dark red, for densities and weights: ColorBrewer's OrRd.
    Heat,
}

impl ColorMap {
    /// sRGB color, each channel in `[0, 1]`; values outside `[0, 1]` are clamped and a value that
    /// is not a number is gray.
    pub fn color(self, value: f64) -> [f32; 3] {
        if value.is_nan() {
            return [0.55; 3];
        }
        let color = match self {
            Self::Violet => colorous::VIRIDIS.eval_continuous(value),
            // The library's runs from red to blue.
            Self::Diverging => colorous::RED_BLUE.eval_continuous(1.0 - value),
            Self::Heat => colorous::ORANGE_RED.eval_continuous(value),
        };
        color.into_array().map(|channel| f32::from(channel) / 255.0)
    }
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

    /// CIE lightness of a gray of the same luminance, 0 to 100.
    fn lightness(map: ColorMap, value: f64) -> f64 {
        let [r, g, b] = map.color(value).map(|c| f64::from(to_linear(c)));
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        116.0 * luminance.cbrt() - 16.0
    }
    fn hex(map: ColorMap, value: f64) -> [u8; 3] {
        map.color(value).map(|c| (255.0 * c).round() as u8)
    }

    #[test]
    fn violet_gets_lighter_evenly() {
        let l: Vec<f64> = (0..=16)
            .map(|i| lightness(ColorMap::Violet, i as f64 / 16.0))
            .collect();
        let mean = (l[16] - l[0]) / 16.0;
        assert!(
            l.windows(2)
                .all(|w| (w[1] - w[0] - mean).abs() < 0.25 * mean),
            "{l:?}"
        );
        // The ends of viridis as its authors published them.
        assert_eq!(hex(ColorMap::Violet, 0.0), [68, 1, 84]);
        assert_eq!(hex(ColorMap::Violet, 1.0), [253, 231, 37]);
    }

    #[test]
    fn signed_values_are_blue_and_red_around_the_lightest_and_weights_get_darker() {
        let [low, _, blue] = ColorMap::Diverging.color(0.1);
        let [red, _, high] = ColorMap::Diverging.color(0.9);
        assert!(blue > low + 0.3 && red > high + 0.3);
        let l = |map, i: i32| lightness(map, f64::from(i) / 20.0);
        for i in 0..10 {
            assert!(l(ColorMap::Diverging, i) < l(ColorMap::Diverging, i + 1));
            assert!(l(ColorMap::Diverging, 20 - i) < l(ColorMap::Diverging, 19 - i));
        }
        assert!((0..20).all(|i| l(ColorMap::Heat, i) > l(ColorMap::Heat, i + 1)));
        for map in [ColorMap::Violet, ColorMap::Diverging, ColorMap::Heat] {
            assert_eq!(map.color(f64::NAN), [0.55; 3]);
            assert_eq!(map.color(7.0), map.color(1.0));
            assert_eq!(map.color(f64::NEG_INFINITY), map.color(0.0));
        }
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
