//! What was understood of a scene, and what looks wrong.

use super::{Region, Scene, TargetKind};
use face_rig::anatomy::{Bone, Side};
use fem_assembly::mesh::Quality;
use serde::Serialize;
use std::fmt;

/// The result of [`check`]: counts, sizes, quality, and warnings. `Display` prints it for people.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckReport {
    /// Title of the scene.
    pub name: String,
    /// The flesh.
    pub mesh: MeshReport,
    /// Free, cranium and jaw nodes.
    pub nodes_per_bone: [usize; 3],
    /// Tets all of whose nodes are prescribed.
    pub tets_all_prescribed: usize,
    /// Tets that touch the cranium and the jaw: they tear or fold when the jaw moves far.
    pub tets_touching_both_bones: usize,
    /// Those of them without a free node: cranium and jaw alone move them, and no flesh can give way
    /// when they turn inside out.
    pub tets_moved_by_both_bones: Vec<u32>,
    /// The regions and how many tets each has.
    pub regions: Vec<(Region, usize)>,
    /// The muscles.
    pub muscles: Vec<MuscleReport>,
    /// Tets with at least one muscle.
    pub muscle_tets: usize,
    /// Most muscles in one tet.
    pub most_muscles_in_a_tet: usize,
    /// Landmarks.
    pub landmarks: usize,
    /// Embedded points.
    pub embedded_points: usize,
    /// Vertices of the skin of dense targets.
    pub skin_vertices: usize,
    /// What acts beside muscles and bones, a sentence each.
    pub influences: Vec<String>,
    /// Targets that are expressions.
    pub expressions: usize,
    /// Targets that are other people.
    pub identities: usize,
    /// What looks wrong, each with its cure.
    pub warnings: Vec<String>,
}

/// Size and shape of the flesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshReport {
    /// Tetrahedra.
    pub tets: usize,
    /// Nodes.
    pub nodes: usize,
    /// Face-connected pieces.
    pub components: usize,
    /// Elements whose orientation was repaired.
    pub inverted: usize,
    /// Width, height and depth, meters.
    pub size: [f64; 3],
    /// m³.
    pub volume: f64,
    /// Degrees.
    pub smallest_dihedral: f64,
    /// Degrees.
    pub largest_dihedral: f64,
    /// Smallest ratio of inscribed to circumscribed radius, times 3.
    pub smallest_radius_ratio: f64,
    /// Shortest, median and longest edge, meters.
    pub edge_lengths: [f64; 3],
    /// Tets with a dihedral angle under 10 degrees.
    pub slivers: usize,
    /// The worst ten tets, worst first.
    pub worst: Vec<u32>,
}

/// One muscle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MuscleReport {
    /// Its name.
    pub name: String,
    /// Its side.
    pub side: Side,
    /// Elements it runs through.
    pub tets: usize,
    /// Its volume (weight times the tets' volumes), m³.
    pub volume: f64,
}

/// Looks a scene over.
pub fn check(scene: &Scene) -> CheckReport {
    let mesh = mesh_report(scene);
    let of_node = scene.bones.of_node();
    let (mut all_prescribed, mut both, mut moved_by_both) = (0, 0, Vec::new());
    for (t, tet) in (0..).zip(scene.mesh.tets()) {
        let on = |bone| tet.iter().any(|&n| of_node[n as usize] == bone);
        let (free, touches_both) = (on(Bone::Free), on(Bone::Cranium) && on(Bone::Jaw));
        all_prescribed += usize::from(!free);
        both += usize::from(touches_both);
        if touches_both && !free {
            moved_by_both.push(t);
        }
    }
    let (muscles, muscle_tets, most, crowded) = muscle_report(scene);
    let tets_of = |r: usize| {
        scene
            .region_of_tet
            .iter()
            .filter(|&&t| t as usize == r)
            .count()
    };
    let identity = |kind| scene.targets.iter().filter(|t| t.kind == kind).count();
    let mut report = CheckReport {
        name: scene.name.clone(),
        mesh,
        nodes_per_bone: [
            scene.bones.free.len(),
            scene.bones.cranium.len(),
            scene.bones.jaw.len(),
        ],
        tets_all_prescribed: all_prescribed,
        tets_touching_both_bones: both,
        tets_moved_by_both_bones: moved_by_both,
        regions: scene
            .regions
            .iter()
            .cloned()
            .enumerate()
            .map(|(k, r)| (r, tets_of(k)))
            .collect(),
        muscles,
        muscle_tets,
        most_muscles_in_a_tet: most,
        landmarks: scene.landmarks.len(),
        embedded_points: scene.embedding.len(),
        skin_vertices: scene.skin.as_ref().map_or(0, |s| s.points.len()),
        influences: scene.influences.iter().map(|i| i.describe(scene)).collect(),
        expressions: identity(TargetKind::Expression),
        identities: identity(TargetKind::Identity),
        warnings: Vec::new(),
    };
    report.warnings = warnings(scene, &report, crowded);
    report
}

