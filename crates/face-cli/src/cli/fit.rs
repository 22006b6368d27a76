//! `face-rig fit`.

use super::args::{FitArgs, Head, Jaw, Method, Multigrid, OutputArgs, Pictures, Points};
use super::at_once;
use super::clock::Clock;
use super::draw::convergence;
use super::error::Failure;
use super::gallery::Gallery;
use super::output::{Output, say};
use super::source::open;
use super::workers::Fitting;
use face_rig::fit::{CraniumModel, FitParams, JawModel, Orthogonality, Parametrization};
use face_rig::rig::{MultigridUse, RigParams};
use face_scenes::{ExpressionFit, FitSpec, Outcome, PointsSpec, Scene, Target, TargetKind};
use fem_solvers::{Loss, StepMethod};
use serde_json::{Value, json};
use std::collections::BTreeMap;

pub fn run(args: &FitArgs, output: &OutputArgs, mut clock: Clock) -> Result<(), Failure> {
    at_once::check(args)?;
    clock.enter("scene");
    let mut source = open(&args.scene, args.align && args.targets.is_none())?;
    if let Some(file) = &args.targets {
        source.scene.read_targets(file, args.align)?;
    }
    let scene = &source.scene;
    let targets = chosen(scene, &args.target)?;
    let mut out = Output::prepare(output, clock)?;
    out.enter("assembly");
    let mut rig_params = RigParams::for_fits();
    if args.multigrid != Multigrid::Auto {
        rig_params.multigrid = args.multigrid.into();
    }
    let rig = scene.rig(rig_params)?;
    let at_once = at_once::count(args, targets.len(), &rig)?;
    let multigrid = rig.params().multigrid;
    let map = parametrization(scene, args);
    let params = params(scene, args);
    out.enter("rest picture");
    let gallery = Gallery::new(&source, &out, targets.len())?;
    let all = Fitting {
        scene,
        rig_params,
        points: points(scene, args),
        landmark_weight: landmark_weight(scene, args),
        map: &map,
        params: &params,
        warm_start: args.warm_start,
        formats: out.formats.clone(),
        gallery: &gallery,
    };
    let (fits, impossible) = all.run(rig, &targets, at_once, &mut out)?;
    out.enter("sheet");
    gallery.finish(&mut out)?;
    if out.pictures != Pictures::None {
        let histories = fits.iter().map(|f| (f.name.as_str(), f.history.as_slice()));
        convergence(&out.path("convergence.svg"), histories)?;
    }
    out.enter("report");
    let muscles: Vec<&str> = scene.muscles.iter().map(|m| m.name.as_str()).collect();
    let results = json!({ "muscles": muscles, "fits": fits, "impossible": impossible });
    let settings = settings(scene, args, &params, multigrid, at_once);
    let report = out.report("fit", settings, results)?;
    if output.json {
        say(serde_json::to_string_pretty(&report)?)?;
    } else {
        summary(scene, &fits, &impossible)?;
        say(format!("results in {}", out.folder().display()))?;
    }
    let unfinished = fits.iter().filter(|f| !f.converged());
    let failed: Vec<String> = unfinished
        .map(|f| f.name.clone())
        .chain(impossible.keys().cloned())
        .collect();
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::Unfinished {
            fits: failed,
            of: targets.len(),
        }),
    }
}

/// What the user is told of all fits.
fn summary(
    scene: &Scene,
    fits: &[ExpressionFit],
    impossible: &BTreeMap<String, String>,
) -> Result<(), Failure> {
    say(table(fits).trim_end())?;
    let found = fits.iter().filter_map(|fit| controls(scene, fit));
    for line in fits.iter().filter_map(aligned).chain(found) {
        say(line)?;
    }
    for (name, why) in impossible {
        say(format!("{name}: {why}"))?;
    }
    Ok(())
}

