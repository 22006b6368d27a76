//! What looks wrong in a scene and can be solved all the same.

use super::check::{CheckReport, MeshReport, MuscleReport};
use super::distance::distance;
use super::material::Region;
use super::names::are_of_one;
use super::{Scene, strays};
use face_rig::anatomy::Side;
use fem_materials::Lame;
use serde::{Serialize, Serializer};
use std::fmt;

/// Something that looks wrong. `Display` says what to do about it, and so does a report in JSON.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// No face is so tall or so small.
    Height {
        /// Its height, meters.
        height: f64,
    },
    /// The flesh is not of one piece.
    Pieces {
        /// Pieces that share no face.
        pieces: usize,
    },
    /// Tets were inside out.
    Repaired {
        /// How many were turned over.
        tets: usize,
    },
    /// Flat tets.
    DihedralAngle {
        /// The smallest angle, degrees.
        angle: f64,
        /// The worst tets.
        worst: Vec<u32>,
    },
    /// No node hangs on the jaw.
    NoJaw,
    /// The jaw closes where it should open.
    HingeReversed,
    /// A region that resists no change of shape.
    NoShearModulus {
        /// Its name.
        region: String,
    },
    /// A region that resists nothing.
    NoStiffness {
        /// Its name.
        region: String,
    },
    /// Tets that both bones pull at.
    TouchBothBones {
        /// How many.
        tets: usize,
    },
    /// Tets without a free node that both bones move.
    MovedByBothBones {
        /// Which.
        tets: Vec<u32>,
    },
    /// A muscle that runs through nothing.
    EmptyMuscle {
        /// Its name.
        muscle: String,
    },
    /// A muscle of one side that the other side lacks.
    NoPartner {
        /// Its name.
        muscle: String,
        /// The name that is missing.
        partner: String,
    },
    /// More muscle in a tet than there is room for.
    Crowded {
        /// In how many.
        tets: usize,
    },
    /// Vertices of the skin that ride on other flesh than what is around them.
    Strays {
        /// Their numbers in the embedding.
        vertices: Vec<u32>,
    },
    /// Not the usual 68 landmarks.
    Landmarks {
        /// How many there are.
        landmarks: usize,
    },
    /// A target without some of the landmarks.
    MissingLandmarks {
        /// Its name.
        target: String,
        /// What it has.
        found: usize,
        /// What the scene has.
        landmarks: usize,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Height { height } => {
                write!(f, "this face is {height:.3} m tall: meters expected, ")?;
                match UNITS
                    .iter()
                    .find(|(_, factor)| is_plausible(height * factor))
                {
                    Some((unit, factor)) => {
                        write!(f, "did you mean {unit}? add \"scale\": {factor}")
                    }
                    None => f.write_str("set \"scale\" to the meters per unit of the files"),
                }
            }
            Self::Pieces { pieces } => write!(
                f,
                "the flesh has {pieces} pieces that share no face; pieces without bone nodes float away"
            ),
            Self::Repaired { tets } => write!(
                f,
                "{tets} tets had negative volume and were repaired; check the mesh's axes"
            ),
            Self::DihedralAngle { angle, worst } => {
                write!(
                    f,
                    "dihedral angles down to {angle:.1}°; remesh around {worst:?}"
                )
            }
            Self::NoJaw => {
                f.write_str("no node hangs on the jaw: its motion will do nothing; label its nodes")
            }
            Self::HingeReversed => f.write_str(
                "a positive jaw angle brings the jaw nearer to the cranium: the axis of the hinge points \
                 the other way, negate it",
            ),
            Self::NoShearModulus { region } => write!(
                f,
                "region {region} has a shear modulus of 0 at rest: nothing but its muscles and neighbors \
                 holds its shape"
            ),
            Self::NoStiffness { region } => write!(
                f,
                "region {region} has no stiffness at all (its moduli are 0 at rest): its flesh keeps any shape \
                 it is given; give it a Young's modulus above 0 Pa"
            ),
            Self::TouchBothBones { tets } => write!(
                f,
                "{tets} tets touch the cranium and the jaw; they limit how far the jaw opens, refine there"
            ),
            Self::MovedByBothBones { tets } => write!(
                f,
                "{} tets hang on cranium and jaw with all their nodes ({}): they are moved by the bones \
                 alone and turn inside out when the jaw moves far; refine or remove them",
                tets.len(),
                first_of(tets)
            ),
            Self::EmptyMuscle { muscle } => write!(
                f,
                "muscle {muscle} runs through no tet and does nothing; refine or check its path"
            ),
            Self::NoPartner { muscle, partner } => {
                write!(f, "muscle {muscle} has no partner {partner}")
            }
            Self::Crowded { tets } => write!(
                f,
                "in {tets} tets the muscles' weights sum to more than 1: more flesh than there is room for"
            ),
            Self::Strays { vertices } => write!(
                f,
                "vertices of the skin ({}) ride on tets that share no node with those of their nearest \
                 neighbors, as of one lip on the other: the skin crosses itself there when the two move \
                 apart; \"strays\": \"repair\" in face.files gives them tets of their neighbors",
                first_of(vertices)
            ),
            Self::Landmarks { landmarks } => {
                write!(f, "{landmarks} landmarks instead of the usual 68")
            }
            Self::MissingLandmarks {
                target,
                found,
                landmarks,
            } => write!(
                f,
                "target {target} has {found} of {landmarks} landmarks; the others are ignored"
            ),
        }
    }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// "3, 7, 12, …": eight at most.
