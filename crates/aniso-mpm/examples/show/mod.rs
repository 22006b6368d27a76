//! What the example programs share: a progress bar, PNG frames, VTK files and an SVG plot.
#![allow(non_snake_case)]
use aniso_mpm::{Energies, Float, MpmError, Particles, Scheme, Simulation};
use face_pictures::{Camera, Canvas, LinePlot, Marker, Panel, PictureError, Series, Sheet, Symbol};
use fem_assembly::mesh::{DataArray, MeshFile};
use indicatif::{ProgressBar, ProgressStyle};
use std::fs;
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
    plot(name, &history).save(&folder.join("energy.svg"))?;
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

fn write_frame<T: Float, S: Scheme, M: DamageField<D>, const D: usize>(
    folder: &Path,
    frame: usize,
    simulation: &Simulation<T, S, M, D>,
    view: &View,
) -> Result<(), Box<dyn std::error::Error>> {
    let particles = simulation.particles();
    picture(particles, view)?.save(&folder.join(format!("frame_{frame:04}.png")))?;
    vertices(particles).write(folder.join(format!("frame_{frame:04}.vtu")))?;
    Ok(())
}

/// Places in space; the plane is the one of the first two axes.
fn in_space<T: Float, const D: usize>(v: &[T; D]) -> [f64; 3] {
    std::array::from_fn(|a| if a < D { v[a].to_f64() } else { 0.0 })
}

/// Dots from back to front; bodies have their own color, damage turns them red.
fn picture<T: Float, const D: usize>(
    particles: &Particles<T, D>,
    view: &View,
) -> Result<Canvas, PictureError> {
    const BODIES: [[f64; 3]; 4] = [
        [0.27, 0.51, 0.71],
        [0.47, 0.63, 0.35],
        [0.47, 0.59, 0.69],
        [0.59, 0.67, 0.53],
    ];
    const BROKEN: [f64; 3] = [0.84, 0.14, 0.12];
    let (sin, cos) = view.tilt.to_radians().sin_cos();
    // Up in the picture is z in 3D: right, up, towards the eye.
    let seen = |p: usize| match in_space(&particles.x[p]) {
        x if D == 2 => x,
        [x, y, z] => [x, z * cos + y * sin, z * sin - y * cos],
    };
    let [width, height] = [0, 1].map(|a| view.max[a] - view.min[a]);
    let camera = Camera {
        target: [
            0.5 * (view.min[0] + view.max[0]),
            0.5 * (view.min[1] + view.max[1]),
            0.0,
        ],
        half_height: 0.5 * height,
        half_width: 0.5 * width,
        yaw: 0.0,
        pitch: 0.0,
        field_of_view: 0.0,
    };
    let per_meter = view.width as f64 / width;
    let mut dots: Vec<Marker> = (0..particles.len())
        .map(|p| {
            let d = particles.damage[p].to_f64().clamp(0.0, 1.0);
            let whole = BODIES[particles.body[p] as usize % BODIES.len()];
            Marker {
                position: seen(p),
                color: std::array::from_fn(|c| ((1.0 - d) * whole[c] + d * BROKEN[c]) as f32),
                radius: (view.radius * per_meter).max(0.7),
                symbol: Symbol::Dot,
            }
        })
        .collect();
    dots.sort_by(|a, b| a.position[2].total_cmp(&b.position[2]));
    Sheet::new("")
        .row(vec![Panel::new("", camera).markers(dots)])
        .draw(view.width, (height * per_meter).round() as usize)
}

/// Particles as VTK vertices.
fn vertices<T: Float, const D: usize>(particles: &Particles<T, D>) -> MeshFile {
    const VERTEX: u8 = 1;
    let count = particles.len() as u32;
    let damage: Vec<f64> = particles.damage.iter().map(|d| d.to_f64()).collect();
    let velocity: Vec<[f64; 3]> = particles.v.iter().map(in_space).collect();
    MeshFile {
        path: PathBuf::new(),
        points: particles.x.iter().map(in_space).collect(),
        connectivity: (0..count).collect(),
        offsets: (1..=count).collect(),
        cell_types: vec![VERTEX; particles.len()],
        point_data: vec![
            DataArray::scalars("damage", &damage),
            DataArray::integers("body", particles.body.iter().map(|&b| i64::from(b))),
            DataArray::integers("id", particles.id.iter().map(|&id| i64::from(id))),
            DataArray::vectors("velocity", &velocity),
        ],
        cell_data: Vec::new(),
    }
}

/// Energies and broken volume over time, each curve as a share of its own largest value.
fn plot(name: &str, history: &[(f64, Energies)]) -> LinePlot {
    type Curve = (&'static str, fn(&Energies) -> f64);
    let curves: [Curve; 3] = [
        ("kinetic, J", |e| e.kinetic),
        ("elastic, J", |e| e.elastic),
        ("broken volume, m³", |e| e.damaged_volume),
    ];
    let mut plot = LinePlot::new(name, "time (s)", "share of the largest");
    for (label, value) in curves {
        let largest = history
            .iter()
            .map(|(_, e)| value(e))
            .fold(f64::MIN_POSITIVE, f64::max);
        plot = plot.series(Series {
            name: format!("{largest:.2e} {label}"),
            points: history
                .iter()
                .map(|(t, e)| [*t, value(e) / largest])
                .collect(),
        });
    }
    plot
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
