//! Names that are almost right.

use std::fmt;

/// The name closest to `wanted` in edit distance, if it is close enough to be meant.
pub(super) fn closest<'a>(
    wanted: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let lower = wanted.to_lowercase();
    names
        .into_iter()
        .map(|name| (strsim::levenshtein(&lower, &name.to_lowercase()), name))
        .min()
        .filter(|&(d, _)| d <= 2 + wanted.chars().count() / 4)
        .map(|(_, name)| name)
}

/// As [`closest`], to keep in an error.
pub(super) fn similar<'a>(
    wanted: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    closest(wanted, names).map(str::to_owned)
}

/// "; did you mean …?" or nothing.
pub(super) struct DidYouMean<'a>(pub &'a Option<String>);

impl fmt::Display for DidYouMean<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(name) => write!(f, "; did you mean \"{name}\"?"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_slips_are_forgiven_and_nonsense_is_not() {
        let names = ["zygomaticus_major_L", "zygomaticus_minor_L", "mentalis_R"];
        assert_eq!(closest("zygomaticus_mayor_l", names), Some(names[0]));
        assert_eq!(closest("mentalis", names), Some(names[2]));
        assert_eq!(closest("elbow", names), None);
    }
}
