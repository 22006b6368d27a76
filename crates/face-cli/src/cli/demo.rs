//! `face-rig demo`: the whole way on the built-in face.

use super::args::{DemoArgs, OutputArgs, Pictures};
use super::clock::Clock;
use super::draw::{Fitted, Shape, Sheets, convergence};
use super::error::Failure;
use super::fit::table;
use super::output::{Output, say};
use super::progress::bar;
use super::source::{Source, builtin};
use face_rig::anatomy::EmbeddedPoint;
use face_rig::fit::{CraniumModel, FitIteration, FitParams, Goal, Parametrization};
use face_rig::rig::{EmbeddedPoints, Rig, RigError, RigParams};
use face_scenes::builtin::BuiltinFace;
use face_scenes::{
    ExpressionFit, Observed, Scene, Target, TargetKind, fit_expression, parse_activations,
};
use indicatif::ProgressBar;
use serde_json::{Value, json};

/// End of the scale of distances, millimeters.
const SCALE: f64 = 1.0;

/// An expression to be made and found again: settings of both sides, and the jaw in degrees.
const EXPRESSIONS: [(&str, &[&str], f64); 3] = [
    (
        "smile",
        &[
            "zygomaticus_major=0.6",
            "zygomaticus_minor=0.4",
            "risorius=0.3",
            "levator_anguli_oris=0.3",
        ],
        2.0,
    ),
    (
        "surprise",
        &["frontalis_medial=0.6", "frontalis_lateral=0.6"],
        12.0,
    ),
    (
        "anger",
        &[
            "corrugator_supercilii=0.6",
            "procerus=0.5",
            "depressor_anguli_oris=0.5",
            "mentalis=0.3",
        ],
        0.0,
    ),
];

/// An expression made and found again.
struct Done {
    fit: ExpressionFit,
    /// Where the flesh was.
    posed: Vec<[f64; 3]>,
    /// The numbers that made it.
    truth: Vec<f64>,
}

pub fn run(args: &DemoArgs, output: &OutputArgs, clock: Clock) -> Result<(), Failure> {
    if !BuiltinFace::TETS.contains(&args.tets) {
        // Before a folder is made for nothing.
        builtin(args.tets)?;
    }
    let mut out = Output::prepare(output, clock)?;
    out.enter("scene");
    let progress = bar(2 * EXPRESSIONS.len() + 2, "demo");
    progress.set_message("making the face");
    let source = builtin(args.tets)?;
    let scene = &source.scene;
    out.enter("assembly");
    let mut rig = scene.rig(RigParams::default())?;
    progress.inc(1);
    let (muscles, jaw) = (scene.muscles.len(), scene.jointed_jaw());
    let map = Parametrization::of_all(muscles, CraniumModel::Fixed, jaw);
    let params = FitParams {
        activation_weight: 1e-9,
        ..FitParams::default()
    };
    let landmarks = scene.landmark_points(0..scene.landmarks.len());
    let demo = Demo {
        scene,
        map: &map,
        params: &params,
        landmarks: &landmarks,
        progress: &progress,
    };
    let rest = rig.equilibrium().clone();
    let mut done: Vec<Done> = Vec::new();
    for (name, settings, degrees) in EXPRESSIONS {
        let mut truth = parse_activations(&scene.muscles, settings.iter().copied())?;
        truth.extend([degrees.to_radians(), 0.0, 0.0, 0.0]);
        out.enter(&format!("pose {name}"));
        rig.start_from(rest.clone())?;
        let posed = demo.pose(name, &mut rig, &truth)?;
        out.enter(&format!("fit {name}"));
        rig.start_from(rest.clone())?;
        let fit = demo.find(name, &mut rig, &posed, &mut out)?;
        done.push(Done { fit, posed, truth });
    }
    if out.pictures != Pictures::None {
        progress.set_message("drawing");
        out.enter("pictures");
        draw(&mut out, &source, &map, &landmarks, &done)?;
    }
    progress.finish_and_clear();
    out.enter("report");
    let settings = json!({ "tets": args.tets, "tets_made": scene.mesh.num_elements(),
        "relax_mm2": 1e6 * params.activation_weight, "max_iterations": params.max_iterations,
        "stop_mm": 1e3 * params.rms_change });
    finish(&mut out, scene, settings, &done, output.json)
}

