//! Runs scenes, several at the same time, smaller ones first.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::run::stages::Script;
use clastic::run::{Simulation, Step};

use crate::common;
use crate::scenes::{Kind, Plan};
use crate::table;
use crate::verdict::{Verdict, check_collapse};

/// Maximum number of solves of a scene. A scene that needs more counts as undecided. The limit is a
/// count and not a time, so that the verdict is the same on every machine.
const MAX_SOLVES: u64 = 20_000;

/// How a scene ended, and its numbers.
#[derive(Clone, Debug)]
pub struct Report {
    pub seed: u64,
    pub kind: Kind,
    pub disks: u32,
    pub porosity: f64,
    pub coulomb: bool,
    pub verdict: Verdict,
    /// The last stage that began.
    pub stage: String,
    pub increments: u64,
    pub capped: u64,
    pub solves: u64,
    pub motion_steps: u64,
    pub seconds: f64,
}

/// Runs all scenes and prints a line when one ends. The reports have the order of the plans.
pub fn all(plans: &[Plan], threads: usize) -> Vec<Report> {
    let mut order: Vec<usize> = (0..plans.len()).collect();
    order.sort_by_key(|k| (plans[*k].sample.count, plans[*k].seed));
    let next = AtomicUsize::new(0);
    let reports = Mutex::new(vec![None; plans.len()]);
    table::print_heading();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, plans.len().max(1)) {
            scope.spawn(|| {
                // One thread a scene: its time does not depend on what the others do.
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
                while let Some(k) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let report = pool.install(|| one(&plans[*k]));
                    table::print_line(&report);
                    reports.lock().unwrap()[*k] = Some(report);
                }
            });
        }
    });
    reports.into_inner().unwrap().into_iter().flatten().collect()
}

/// Runs a scene. A panic is reported as a wrong result.
fn one(plan: &Plan) -> Report {
    let start = Instant::now();
    let mut report = Report {
        seed: plan.seed,
        kind: plan.kind,
        disks: plan.sample.count,
        porosity: plan.sample.porosity,
        coulomb: plan.sample.coulomb,
        verdict: Verdict::Complete,
        stage: String::new(),
        increments: 0,
        capped: 0,
        solves: 0,
        motion_steps: 0,
        seconds: 0.0,
    };
    let verdict = catch_unwind(AssertUnwindSafe(|| follow(plan, &mut report)));
    report.verdict = verdict.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Verdict::Wrong(format!("panic: {}", text.unwrap_or("without words")))
    });
    report.seconds = start.elapsed().as_secs_f64();
    report
}

/// Runs a scene to its end, and adds its numbers to the report.
fn follow(plan: &Plan, report: &mut Report) -> Verdict {
    let scene = common::parse(&plan.text);
    let mut simulation = Simulation::new(&scene, None);
    let mut proofs = Vec::new();
    loop {
        match simulation.step() {
            Step::Finished(outcome) => return Verdict::of(plan.kind, &outcome, &proofs),
            Step::Increment => {
                let record = simulation.world().resource::<Observation>();
                let status = record.status;
                report.increments += 1;
                report.capped += u64::from(status == IncrementStatus::Capped);
                report.solves += u64::from(record.solves);
                report.motion_steps += u64::from(record.motion_steps);
                let ends = &simulation.world().resource::<Script>().ends;
                report.stage = ends.last().map_or(String::new(), |end| end.stage.clone());
                if status == IncrementStatus::Collapsed {
                    match check_collapse(&mut simulation) {
                        Ok(proof) => proofs.push(proof),
                        Err(error) => {
                            return Verdict::Wrong(format!(
                                "the proof of a collapse fails: {error}"
                            ));
                        }
                    }
                }
                if report.solves > MAX_SOLVES {
                    return Verdict::Undecided(format!("more than {MAX_SOLVES} solves"));
                }
            }
        }
    }
}
