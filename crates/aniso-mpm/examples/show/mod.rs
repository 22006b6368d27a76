//! What the example programs share: a progress bar, PNG frames, VTP files and an SVG plot.
#![allow(non_snake_case)]
use aniso_mpm::{Energies, Float, MpmError, Particles, Scheme, Simulation};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fem_materials::DamageField;
/// The part of space that a picture shows, and its size.
pub struct View {
    /// Lower left corner, m.
    pub min: [f64; 2],
    /// Upper right corner, m.
    pub max: [f64; 2],
    /// Width of the picture in pixels.
    pub width: usize,
    /// Radius of a particle, m.
    pub radius: f64,
    /// In 3D the picture looks along the second axis, from above by this angle, degrees.
    pub tilt: f64,
}

/// Runs a simulation frame by frame into `out/<name>`: pictures, particles, energies. `watch` sees
/// it after every frame.
pub fn run<T: Float, S: Scheme, M: DamageField<D>, const D: usize>(
    name: &str,
    simulation: &mut Simulation<T, S, M, D>,
    frames: usize,
    frame_time: f64,
    view: &View,
    mut watch: impl FnMut(&Simulation<T, S, M, D>),
) -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from("out").join(name);
    fs::create_dir_all(&folder)?;
    let start = Instant::now();
    let bar = ProgressBar::new(frames as u64).with_style(ProgressStyle::with_template(
        "{msg} [{bar:40}] {pos}/{len} frames, {eta} left",
    )?);
    bar.set_message(name.to_owned());
    let mut history = vec![(0.0, simulation.energies())];
    write_frame(&folder, 0, simulation, view)?;
    let mut steps = 0;
    for frame in 1..=frames {
        let info = simulation
            .advance(frame_time)
            .inspect_err(|error: &MpmError| {
                bar.abandon_with_message(error.to_string());
            })?;
        steps += info.substeps;
        history.push((simulation.time(), simulation.energies()));
        write_frame(&folder, frame, simulation, view)?;
        watch(simulation);
        bar.inc(1);
    }
    bar.finish();
    write_whole(&folder.join("energy.svg"), plot(name, &history).as_bytes())?;
    let particles = simulation.particles();
    let broken = particles.damage.iter().filter(|d| d.to_f64() > 0.5).count();
    println!(
        "{name}: {} particles, {steps} steps in {:.1} s, {broken} particles with d > 0.5; see {}",
        particles.len(),
        start.elapsed().as_secs_f64(),
        folder.display()
    );
    Ok(())
}

/// Writes a file beside its place and moves it there: a reader never sees half of it.
fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = path.with_extension("tmp");
    fs::write(&beside, bytes)?;
    fs::rename(&beside, path)
}

fn write_frame<T: Float, S: Scheme, M: DamageField<D>, const D: usize>(
    folder: &Path,
    frame: usize,
    simulation: &Simulation<T, S, M, D>,
    view: &View,
) -> io::Result<()> {
    let particles = simulation.particles();
    write_whole(
        &folder.join(format!("frame_{frame:04}.png")),
        &picture(particles, view)?,
    )?;
    write_whole(
        &folder.join(format!("frame_{frame:04}.vtp")),
        vtp(particles).as_bytes(),
    )
}