/// The report and the summary.
fn finish(
    out: &mut Output,
    scene: &Scene,
    settings: Value,
    done: &[Done],
    json: bool,
) -> Result<(), Failure> {
    let fits: Vec<ExpressionFit> = done.iter().map(|d| d.fit.clone()).collect();
    let truths: Vec<&[f64]> = done.iter().map(|d| d.truth.as_slice()).collect();
    let names: Vec<&str> = scene.muscles.iter().map(|m| m.name.as_str()).collect();
    let results = json!({ "muscles": names, "fits": fits, "truths": truths });
    let report = out.report("demo", settings, results)?;
    if json {
        say(serde_json::to_string_pretty(&report)?)?;
    } else {
        let (name, nodes) = (&scene.name, scene.mesh.num_nodes());
        let muscles = scene.muscles.len();
        say(format!("{name}: {nodes} nodes, {muscles} muscles"))?;
        say(table(&fits).trim_end())?;
        say(format!(
            "look at {}; the report is report.json",
            out.folder().join("demo.png").display()
        ))?;
    }
    let unfinished = fits.iter().filter(|fit| !fit.converged());
    let unfinished: Vec<String> = unfinished.map(|fit| fit.name.clone()).collect();
    match unfinished.is_empty() {
        true => Ok(()),
        false => Err(Failure::Unfinished {
            fits: unfinished,
            of: fits.len(),
        }),
    }
}

/// What all expressions have in common.
struct Demo<'a> {
    scene: &'a Scene,
    map: &'a Parametrization,
    params: &'a FitParams,
    landmarks: &'a EmbeddedPoints,
    progress: &'a ProgressBar,
}

impl Demo<'_> {
    /// Where the flesh is for these numbers.
    fn pose(&self, name: &str, rig: &mut Rig, truth: &[f64]) -> Result<Vec<[f64; 3]>, Failure> {
        self.progress.set_message(format!("posing: {name}"));
        let parameters = self.map.parameters(truth)?;
        let posed = rig.solve(&parameters)?.positions();
        self.progress.inc(1);
        Ok(posed)
    }

    /// Finds the numbers again from where the landmarks are.
    fn find(
        &self,
        name: &str,
        rig: &mut Rig,
        posed: &[[f64; 3]],
        out: &mut Output,
    ) -> Result<ExpressionFit, Failure> {
        let goal = |&point: &EmbeddedPoint| Goal {
            point,
            position: point.position(posed),
            weight: 1.0,
        };
        let target = Target {
            name: name.into(),
            kind: TargetKind::Expression,
            landmarks: self.landmarks.0.iter().map(goal).collect(),
            dense: None,
            jaw_truth: None,
            alignment: None,
        };
        let mut observer = |i: &FitIteration| {
            self.progress.set_message(format!(
                "fitting {name}: step {}, {:.3} mm",
                i.iteration, i.rms_mm
            ));
        };
        let fit = fit_expression(
            self.scene,
            rig,
            &target,
            Observed::Landmarks,
            self.map,
            self.params,
            &self.map.rest(),
            &mut observer,
        )?;
        out.enter("files");
        let parameters = self.map.parameters(&fit.q)?;
        out.write_shape(name, self.scene, rig, &parameters, &fit.positions)?;
        self.progress.inc(1);
        Ok(fit)
    }
}

fn draw(
    out: &mut Output,
    source: &Source,
    map: &Parametrization,
    landmarks: &EmbeddedPoints,
    done: &[Done],
) -> Result<(), Failure> {
    let sheets = Sheets::new(source, SCALE)?;
    let on = |x: &[[f64; 3]]| {
        landmarks
            .0
            .iter()
            .map(|p| p.position(x))
            .collect::<Vec<_>>()
    };
    let shape = |x: &[[f64; 3]], q: &[f64]| -> Result<Shape, RigError> {
        Ok(Shape::new(source, x, &map.parameters(q)?.jaw))
    };
    let both = |d: &Done| -> Result<[Shape; 2], RigError> {
        Ok([
            shape(&d.fit.positions, &d.fit.q)?,
            shape(&d.posed, &d.truth)?,
        ])
    };
    let shapes: Vec<[Shape; 2]> = done.iter().map(both).collect::<Result<_, _>>()?;
    let points: Vec<[Vec<[f64; 3]>; 2]> = done
        .iter()
        .map(|d| [on(&d.fit.positions), on(&d.posed)])
        .collect();
    let headings: Vec<String> = done
        .iter()
        .map(|Done { fit, .. }| {
            let (name, steps) = (&fit.name, fit.iterations);
            format!("{name}: found from 68 landmarks in {steps} steps")
        })
        .collect();
    let rows: Vec<Fitted> = (0..done.len())
        .map(|k| Fitted {
            heading: &headings[k],
            caption: &done[k].fit.name,
            fitted: &shapes[k][0],
            target: Some(&shapes[k][1]),
            observed: &points[k][0],
            wanted: &points[k][1],
        })
        .collect();
    let title = "three expressions, made and found again";
    sheets.rows(&out.path("demo.png"), title, &rows)?;
    let histories = done
        .iter()
        .map(|d| (d.fit.name.as_str(), d.fit.history.as_slice()));
    convergence(&out.path("convergence.svg"), histories)
}