fn mesh_report(scene: &Scene) -> MeshReport {
    let quality = Quality::measure(&scene.mesh);
    let (low, high) = scene.mesh.bounding_box();
    let edges = quality.edge_length;
    MeshReport {
        tets: scene.mesh.num_elements(),
        nodes: scene.mesh.num_nodes(),
        components: scene.mesh.components().1,
        inverted: scene.repairs.inverted.len(),
        size: std::array::from_fn(|i| high[i] - low[i]),
        volume: quality.volume,
        smallest_dihedral: quality.smallest_dihedral.min,
        largest_dihedral: quality.largest_dihedral.max,
        smallest_radius_ratio: quality.radius_ratio.min,
        edge_lengths: [edges.min, edges.median, edges.max],
        slivers: quality.slivers,
        worst: quality.worst,
    }
}

/// Muscles, tets with muscles, most muscles in a tet, tets whose weights sum to over 1.05.
fn muscle_report(scene: &Scene) -> (Vec<MuscleReport>, usize, usize, usize) {
    let mut muscles: Vec<MuscleReport> = scene
        .muscles
        .iter()
        .map(|m| MuscleReport {
            name: m.name.clone(),
            side: m.side(),
            tets: 0,
            volume: 0.0,
        })
        .collect();
    let (mut tets, mut most, mut crowded) = (0, 0, 0);
    for in_tet in scene.fiber_field.entries().chunk_by(|a, b| a.tet == b.tet) {
        let volume = scene.mesh.volume(in_tet[0].tet as usize);
        for entry in in_tet {
            let muscle = &mut muscles[entry.muscle as usize];
            muscle.tets += 1;
            muscle.volume += entry.weight * volume;
        }
        tets += 1;
        most = most.max(in_tet.len());
        crowded += usize::from(in_tet.iter().map(|e| e.weight).sum::<f64>() > 1.05);
    }
    (muscles, tets, most, crowded)
}

/// Units whose factor to meters a scene's `scale` can give.
const UNITS: [(&str, f64); 4] = [("mm", 1e-3), ("cm", 1e-2), ("inches", 0.0254), ("µm", 1e-6)];

/// "this face is 180 m tall …" for a face that is not 8 cm to 80 cm tall.
fn units_warning(height: f64) -> Option<String> {
    let plausible = |h: f64| (0.08..=0.8).contains(&h);
    if plausible(height) {
        return None;
    }
    let guess = UNITS.iter().find(|(_, factor)| plausible(height * factor));
    let cure = guess.map_or_else(
        || "set \"scale\" to the meters per unit of the files".into(),
        |(unit, factor)| format!("did you mean {unit}? add \"scale\": {factor}"),
    );
    Some(format!(
        "this face is {height:.3} m tall: meters expected, {cure}"
    ))
}

/// What looks wrong, in the order of the report.
#[derive(Default)]
struct Warnings(Vec<String>);

impl Warnings {
    fn add(&mut self, condition: bool, text: impl FnOnce() -> String) {
        if condition {
            self.0.push(text());
        }
    }

    fn mesh(&mut self, mesh: &MeshReport) {
        self.0.extend(units_warning(mesh.size[1]));
        let pieces = mesh.components;
        self.add(pieces > 1, || {
            format!(
                "the flesh has {pieces} pieces that share no face; pieces without bone nodes float away"
            )
        });
        let inverted = mesh.inverted;
        self.add(inverted > 0, || {
            format!("{inverted} tets had negative volume and were repaired; check the mesh's axes")
        });
        let (angle, worst) = (mesh.smallest_dihedral, &mesh.worst);
        self.add(angle < 5.0, || {
            format!("dihedral angles down to {angle:.1}°; remesh around {worst:?}")
        });
    }

    fn bones(&mut self, scene: &Scene, report: &CheckReport) {
        self.add(scene.bones.jaw.is_empty(), || {
            "no node hangs on the jaw: its motion will do nothing; label its nodes".into()
        });
        let both = report.tets_touching_both_bones;
        self.add(both > 0, || {
            format!(
                "{both} tets touch the cranium and the jaw; they limit how far the jaw opens, refine there"
            )
        });
        let between = &report.tets_moved_by_both_bones;
        let (count, named) = (between.len(), &between[..between.len().min(8)]);
        let more = if count > named.len() { ", …" } else { "" };
        let list: Vec<String> = named.iter().map(u32::to_string).collect();
        self.add(count > 0, || {
            format!(
                "{count} tets hang on cranium and jaw with all their nodes ({}{more}): they are moved by \
                 the bones alone and turn inside out when the jaw moves far; refine or remove them",
                list.join(", ")
            )
        });
    }

