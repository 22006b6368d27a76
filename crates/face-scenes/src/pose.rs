//! A pose as a person types it: `zygomaticus_major_L=0.6`, `12deg`.

use super::Influence;
use super::names::{DidYouMean, meant, similar};
use face_rig::anatomy::Muscle;

/// Why a typed setting cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// Not of the form `name=value`.
    #[error("\"{0}\": expected name=value, like zygomaticus_major_L=0.6")]
    Form(String),
    /// No muscle of that name.
    #[error("\"{setting}\": there is no muscle \"{name}\"{}", DidYouMean(similar))]
    UnknownMuscle {
        /// The whole setting.
        setting: String,
        /// The name in it.
        name: String,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// An activation that is no number between 0 and 1.
    #[error("\"{setting}\": an activation is a number from 0 (relaxed) to 1 (full), not {value}")]
    Activation {
        /// The whole setting.
        setting: String,
        /// What was given.
        value: String,
    },
    /// One muscle set twice.
    #[error("\"{setting}\": {name} is already set; give each name once")]
    Twice {
        /// The second setting.
        setting: String,
        /// The muscle.
        name: String,
    },
    /// No load, cavity, motion, strength or stiffness of that name.
    #[error(
        "\"{setting}\": the scene has no control \"{name}\"{}",
        DidYouMean(similar)
    )]
    UnknownControl {
        /// The whole setting.
        setting: String,
        /// The name in it.
        name: String,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// A value that is no number or that the scene does not allow.
    #[error("\"{setting}\": {value} is no number that the scene allows: {allowed}")]
    Control {
        /// The whole setting.
        setting: String,
        /// What was given.
        value: String,
        /// What may be given.
        allowed: Allowed,
    },
    /// An angle without unit, or no number.
    #[error("\"{0}\": an angle is a number with its unit, like 12deg or 0.2rad")]
    Angle(String),
}

/// What a control may be set to.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Allowed {
    /// The range that the scene gives it.
    #[error("{low} to {high} {unit}")]
    Range {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// Pa for a cavity, else nothing.
        unit: &'static str,
    },
    /// Anything that makes sense.
    #[error("{0} or more")]
    AtLeast(f64),
    /// Any number.
    #[error("finite")]
    Finite,
}

/// The activations of all muscles from settings `name=value`; muscles not named get 0. A name
/// without `_L` or `_R` sets both sides, one without a number all bundles of a muscle.
///
/// ```
/// use face_rig::anatomy::Muscle;
/// use face_scenes::parse_activations;
/// let muscles = ["smile_L", "smile_R", "chin"].map(|name| Muscle { name: name.into() });
/// let activations = parse_activations(&muscles, ["smile=0.5", "chin=1"])?;
/// assert_eq!(activations, [0.5, 0.5, 1.0]);
/// # Ok::<(), face_scenes::SettingError>(())
/// ```
///
/// # Errors
/// [`SettingError`], with a suggestion for names that are almost right.
pub fn parse_activations<'a>(
    muscles: &[Muscle],
    settings: impl IntoIterator<Item = &'a str>,
) -> Result<Vec<f64>, SettingError> {
    let mut activations = vec![None; muscles.len()];
    for setting in settings {
        let (name, value) = setting
            .split_once('=')
            .map(|(name, value)| (name.trim(), value.trim()))
            .filter(|(name, _)| !name.is_empty())
            .ok_or_else(|| SettingError::Form(setting.into()))?;
        let activation = value.parse().ok().filter(|a| (0.0..=1.0).contains(a));
        let activation: f64 = activation.ok_or_else(|| SettingError::Activation {
            setting: setting.into(),
            value: value.into(),
        })?;
        let found = meant(name, muscles.iter().map(|m| m.name.as_str()));
        if found.is_empty() {
            return Err(SettingError::UnknownMuscle {
                setting: setting.into(),
                name: name.into(),
                similar: similar(name, muscles.iter().map(|m| m.name.as_str())),
            });
        }
        for m in found {
            if activations[m].replace(activation).is_some() {
                return Err(SettingError::Twice {
                    setting: setting.into(),
                    name: muscles[m].name.clone(),
                });
            }
        }
    }
    Ok(activations
        .into_iter()
        .map(Option::unwrap_or_default)
        .collect())
}

