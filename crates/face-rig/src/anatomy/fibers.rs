//! Muscles and the elements that their fibers run through.

use serde::Serialize;
use std::ops::Range;

/// Which half of the face a muscle lies in, read from the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The subject's left, `_L`.
    Left,
    /// The subject's right, `_R`.
    Right,
    /// Neither ending.
    Middle,
}

/// A muscle: one activation of the rig.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Muscle {
    /// Its name, unique in the face.
    pub name: String,
}

impl Muscle {
    /// The half of the face that its name tells.
    pub fn side(&self) -> Side {
        match self.name.rsplit_once('_') {
            Some((_, "L")) => Side::Left,
            Some((_, "R")) => Side::Right,
            _ => Side::Middle,
        }
    }
}

/// One muscle in one element: the active stress there is α σ_max `weight` times the tension curve
/// along `direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiberEntry {
    /// The element.
    pub tet: u32,
    /// The muscle.
    pub muscle: u32,
    /// Share of the element's volume that the muscle fills, above 0, at most 1.
    pub weight: f64,
    /// Fiber direction at rest, of length 1; its sign means nothing.
    pub direction: [f64; 3],
}

/// Why a list of fiber entries cannot be used; `entry` is its place in the list.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FiberError {
    /// No such element.
    #[error("tet {tet} is not in the mesh, which has {tets} (0 to {last})", last = tets.saturating_sub(1))]
    Tet {
        /// Place in the list.
        entry: usize,
        /// The element named.
        tet: u32,
        /// Elements of the mesh.
        tets: usize,
    },
    /// No such muscle.
    #[error(
        "muscle {muscle} is unknown, there are {muscles} names (0 to {last})",
        last = muscles.saturating_sub(1)
    )]
    Muscle {
        /// Place in the list.
        entry: usize,
        /// The muscle named.
        muscle: u32,
        /// Muscles of the face.
        muscles: usize,
    },
    /// A weight outside (0, 1].
    #[error("weight {weight} is not above 0 and at most 1")]
    Weight {
        /// Place in the list.
        entry: usize,
        /// The weight.
        weight: f64,
    },
    /// A direction whose length is off 1 by more than 0.001.
    #[error("the fiber has length {length}, not 1; normalize it")]
    Direction {
        /// Place in the list.
        entry: usize,
        /// |f|.
        length: f64,
    },
    /// The same muscle twice in one element.
    #[error("muscle {muscle} appears twice in tet {tet}; add the weights up")]
    Twice {
        /// Place of the second in the list.
        entry: usize,
        /// The element.
        tet: u32,
        /// The muscle.
        muscle: u32,
    },
}

impl FiberError {
    /// Place of the offending entry in the list given.
    pub fn entry(&self) -> usize {
        match self {
            Self::Tet { entry, .. }
            | Self::Muscle { entry, .. }
            | Self::Weight { entry, .. }
            | Self::Direction { entry, .. }
            | Self::Twice { entry, .. } => *entry,
        }
    }
}

/// All fibers of a face, validated, sorted by element and within it by muscle. An element may
/// carry several muscles, which add up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FiberField {
    entries: Vec<FiberEntry>,
}

