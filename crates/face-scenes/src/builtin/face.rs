//! The built-in face as arrays.

use fem_solvers::parallel;

use super::bones::{Inner, inner};
use super::decoration::{Decoration, decorations, teeth_block};
use super::features::{EYEBALL, EYEBALL_RADIUS};
use super::form::{Form, MOUTH, Side};
use super::grid::Grid;
use super::landmarks::landmarks;
use super::muscles::{entries, names};
use super::tissue::{Tissue, tissues};
use face_rig::anatomy::{Bone, EmbeddedPoint, FiberEntry, JawHinge};
use fem_assembly::mesh::SimplexMesh;

/// A face cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuiltinError {
    /// The resolution is out of range.
    #[error("a built-in face of {target} tets cannot be made: ask for 4000 to 2000000")]
    Resolution {
        /// Tets asked for.
        target: usize,
    },
}

/// Material `b` of the cut where nothing holds it, millimeters.
const SLIDING: std::ops::RangeInclusive<f64> = -110.0..=0.0;
/// Half of the width of the part of the lips that may touch, and its reach above and below the line of
/// the mouth, millimeters.
const LIPS: [f64; 2] = [45.0, 22.0];

/// What a boundary triangle touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Touching {
    /// Air: the outer skin.
    Air = 1,
    /// The mouth: lips and cheeks from inside.
    Mouth = 2,
    /// The eye sockets: lids from inside, and their margins.
    EyeSocket = 3,
    /// Bone, attached.
    Bone = 4,
    /// The cut in front of the ears, on the forehead and the neck.
    Cut = 5,
    /// Unattached depth: the floor of the mouth, the gap at the joint of the jaw.
    Gap = 6,
}

/// A triangle of the mesh's boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoundaryTriangle {
    /// Mesh nodes, counter-clockwise from outside.
    pub nodes: [u32; 3],
    /// The tet behind it.
    pub tet: u32,
    /// What it touches.
    pub touching: Touching,
}

/// A parametric head from ear to ear: flesh between skull and skin, with lips and lids that open.
///
/// Positions are in meters, `+x` to the subject's left, `+y` up, `+z` forward. The mesh is its own
/// mirror image: node for node, tet for tet, and muscle for muscle.
///
/// ```
/// use face_rig::anatomy::Bone;
/// use face_scenes::builtin::BuiltinFace;
///
/// let face = BuiltinFace::with_tets(5_000)?;
/// assert_eq!(face.nodes.len(), face.bone.len());
/// assert!(face.bone.contains(&Bone::Jaw));
/// # Ok::<(), face_scenes::builtin::BuiltinError>(())
/// ```
#[derive(Debug, Clone)]
pub struct BuiltinFace {
    /// Rest positions, meters.
    pub nodes: Vec<[f64; 3]>,
    /// Positively oriented tets.
    pub tets: Vec<[u32; 4]>,
    /// What each tet is made of.
    pub tissue: Vec<Tissue>,
    /// What each node is attached to.
    pub bone: Vec<Bone>,
    /// Material coordinates of each node: millimeters sideways, millimeters upwards, and depth from
    /// 0 at the bone to 1 at the skin. What [`super::flesh_color`] takes.
    pub material: Vec<[f64; 3]>,
    /// The whole boundary, outward oriented, by tet.
    pub boundary: Vec<BoundaryTriangle>,
    /// The joint of the jaw.
    pub hinge: JawHinge,
    /// The 68 landmarks in Multi-PIE order.
    pub landmarks: Vec<EmbeddedPoint>,
    /// Names of the muscles: those of the left side, ending in `_L`, then the same of the right.
    pub muscles: Vec<String>,
    /// Which muscles run through which tets, and where to; sorted by tet, then by muscle.
    pub fibers: Vec<FiberEntry>,
    grid: Grid,
}

impl BuiltinFace {
    /// The numbers of tets that can be asked for.
    pub const TETS: std::ops::RangeInclusive<usize> = 4_000..=2_000_000;

    /// Center of the left eyeball, meters.
    pub const EYEBALL_CENTER: [f64; 3] = [1e-3 * EYEBALL[0], 1e-3 * EYEBALL[1], 1e-3 * EYEBALL[2]];
    /// Radius of the eyeballs, meters.
    pub const EYEBALL_RADIUS: f64 = 1e-3 * EYEBALL_RADIUS;

    /// The face whose number of tets is as near to `target` as the grid allows (a few per cent).
    ///
    /// # Errors
    /// [`BuiltinError::Resolution`] outside 4,000 to 2,000,000.
    pub fn with_tets(target: usize) -> Result<Self, BuiltinError> {
        if !Self::TETS.contains(&target) {
            return Err(BuiltinError::Resolution { target });
        }
        let form = Form::new();
        let grid = Grid::with_tets(target, &form);
        let with_sides = grid.material();
        let nodes: Vec<[f64; 3]> = parallel::indexed(with_sides.len(), |k| {
            let ([a, b, w], side) = with_sides[k];
            form.position(a, b, w, side).map(|x| 1e-3 * x)
        });
        let tets = grid.tets();
        let bone = attachments(&grid);
        let material: Vec<[f64; 3]> = with_sides.iter().map(|m| m.0).collect();
        let tissue = tissues(&form, &tets, &material);
        let boundary = boundary(&nodes, &tets, &grid, &material);
        let hinge = JawHinge::sideways([0.0, 0.002, 0.012]);
        let landmarks = landmarks(&form)
            .iter()
            .map(|&([a, b], side)| grid.locate(a, b, 1.0, side))
            .collect();
        let fibers = entries(&grid, &nodes, &tets, &material);
        let muscles = names();
        Ok(Self {
            nodes,
            tets,
            tissue,
            bone,
            material,
            boundary,
            hinge,
            landmarks,
            muscles,
            fibers,
            grid,
        })
    }

