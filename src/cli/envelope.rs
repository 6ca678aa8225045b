//! `clastic envelope`: the strength of a scene at several confining stresses, and its envelopes.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use bevy_app::App;

use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use crate::output::csv_file::Row;
use crate::output::directory::{self, default_directory};
use crate::output::marks::marks;
use crate::output::read_history::History;
use crate::study::means::Spread;
use crate::study::strength::{HoekBrown, MohrCoulomb, Strength};
use crate::study::{Study, plan, table};

use super::EnvelopeArgs;
use super::exit::{Exit, Failure, say};
use super::sweep::{self, Sweep, collect, jobs};

/// Name of the confining stress among the settings of the study.
const CONFINING: &str = "confining";
/// Field that is the confining stress unless `--field` names others.
pub const DEFAULT_FIELD: &str = "let.confining";
/// Name of the seed.
const SEED: &str = "seed";

/// Makes the runs, prints the envelopes, and writes the table of peaks.
pub fn envelope(args: &EnvelopeArgs, words: &[OsString], app: &App) -> Result<Exit, Failure> {
    let sweep = study(args, app)?;
    fs::create_dir_all(&sweep.folder).map_err(OutputError::at(&sweep.folder))?;
    let all: Vec<_> = (0..sweep.plan.runs.len()).collect();
    let interrupted = jobs::run_all(&sweep, words, &all, args.jobs, args.quiet)?;
    let exit = collect::collect(&sweep)?;
    if interrupted {
        return Ok(Exit::Interrupted);
    }
    let points = points(&sweep);
    report(&sweep, &points)?;
    Ok(exit)
}

/// The runs: every confining stress with every seed.
fn study(args: &EnvelopeArgs, app: &App) -> Result<Sweep, Failure> {
    if args.confining.iter().all(|stress| *stress == args.confining[0]) {
        let message =
            "--confining: an envelope needs two confining stresses or more, as in 0,5e6,10e6";
        return Err(Failure { exit: Exit::Usage, message: message.to_owned() });
    }
    let list = |values: &[f64]| {
        let values: Vec<_> = values.iter().map(|value| format!("{value:?}")).collect();
        values.join(", ")
    };
    let quoted = |fields: &[String]| {
        let fields: Vec<_> = fields.iter().map(|field| format!("{field:?}")).collect();
        fields.join(", ")
    };
    let mut settings = format!("\"{CONFINING}\": [{}]", quoted(&args.fields));
    let mut axes = format!("\"{CONFINING}\": [{}]", list(&args.confining));
    let mut of_preparation = String::new();
    if !args.seeds.is_empty() {
        let seeds: Vec<_> = args.seeds.iter().map(u64::to_string).collect();
        axes += &format!(", \"{SEED}\": [{}]", seeds.join(", "));
        let of_seed = format!("\"{SEED}\": [{}]", quoted(&args.seed_fields));
        match &args.prepare {
            Some(_) => of_preparation = of_seed,
            None => settings += &format!(", {of_seed}"),
        }
    }
    let prepare = args.prepare.as_ref().map_or(String::new(), |scene| {
        format!("prepare: (scene: {scene:?}, settings: {{ {of_preparation} }}),")
    });
    let text = format!(
        "(version: 1, title: {:?}, scene: {:?}, {prepare} set: [{}], settings: {{ {settings} }}, \
         runs: Grid({{ {axes} }}))",
        format!("strength of {}", args.scene.display()),
        args.scene,
        quoted(&args.sets),
    );
    let name = PathBuf::from(format!(
        "{}_envelope",
        args.scene.file_stem().unwrap_or(args.scene.as_os_str()).to_string_lossy()
    ));
    let study = Study::read(&text, &args.scene)?;
    let plan = plan(&study, &args.scene, |wanted| {
        let is_prepared = args.prepare.as_deref() == Some(wanted.scene);
        sweep::load(wanted, Path::new(""), app)
            .map_err(|error| if is_prepared { error } else { with_field(error, args) })
    })?;
    let folder = args.out.clone().unwrap_or_else(|| default_directory(&name));
    Ok(Sweep { title: study.title, plan, average_over: study.average_over, folder })
}

/// An error of the scene, with what to do if it is that the default field is not there.
fn with_field(error: String, args: &EnvelopeArgs) -> String {
    let is_default = args.fields == [DEFAULT_FIELD];
    if !(is_default && error.contains(DEFAULT_FIELD)) {
        return error;
    }
    format!(
        "{error}\nwrite the confining stress of the scene once, as a value `{CONFINING}` of `let`, or \
         name the fields that are the confining stress with --field"
    )
}

/// A run that has a peak.
struct Point {
    seed: String,
    /// Whether the peak is in the last row of the history.
    is_last: bool,
    strength: Strength,
}

