//! `face-rig check`.

use super::args::{CheckArgs, OutputArgs};
use super::error::Failure;
use super::output::say;
use super::source::open;
use face_scenes::check;

pub fn run(args: &CheckArgs, output: &OutputArgs) -> Result<(), Failure> {
    let source = open(&args.scene, false)?;
    let report = check(&source.scene);
    if output.json {
        say(serde_json::to_string_pretty(&report)?)?;
    } else {
        say(report)?;
    }
    Ok(())
}