    /// Eyeballs, teeth and the inside of the mouth, to be drawn but not simulated.
    pub fn decorations(&self) -> Vec<Decoration> {
        decorations()
    }

    /// Teeth and gums of one jaw as a closed surface, meters: points, and triangles counter-clockwise
    /// from outside.
    pub fn teeth(bone: Bone) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        teeth_block(bone)
    }

    /// Positions of the landmarks for given node positions; NaN where a node of a landmark has none.
    pub fn landmark_positions(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.landmarks
            .iter()
            .map(|p| p.position(positions))
            .collect()
    }

    /// Triangles of the outer skin, over mesh nodes.
    pub fn skin(&self) -> Vec<[u32; 3]> {
        self.triangles(|t| t == Touching::Air)
    }

    /// Triangles of the lips, inside and outside, that may touch each other.
    pub fn lips(&self) -> Vec<[u32; 3]> {
        let near = |t: &&BoundaryTriangle| {
            let apart = |n: &u32| {
                let [a, b, _] = self.material[*n as usize];
                a.abs() > LIPS[0] || (b - MOUTH).abs() > LIPS[1]
            };
            let touches = matches!(t.touching, Touching::Air | Touching::Mouth);
            touches && !t.nodes.iter().any(apart)
        };
        self.boundary.iter().filter(near).map(|t| t.nodes).collect()
    }

    /// Boundary triangles over mesh nodes, chosen by what they touch.
    pub fn triangles(&self, wanted: impl Fn(Touching) -> bool) -> Vec<[u32; 3]> {
        self.boundary
            .iter()
            .filter(|t| wanted(t.touching))
            .map(|t| t.nodes)
            .collect()
    }

    /// Where a material point is in the mesh; coordinates outside are moved to the nearest inside.
    pub fn embed(&self, material: [f64; 3], side: Side) -> EmbeddedPoint {
        self.grid
            .locate(material[0], material[1], material[2], side)
    }
}

fn attachments(grid: &Grid) -> Vec<Bone> {
    let mut bone = vec![Bone::Free; grid.node_count()];
    for j in 0..=grid.along() {
        for i in 0..=grid.across() {
            // Behind the jaw the skin of the neck slides on beyond the cut.
            let slides = SLIDING.contains(&grid.b(j));
            let behind = i == 0 || i == grid.across();
            let cut = behind && !slides || j == 0 || j == grid.along();
            for side in [Side::Lower, Side::Upper] {
                for k in 0..=grid.layers() {
                    bone[grid.node(i, j, k, side) as usize] = if cut {
                        Bone::Cranium
                    } else if k > 0 {
                        Bone::Free
                    } else if let Inner::Attached(b) = inner(grid.a(i), grid.b(j)) {
                        b
                    } else {
                        Bone::Free
                    };
                }
            }
        }
    }
    bone
}

fn boundary(
    nodes: &[[f64; 3]],
    tets: &[[u32; 4]],
    grid: &Grid,
    material: &[[f64; 3]],
) -> Vec<BoundaryTriangle> {
    let Ok(mesh) = SimplexMesh::<3>::new(nodes.to_vec(), tets.as_flattened().to_vec()) else {
        return Vec::new();
    };
    let surface = mesh.boundary();
    let (side, bottom, top) = (grid.a(grid.across()), grid.b(0), grid.b(grid.along()));
    let triangles = surface.faces.iter().zip(&surface.element);
    triangles
        .map(|(&t, &tet)| {
            let m = t.map(|n| material[n as usize]);
            let all = |test: &dyn Fn([f64; 3]) -> bool| m.iter().all(|&p| test(p));
            let middle = [0, 1].map(|k| (m[0][k] + m[1][k] + m[2][k]) / 3.0);
            let touching = if all(&|p| p[2] == 1.0) {
                Touching::Air
            } else if all(&|p| p[0].abs() == side)
                || all(&|p| p[1] == bottom)
                || all(&|p| p[1] == top)
            {
                Touching::Cut
            } else if all(&|p| p[2] == 0.0) {
                match inner(middle[0], middle[1]) {
                    Inner::Attached(_) => Touching::Bone,
                    Inner::Mouth => Touching::Mouth,
                    Inner::Socket => Touching::EyeSocket,
                    Inner::Gap => Touching::Gap,
                }
            } else if middle[1] > 0.0 {
                Touching::EyeSocket
            } else {
                Touching::Mouth
            };
            BoundaryTriangle {
                nodes: t,
                tet,
                touching,
            }
        })
        .collect()
}