fn first_of(tets: &[u32]) -> String {
    let named: Vec<String> = tets.iter().take(8).map(u32::to_string).collect();
    let more = if tets.len() > named.len() {
        ", …"
    } else {
        ""
    };
    format!("{}{more}", named.join(", "))
}

/// Units whose factor to meters a scene's `scale` can give.
const UNITS: [(&str, f64); 4] = [("mm", 1e-3), ("cm", 1e-2), ("inches", 0.0254), ("µm", 1e-6)];

/// Faces are 8 cm to 80 cm tall.
fn is_plausible(height: f64) -> bool {
    (0.08..=0.8).contains(&height)
}

/// Does opening the jaw bring its part far from the hinge nearer to the middle of the cranium, and
/// closing it carry it away?
fn closes(scene: &Scene) -> bool {
    let place = |&n: &u32| scene.mesh.node(n);
    let cranium: Vec<[f64; 3]> = scene.bones.cranium.iter().map(place).collect();
    let count = cranium.len() as f64;
    let middle = |i: usize| cranium.iter().map(|p| p[i]).sum::<f64>() / count;
    let middle: [f64; 3] = std::array::from_fn(middle);
    let hinge = scene.joint.hinge();
    let away = |p: &[f64; 3]| distance(*p, hinge.point());
    let jaw = scene.bones.jaw.iter().map(place);
    let Some(chin) = jaw.max_by(|a, b| away(a).total_cmp(&away(b))) else {
        return false;
    };
    // Far enough to tell from a tie: 0.1 rad of a chin 0.1 m away is 10 mm.
    let at = |angle: f64| distance(hinge.motion(angle, [0.0; 3]).apply(chin), middle);
    at(0.1) < at(-0.1) - 0.02 * away(&chin)
}

/// What looks wrong, in the order of the report; `crowded` tets have more muscle than room.
pub(super) fn all(scene: &Scene, report: &CheckReport, crowded: usize) -> Vec<Warning> {
    let mut warnings = Warnings::default();
    warnings.mesh(&report.mesh);
    warnings.bones(scene, report);
    warnings.flesh(scene);
    warnings.muscles(scene, report, crowded);
    warnings.skin(scene);
    warnings.targets(scene, report.landmarks);
    warnings.0
}

#[derive(Default)]
struct Warnings(Vec<Warning>);

impl Warnings {
    fn add(&mut self, condition: bool, warning: impl FnOnce() -> Warning) {
        if condition {
            self.0.push(warning());
        }
    }

    fn mesh(&mut self, mesh: &MeshReport) {
        let (height, pieces, tets) = (mesh.size[1], mesh.components, mesh.inverted);
        self.add(!is_plausible(height), || Warning::Height { height });
        self.add(pieces > 1, || Warning::Pieces { pieces });
        self.add(tets > 0, || Warning::Repaired { tets });
        let angle = mesh.smallest_dihedral;
        self.add(angle < 5.0, || Warning::DihedralAngle {
            angle,
            worst: mesh.worst.clone(),
        });
    }

    fn bones(&mut self, scene: &Scene, report: &CheckReport) {
        self.add(scene.bones.jaw.is_empty(), || Warning::NoJaw);
        self.add(closes(scene), || Warning::HingeReversed);
        let tets = report.tets_touching_both_bones;
        self.add(tets > 0, || Warning::TouchBothBones { tets });
        let between = &report.tets_moved_by_both_bones;
        self.add(!between.is_empty(), || Warning::MovedByBothBones {
            tets: between.clone(),
        });
    }

    fn flesh(&mut self, scene: &Scene) {
        for Region { name, material, .. } in &scene.regions {
            let Ok(Lame { mu, lambda }) = material.at_rest() else {
                continue;
            };
            let region = name.clone();
            self.add(mu == 0.0 && lambda != 0.0, || {
                let region = region.clone();
                Warning::NoShearModulus { region }
            });
            self.add(mu == 0.0 && lambda == 0.0, || Warning::NoStiffness {
                region,
            });
        }
    }

    fn muscles(&mut self, scene: &Scene, report: &CheckReport, crowded: usize) {
        for MuscleReport { name, tets, .. } in &report.muscles {
            let muscle = name.clone();
            self.add(*tets == 0, || Warning::EmptyMuscle { muscle });
        }
        for muscle in &scene.muscles {
            let name = &muscle.name;
            let partner = match muscle.side() {
                Side::Left => name.strip_suffix('L').map(|s| format!("{s}R")),
                Side::Right => name.strip_suffix('R').map(|s| format!("{s}L")),
                Side::Middle => None,
            };
            let missing = partner.filter(|p| !scene.muscles.iter().any(|m| are_of_one(&m.name, p)));
            self.0.extend(missing.map(|partner| Warning::NoPartner {
                muscle: name.clone(),
                partner,
            }));
        }
        self.add(crowded > 0, || Warning::Crowded { tets: crowded });
    }

