//! The command line.

mod args;
mod at_once;
mod check;
mod clock;
mod demo;
mod draw;
mod error;
mod fit;
mod gallery;
mod jacobian;
mod output;
mod plain_portrait;
mod portrait;
mod progress;
mod shape_files;
mod simulate;
mod source;
mod workers;

use args::{Args, Command};
use clap::Parser;
use clock::Clock;

use std::process::ExitCode;

/// Parses, runs, reports; see [`error::Failure`] for the exit codes.
pub fn run() -> ExitCode {
    let clock = Clock::start();
    let args = Args::parse();
    let outcome = args.in_pool(|| match &args.command {
        Command::Demo(demo) => demo::run(demo, &args.output, clock),
        Command::Simulate(simulate) => simulate::run(simulate, &args.output, clock),
        Command::Fit(fit) => fit::run(fit, &args.output, clock),
        Command::Jacobian(jacobian) => jacobian::run(jacobian, &args.output, clock),
        Command::Check(check) => check::run(check, &args.output),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("face-rig: {failure}");
            failure.exit_code()
        }
    }
}

impl Args {
    fn in_pool<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, usize::from))
            .build()
        {
            Ok(pool) => pool.install(work),
            Err(_) => work(),
        }
    }
}
