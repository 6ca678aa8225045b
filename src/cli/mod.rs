//! The command line: arguments, and the file that handles each command.
//!
//! A program with plugins of its own gets this command line from one call, [`main`]: `check`, `run`
//! and `resume` know the stages, measures and walls that the plugins provide.

mod check;
pub mod exit;
mod export;
mod interrupt;
pub mod memory;
mod new;
pub mod own_findings;
mod progress;
#[cfg(feature = "report")]
mod report;
pub mod resolve;
mod resume;
mod run;
mod summary;
mod sweep;
mod threads;

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use bevy_app::Plugins;
use clap::{Args, Parser, Subcommand};

use crate::run::app;

use self::exit::Exit;
use self::threads::on_threads;

const EXAMPLES: &str = "\
Examples:
  clastic list                                  scenes that have a name
  clastic new biaxial > my_rig.ron              a commented scene to start from
  clastic check uniaxial                        is the scene sound?
  clastic run uniaxial                          run it; results go to runs/uniaxial
  clastic report runs/uniaxial                  a page to look at it: animation, curves, key results
  clastic report runs/a runs/b                  their curves over one another, and a table
  clastic run uniaxial --checkpoint-every 10    lose no more than 10 increments if it is killed
  clastic resume runs/uniaxial                  go on from there
  clastic resume runs/a --scene longer.ron      give a run that has ended more stages
  clastic sweep study.ron                       many runs, one table (docs/studies.md)
  clastic run my_rig.ron --out out --set gravity='(0.0, -9.81)'

Exit codes:
  0    done; a collapse of the specimen is a result
  1    input or output failed: no such file, directory in use, disk full
  2    wrong usage, or a --set that leads nowhere
  3    the scene is wrong, or a stage of it cannot begin; results up to there are written
  4    an increment could not be solved; results up to there are written
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); results up to there are written";

/// Granular contact dynamics with elastic bonds: runs scenes written in RON.
#[derive(Parser)]
#[command(version, after_help = EXAMPLES, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and write its results
    #[command(after_help = EXAMPLES)]
    Run(RunArgs),
    /// Continue a run that was interrupted, killed or stalled, or extend one that has ended
    Resume(ResumeArgs),
    /// Read a scene and report everything that is wrong with it
    Check(SceneArgs),
    /// List the scenes that have a name: those in ./scenes and those that clastic ships
    List,
    /// Print a commented scene to start from
    New {
        /// A rig, or a scene that clastic ships; without it the names of the rigs
        name: Option<String>,
    },
    /// Make the runs of a study, several at once, and write one table
    Sweep(SweepArgs),
    /// Find the strength at several confining stresses: a command of the package for Python
    /// (docs/studies.md)
    #[command(disable_help_flag = true)]
    Envelope(OfPython),
    /// Find the factor at which slopes slide: a command of the package for Python (docs/python.md)
    #[command(disable_help_flag = true)]
    Stability(OfPython),
    /// Write the frames of a run for ParaView, as VTK XML (.vtp) with series (.pvd)
    Export(export::ExportArgs),
    /// Write a page for a browser: curves, animation and key results of a run, or curves and a
    /// table of several runs, which is printed too
    #[cfg(feature = "report")]
    Report {
        /// Directories of runs, or of studies with all their runs
        #[arg(required = true, value_name = "DIR")]
        runs: Vec<PathBuf>,
        /// The page [default: DIR/report.html of one run, runs/report.html of several]
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

/// Arguments of a sweep.
#[derive(Args)]
struct SweepArgs {
    /// The study, a RON file (see docs/studies.md)
    study: PathBuf,
    /// Directory for the runs and the table [default: runs/<name of the study>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Maximum number of simultaneous runs [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    jobs: Option<u32>,
    /// Make only the Nth run of the study, as a task of a job array does
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    only: Option<u32>,
    /// Make no run; write the table of the existing runs
    #[arg(long, conflicts_with = "only")]
    collect: bool,
    /// Print a job array for a cluster and make no run
    #[arg(long, value_name = "FORM", conflicts_with_all = ["only", "collect"])]
    emit: Option<Emit>,
    /// Show no progress, only the result
    #[arg(short, long)]
    quiet: bool,
}

/// Arguments of a command of the package for Python.
#[derive(Args)]
struct OfPython {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<OsString>,
}

impl OfPython {
    /// Where the command is.
    fn refuse(self, command: &str) -> Result<Exit, exit::Failure> {
        let message = format!(
            "`clastic {command}` is a command of the package for Python: `pip install './python[all]'`, and \
             then `clastic {command} --help` of that environment; docs/python.md has the rest"
        );
        Err(exit::Failure::new(Exit::Usage, message))
    }
}

/// Batch systems that a sweep can write jobs for.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Emit {
    /// A job array for `sbatch` of Slurm
    Slurm,
}

