//! What can be typed.

use clap::{Parser, Subcommand, ValueEnum};
use face_rig::rig::MultigridUse;
use std::path::PathBuf;

/// Pose a face by its muscles, and find the muscles behind an expression.
///
/// A SCENE is a scene file (JSON; `face-rig check SCENE` says what was understood), or the face that
/// the program makes itself: `builtin`, or `builtin:50000` for about 50,000 tetrahedra.
#[derive(Parser, Debug)]
#[command(
    name = "face-rig",
    version,
    after_help = "EXIT CODES\n  0  done\n  1  a solve or fit did not converge; `fit` still writes the best pose that it found\n  2  wrong command line\n  3  bad input: scene, mesh, table, target or setting\n  4  output exists already (use --force) or cannot be written\n\nEXAMPLES\n  face-rig demo\n  face-rig simulate builtin --set zygomaticus_major=0.6 --jaw 5deg --out smile\n  face-rig fit head.json --target jawOpen --target mouthSmile_L --out fits\n  face-rig check head.json"
)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub output: OutputArgs,
    /// Threads; all processors by default. Results have the same bits for any number.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

/// Where results go.
#[derive(clap::Args, Debug)]
pub struct OutputArgs {
    /// Folder for results; made if missing.
    #[arg(long, global = true, default_value = "out", value_name = "DIR")]
    pub out: PathBuf,
    /// Write into a folder that already holds files, replacing those of the same name.
    #[arg(long, global = true)]
    pub force: bool,
    /// Which pictures are drawn: a `sheet` (all that one pose needs, or one sheet for many targets),
    /// `all` (also one for each target), or `none`.
    #[arg(long, global = true, value_enum, default_value = "sheet")]
    pub pictures: Pictures,
    /// Which shapes are written, separated by commas.
    #[arg(
        long,
        global = true,
        value_enum,
        value_delimiter = ',',
        default_value = "vtu,obj,glb",
        value_name = "FORMATS"
    )]
    pub write: Vec<Format>,
    /// Print the report as JSON instead of text.
    #[arg(long, global = true)]
    pub json: bool,
}

/// Which pictures are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Pictures {
    None,
    Sheet,
    All,
}

/// A file of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// The flesh, with displacement, det F, fiber stretch and activation.
    Vtu,
    /// The skin.
    Obj,
    /// The skin with a morph target from rest.
    Glb,
    /// No file.
    None,
}

#[derive(Subcommand, Debug)]
pub enum Command {
    /// Make the built-in face, pose it, and fit three expressions back from their landmarks.
    Demo(DemoArgs),
    /// Find the shape of a pose: muscles set to activations, the jaw to an angle.
    Simulate(SimulateArgs),
    /// Find the activations and jaw pose behind expressions.
    Fit(FitArgs),
    /// Write the exact derivative of the landmarks by muscles, jaw and head.
    Jacobian(JacobianArgs),
    /// Say what was understood of a scene, how good its mesh is, and what is wrong.
    Check(CheckArgs),
}

#[derive(clap::Args, Debug)]
pub struct DemoArgs {
    /// About how many tetrahedra, 4,000 to 2,000,000.
    #[arg(long, default_value_t = 20_000)]
    pub tets: usize,
}

/// A pose, as typed.
#[derive(clap::Args, Debug)]
pub struct PoseArgs {
    /// Activation of a muscle, 0 to 1; a name without _L or _R sets both sides. Repeatable.
    #[arg(long = "set", value_name = "MUSCLE=VALUE")]
    pub set: Vec<String>,
    /// Value of a load, cavity, motion, strength or stiffness of the scene by its name: a cavity's in
    /// pascals, a load's or motion's factor, the relative change of a strength or stiffness. Repeatable.
    #[arg(
        long = "control",
        value_name = "NAME=VALUE",
        allow_hyphen_values = true
    )]
    pub control: Vec<String>,
    /// Opening of the jaw; its condyles glide along the scene's path. Positive opens.
    #[arg(long, value_name = "12deg", allow_hyphen_values = true)]
    pub jaw: Option<String>,
    /// A further shift of the jaw, millimeters: left, up, forward.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub jaw_shift: Option<String>,
}

/// When conjugate gradients on a multigrid hierarchy stand in for factorizations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Multigrid {
    /// Where that takes fewer operations than factorizations.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl From<Multigrid> for MultigridUse {
    fn from(multigrid: Multigrid) -> Self {
        match multigrid {
            Multigrid::Auto => Self::WhereCheaper,
            Multigrid::Always => Self::Always,
            Multigrid::Never => Self::Never,
        }
    }
}

impl Multigrid {
    /// What a rig does, as a report tells it: a scene may have decided otherwise than was asked for.
    pub fn told(of_rig: MultigridUse) -> String {
        let effective = match of_rig {
            MultigridUse::WhereCheaper | MultigridUse::WhereFarCheaper => Self::Auto,
            MultigridUse::Always => Self::Always,
            MultigridUse::Never => Self::Never,
        };
        format!("{effective:?}").to_lowercase()
    }
}

#[derive(clap::Args, Debug)]
pub struct SimulateArgs {
    /// Scene file, `builtin` or `builtin:TETS`.
    pub scene: String,
    #[command(flatten)]
    pub pose: PoseArgs,
    /// When a multigrid hierarchy is used in place of factorizations; the shape is the same.
    #[arg(long, default_value = "auto")]
    pub multigrid: Multigrid,
}

