//! `clastic bench`: run time against error, into a directory of CSV, SVG and Markdown.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};

use clastic::bench::rigs::Scenes;
use clastic::bench::{
    BenchError, Extent, increments, precision, report, size, stages, theta, threads,
};

use super::exit::{Exit, Failure, complain, say};
use super::resolve::SCENES;

/// A part of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Name {
    /// One program: time against error by solver and tolerance
    Precision,
    /// Whole curves by size of the increment
    Increments,
    /// Order of the theta-method
    Theta,
    /// Time by stage and size of the program, by what a scene has
    Stages,
    /// Time and memory against the number of disks
    Size,
    /// One thread against two
    Threads,
}

/// What is measured.
#[derive(Args)]
pub struct BenchArgs {
    /// Parts to run, in this order; all if none is named
    #[arg(value_name = "PART")]
    parts: Vec<Name>,
    /// Directory for the results; what other parts left there stays
    #[arg(long, value_name = "DIR", default_value = "bench")]
    out: PathBuf,
    /// Directory of the scenes that are measured
    #[arg(long, value_name = "DIR", default_value = SCENES)]
    scenes: PathBuf,
    /// Markdown page whose passages between <!-- begin NAME.md --> and <!-- end NAME.md --> are to
    /// become what the directory holds
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Small specimens and few repetitions: about a minute
    #[arg(long)]
    quick: bool,
    /// Everything: size of the increment at full size, all tolerances, 300 000 disks
    #[arg(long, conflicts_with = "quick")]
    full: bool,
}

/// Runs the benchmark.
pub fn bench(args: &BenchArgs) -> Result<Exit, Failure> {
    let extent = match (args.quick, args.full) {
        (true, _) => Extent::Quick,
        (_, true) => Extent::Full,
        _ => Extent::Standard,
    };
    let parts = if args.parts.is_empty() { Name::value_variants() } else { &args.parts[..] };
    let scenes = Scenes::new(&args.scenes);
    for part in parts {
        let clock = Instant::now();
        let done = match part {
            Name::Precision => precision::run(&scenes, extent),
            Name::Increments => increments::run(&scenes, extent),
            Name::Theta => theta::run(),
            Name::Stages => stages::run(&scenes, extent, &args.out),
            Name::Size => size::run(&scenes, extent),
            Name::Threads => {
                let program = std::env::current_exe().map_err(|error| {
                    BenchError::Run(format!("where this program is is unknown: {error}"))
                });
                program.and_then(|p| threads::run(&p, &args.scenes, extent, &args.out))
            }
        }?;
        let command = command(done.name, args);
        report::write_part(&args.out, &done, &command)?;
        for table in done.tables.iter().filter(|table| table.in_summary) {
            say(format_args!("{}\n\n{}", table.title, table.markdown()))?;
        }
        let seconds = clock.elapsed().as_secs_f64();
        complain(format_args!("{}: {seconds:.0} s", done.name));
    }
    report::write_summary(&args.out)?;
    if let Some(page) = &args.page {
        report::update_page(page, &args.out)?;
    }
    say(format_args!("results in {}", args.out.display()))?;
    Ok(Exit::Ok)
}

/// The command that repeats a part.
fn command(part: &str, args: &BenchArgs) -> String {
    let extent = match (args.quick, args.full) {
        (true, _) => " --quick",
        (_, true) => " --full",
        _ => "",
    };
    format!("clastic bench {part}{extent}")
}

impl From<BenchError> for Failure {
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::Scene(error) => error.into(),
            BenchError::Output(error) => error.into(),
            BenchError::Run(message) => Self { exit: Exit::Solver, message },
        }
    }
}
