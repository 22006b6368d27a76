//! Every muscle of the built-in face at 1, and its jaw open: a table of what moves and a sheet of
//! pictures. `cargo run --release -p face-cli --example builtin_motions -- [TETS] [DIR] [NAMES]`.

#[path = "../../face-scenes/tests/all/motion.rs"]
#[allow(dead_code)] // What the tests need of it, too.
mod motion;
#[path = "../src/cli/portrait.rs"]
mod portrait;
#[path = "../../face-rig/tests/all/promise.rs"]
mod promise;

use face_pictures::{Camera, Panel, Portrait, Sheet};
use face_rig::rig::{AffineMap, Parameters, RigParams};
use face_scenes::Scene;
use motion::{Probe, parameters};

const JAW: [f64; 4] = [0.0, 10.0, 20.0, 35.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let tets = arguments.next().map_or(Ok(20_000), |t| t.parse())?;
    let folder = std::path::PathBuf::from(arguments.next().unwrap_or_else(|| ".".into()));
    let wanted: Vec<String> = arguments.collect();
    let probe = Probe::new(tets);
    let face = probe.face();
    let scene = Scene::builtin(tets)?;
    let params = RigParams::default();
    let mut rig = promise::Rig::of(scene.rig(params)?, params);
    let rest = rig.equilibrium().clone();
    let names = face.muscles.iter().filter_map(|m| m.strip_suffix("_L"));
    let mut poses: Vec<(String, Parameters)> = names
        .map(|m| (m.to_owned(), parameters(&scene, &[m], &["L", "R"], 1.0)))
        .collect();
    let oris = ["orbicularis_oris_upper", "orbicularis_oris_lower"];
    poses.push((
        "orbicularis_oris".into(),
        parameters(&scene, &oris, &["L", "R"], 1.0),
    ));
    for degrees in JAW {
        let mut open = Parameters::rest(scene.muscles.len());
        let radians: f64 = degrees;
        open.jaw = scene.joint.motion([radians.to_radians(), 0.0, 0.0, 0.0]).0;
        poses.push((format!("jaw {degrees}°"), open));
    }
    poses.retain(|(name, _)| wanted.is_empty() || wanted.iter().any(|w| name.contains(w.as_str())));
    let mut drawn: Vec<(String, Portrait)> = Vec::new();
    println!(
        "{:24} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>11} {:>11}",
        "out up forward (mm)",
        "nose tip",
        "inner brow",
        "outer brow",
        "inner canthus",
        "outer canthus",
        "upper lip",
        "lower lip",
        "mouth corner",
        "cheek",
        "cheek inside",
        "eye gap",
        "lip gap"
    );
    for (name, parameters) in &poses {
        rig.start_from(rest.clone())?;
        let start = std::time::Instant::now();
        let steps = rig.work().newton_steps;
        let positions = match motion::pose(&mut rig, parameters) {
            Ok(positions) => positions,
            Err(error) => {
                println!("{name:24} {error}");
                continue;
            }
        };
        let m = probe.motion(&rig, &positions);
        let v = |v: [f64; 3]| format!("{:.1} {:.1} {:.1}", v[0], v[1], v[2]);
        let g = |g: [f64; 2]| format!("{:.1} {:.1}", g[0], g[1]);
        println!(
            "{:24} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>14} {:>11} {:>11}  {} steps {:.2} s {} inverted",
            name.chars().take(24).collect::<String>(),
            v(m.nose_tip),
            v(m.inner_brow),
            v(m.outer_brow),
            v(m.inner_canthus),
            v(m.outer_canthus),
            v(m.upper_lip),
            v(m.lower_lip),
            v(m.mouth_corner),
            v(m.cheek),
            v(m.cheek_inside),
            g(m.eye_gap),
            g(m.lip_gap),
            rig.work().newton_steps - steps,
            start.elapsed().as_secs_f64(),
            m.inverted
        );
        let jaw: AffineMap = parameters.jaw;
        drawn.push((
            name.clone(),
            portrait::portrait(face, &positions, |p| jaw.apply(p)),
        ));
    }
    let camera = Camera::framing(&face.nodes, 0.0, 0.0)?;
    let mut sheet = Sheet::new("every muscle of the built-in face at 1, and its jaw");
    for row in drawn.chunks(3) {
        let panels: Vec<Panel> = row
            .iter()
            .flat_map(|(name, portrait)| {
                [
                    portrait.panel(name.clone(), camera),
                    portrait.panel("", camera.turned(55.0, 0.0)),
                ]
            })
            .collect();
        sheet = sheet.row(panels);
    }
    sheet.draw(220, 257)?.save(&folder.join("motions.png"))?;
    Ok(())
}