impl FiberField {
    /// Validates and sorts; directions are normalized to the last digit.
    ///
    /// # Errors
    /// [`FiberError`] with the first offending entry.
    pub fn new(
        mut entries: Vec<FiberEntry>,
        tets: usize,
        muscles: usize,
    ) -> Result<Self, FiberError> {
        for (entry, e) in entries.iter_mut().enumerate() {
            if e.tet as usize >= tets {
                let tet = e.tet;
                return Err(FiberError::Tet { entry, tet, tets });
            }
            if e.muscle as usize >= muscles {
                return Err(FiberError::Muscle {
                    entry,
                    muscle: e.muscle,
                    muscles,
                });
            }
            if !(e.weight > 0.0 && e.weight <= 1.0 + 1e-9) {
                let weight = e.weight;
                return Err(FiberError::Weight { entry, weight });
            }
            let length = e.direction.iter().map(|v| v * v).sum::<f64>().sqrt();
            let unit = (length - 1.0).abs() <= 1e-3;
            if !unit {
                return Err(FiberError::Direction { entry, length });
            }
            e.direction = e.direction.map(|v| v / length);
        }
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_by_key(|&i| (entries[i].tet, entries[i].muscle));
        for pair in order.windows(2) {
            let (a, b) = (entries[pair[0]], entries[pair[1]]);
            if (a.tet, a.muscle) == (b.tet, b.muscle) {
                return Err(FiberError::Twice {
                    entry: pair[1],
                    tet: b.tet,
                    muscle: b.muscle,
                });
            }
        }
        Ok(Self {
            entries: order.into_iter().map(|i| entries[i]).collect(),
        })
    }
    /// All entries, by element, then muscle.
    pub fn entries(&self) -> &[FiberEntry] {
        &self.entries
    }
    /// Where the entries of element `tet` are; empty for passive elements.
    pub fn range_of(&self, tet: u32) -> Range<usize> {
        let start = self.entries.partition_point(|e| e.tet < tet);
        let count = self.entries[start..].partition_point(|e| e.tet == tet);
        start..start + count
    }
    /// The muscles of element `tet`; empty for passive elements.
    pub fn of_tet(&self, tet: u32) -> &[FiberEntry] {
        &self.entries[self.range_of(tet)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(tet: u32, muscle: u32) -> FiberEntry {
        FiberEntry {
            tet,
            muscle,
            weight: 0.5,
            direction: [0.0, 0.6, 0.8],
        }
    }

    #[test]
    fn several_muscles_share_an_element() {
        let list = vec![entry(4, 1), entry(2, 0), entry(4, 0)];
        let field = FiberField::new(list, 5, 2).expect("valid");
        let muscles: Vec<u32> = field.of_tet(4).iter().map(|e| e.muscle).collect();
        assert_eq!(muscles, [0, 1]);
        assert!(field.of_tet(3).is_empty());
        assert_eq!(field.range_of(2), 0..1);
    }

    #[test]
    fn each_defect_has_its_own_error() {
        let with = |change: fn(&mut FiberEntry)| {
            let mut list = vec![entry(0, 0), entry(1, 1)];
            change(&mut list[1]);
            FiberField::new(list, 5, 2).expect_err("must be refused")
        };
        let error = with(|e| e.tet = 5);
        assert!(matches!(
            error,
            FiberError::Tet {
                entry: 1,
                tet: 5,
                ..
            }
        ));
        assert!(error.to_string().contains("0 to 4"), "{error}");
        assert!(matches!(
            with(|e| e.muscle = 2),
            FiberError::Muscle { muscle: 2, .. }
        ));
        for weight in [0.0, -0.1, 1.1, f64::NAN] {
            let mut list = vec![entry(0, 0)];
            list[0].weight = weight;
            assert!(matches!(
                FiberField::new(list, 5, 2),
                Err(FiberError::Weight { entry: 0, .. })
            ));
        }
        assert!(matches!(
            with(|e| e.direction[2] = 0.9),
            FiberError::Direction { .. }
        ));
        assert!(matches!(
            with(|e| e.direction[0] = f64::NAN),
            FiberError::Direction { .. }
        ));
        let twice = with(|e| (e.tet, e.muscle) = (0, 0));
        assert!(matches!(
            twice,
            FiberError::Twice {
                entry: 1,
                tet: 0,
                muscle: 0
            }
        ));
        assert_eq!(twice.entry(), 1);
    }

    #[test]
    fn sides_come_from_names() {
        let side = |name: &str| Muscle { name: name.into() }.side();
        assert_eq!(side("zygomaticus_major_L"), Side::Left);
        assert_eq!(side("mentalis_R"), Side::Right);
        assert_eq!(side("procerus"), Side::Middle);
    }
}
