//! The `clastic` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    clastic::cli::main(())
}
