//! What acts on a face beside muscles and bones: each is a number that can be set and fitted.

mod load;
mod places;
mod spec;

pub(super) use load::{Ground, load};
pub use spec::{
    BoxSpec, CavitySpec, ClosureSpec, LabelsSpec, LoadSpec, MotionSpec, PlaceSpec, SphereSpec,
    StiffnessSpec, StrengthSpec,
};

use super::Scene;
use face_rig::fit::{ControlModel, CraniumModel, JawModel, Parametrization};
use face_rig::rig::{Control, Effect, Parameters};
use fem_assembly::{
    AssemblyBuilder, AssemblyError, Cavity, Gravity, ImplicitSurface, NodalLoads, Penalty, Scaled,
    Springs,
};

/// A load, a cavity, a motion, a strength or a stiffness of a scene; a control of its rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    /// Its name.
    pub name: String,
    /// Its value unless it is set.
    pub neutral: f64,
    /// What a fit may vary it between.
    pub range: Option<[f64; 2]>,
    /// What it does.
    pub kind: InfluenceKind,
}

/// What an influence does at its value c.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InfluenceKind {
    /// c times these forces on nodes, newtons.
    Forces(Vec<(usize, [f64; 3])>),
    /// c times the weight.
    Gravity {
        /// kg/m³.
        density: f64,
        /// m/s².
        acceleration: [f64; 3],
    },
    /// c times these springs.
    Springs {
        /// Nodes and where their springs end, meters.
        ends: Vec<(usize, [f64; 3])>,
        /// N/m.
        stiffness: f64,
    },
    /// c times these penalties.
    Penalties {
        /// The nodes that are pushed.
        nodes: Vec<usize>,
        /// N/m.
        stiffness: f64,
        /// What pushes them, meters.
        obstacles: Vec<ImplicitSurface<3>>,
    },
    /// c pascals in a cavity.
    Cavity {
        /// Its faces, counter-clockwise seen from outside the cavity, with those that close it.
        faces: Vec<[u32; 3]>,
        /// What a mantle closes it to, if anything is left open; meters.
        apex: Option<[f64; 3]>,
    },
    /// Coordinates (node, axis) c times so many meters from rest.
    Motion(Vec<(usize, usize, f64)>),
    /// 1 + c times as strong.
    Strength {
        /// The muscles.
        muscles: Vec<u32>,
    },
    /// 1 + c times as stiff.
    Stiffness {
        /// Place of the region in [`Scene::regions`].
        region: usize,
    },
}

impl Influence {
    /// The unit of its value, as a report writes it; empty for a factor or a relative change.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            InfluenceKind::Cavity { .. } => "Pa",
            _ => "",
        }
    }

    /// The least value that makes sense: what is changed by less than −1 pushes the wrong way.
    pub fn least(&self) -> f64 {
        match self.kind {
            InfluenceKind::Strength { .. } | InfluenceKind::Stiffness { .. } => -1.0,
            _ => f64::MIN,
        }
    }

    /// The pressure of its cavity is 1 Pa.
    pub(super) fn cavity(&self) -> Option<Result<Cavity<3>, AssemblyError>> {
        let InfluenceKind::Cavity { faces, apex } = &self.kind else {
            return None;
        };
        Some(match apex {
            Some(apex) => Cavity::about(faces.clone(), *apex, 1.0),
            None => Cavity::closed(faces.clone(), 1.0),
        })
    }

    /// What counts as much as an activation of 1.
    fn largest(&self) -> f64 {
        let [low, high] = self.range.unwrap_or([self.neutral; 2]);
        match low.abs().max(high.abs()) {
            0.0 => 1.0,
            largest => largest,
        }
    }

    /// What it does at a glance.
    pub(super) fn describe(&self, scene: &Scene) -> String {
        let what = match &self.kind {
            InfluenceKind::Forces(forces) => {
                let total = |i: usize| forces.iter().map(|(_, f)| f[i]).sum::<f64>();
                let [x, y, z] = [0, 1, 2].map(total);
                format!("{x:.3}, {y:.3}, {z:.3} N on {} nodes", forces.len())
            }
            InfluenceKind::Gravity { density, .. } => format!("weight of {density} kg/m³"),
            InfluenceKind::Springs { ends, stiffness } => {
                format!("{} springs of {stiffness} N/m", ends.len())
            }
            InfluenceKind::Penalties {
                nodes,
                stiffness,
                obstacles,
            } => {
                let (nodes, solids) = (nodes.len(), obstacles.len());
                format!("penalty of {stiffness} N/m on {nodes} nodes in {solids} solids")
            }
            InfluenceKind::Cavity { faces, .. } => {
                let cavity = self.cavity().and_then(Result::ok);
                let volume = cavity.and_then(|c| c.volume(scene.mesh.nodes()).ok());
                let volume = volume.unwrap_or(f64::NAN);
                format!("cavity of {:.2} cm³, {} faces", 1e6 * volume, faces.len())
            }
            InfluenceKind::Motion(moved) => format!("{} coordinates prescribed", moved.len()),
            InfluenceKind::Strength { muscles } => format!("strength of {} muscles", muscles.len()),
            InfluenceKind::Stiffness { region } => {
                let name = scene.regions.get(*region).map_or("", |r| r.name.as_str());
                format!("stiffness of {name}")
            }
        };
        let (neutral, unit) = (self.neutral, self.unit());
        let range = self.range.map_or_else(
            || "fixed in a fit".to_owned(),
            |[low, high]| format!("{low} to {high} {unit} in a fit"),
        );
        format!(
            "{}: {what}; {neutral} {unit} unless set, {range}",
            self.name
        )
    }
}