    fn muscles(&mut self, scene: &Scene, report: &CheckReport, crowded: usize) {
        for MuscleReport { name, tets, .. } in &report.muscles {
            self.add(*tets == 0, || {
                format!(
                    "muscle {name} runs through no tet and does nothing; refine or check its path"
                )
            });
        }
        for muscle in &scene.muscles {
            let name = &muscle.name;
            let partner = match muscle.side() {
                Side::Left => name.strip_suffix('L').map(|s| format!("{s}R")),
                Side::Right => name.strip_suffix('R').map(|s| format!("{s}L")),
                Side::Middle => None,
            };
            let missing = partner.filter(|p| !scene.muscles.iter().any(|m| m.name == *p));
            let warning = |partner| format!("muscle {name} has no partner {partner}");
            self.0.extend(missing.map(warning));
        }
        self.add(crowded > 0, || {
            format!(
                "in {crowded} tets the muscles' weights sum to more than 1: more flesh than there is room for"
            )
        });
    }

    fn targets(&mut self, scene: &Scene, landmarks: usize) {
        self.add(landmarks != 0 && landmarks != 68, || {
            format!("{landmarks} landmarks instead of the usual 68")
        });
        for target in &scene.targets {
            let (goals, name) = (target.landmarks.len(), &target.name);
            self.add(goals < landmarks, || {
                format!(
                    "target {name} has {goals} of {landmarks} landmarks; the others are ignored"
                )
            });
        }
    }
}

fn warnings(scene: &Scene, report: &CheckReport, crowded: usize) -> Vec<String> {
    let mut warnings = Warnings::default();
    warnings.mesh(&report.mesh);
    warnings.bones(scene, report);
    warnings.muscles(scene, report, crowded);
    warnings.targets(scene, report.landmarks);
    warnings.0
}

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.name)?;
        self.mesh.lines(f)?;
        self.flesh(f)?;
        for influence in &self.influences {
            writeln!(f, "  control    {influence}")?;
        }
        writeln!(
            f,
            "  points     {} landmarks, {} embedded, {} on the skin of dense targets",
            self.landmarks, self.embedded_points, self.skin_vertices
        )?;
        writeln!(
            f,
            "  targets    {} expressions, {} identities",
            self.expressions, self.identities
        )?;
        for warning in &self.warnings {
            writeln!(f, "  warning: {warning}")?;
        }
        Ok(())
    }
}

impl CheckReport {
    fn flesh(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [free, cranium, jaw] = self.nodes_per_bone;
        writeln!(f, "  nodes      {free} free, {cranium} cranium, {jaw} jaw")?;
        writeln!(
            f,
            "  tets       {} with all nodes prescribed, {} touching both bones",
            self.tets_all_prescribed, self.tets_touching_both_bones
        )?;
        for (region, tets) in &self.regions {
            writeln!(
                f,
                "  region     {}: {tets} tets, {}",
                region.name, region.material
            )?;
        }
        writeln!(
            f,
            "  muscles    {}, in {} tets, at most {} in one",
            self.muscles.len(),
            self.muscle_tets,
            self.most_muscles_in_a_tet
        )?;
        for muscle in &self.muscles {
            let side = match muscle.side {
                Side::Left => "left",
                Side::Right => "right",
                Side::Middle => "middle",
            };
            let (name, tets, cm3) = (&muscle.name, muscle.tets, muscle.volume * 1e6);
            writeln!(f, "    {name:<44} {side:<6} {tets:>7} tets {cm3:>8.3} cm³")?;
        }
        Ok(())
    }
}

impl MeshReport {
    fn lines(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [w, h, d] = self.size.map(|v| v * 1e3);
        let [shortest, median, longest] = self.edge_lengths.map(|v| v * 1e3);
        writeln!(
            f,
            "  mesh       {} tets, {} nodes, {} piece(s)",
            self.tets, self.nodes, self.components
        )?;
        writeln!(
            f,
            "  size       {w:.1} x {h:.1} x {d:.1} mm, {:.1} cm³",
            self.volume * 1e6
        )?;
        writeln!(
            f,
            "  quality    dihedral angles {:.1}° to {:.1}°, {} tets under 10°, radius ratio from {:.3}",
            self.smallest_dihedral, self.largest_dihedral, self.slivers, self.smallest_radius_ratio
        )?;
        writeln!(
            f,
            "             edges {shortest:.2} to {longest:.2} mm, median {median:.2} mm"
        )?;
        writeln!(f, "             worst tets {:?}", self.worst)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::units_warning;

    #[test]
    fn units_are_guessed_from_the_height() {
        assert_eq!(units_warning(0.22), None);
        let text = units_warning(180.0).expect("too tall");
        let cure =
            "this face is 180.000 m tall: meters expected, did you mean mm? add \"scale\": 0.001";
        assert_eq!(text, cure);
        assert!(units_warning(22.0).is_some_and(|t| t.contains("did you mean cm?")));
        assert!(units_warning(1e-4).is_some_and(|t| t.contains("meters per unit")));
    }
}