fn settings(
    scene: &Scene,
    args: &FitArgs,
    params: &FitParams,
    multigrid: MultigridUse,
    at_once: usize,
) -> Value {
    let of_scene = scene.fit.orthogonality;
    let orthogonality = match args.orthogonality {
        Some(mm2) => json!(mm2),
        None if of_scene.cranium_mm2 == of_scene.jaw_mm2 => json!(of_scene.jaw_mm2),
        None => json!({ "cranium": of_scene.cranium_mm2, "jaw": of_scene.jaw_mm2 }),
    };
    json!({ "scene": args.scene, "targets": args.targets, "align": args.align, "target": args.target,
        "points": points(scene, args), "landmark_weight": landmark_weight(scene, args),
        "head": format!("{:?}", args.head).to_lowercase(), "jaw": format!("{:?}", args.jaw).to_lowercase(),
        "method": format!("{:?}", params.method), "relax_mm2": args.relax,
        "jaw_weight_mm2": jaw_weight(scene, args), "orthogonality_mm2": orthogonality, "robust_mm": args.robust,
        "stop_mm": args.stop, "max_iterations": args.max_iterations, "warm_start": args.warm_start,
        "at_once": at_once, "multigrid": Multigrid::told(multigrid) })
}

/// What the command line says, or else the scene; landmarks alone where no target knows the skin.
fn points(scene: &Scene, args: &FitArgs) -> PointsSpec {
    let said = match args.points {
        None => scene.fit.points,
        Some(Points::Landmarks) => PointsSpec::Landmarks,
        Some(Points::Dense) => PointsSpec::Dense,
        Some(Points::Both) => PointsSpec::Both,
    };
    let no_skin = scene.targets.iter().all(|target| target.dense.is_none());
    match said {
        PointsSpec::Both if no_skin => PointsSpec::Landmarks,
        _ => said,
    }
}

fn landmark_weight(scene: &Scene, args: &FitArgs) -> f64 {
    args.landmark_weight.unwrap_or(scene.fit.landmark_weight)
}

/// Millimeters squared. A scene's own suits the points that it has its fits see, and no others.
fn jaw_weight(scene: &Scene, args: &FitArgs) -> f64 {
    let otherwise = match points(scene, args) == scene.fit.points {
        true => scene.fit,
        false => FitSpec::default(),
    };
    args.jaw_weight.unwrap_or(otherwise.jaw_weight_mm2)
}

fn chosen<'s>(scene: &'s Scene, names: &[String]) -> Result<Vec<&'s Target>, Failure> {
    let targets: Vec<&Target> = match names {
        [] => scene
            .targets
            .iter()
            .filter(|t| t.kind == TargetKind::Expression)
            .collect(),
        names => {
            let mut once: Vec<&String> = Vec::new();
            names.iter().for_each(|n| {
                if !once.contains(&n) {
                    once.push(n);
                }
            });
            once.iter()
                .map(|n| scene.target(n))
                .collect::<Result<_, _>>()?
        }
    };
    match targets.as_slice() {
        [] => Err(Failure::NoTargets {
            scene: scene.name.clone(),
        }),
        _ => Ok(targets),
    }
}

fn parametrization(scene: &Scene, args: &FitArgs) -> Parametrization {
    let cranium = match args.head {
        Head::Fixed => CraniumModel::Fixed,
        Head::Rigid => CraniumModel::Rigid,
        Head::Affine => CraniumModel::Affine,
    };
    let jaw = match args.jaw {
        Jaw::Fixed => JawModel::Fixed,
        Jaw::Joint => scene.jointed_jaw(),
        Jaw::Hinge => JawModel::Hinge(*scene.joint.hinge()),
        Jaw::Rigid => JawModel::Rigid {
            point: scene.joint.hinge().point(),
        },
        Jaw::Affine => JawModel::Affine,
    };
    scene.parametrization(cranium, jaw)
}