#[derive(clap::Args, Debug)]
pub struct JacobianArgs {
    /// Scene file, `builtin` or `builtin:TETS`.
    pub scene: String,
    #[command(flatten)]
    pub pose: PoseArgs,
    /// When a multigrid hierarchy is used in place of factorizations, for the equilibrium and for the
    /// derivative: `auto` decides for each by itself, `always` takes the least memory.
    #[arg(long, default_value = "auto")]
    pub multigrid: Multigrid,
}

#[derive(clap::Args, Debug)]
pub struct CheckArgs {
    /// Scene file, `builtin` or `builtin:TETS`.
    pub scene: String,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Points {
    Landmarks,
    Dense,
    Both,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Method {
    Qr,
    NormalEquations,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Head {
    Fixed,
    Rigid,
    Affine,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Jaw {
    Fixed,
    /// In its joint: opening, protrusion, lateral shift and yaw, each within its limits.
    Joint,
    /// About its hinge alone.
    Hinge,
    /// A turn about any axis and a shift.
    Rigid,
    /// The documents' twelve numbers.
    Affine,
}

#[derive(clap::Args, Debug)]
pub struct FitArgs {
    /// Scene file.
    pub scene: String,
    /// Landmark table (target,landmark,ict_vertex,x,y,z, optionally weight; meters) instead of the
    /// scene's own. Its names to skip and of identities still hold.
    #[arg(long, value_name = "FILE")]
    pub targets: Option<PathBuf>,
    /// Lays the targets over the face at rest first, by a motion with scale: for tables with other axes,
    /// another unit or another place. A neutral face among them that the scene skips (`rest`) gives one
    /// motion for all; without it each target's own landmarks do, those that moved counting less.
    #[arg(long)]
    pub align: bool,
    /// A target to fit; repeatable. All expressions of the scene if none is named.
    #[arg(long = "target", value_name = "NAME")]
    pub target: Vec<String>,
    /// Which points are fitted. Those that the scene says (`fit.points`) if it is not given, landmarks where
    /// the scene says nothing.
    #[arg(long, value_enum)]
    pub points: Option<Points>,
    /// How a Gauss-Newton step is computed.
    #[arg(long, value_enum, default_value = "qr")]
    pub method: Method,
    /// How the head may move.
    #[arg(long, value_enum, default_value = "fixed")]
    pub head: Head,
    /// How the jaw may move.
    #[arg(long, value_enum, default_value = "joint")]
    pub jaw: Jaw,
    /// Tikhonov weight of the joint's protrusion, lateral shift and yaw, each relative to its limit,
    /// millimeters squared: larger prefers a jaw that only opens. That of the scene (`fit.jaw_weight_mm2`)
    /// if it is not given, 300 where the scene says nothing or its fits see other points.
    #[arg(long, value_name = "MM2", value_parser = not_negative, allow_hyphen_values = true)]
    pub jaw_weight: Option<f64>,
    /// Weight of ½ w |MᵀM − I|² for a head or jaw that may move by an affine map M, millimeters squared:
    /// larger keeps it rigid, 0 lets it stretch and shear. Those of the scene (`fit.orthogonality`) if it
    /// is not given, 10000 where the scene says nothing.
    #[arg(long, value_name = "MM2", value_parser = not_negative, allow_hyphen_values = true)]
    pub orthogonality: Option<f64>,
    /// Tikhonov weight of the activations, millimeters squared: larger prefers relaxed muscles.
    #[arg(long, default_value_t = 0.1, value_name = "MM2", value_parser = not_negative, allow_hyphen_values = true)]
    pub relax: f64,
    /// How much a landmark counts beside a point of the dense skin, where both are fitted. That of the scene
    /// (`fit.landmark_weight`) if it is not given, 1 where the scene says nothing.
    #[arg(long, value_name = "WEIGHT", value_parser = positive, allow_hyphen_values = true)]
    pub landmark_weight: Option<f64>,
    /// Robust loss: points farther off than this many millimeters count less (Huber).
    #[arg(long, value_name = "MM", value_parser = positive, allow_hyphen_values = true)]
    pub robust: Option<f64>,
    /// Stop when a step gains less than this root-mean-square distance, millimeters.
    #[arg(long, default_value_t = 0.002, value_name = "MM", value_parser = not_negative, allow_hyphen_values = true)]
    pub stop: f64,
    /// Most Gauss-Newton steps.
    #[arg(long, default_value_t = 40)]
    pub max_iterations: usize,
    /// Start each target from the result of the one before, as for the frames of a sequence.
    #[arg(long)]
    pub warm_start: bool,
    /// Fits that run at once, each with a rig of its own and its share of the threads; results have the same
    /// bits for any number. If it is not given, one for each thread, since one fit cannot keep several threads
    /// busy: but not more than there are targets, and only as many as keep the factors of all rigs below
    /// 4 GiB (two in each rig, of 8 bytes for each nonzero, counted at rest). 1 takes the least memory.
    /// Always 1 with --warm-start, where each fit waits for the one before.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub at_once: Option<u16>,
    /// When a multigrid hierarchy is used in place of factorizations: `auto` from a few hundred thousand
    /// tetrahedra on, and for derivatives of few numbers; `always` takes the least memory.
    #[arg(long, default_value = "auto")]
    pub multigrid: Multigrid,
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0, "a number from 0 up")
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0, "a number above 0")
}

fn number(text: &str, good: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok();
    let value = value.filter(|v: &f64| v.is_finite() && good(*v));
    value.ok_or_else(|| format!("expected {wanted}"))
}