/// Arguments that name a scene and its settings.
#[derive(Args)]
struct SceneArgs {
    /// A scene file, or the name of a scene in ./scenes or of one that clastic ships
    scene: PathBuf,
    /// Set a field of the scene, e.g. --set stages[0].increments=10; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    sets: Vec<String>,
}

#[derive(Args)]
struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Directory for the results [default: runs/<name of the scene>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite the results of an earlier run
    #[arg(long)]
    force: bool,
    /// Write the cone program and solution of an increment as JSON; may be repeated. N counts the
    /// increments of the run, as the column `increment` of the history does; STAGE:N those of a
    /// stage, as `record.frames` does
    #[arg(long = "dump-program", value_name = "[STAGE:]N", value_parser = dump_at)]
    dump_programs: Vec<DumpAt>,
    #[command(flatten)]
    output: OutputArgs,
}

/// An increment whose program is dumped, from 1: of a stage, or without one of the run.
type DumpAt = (Option<String>, u64);

fn dump_at(text: &str) -> Result<DumpAt, String> {
    let (stage, number) = match text.rsplit_once(':') {
        Some((stage, number)) => (Some(stage.to_owned()), number),
        None => (None, text),
    };
    let increment = number.parse().ok().filter(|n| *n > 0);
    Ok((stage, increment.ok_or("write N or STAGE:N, with N a whole number from 1")?))
}

#[derive(Args)]
struct ResumeArgs {
    /// Directory of the run
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Set a field of the scene for the rest of the run, e.g. --set acceptance.turn=0.5; may be
    /// repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    sets: Vec<String>,
    /// Continue with this scene: that of the run, with other or additional stages after the present
    /// one
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Options of the output and of the threads.
#[derive(Args)]
struct OutputArgs {
    /// Write a checkpoint after every N increments, for `clastic resume` [default of resume: as
    /// before]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    checkpoint_every: Option<u32>,
    /// Maximum number of threads; results do not depend on it [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Show no progress, only the result
    #[arg(short, long)]
    quiet: bool,
}

/// Runs the `clastic` program with further plugins; `()` for none. The arguments are those of the
/// process.
pub fn main<M>(plugins: impl Plugins<M> + Send) -> ExitCode {
    call(&[], env::args_os(), plugins).into()
}

/// Runs the command line with these arguments, of which the first is the name of the program. Wrong
/// arguments end the process. `words` begin this command line in another process, in which studies
/// make their runs: none where the executable of this process does, unlike an interpreter.
pub fn call<M, T: Into<OsString> + Clone>(
    words: &[OsString],
    arguments: impl IntoIterator<Item = T>,
    plugins: impl Plugins<M> + Send,
) -> Exit {
    // An app cannot change threads.
    let program = || app(plugins);
    let done = match Cli::parse_from(arguments).command {
        Command::Run(args) => on_threads(args.output.threads, || run::run(&args, program())),
        Command::Resume(args) => {
            on_threads(args.output.threads, || resume::resume(&args, program()))
        }
        Command::Check(args) => check::check(&args, &program()),
        Command::List => resolve::list(),
        Command::New { name } => new::new(name.as_deref()),
        Command::Sweep(args) => sweep::sweep(&args, words, &program()),
        Command::Envelope(args) => args.refuse("envelope"),
        Command::Stability(args) => args.refuse("stability"),
        Command::Export(args) => export::export(&args),
        #[cfg(feature = "report")]
        Command::Report { runs, out } => report::report(&runs, out),
    };
    done.unwrap_or_else(|failure| {
        exit::complain(&failure.message);
        failure.exit
    })
}
