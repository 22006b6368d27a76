//! Which nodes hang on which bone.

use serde::Serialize;

/// What holds a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Bone {
    /// Nothing: the node is free (x^U of document 000).
    #[default]
    Free,
    /// The skull.
    Cranium,
    /// The lower jaw.
    Jaw,
}

/// The nodes of a face by the bone they hang on; each list ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bones {
    of_node: Vec<Bone>,
    /// Nodes that move freely.
    pub free: Vec<u32>,
    /// Nodes fixed to the skull.
    pub cranium: Vec<u32>,
    /// Nodes fixed to the jaw.
    pub jaw: Vec<u32>,
}

impl Bones {
    /// Sorts nodes by their label.
    pub fn new(of_node: Vec<Bone>) -> Self {
        let list = |bone| {
            let nodes = of_node.iter().enumerate();
            nodes
                .filter_map(|(n, &b)| (b == bone).then_some(n as u32))
                .collect()
        };
        Self {
            free: list(Bone::Free),
            cranium: list(Bone::Cranium),
            jaw: list(Bone::Jaw),
            of_node,
        }
    }
    /// The bone of every node.
    pub fn of_node(&self) -> &[Bone] {
        &self.of_node
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_is_in_one_list() {
        let bones = Bones::new(vec![Bone::Jaw, Bone::Free, Bone::Cranium, Bone::Free]);
        assert_eq!(bones.free, [1, 3]);
        assert_eq!((&bones.cranium[..], &bones.jaw[..]), (&[2][..], &[0][..]));
        assert_eq!(bones.of_node()[2], Bone::Cranium);
    }
}