/// The strengths of the runs that ended as planned and have a peak.
fn points(sweep: &Sweep) -> Vec<Point> {
    let records = table::records(&sweep.plan, &sweep.folder);
    let runs = sweep.plan.runs.iter().zip(&records);
    runs.filter_map(|(run, record)| {
        let status = record["outcome"]["status"].as_str()?;
        let peak = record["results"]["peak_stress_pa"].as_f64()?;
        matches!(status, "completed" | "collapsed").then_some(())?;
        let confining = run.values.first()?.parse().ok()?;
        let seed = run.values.get(1).cloned().unwrap_or_default();
        let history = sweep.folder.join(&run.directory).join(directory::HISTORY);
        let curve = History::read(&history).ok()?.points("axial_strain", "axial_stress_pa");
        let is_last = curve.last().is_some_and(|(_, stress)| *stress == peak);
        Some(Point { seed, is_last, strength: Strength { confining, peak } })
    })
    .collect()
}

/// A fitted quantity: its name, unit, factor to that unit, and digits.
type Quantity = (&'static str, &'static str, f64, usize);

const QUANTITIES: [Quantity; 4] = [
    ("c", "MPa", 1e-6, 4),
    ("phi", "degrees", 1.0, 2),
    ("sigma_ci", "MPa", 1e-6, 3),
    ("m_i", "", 1.0, 2),
];

/// c, phi, sigma_ci and m_i of some strengths, or the reasons why they do not exist.
fn fitted(strengths: &[Strength]) -> [Result<f64, &'static str>; 4] {
    let line = MohrCoulomb::fit(strengths);
    let rock = HoekBrown::fit(strengths);
    [
        line.map(|fit| fit.cohesion),
        line.map(|fit| fit.friction_angle),
        rock.map(|fit| fit.strength),
        rock.map(|fit| fit.m),
    ]
}

fn report(sweep: &Sweep, points: &[Point]) -> Result<(), Failure> {
    let strengths: Vec<_> = points.iter().map(|point| point.strength).collect();
    let left_out = sweep.plan.runs.len() - points.len();
    if left_out > 0 {
        say(format_args!(
            "{left_out} runs without a peak are left out of the envelopes (see `marks`)"
        ))?;
    }
    let records = table::records(&sweep.plan, &sweep.folder);
    let uncertain = records.iter().filter(|record| {
        record["results"]["peak_stress_pa"].is_number() && !marks(record).is_empty()
    });
    let uncertain = uncertain.count();
    if uncertain > 0 {
        say(format_args!("the envelopes include {uncertain} runs with marks"))?;
    }
    let last = points.iter().filter(|point| point.is_last).count();
    if last > 0 {
        say(format_args!(
            "WARNING: in {last} runs the stress is at its maximum in the last increment, and may rise further; \
             give more increments"
        ))?;
    }
    if points.is_empty() {
        say(format_args!(
            "no run has a peak, so that there is no envelope; the `outcome` of each run says why. A packing that jams \
             does so at every confining stress: `--prepare SCENE` makes it once"
        ))?;
        return write(sweep, points);
    }
    let mut by_seed: BTreeMap<&str, Vec<Strength>> = BTreeMap::new();
    for point in points {
        by_seed.entry(&point.seed).or_default().push(point.strength);
    }
    let of_seeds: Vec<_> = by_seed.values().map(|strengths| fitted(strengths)).collect();
    let all = fitted(&strengths);
    let range = strengths.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
        (low.min(s.confining), high.max(s.confining))
    });
    say(format_args!(
        "envelopes of {} peaks at confining stresses from {} to {} MPa, least squares of sigma_1:",
        strengths.len(),
        megapascals(range.0),
        megapascals(range.1)
    ))?;
    for (k, (name, unit, factor, digits)) in QUANTITIES.into_iter().enumerate() {
        let value = match all[k] {
            Ok(value) => value,
            Err(reason) => {
                say(format_args!("  {name:9} not defined: {reason}"))?;
                continue;
            }
        };
        let seeds: Vec<f64> = of_seeds.iter().filter_map(|fit| fit[k].ok()).collect();
        let scatter = Spread::of(&seeds).deviation.map_or(String::new(), |s| {
            format!(", standard deviation over {} seeds {:.digits$}", seeds.len(), factor * s)
        });
        say(format_args!("  {name:9} {:.digits$} {unit}{scatter}", factor * value))?;
    }
    write(sweep, points)
}

/// A stress in MPa without digits of round-off.
fn megapascals(stress: f64) -> f64 {
    format!("{:.9e}", 1e-6 * stress).parse().unwrap_or(f64::NAN)
}

fn write(sweep: &Sweep, points: &[Point]) -> Result<(), Failure> {
    let path: &Path = &sweep.folder.join("envelope.csv");
    let header = ["seed", "confining_pa", "peak_pa"];
    let mut text = header.iter().fold(Row::default(), |row, name| row.text(name)).line();
    for Point { seed, strength, .. } in points {
        text += &Row::default().text(seed).numbers([strength.confining, strength.peak]).line();
    }
    write_atomic(path, text)?;
    say(format_args!("written: {}", path.display()))
}
