//! The `clastic_bench` program: run time against error, into a directory of CSV, SVG and Markdown.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, ValueEnum};
use rayon::ThreadPoolBuilder;

use clastic_bench::rigs::Scenes;
use clastic_bench::{
    BenchError, Extent, Part, increments, precision, report, size, stages, theta, threads,
};

/// Stack of the thread that measures, bytes: that of a main thread, as in `clastic run`.
const STACK: usize = 8 << 20;

/// A part of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Name {
    /// One program: time against error by solver and tolerance
    Precision,
    /// Whole curves by size of the increment
    Increments,
    /// Order of the theta-method
    Theta,
    /// Time by stage and size of the program, by features of the scene
    Stages,
    /// Time and memory against the number of disks
    Size,
    /// One thread against two
    Threads,
}

/// Measures run time against error; writes CSV, SVG and summary.md.
#[derive(Parser)]
#[command(version)]
struct Cli {
    /// Parts to run, in this order; all if none is named
    #[arg(value_name = "PART")]
    parts: Vec<Name>,
    /// Directory for the results; results of other parts in it are kept
    #[arg(long, value_name = "DIR", default_value = "bench")]
    out: PathBuf,
    /// Directory of the scenes that are measured
    #[arg(long, value_name = "DIR", default_value = "scenes")]
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

fn main() -> ExitCode {
    let args = Cli::parse();
    // One thread: the other solvers and programs of the comparison use one core.
    let pool = ThreadPoolBuilder::new().num_threads(1).stack_size(STACK).build();
    let done = match pool {
        Ok(pool) => pool.install(|| bench(&args)),
        Err(error) => Err(BenchError::Run(format!("cannot start a thread: {error}"))),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&error.to_string());
            ExitCode::FAILURE
        }
    }
}

/// Runs the parts and writes their results.
fn bench(args: &Cli) -> Result<(), BenchError> {
    let parts = if args.parts.is_empty() { Name::value_variants() } else { &args.parts[..] };
    for part in parts {
        let clock = Instant::now();
        let done = measure(*part, args)?;
        report::write_part(&args.out, &done, &command(done.name, args))?;
        for table in done.tables.iter().filter(|table| table.in_summary) {
            say(&format!("{}\n\n{}", table.title, table.markdown()));
        }
        complain(&format!("{}: {:.0} s", done.name, clock.elapsed().as_secs_f64()));
    }
    report::write_summary(&args.out)?;
    if let Some(page) = &args.page {
        report::update_page(page, &args.out)?;
    }
    say(&format!("results in {}", args.out.display()));
    Ok(())
}

/// Runs one part.
fn measure(part: Name, args: &Cli) -> Result<Part, BenchError> {
    let extent = match (args.quick, args.full) {
        (true, _) => Extent::Quick,
        (_, true) => Extent::Full,
        _ => Extent::Standard,
    };
    let scenes = Scenes::new(&args.scenes);
    match part {
        Name::Precision => precision::run(&scenes, extent),
        Name::Increments => increments::run(&scenes, extent),
        Name::Theta => theta::run(),
        Name::Stages => stages::run(&scenes, extent, &args.out),
        Name::Size => size::run(&scenes, extent),
        Name::Threads => threads::run(&scenes, extent, &args.out),
    }
}

/// The command that repeats a part.
fn command(part: &str, args: &Cli) -> String {
    let extent = match (args.quick, args.full) {
        (true, _) => " --quick",
        (_, true) => " --full",
        _ => "",
    };
    format!("cargo run --release -p clastic_bench -- {part}{extent}")
}

/// A line on standard output. A closed pipe is no error, because the results are in the directory.
fn say(what: &str) {
    let _ = writeln!(io::stdout(), "{what}");
}

/// A line on standard error.
fn complain(what: &str) {
    let _ = writeln!(io::stderr(), "{what}");
}