fn params(scene: &Scene, args: &FitArgs) -> FitParams {
    FitParams {
        method: match args.method {
            Method::Qr => StepMethod::Qr,
            Method::NormalEquations => StepMethod::NormalEquations,
        },
        activation_weight: 1e-6 * args.relax,
        joint_weight: 1e-6 * jaw_weight(scene, args),
        orthogonality: args.orthogonality.map_or(scene.orthogonality(), |mm2| {
            let [cranium, jaw] = [1e-6 * mm2; 2];
            Orthogonality { cranium, jaw }
        }),
        jaw_angle_bounds: Some(scene.joint.limits().opening),
        loss: args
            .robust
            .map_or(Loss::Square, |mm| Loss::Huber { scale: 1e-3 * mm }),
        rms_change: 1e-3 * args.stop,
        max_iterations: args.max_iterations,
        ..FitParams::default()
    }
}

/// The line above the picture of a fit.
pub fn line(fit: &ExpressionFit, points: PointsSpec) -> String {
    let jaw = match fit.jaw_pose.opening_degrees {
        0.0 => String::new(),
        d => format!(", jaw {d:.1} deg"),
    };
    let told = match points {
        PointsSpec::Both => " of landmarks",
        _ => "",
    };
    format!(
        "{}: {} points, {:.2} -> {:.2} mm RMS{told} in {} steps{jaw}",
        fit.name, fit.points, fit.rms_before_mm, fit.rms_after_mm, fit.iterations
    )
}

/// What a fit found for the controls that it varied: "cheekPuff: mouth 1240 Pa".
fn controls(scene: &Scene, fit: &ExpressionFit) -> Option<String> {
    let varied = scene.influences.iter().filter(|i| i.range.is_some());
    let found = varied.filter_map(|i| {
        let value = fit.controls.get(&i.name)?;
        Some(
            format!("{} {value:.3} {}", i.name, i.unit())
                .trim_end()
                .to_owned(),
        )
    });
    let found: Vec<String> = found.collect();
    (!found.is_empty()).then(|| format!("{}: {}", fit.name, found.join(", ")))
}

/// How the target was laid over the face.
fn aligned(fit: &ExpressionFit) -> Option<String> {
    let by = fit.alignment?;
    Some(format!(
        "{}: target scaled by {:.5} and turned by {:.2} degrees before the fit",
        fit.name,
        by.scale,
        by.angle().to_degrees()
    ))
}

/// A row for each fit, as Markdown.
pub fn table(fits: &[ExpressionFit]) -> String {
    let mut text = String::from(
        "| target | RMS before (mm) | RMS after (mm) | left | dense left | steps | seconds | jaw (deg) | protrusion (mm) \
         | lateral (mm) | yaw (deg) | condyles off (mm) | crossing triangles | deepest contact (mm) | inverted tets | end |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|\n",
    );
    for f in fits {
        let end = match &f.outcome {
            Outcome::Converged(_) => "converged".to_owned(),
            Outcome::Missed { .. } => format!("missed: {}", f.outcome.why()),
            Outcome::Impossible(_) => format!("impossible pose: {}", f.outcome.why()),
            _ => format!("not converged: {}", f.outcome.why()),
        };
        let jaw = &f.jaw_pose;
        let off = jaw.condyles_off_mm;
        let off = off.map_or(String::new(), |mm| format!("{mm:.1}"));
        let dense = f.dense.filter(|d| d.rms_before_mm > 0.0);
        let dense = dense.map_or(String::new(), |d| {
            format!("{:.0} %", 100.0 * d.rms_after_mm / d.rms_before_mm)
        });
        let crossing = f
            .crossing_triangles
            .map_or(String::new(), |n| n.to_string());
        let deepest = f.deepest_contact_mm;
        let deepest = deepest.map_or(String::new(), |mm| format!("{mm:.2}"));
        text += &format!(
            "| {} | {:.2} | {:.2} | {:.0} % | {dense} | {} | {:.2} | {:.1} | {:.1} | {:.1} | {:.1} | {off} | {crossing} | {deepest} | {} | {end} |\n",
            f.name,
            f.rms_before_mm,
            f.rms_after_mm,
            100.0 * f.remaining(),
            f.iterations,
            f.seconds,
            jaw.opening_degrees,
            jaw.protrusion_mm,
            jaw.lateral_mm,
            jaw.yaw_degrees,
            f.inverted_tets
        );
    }
    text
}