    fn skin(&mut self, scene: &Scene) {
        let Some(skin) = &scene.skin else {
            return;
        };
        let number = |v: &u32| {
            let point = &skin.points[*v as usize];
            let named = scene.embedding.iter().find(|(_, known)| *known == point);
            named.map_or(*v, |(number, _)| *number)
        };
        let strays = strays::strays(skin, scene.mesh.nodes());
        let vertices: Vec<u32> = strays.iter().map(number).collect();
        self.add(!vertices.is_empty(), || Warning::Strays { vertices });
    }

    fn targets(&mut self, scene: &Scene, landmarks: usize) {
        self.add(landmarks != 0 && landmarks != 68, || Warning::Landmarks {
            landmarks,
        });
        for target in &scene.targets {
            let found = target.landmarks.len();
            self.add(found < landmarks, || Warning::MissingLandmarks {
                target: target.name.clone(),
                found,
                landmarks,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Warning, is_plausible};
    use crate::material::NamedMaterial;
    use crate::{Scene, Skin, check};
    use face_rig::anatomy::{CondylarPath, JawHinge, JawJoint};
    use fem_assembly::mesh::EmbeddedPoint;

    #[test]
    fn a_reversed_hinge_and_flesh_without_stiffness_are_told() {
        let mut scene = Scene::builtin(5_000).expect("a face");
        let told = |scene: &Scene| check(scene).warnings;
        let is = |w: &Warning| {
            let flesh = matches!(
                w,
                Warning::NoShearModulus { .. } | Warning::NoStiffness { .. }
            );
            flesh || *w == Warning::HingeReversed
        };
        assert!(!told(&scene).iter().any(is), "{:?}", told(&scene));
        let hinge = scene.joint.hinge();
        let (point, axis) = (hinge.point(), hinge.axis().map(|a| -a));
        let hinge = JawHinge::new(point, axis).expect("a hinge");
        let limits = *scene.joint.limits();
        scene.joint = JawJoint::new(hinge, CondylarPath::ADULT, limits).expect("a joint");
        let region = scene.regions[0].name.clone();
        scene.regions[0].material =
            NamedMaterial::new("neo_hookean", [("mu", 0.0), ("lambda", 1e5)]);
        let found: Vec<Warning> = told(&scene).into_iter().filter(is).collect();
        let fluid = Warning::NoShearModulus {
            region: region.clone(),
        };
        assert_eq!(found, [Warning::HingeReversed, fluid]);
        for (mu, wanted) in [(0.0, true), (1e-3, false)] {
            scene.regions[0].material =
                NamedMaterial::new("neo_hookean", [("mu", mu), ("lambda", 0.0)]);
            let limp = Warning::NoStiffness {
                region: region.clone(),
            };
            let found: Vec<Warning> = told(&scene).into_iter().filter(is).collect();
            assert_eq!(found.contains(&limp), wanted, "{found:?}");
            assert_eq!(found.len(), 1 + usize::from(wanted), "{found:?}");
        }
    }

    /// Five points of a skin in the middle of one tet, the first carried by a tet far away.
    #[test]
    fn a_vertex_that_rides_on_other_flesh_is_named_as_the_embedding_does() {
        let mut scene = Scene::builtin(5_000).expect("a face");
        let at = |tet: usize, w: [f64; 4]| EmbeddedPoint {
            nodes: scene.mesh.tet(tet),
            weights: w,
        };
        let near = |k: usize| {
            let mut weights = [0.22; 4];
            weights[k] += 0.12;
            at(0, weights)
        };
        let last = scene.mesh.num_elements() - 1;
        let points = vec![at(0, [0.25; 4]), near(0), near(1), near(2), near(3)];
        let rest = points
            .iter()
            .map(|p| p.position(scene.mesh.nodes()))
            .collect();
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        let stray = at(last, [0.25; 4]);
        scene.embedding = (71..).zip(points.clone()).collect();
        scene.skin = Some(Skin {
            points,
            rest,
            triangles,
        });
        let told = |scene: &Scene| {
            let strays = |w: &Warning| matches!(w, Warning::Strays { .. });
            check(scene)
                .warnings
                .into_iter()
                .filter(strays)
                .collect::<Vec<_>>()
        };
        assert_eq!(told(&scene), []);
        scene.embedding.insert(71, stray);
        if let Some(skin) = &mut scene.skin {
            skin.points[0] = stray;
        }
        assert_eq!(told(&scene), [Warning::Strays { vertices: vec![71] }]);
    }

    #[test]
    fn units_are_guessed_from_the_height() {
        assert!(is_plausible(0.22) && !is_plausible(180.0) && !is_plausible(f64::NAN));
        let text = |height| Warning::Height { height }.to_string();
        let cure =
            "this face is 180.000 m tall: meters expected, did you mean mm? add \"scale\": 0.001";
        assert_eq!(text(180.0), cure);
        assert!(text(22.0).contains("did you mean cm?"));
        assert!(text(1e-4).contains("meters per unit"));
    }
}
