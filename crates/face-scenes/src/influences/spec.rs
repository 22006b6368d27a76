//! What a scene file says of loads, cavities, motions, strengths and stiffnesses.

use crate::shape::ShapeSpec;
use serde::{Deserialize, Serialize};

/// Nodes or faces: those that meet every condition given, at least one. A face of the boundary meets
/// a condition when its three nodes do. Lengths are in the scene's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlaceSpec {
    /// Inside a box with faces along the axes.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub inside_box: Option<BoxSpec>,
    /// Inside a sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphere: Option<SphereSpec>,
    /// With one of these labels in a point data array of whole numbers of the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub array: Option<LabelsSpec>,
    /// A node of an element of the region with this name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// One of these nodes of the mesh, counted from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Vec<u32>>,
    /// Faces only: turned toward this point, and no other face is between.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seen_from: Option<[f64; 3]>,
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// The corner of the least coordinates.
    pub low: [f64; 3],
    /// The corner of the greatest.
    pub high: [f64; 3],
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// Its center.
    pub center: [f64; 3],
    /// Its radius.
    pub radius: f64,
}

/// Labels of a point data array.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelsSpec {
    /// Name of the array.
    pub name: String,
    /// The labels.
    pub labels: Vec<i64>,
}

/// A load. With a `range` its factor is 0 (or the end nearest to it) until it is set, and a fit
/// varies it; without one the factor is 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum LoadSpec {
    /// A force on nodes that keeps its direction.
    Force {
        /// A name to set it by.
        name: String,
        /// The nodes.
        at: PlaceSpec,
        /// The force on all of them together, newtons; each carries an equal part.
        newtons: [f64; 3],
        /// The factors that a fit may choose.
        #[serde(default)]
        range: Option<[f64; 2]>,
    },
    /// A traction on faces that keeps its direction.
    Traction {
        /// A name to set it by.
        name: String,
        /// The faces.
        on: PlaceSpec,
        /// Force on each square meter at rest, pascals.
        pascals: [f64; 3],
        /// The factors that a fit may choose.
        #[serde(default)]
        range: Option<[f64; 2]>,
    },
    /// A pressure on faces, against their outward normals at rest. For one that follows the faces see
    /// `cavities`.
    Pressure {
        /// A name to set it by.
        name: String,
        /// The faces.
        on: PlaceSpec,
        /// The pressure, pascals.
        pascals: f64,
        /// The factors that a fit may choose.
        #[serde(default)]
        range: Option<[f64; 2]>,
    },
    /// Weight of the flesh.
    Gravity {
        /// A name to set it by.
        name: String,
        /// kg/m³.
        density: f64,
        /// m/s².
        acceleration: [f64; 3],
        /// The factors that a fit may choose.
        #[serde(default)]
        range: Option<[f64; 2]>,
    },
    /// Springs of rest length 0 from nodes to a point, or each to where its node rests.
    Springs {
        /// A name to set it by.
        name: String,
        /// The nodes.
        at: PlaceSpec,
        /// Of each spring, newtons per meter.
        stiffness: f64,
        /// Where they end.
        #[serde(default)]
        to: Option<[f64; 3]>,
        /// The factors that a fit may choose.
        #[serde(default)]
        range: Option<[f64; 2]>,
    },
    /// Penalty collisions (document 000, 5.7): nodes inside a solid that stands still in the frame of the
    /// skull are pushed out by stiffness times depth. Softer and simpler than `contact`.
    Penalty {
        /// A name to set it by.
        name: String,
        /// The nodes.
        at: PlaceSpec,
        /// Of each node, newtons per meter of depth.
        stiffness: f64,
        /// The solid: any shape but triangles.
        shape: ShapeSpec,
        /// The factors that a fit may choose.
        #[serde(default)]
        range: Option<[f64; 2]>,
    },
}

/// A pressure inside a cavity that flesh surrounds; it follows the faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CavitySpec {
    /// A name to set it by.
    pub name: String,
    /// The faces of the flesh that the cavity touches.
    pub faces: PlaceSpec,
    /// What closes it where they do not.
    #[serde(default)]
    pub closed_by: ClosureSpec,
    /// The pressure where none is set, pascals.
    #[serde(default)]
    pub pascals: f64,
    /// The pressures that a fit may choose, pascals.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
}

/// What closes a cavity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum ClosureSpec {
    /// Each hole a fan of triangles through the nodes of its rim, around one on a bone if there is one.
    #[default]
    Fan,
    /// Nothing: the faces are closed, or that is an error.
    Nothing,
    /// A mantle from the rims to a point that stays where it is.
    Point([f64; 3]),
}

/// Free nodes that are put somewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    /// A name to set it by.
    pub name: String,
    /// The nodes; those on bones stay with their bone.
    pub nodes: PlaceSpec,
    /// Which coordinates are prescribed, of x, y and z; the others stay free.
    #[serde(default = "all_axes")]
    pub axes: String,
    /// How far from rest, in the scene's unit, at factor 1.
    pub by: [f64; 3],
    /// The factors that a fit may choose; without it the factor is 1.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
}

fn all_axes() -> String {
    "xyz".into()
}

/// The relative change of a muscle's strength (its maximal isometric stress, and its passive stress).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrengthSpec {
    /// A name to set it by.
    pub name: String,
    /// The muscle; without `_L` or `_R` both sides.
    pub muscle: String,
    /// The change where none is set: 0.5 is half as strong again, −1 is no muscle.
    #[serde(default)]
    pub change: f64,
    /// The changes that a fit may choose.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
}

/// The relative change of a region's stiffness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StiffnessSpec {
    /// A name to set it by.
    pub name: String,
    /// The region's name; `flesh` for the scene's own material.
    pub region: String,
    /// The change where none is set: 0.5 is half as stiff again.
    #[serde(default)]
    pub change: f64,
    /// The changes that a fit may choose.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
}
