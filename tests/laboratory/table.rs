//! Output: a line for every scene, and a table of all scenes.

use std::collections::BTreeMap;

use crate::run::Report;
use crate::scenes::{KINDS, Kind};
use crate::verdict::Verdict;

/// Prints the heading of the lines.
pub fn print_heading() {
    println!(
        "{:<16} {:>4} {:>5} {:>8} {:<10} {:<9} {:<13} {:>10} {:>6} {:>6} {:>7} {:>8}",
        "kind",
        "seed",
        "disks",
        "porosity",
        "law",
        "outcome",
        "stage",
        "increments",
        "capped",
        "solves",
        "moved",
        "seconds"
    );
}

/// Prints the line of a scene, with the reason of a failure at its end.
pub fn print_line(r: &Report) {
    println!(
        "{:<16} {:>4} {:>5} {:>8.3} {:<10} {:<9} {:<13} {:>10} {:>6} {:>6} {:>7} {:>8.1}  {}",
        r.kind.name(),
        r.seed,
        r.disks,
        r.porosity,
        if r.coulomb { "Coulomb" } else { "associated" },
        r.verdict.name(),
        r.stage,
        r.increments,
        r.capped,
        r.solves,
        r.motion_steps,
        r.seconds,
        r.verdict.reason()
    );
}

/// Prints the table by kinds. Its last column is the maximum time of a scene over the median time
/// of its kind and size.
pub fn print(reports: &[Report]) {
    println!(
        "\n| kind | complete | of | of these collapsed, proved | by motion | while confined | undecided | wrong | \
         increments | capped | median, s | maximum, s | slowest / median |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for kind in KINDS {
        let of_kind: Vec<&Report> = reports.iter().filter(|r| r.kind == kind).collect();
        if !of_kind.is_empty() {
            print_row(kind.name(), &of_kind);
        }
    }
    print_row("all", &reports.iter().collect::<Vec<_>>());
    let slow: Vec<String> = outliers(reports)
        .into_iter()
        .filter(|(_, ratio)| *ratio > 5.0)
        .map(|(seed, ratio)| format!("{seed} ({ratio:.1})"))
        .collect();
    println!("more than five times the median of its kind and size: seeds {}", slow.join(", "));
}

fn print_row(name: &str, reports: &[&Report]) {
    let count =
        |wanted: fn(&Verdict) -> bool| reports.iter().filter(|r| wanted(&r.verdict)).count();
    let sum = |of: fn(&Report) -> u64| reports.iter().map(|r| of(r)).sum::<u64>();
    let seconds: Vec<f64> = reports.iter().map(|r| r.seconds).collect();
    let owned: Vec<Report> = reports.iter().map(|r| (*r).clone()).collect();
    let ratio = outliers(&owned).into_iter().map(|(_, ratio)| ratio).fold(0.0, f64::max);
    println!(
        "| {name} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1} | {:.1} | {ratio:.1} |",
        count(|v| !v.is_failure()),
        reports.len(),
        count(|v| *v == Verdict::Collapsed { proved: true }),
        count(|v| *v == Verdict::Collapsed { proved: false }),
        count(|v| matches!(v, Verdict::Confined(_))),
        count(|v| matches!(v, Verdict::Undecided(_))),
        count(|v| matches!(v, Verdict::Wrong(_))),
        sum(|r| r.increments),
        sum(|r| r.capped),
        median(&seconds),
        seconds.iter().copied().fold(0.0, f64::max),
    );
}

/// Seed of every scene, with its time over the median time of its kind and size (up to 300, up to
/// 800, or more disks).
fn outliers(reports: &[Report]) -> Vec<(u64, f64)> {
    let mut groups: BTreeMap<(Kind, u32), Vec<&Report>> = BTreeMap::new();
    for r in reports {
        let size = if r.disks <= 300 { 0 } else { 1 + u32::from(r.disks > 800) };
        groups.entry((r.kind, size)).or_default().push(r);
    }
    let ratios = groups.values().flat_map(|group| {
        let median = median(&group.iter().map(|r| r.seconds).collect::<Vec<_>>());
        group.iter().map(move |r| (r.seed, r.seconds / median.max(1e-3))).collect::<Vec<_>>()
    });
    ratios.collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}
