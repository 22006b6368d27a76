//! Draws the built-in face: `cargo run --release -p face-cli --example draw_builtin -- [TETS] [DIR]`.

#[path = "../src/cli/portrait.rs"]
mod portrait;

use face_pictures::{Camera, ColorMap, Layer, Occlusion, Paint, Panel, ScalarBar, Segment, Sheet};
use face_scenes::builtin::BuiltinFace;
use fem_assembly::mesh::{Quality, SimplexMesh};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let tets = arguments.next().map_or(Ok(20_000), |t| t.parse())?;
    let folder = std::path::PathBuf::from(arguments.next().unwrap_or_else(|| ".".into()));
    let start = std::time::Instant::now();
    let face = BuiltinFace::with_tets(tets)?;
    println!(
        "{} tets, {} nodes in {:?}",
        face.tets.len(),
        face.nodes.len(),
        start.elapsed()
    );
    let mesh = SimplexMesh::new(face.nodes.clone(), face.tets.as_flattened().to_vec())?;
    println!("{}", Quality::measure(&mesh));
    let all = face.triangles(|_| true);
    let camera = Camera::framing(&face.nodes, 0.0, 0.0)?;
    let portrait = portrait::portrait(&face, &face.nodes, |p| p);
    let panel =
        |title: &str, yaw: f64, pitch: f64| portrait.panel(title, camera.turned(yaw, pitch));
    let height: Vec<f64> = face.nodes.iter().map(|p| 1e3 * p[2]).collect();
    let bar = ScalarBar {
        label: "z (mm)".into(),
        range: [0.0, 120.0],
        map: ColorMap::Violet,
    };
    let marks = face.landmark_positions(&face.nodes);
    let wire = Panel::new("mesh", camera.turned(20.0, 0.0))
        .layer(Layer::new(&face.nodes, &all, Paint::Uniform([0.85, 0.72, 0.62])).with_edges());
    let start = std::time::Instant::now();
    Sheet::new(format!("built-in face, {} tets", face.tets.len()))
        .row(vec![
            panel("front", 0.0, 0.0),
            panel("three quarters", 35.0, 5.0),
        ])
        .row(vec![panel("profile", 88.0, 0.0), wire])
        .row(vec![
            panel("landmarks", 0.0, 0.0).dots(&marks, [0.1, 0.35, 0.75], 3.0),
            portrait.scalar_panel(
                "height above the ears",
                camera.turned(20.0, 0.0),
                &height,
                bar,
            ),
        ])
        .draw(620, 760)?
        .save(&folder.join("face.png"))?;
    draw_muscles(&face, camera)?.save(&folder.join("muscles.png"))?;
    println!("drawn in {:?}", start.elapsed());
    Ok(())
}

/// One panel per muscle of the left side: its weight on the tets' centers as short fibers.
fn draw_muscles(
    face: &BuiltinFace,
    camera: Camera,
) -> Result<face_pictures::Canvas, Box<dyn std::error::Error>> {
    let skin = face.skin();
    let mut sheet = Sheet::new("muscles of the left side");
    let left: Vec<usize> = (0..face.muscles.len() / 2).collect();
    for row in left.chunks(6) {
        let panels = row.iter().map(|&m| {
            let entries = face.fibers.iter().filter(|e| e.muscle as usize == m);
            let segments = entries.map(|e| {
                let mut center = [0.0; 3];
                for n in face.tets[e.tet as usize] {
                    for k in 0..3 {
                        center[k] += 0.25 * face.nodes[n as usize][k];
                    }
                }
                let end = |s: f64| [0, 1, 2].map(|k| center[k] + s * 0.003 * e.direction[k]);
                Segment {
                    ends: [end(-1.0), end(1.0)],
                    color: ColorMap::Heat.color(0.35 + 0.5 * e.weight),
                    width: 1.2,
                }
            });
            Panel::new(face.muscles[m].clone(), camera.turned(30.0, 0.0))
                .layer(Layer::new(
                    &face.nodes,
                    &skin,
                    Paint::Uniform([0.9, 0.88, 0.85]),
                ))
                .occlusion(Occlusion::Ignored)
                .segments(segments)
        });
        sheet = sheet.row(panels.collect());
    }
    Ok(sheet.draw(300, 360)?)
}