impl Scene {
    /// The relaxed pose at rest, every influence at its neutral value.
    pub fn rest_pose(&self) -> Parameters {
        let neutral = self.influences.iter().map(|i| i.neutral);
        Parameters::rest(self.muscles.len()).with_controls(neutral.collect())
    }

    /// All activations, a head and a jaw that move as said, and the influences that have a range.
    pub fn parametrization(&self, cranium: CraniumModel, jaw: JawModel) -> Parametrization {
        let model = |i: &super::Influence| ControlModel {
            neutral: i.neutral,
            bounds: i.range,
        };
        let controls = self.influences.iter().map(model).collect();
        Parametrization::of_all(self.muscles.len(), cranium, jaw).with_controls(controls)
    }

    /// The influences as a rig takes them.
    pub(super) fn controls(&self) -> Vec<Control> {
        let control = |i: &Influence| Control {
            unit: i.largest(),
            effect: match &i.kind {
                InfluenceKind::Motion(moved) => Effect::Motion(moved.clone()),
                _ => Effect::Energy,
            },
        };
        self.influences.iter().map(control).collect()
    }

    /// Which control of the energy each influence is, behind the muscles.
    fn places(&self) -> impl Iterator<Item = (usize, &Influence)> {
        let energies = self
            .influences
            .iter()
            .filter(|i| !matches!(i.kind, InfluenceKind::Motion(_)));
        (self.muscles.len()..).zip(energies)
    }

    /// The control that a muscle's strength is changed by, if any.
    pub(super) fn strength_of(&self, muscle: u32) -> Option<usize> {
        self.places().find_map(|(control, i)| match &i.kind {
            InfluenceKind::Strength { muscles } => muscles.contains(&muscle).then_some(control),
            _ => None,
        })
    }

    /// How strong a muscle is in a pose, 1 where nothing changes it.
    pub(super) fn strength(&self, muscle: u32, pose: &Parameters) -> f64 {
        let changes = self.influences.iter().zip(&pose.controls);
        let own = changes.filter(|(i, _)| match &i.kind {
            InfluenceKind::Strength { muscles } => muscles.contains(&muscle),
            _ => false,
        });
        1.0 + own.map(|(_, change)| change).sum::<f64>()
    }

    /// The control that a region's stiffness is changed by, if any.
    pub(super) fn stiffness_of(&self, wanted: usize) -> Option<usize> {
        self.places().find_map(|(control, i)| match &i.kind {
            InfluenceKind::Stiffness { region } => (*region == wanted).then_some(control),
            _ => None,
        })
    }

    /// (node, axis) of everything that motions prescribe.
    pub(super) fn moved_axes(&self) -> Vec<(usize, usize)> {
        let moved = self.influences.iter().flat_map(|i| match &i.kind {
            InfluenceKind::Motion(moved) => moved.as_slice(),
            _ => &[],
        });
        moved.map(|&(node, axis, _)| (node, axis)).collect()
    }

    /// Adds the loads and the cavities.
    pub(super) fn with_loads(
        &self,
        mut builder: AssemblyBuilder<3>,
    ) -> Result<AssemblyBuilder<3>, AssemblyError> {
        for (control, influence) in self.places() {
            builder = builder.controls(control + 1);
            builder = match &influence.kind {
                InfluenceKind::Forces(forces) => {
                    builder.term(Scaled::new(NodalLoads::new(forces.clone())?, control)?)?
                }
                InfluenceKind::Gravity {
                    density,
                    acceleration,
                } => {
                    let weight = Gravity::new(&self.mesh, *density, *acceleration)?;
                    builder.term(Scaled::new(weight, control)?)?
                }
                InfluenceKind::Springs { ends, stiffness } => {
                    let springs = Springs::at_nodes(ends.iter().copied(), *stiffness)?;
                    builder.term(Scaled::new(springs, control)?)?
                }
                InfluenceKind::Penalties {
                    nodes,
                    stiffness,
                    obstacles,
                } => {
                    for obstacle in obstacles {
                        let penalty = Penalty {
                            nodes: nodes.clone(),
                            stiffness: *stiffness,
                            obstacle: *obstacle,
                        };
                        builder = builder.term(Scaled::new(penalty, control)?)?;
                    }
                    builder
                }
                _ => match influence.cavity() {
                    Some(cavity) => builder.term(Scaled::new(cavity?, control)?)?,
                    None => builder,
                },
            };
        }
        Ok(builder)
    }
}