/// The values of all influences from settings `name=value`, in each one's own unit (pascals for a
/// cavity); those not named keep their neutral value.
///
/// # Errors
/// [`SettingError`], with a suggestion for names that are almost right, for values that are no number
/// or outside the range of the scene, and for one set twice.
pub fn parse_controls<'a>(
    influences: &[Influence],
    settings: impl IntoIterator<Item = &'a str>,
) -> Result<Vec<f64>, SettingError> {
    let mut values: Vec<f64> = influences.iter().map(|i| i.neutral).collect();
    let mut set = vec![false; influences.len()];
    for setting in settings {
        let (name, text) = setting
            .split_once('=')
            .map(|(name, value)| (name.trim(), value.trim()))
            .filter(|(name, _)| !name.is_empty())
            .ok_or_else(|| SettingError::Form(setting.into()))?;
        let found = influences.iter().position(|i| i.name == name);
        let k = found.ok_or_else(|| SettingError::UnknownControl {
            setting: setting.into(),
            name: name.into(),
            similar: similar(name, influences.iter().map(|i| i.name.as_str())),
        })?;
        let least = influences[k].least();
        let [low, high] = influences[k].range.unwrap_or([least, f64::MAX]);
        let value = text.parse().ok().filter(|v| low <= *v && *v <= high);
        values[k] = value.ok_or_else(|| SettingError::Control {
            setting: setting.into(),
            value: text.into(),
            allowed: match influences[k].range {
                Some([low, high]) => Allowed::Range {
                    low,
                    high,
                    unit: influences[k].unit(),
                },
                None if least > f64::MIN => Allowed::AtLeast(least),
                None => Allowed::Finite,
            },
        })?;
        if std::mem::replace(&mut set[k], true) {
            return Err(SettingError::Twice {
                setting: setting.into(),
                name: name.into(),
            });
        }
    }
    Ok(values)
}

/// An angle with its unit, `12deg` or `0.2rad`, in radians.
///
/// # Errors
/// [`SettingError::Angle`].
pub fn parse_angle(text: &str) -> Result<f64, SettingError> {
    let trimmed = text.trim();
    let number = |s: &str| s.trim().parse().ok().filter(|v: &f64| v.is_finite());
    let radians = if let Some(value) = trimmed.strip_suffix("deg") {
        number(value).map(f64::to_radians)
    } else {
        trimmed.strip_suffix("rad").and_then(number)
    };
    radians.ok_or_else(|| SettingError::Angle(text.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(settings: &[&str]) -> Result<Vec<f64>, SettingError> {
        let muscles = ["zygomaticus_major_L", "zygomaticus_major_R", "procerus"]
            .map(|name| Muscle { name: name.into() });
        parse_activations(&muscles, settings.iter().copied())
    }

    #[test]
    fn one_side_or_both() {
        assert_eq!(parse(&[]), Ok(vec![0.0; 3]));
        assert_eq!(
            parse(&["zygomaticus_major_R=0.25"]),
            Ok(vec![0.0, 0.25, 0.0])
        );
        assert_eq!(
            parse(&["zygomaticus_major = 0.5", "procerus=1"]),
            Ok(vec![0.5, 0.5, 1.0])
        );
    }

    #[test]
    fn an_activation_of_seven_is_refused() {
        for value in ["7", "-0.1", "nan", "inf", "half", ""] {
            let setting = format!("procerus={value}");
            let error = parse(&[&setting]).expect_err("out of range");
            assert!(matches!(error, SettingError::Activation { .. }), "{error}");
            assert!(
                error.to_string().contains("from 0 (relaxed) to 1"),
                "{error}"
            );
        }
    }

    #[test]
    fn unknown_names_get_a_suggestion() {
        let error = parse(&["zygomaticus_mayor_L=0.6"]).expect_err("unknown");
        assert!(
            error
                .to_string()
                .contains("did you mean \"zygomaticus_major_L\"?"),
            "{error}"
        );
        let error = parse(&["elbow=0.6"]).expect_err("unknown");
        assert!(!error.to_string().contains("did you mean"), "{error}");
        assert!(matches!(parse(&["procerus"]), Err(SettingError::Form(_))));
        assert!(matches!(parse(&["=1"]), Err(SettingError::Form(_))));
        assert!(matches!(
            parse(&["zygomaticus_major=1", "zygomaticus_major_L=0"]),
            Err(SettingError::Twice { .. })
        ));
    }

    #[test]
    fn angles_need_their_unit() {
        assert_eq!(parse_angle("180deg"), Ok(std::f64::consts::PI));
        assert_eq!(parse_angle(" 0.2 rad"), Ok(0.2));
        for bad in ["12", "deg", "nandeg", "12 grad", ""] {
            assert!(
                matches!(parse_angle(bad), Err(SettingError::Angle(_))),
                "{bad}"
            );
        }
    }
}