/// Discs sorted from back to front; bodies have their own color, damage turns them red.
fn picture<T: Float, const D: usize>(
    particles: &Particles<T, D>,
    view: &View,
) -> io::Result<Vec<u8>> {
    const BODIES: [[f64; 3]; 4] = [
        [70.0, 130.0, 180.0],
        [120.0, 160.0, 90.0],
        [120.0, 150.0, 175.0],
        [150.0, 170.0, 135.0],
    ];
    let scale = view.width as f64 / (view.max[0] - view.min[0]);
    let height = ((view.max[1] - view.min[1]) * scale).round() as usize;
    let mut image = vec![246u8; view.width * height * 3];
    let mut order: Vec<usize> = (0..particles.len()).collect();
    let (sin, cos) = view.tilt.to_radians().sin_cos();
    // Height in the picture and distance from the eye.
    let seen = |p: usize| {
        let x = particles.x[p].map(Float::to_f64);
        if D == 3 {
            let (y, z) = (x[1], x[D - 1]);
            (z * cos + y * sin, y * cos - z * sin)
        } else {
            (x[1], 0.0)
        }
    };
    let depth = |p: usize| seen(p).1;
    // Far ones first.
    order.sort_by(|&a, &b| depth(b).total_cmp(&depth(a)));
    let (near, far) = order.iter().fold((f64::MAX, f64::MIN), |(n, f), &p| {
        (n.min(depth(p)), f.max(depth(p)))
    });
    let radius = (view.radius * scale).max(0.7);
    for p in order {
        let x = (particles.x[p][0].to_f64() - view.min[0]) * scale;
        let y = (view.max[1] - seen(p).0) * scale;
        let d = particles.damage[p].to_f64().clamp(0.0, 1.0);
        let shade = if far > near {
            1.0 - 0.45 * (depth(p) - near) / (far - near)
        } else {
            1.0
        };
        let whole = BODIES[particles.body[p] as usize % BODIES.len()];
        let broken = [215.0, 35.0, 30.0];
        let color: [f64; 3] =
            std::array::from_fn(|c| shade * ((1.0 - d) * whole[c] + d * broken[c]));
        let rows = (y - radius).floor().max(0.0) as usize
            ..((y + radius).ceil().max(0.0) as usize + 1).min(height);
        for row in rows {
            let columns = (x - radius).floor().max(0.0) as usize
                ..((x + radius).ceil().max(0.0) as usize + 1).min(view.width);
            for column in columns {
                let (dx, dy) = (column as f64 + 0.5 - x, row as f64 + 0.5 - y);
                let cover = (radius + 0.5 - dx.hypot(dy)).clamp(0.0, 1.0);
                let at = (row * view.width + column) * 3;
                for c in 0..3 {
                    let old = f64::from(image[at + c]);
                    image[at + c] = (old + cover * (color[c] - old)).round() as u8;
                }
            }
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, view.width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(&image).map_err(io::Error::other)?;
    drop(writer);
    Ok(bytes)
}

/// Particles as VTK polygonal data in plain XML.
fn vtp<T: Float, const D: usize>(particles: &Particles<T, D>) -> String {
    let n = particles.len();
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n<Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
    );
    let array = |text: &mut String,
                 kind: &str,
                 name: &str,
                 width: usize,
                 rows: &mut dyn FnMut(usize) -> String| {
        let _ = writeln!(
            text,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"ascii\">"
        );
        for p in 0..n {
            text.push_str(&rows(p));
            text.push('\n');
        }
        text.push_str("</DataArray>\n");
    };
    let vector = |v: &[T; D]| {
        let mut c = [0.0; 3];
        for a in 0..D {
            c[a] = v[a].to_f64();
        }
        format!("{:.6e} {:.6e} {:.6e}", c[0], c[1], c[2])
    };
    text.push_str("<Points>\n");
    array(&mut text, "Float32", "position", 3, &mut |p| {
        vector(&particles.x[p])
    });
    text.push_str("</Points>\n<PointData Scalars=\"damage\">\n");
    array(&mut text, "Float32", "damage", 1, &mut |p| {
        format!("{:.4}", particles.damage[p].to_f64())
    });
    array(&mut text, "Int32", "body", 1, &mut |p| {
        particles.body[p].to_string()
    });
    array(&mut text, "Int32", "id", 1, &mut |p| {
        particles.id[p].to_string()
    });
    array(&mut text, "Float32", "velocity", 3, &mut |p| {
        vector(&particles.v[p])
    });
    text.push_str("</PointData>\n<Verts>\n");
    array(&mut text, "Int32", "connectivity", 1, &mut |p| {
        p.to_string()
    });
    array(&mut text, "Int32", "offsets", 1, &mut |p| {
        (p + 1).to_string()
    });
    text.push_str("</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n");
    text
}

/// Energies and broken volume over time, each curve to its own scale.
fn plot(name: &str, history: &[(f64, Energies)]) -> String {
    let (w, h, left, low) = (760.0, 420.0, 60.0, 40.0);
    let end = history.last().map_or(1.0, |p| p.0).max(1e-300);
    let energy_max = history
        .iter()
        .map(|(_, e)| e.kinetic.max(e.elastic))
        .fold(1e-300, f64::max);
    let broken_max = history
        .iter()
        .map(|(_, e)| e.damaged_volume)
        .fold(1e-300, f64::max);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>\n<text x=\"{left}\" y=\"20\">{name}: energy (largest {energy_max:.3e} J) and broken volume (largest {broken_max:.3e})</text>\n"
    );
    let _ = writeln!(
        svg,
        "<path d=\"M{left} 30V{y}H{x}\" fill=\"none\" stroke=\"black\"/><text x=\"{x}\" y=\"{t}\" text-anchor=\"end\">time, 0 to {end:.3} s</text>",
        y = h - low,
        x = w - 20.0,
        t = h - 12.0
    );
    type Curve = (&'static str, &'static str, fn(&Energies) -> f64, bool);
    let curves: [Curve; 3] = [
        ("kinetic", "#2a6fb0", |e| e.kinetic, false),
        ("elastic", "#2f8f4e", |e| e.elastic, false),
        ("broken volume", "#c8322b", |e| e.damaged_volume, true),
    ];
    for (k, (label, color, value, of_volume)) in curves.into_iter().enumerate() {
        let top = if of_volume { broken_max } else { energy_max };
        let points: String = history
            .iter()
            .map(|(t, e)| {
                format!(
                    "{:.1},{:.1} ",
                    left + (w - 20.0 - left) * t / end,
                    h - low - (h - low - 40.0) * (value(e) / top).clamp(0.0, 1.0)
                )
            })
            .collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.6\"/><text x=\"{x}\" y=\"{y}\" fill=\"{color}\">{label}</text>",
            x = left + 12.0,
            y = 50.0 + 17.0 * k as f64
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// Adds the particles of a box to a body: `per_cell` on each axis of a cell of size `h`, where
/// `inside` says so, with the fiber frame `frame`.
pub fn fill_box<T: Float, const D: usize>(
    particles: &mut Particles<T, D>,
    min: [f64; D],
    max: [f64; D],
    spacing: f64,
    density: f64,
    body: u16,
    frame: fem_kinematics::Mat<f64, D>,
    inside: impl Fn([f64; D]) -> bool,
) -> Result<(), MpmError> {
    let counts: [usize; D] =
        std::array::from_fn(|a| ((max[a] - min[a]) / spacing).round() as usize);
    let volume = spacing.powi(D as i32);
    for i in 0..counts.iter().product() {
        let mut rest = i;
        let x = std::array::from_fn(|a| {
            let k = rest % counts[a];
            rest /= counts[a];
            min[a] + (k as f64 + 0.5) * spacing
        });
        if inside(x) {
            particles.push(&aniso_mpm::Particle {
                x,
                v: [0.0; D],
                F: frame,
                mass: density * volume,
                volume,
                damage: 0.0,
                body,
            })?;
        }
    }
    Ok(())
}
