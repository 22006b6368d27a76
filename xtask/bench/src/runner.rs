//! Runs scenes, prints their curves, keeps and compares them.

use crate::baseline::{Baseline, Change};
use crate::curve::Curve;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::scenes::{self, Scene};
use crate::settings::{Settings, on_threads};
use crate::{instructions, plot, table};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use workbench::report::Style;

/// What can be typed.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Scenes by name; `all` for all of them, `list` to say which there are
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// Smaller bodies: all scenes but head-medium in less than two minutes
    #[arg(long)]
    pub quick: bool,
    /// Also bars and faces of 300,000 and a million tetrahedra
    #[arg(long)]
    pub large: bool,
    /// Cells along the short side, separated by commas, for scenes that are grids
    #[arg(long, value_delimiter = ',', value_name = "N")]
    pub n: Option<Vec<usize>>,
    /// Threads; 0 takes all processors
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Most repetitions of a measurement; the fastest counts
    #[arg(long, default_value_t = 3)]
    pub repetitions: usize,
    /// Write NAME.csv and NAME.svg of every scene to this folder
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Keep this run in a file
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Compare with a run that was kept on the same machine
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// With --compare: fail where a scene takes more than so many times as long as then
    #[arg(long, value_name = "RATIO", requires = "compare")]
    pub limit: Option<f64>,
    /// Also count the instructions of each scene's smallest run with valgrind
    #[arg(long)]
    pub instructions: bool,
    /// No instructions that a processor may lack: what one without AVX2 runs, or of another kind
    #[arg(long, conflicts_with_all = ["save", "compare"])]
    pub portable: bool,
    /// Only a scene's smallest run, without a word: what valgrind counts
    #[arg(long, hide = true)]
    pub alone: bool,
}

impl Options {
    fn settings(&self) -> Settings {
        Settings {
            quick: self.quick,
            large: self.large,
            sizes: self.n.clone(),
            repetitions: self.repetitions.max(1),
        }
    }
}

/// Runs what was asked for; true if every claim holds and nothing became slower than allowed.
///
/// # Errors
/// If there is no such scene, a scene cannot be carried through, or a file cannot be used.
pub fn run(options: &Options) -> Result<bool, Failure> {
    if options.scenes == ["list"] {
        scenes::all().iter().for_each(listed);
        return Ok(true);
    }
    let wanted = wanted(&options.scenes)?;
    fem_kinematics::portable_only(options.portable);
    on_threads(options.threads, || match options.alone {
        true => alone(&wanted),
        false => measured(&wanted, options),
    })
}

fn listed(scene: &Scene) {
    println!("{}: {}", scene.name, scene.about);
    println!("    error: {}; truth: {}", scene.measure, scene.truth);
}

fn wanted(names: &[String]) -> Result<Vec<Scene>, Failure> {
    let all = scenes::all();
    if names == ["all"] {
        return Ok(all);
    }
    let find = |name: &String| {
        let found = all.iter().find(|scene| scene.name == name.as_str());
        found.cloned().ok_or_else(|| {
            let told = format!("no scene is named {name}; `bench list` shows them");
            Failure::Failed(told.into())
        })
    };
    names.iter().map(find).collect()
}

fn alone(scenes: &[Scene]) -> Result<bool, Failure> {
    for scene in scenes {
        let counted = scene.counted.ok_or_else(|| {
            let told = format!("{} has no smallest run", scene.name);
            Failure::Failed(told.into())
        })?;
        counted()?;
    }
    Ok(true)
}

fn measured(scenes: &[Scene], options: &Options) -> Result<bool, Failure> {
    let style = Style::of_stdout();
    let threads = rayon::current_num_threads();
    println!("{}; {threads} used", Machine::here());
    let begin = Instant::now();
    let mut runs = Vec::new();
    let mut counts = BTreeMap::new();
    let mut right = true;
    for scene in scenes {
        println!("{}: {}", style.bold(scene.name), scene.about);
        let curves = match (scene.run)(&options.settings()) {
            Err(Failure::Skipped(what)) => {
                println!("  skipped: {what}");
                continue;
            }
            curves => curves?,
        };
        for curve in &curves {
            table::print(curve, scene.measure, style);
            right &= curve.broken().is_none();
        }
        if let Some(folder) = &options.out {
            write(folder, scene, &curves)?;
        }
        if options.instructions {
            counted(scene, &mut counts)?;
        }
        runs.push((scene.name.to_owned(), curves));
    }
    let seconds = begin.elapsed().as_secs_f64();
    println!("{} scenes in {seconds:.0} s", runs.len());
    let run = Baseline::of(&runs, counts);
    if let Some(path) = &options.compare {
        let changes = run.changes_since(&Baseline::read(path)?)?;
        right &= compared(&changes, options.limit, style);
    }
    if let Some(path) = &options.save {
        run.write(path)?;
    }
    Ok(right)
}

fn write(folder: &Path, scene: &Scene, curves: &[Curve]) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    table::csv(
        scene.name,
        curves,
        &folder.join(format!("{}.csv", scene.name)),
    )?;
    if let Some(plot) = plot::plot(scene.about, scene.measure, curves) {
        plot.save(&folder.join(format!("{}.svg", scene.name)))?;
    }
    Ok(())
}

fn counted(scene: &Scene, counts: &mut BTreeMap<String, u64>) -> Result<(), Failure> {
    if scene.counted.is_none() {
        println!("  instructions: not counted, its smallest run is too long for that");
        return Ok(());
    }
    match instructions::count(scene.name)? {
        Some(count) => {
            println!(
                "  {:.4} million instructions in its smallest run",
                count as f64 / 1e6
            );
            counts.insert(scene.name.to_owned(), count);
        }
        None => println!("  instructions: skipped, there is no valgrind here"),
    }
    Ok(())
}

fn compared(changes: &[Change], limit: Option<f64>, style: Style) -> bool {
    println!("{}", style.bold("now over then"));
    let mut right = true;
    for change in changes {
        let slow = limit.is_some_and(|limit| !(change.ratio <= limit));
        let (name, worst) = &change.worst;
        let counted = change.instructions;
        let counted = counted.map_or_else(String::new, |r| format!(", instructions {r:.4}"));
        let ratio = format!("{:.2}", change.ratio);
        println!(
            "  {:<12} {} over {} points{counted}; slowest {worst:.2}: {name}",
            change.scene,
            if slow { style.red(&ratio) } else { ratio },
            change.points
        );
        for point in &change.less_exact {
            println!("    {} {point}", style.red("less exact:"));
        }
        right &= !slow && change.less_exact.is_empty();
    }
    right
}
