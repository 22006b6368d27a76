//! The program `face-rig`: poses a face by its muscles and fits muscles to expressions.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
