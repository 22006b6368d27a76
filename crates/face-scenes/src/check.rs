//! What was understood of a scene, and what looks wrong.

use super::warning::{self, Warning};
use super::{FitSpec, Inversion, LinearMethod, PointsSpec, Region, Scene, TargetKind};
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
    /// Those of them that were given the flesh of their neighbors, by their numbers.
    pub repaired_strays: Vec<u32>,
    /// What acts beside muscles and bones, a sentence each.
    pub influences: Vec<String>,
    /// How elements are kept from turning inside out, what solves for steps, and what fits see: a sentence
    /// each where it is not the default.
    pub settings: Vec<String>,
    /// Targets that are expressions.
    pub expressions: usize,
    /// Targets that are other people.
    pub identities: usize,
    /// What looks wrong, each with its cure.
    pub warnings: Vec<Warning>,
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
        repaired_strays: scene.repaired_strays.clone(),
        influences: scene.influences.iter().map(|i| i.describe(scene)).collect(),
        settings: settings(scene),
        expressions: identity(TargetKind::Expression),
        identities: identity(TargetKind::Identity),
        warnings: Vec::new(),
    };
    report.warnings = warning::all(scene, &report, crowded);
    report
}

fn settings(scene: &Scene) -> Vec<String> {
    let mut all = Vec::new();
    match scene.inversion {
        Inversion::Barred => {}
        Inversion::Allowed => all.push("elements may turn inside out".to_owned()),
        Inversion::Thresholded(threshold) => all.push(format!(
            "stretches below {threshold} are felt as {threshold}: elements may turn inside out"
        )),
    }
    if scene.linear_solver == LinearMethod::Qr {
        all.push("Newton's steps by dense QR".to_owned());
    }
    let fit = scene.fit;
    match fit.points {
        PointsSpec::Landmarks => {}
        PointsSpec::Dense => all.push("fits see the skin".to_owned()),
        PointsSpec::Both => all.push(format!(
            "fits see landmarks and skin, a landmark {} times as much as a point of the skin",
            fit.landmark_weight
        )),
    }
    if fit.jaw_weight_mm2 != FitSpec::default().jaw_weight_mm2 {
        let weight = fit.jaw_weight_mm2;
        all.push(format!("fits weigh the jaw's slides by {weight} mm²"));
    }
    all
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

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.name)?;
        self.mesh.lines(f)?;
        self.flesh(f)?;
        for influence in &self.influences {
            writeln!(f, "  control    {influence}")?;
        }
        for setting in &self.settings {
            writeln!(f, "  setting    {setting}")?;
        }
        writeln!(
            f,
            "  points     {} landmarks, {} embedded, {} on the skin of dense targets",
            self.landmarks, self.embedded_points, self.skin_vertices
        )?;
        if !self.repaired_strays.is_empty() {
            let strays = &self.repaired_strays;
            writeln!(
                f,
                "             given the flesh of their neighbors: {strays:?}"
            )?;
        }
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
