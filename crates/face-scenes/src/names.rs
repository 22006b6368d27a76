//! Names of muscles: of one, of both sides, of a bundle; and names that are almost right.

use std::fmt;

/// The name of a bundle of a muscle, from 1: `zygomaticus_major.2_L`.
pub(super) fn bundle(muscle: &str, number: usize) -> String {
    let (stem, side) = parted(muscle);
    format!("{stem}.{number}{side}")
}

/// A name without its side, and the side: `_L`, `_R` or nothing.
fn parted(name: &str) -> (&str, &str) {
    let at = match name.len().checked_sub(2) {
        Some(at) if name.ends_with("_L") || name.ends_with("_R") => at,
        _ => name.len(),
    };
    name.split_at(at)
}

/// The muscle that a bundle is of, and its side; any other name, parted as it is.
fn whole(name: &str) -> (&str, &str) {
    let (stem, side) = parted(name);
    let number = |(_, n): &(&str, &str)| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
    let numbered = stem.rsplit_once('.').filter(number);
    (numbered.map_or(stem, |(whole, _)| whole), side)
}

/// Are they one muscle, or bundles of one?
pub(super) fn are_of_one(a: &str, b: &str) -> bool {
    whole(a) == whole(b)
}

/// Those that a name means: the muscle of that name; else its bundles; else, of a name without a side,
/// those of both. Bundles of two sides are numbered each by itself: one alone is named with its side.
pub(super) fn meant<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<usize> {
    let how = |name: &str| {
        let (whole, side) = whole(name);
        let ways = [
            name == wanted,
            wanted.strip_prefix(whole) == Some(side),
            whole == wanted,
        ];
        ways.iter().position(|&meant| meant)
    };
    let ways: Vec<Option<usize>> = names.into_iter().map(how).collect();
    let best = ways.iter().flatten().min();
    let is_best = |way: &Option<usize>| way.is_some() && way.as_ref() == best;
    let found = ways.iter().enumerate().filter(|(_, way)| is_best(way));
    found.map(|(place, _)| place).collect()
}

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
    fn a_name_means_a_muscle_or_its_bundles_of_one_side_or_both() {
        let names = [
            "smile_L", "pout.1_L", "pout.2_L", "smile_R", "pout.1_R", "chin", "v.x",
        ];
        let cases: [(&str, &[usize]); 10] = [
            ("smile_L", &[0]),
            ("smile", &[0, 3]),
            ("pout_L", &[1, 2]),
            ("pout", &[1, 2, 4]),
            ("pout.1", &[]),
            ("pout.2_L", &[2]),
            ("chin", &[5]),
            ("v.x", &[6]),
            ("v", &[]),
            ("chin_L", &[]),
        ];
        for (wanted, expected) in cases {
            assert_eq!(meant(wanted, names), expected, "{wanted}");
        }
        assert_eq!(bundle("pout_L", 2), names[2]);
        assert_eq!(bundle("chin", 1), "chin.1");
        // One side whole, the other in parts.
        assert_eq!(meant("a", ["a.1_L", "a.2_L", "a_R"]), [0, 1, 2]);
        assert!(are_of_one("a.1_L", "a_L") && !are_of_one("a.1_L", "a.1_R"));
        // The one of the very name before both sides.
        assert_eq!(meant("a", ["a_L", "a", "a_R"]), [1]);
    }

    #[test]
    fn small_slips_are_forgiven_and_nonsense_is_not() {
        let names = ["zygomaticus_major_L", "zygomaticus_minor_L", "mentalis_R"];
        assert_eq!(closest("zygomaticus_mayor_l", names), Some(names[0]));
        assert_eq!(closest("mentalis", names), Some(names[2]));
        assert_eq!(closest("elbow", names), None);
    }
}
