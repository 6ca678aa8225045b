//! Distributions of radii.

use std::fmt::Arguments;

use crate::scene::format::Sizes;

use super::findings::Findings;

/// Checks a size distribution. Returns its minimum and maximum radius.
pub(super) fn check_sizes(
    path: Arguments,
    sizes: &Sizes,
    findings: &mut Findings,
) -> Option<(f64, f64)> {
    let radius = format_args!("{path}.radius");
    let what = "a radius in m";
    match sizes {
        Sizes::Equal { radius: r } => findings.positive(radius, *r, what).then_some((*r, *r)),
        Sizes::Uniform { radius: range } => findings.range(radius, *range, what).then_some(*range),
        Sizes::Sieve { passing } => sieve(format_args!("{path}.passing"), passing, findings),
        &Sizes::LogNormal { radius: median, deviation, limits } => {
            let ranged = findings.range(format_args!("{path}.limits"), limits, what);
            findings.not_negative(
                format_args!("{path}.deviation"),
                deviation,
                "a standard deviation of ln(radius)",
            );
            if findings.positive(radius, median, what)
                && ranged
                && !(limits.0..=limits.1).contains(&median)
            {
                let message = format!("the median is outside of the limits ({median:?})");
                findings.add(radius, message, "give a median between the limits");
            }
            ranged.then_some(limits)
        }
    }
}

/// Checks a sieve curve. Returns its minimum and maximum radius.
fn sieve(path: Arguments, passing: &[(f64, f64)], findings: &mut Findings) -> Option<(f64, f64)> {
    let mut fine = true;
    for (i, (diameter, percent)) in passing.iter().enumerate() {
        let what = "a diameter in m";
        fine &= findings.positive(format_args!("{path}[{i}][0]"), *diameter, what);
        let allowed = |percent| (0.0..=100.0).contains(&percent);
        let what = "the per cent by mass that pass, 0 to 100";
        fine &= findings.number(format_args!("{path}[{i}][1]"), *percent, allowed, what);
    }
    if !fine || !findings.is_sure_of_part(path) {
        return None;
    }
    let (Some(first), Some(last)) = (passing.first(), passing.last().filter(|_| passing.len() > 1))
    else {
        let help = "give (diameter, per cent) from 0 to 100 %, two points or more";
        findings.add(path, "a curve of fewer than two points", help);
        return None;
    };
    for (i, step) in passing.windows(2).enumerate() {
        let (before, here) = (step[0], step[1]);
        if here.0 <= before.0 || here.1 < before.1 {
            let message = format!("not above the point before it ({here:?} after {before:?})");
            let help = "order the points by diameter; more per cent pass a larger one";
            findings.add(format_args!("{path}[{}]", i + 1), message, help);
            return None;
        }
    }
    for (i, point, wanted, what) in
        [(0, first, 0.0, "smallest"), (passing.len() - 1, last, 100.0, "largest")]
    {
        if point.1 != wanted {
            let message = format!("{:?} % pass the {what} diameter", point.1);
            let help = format!("begin with 0 % and end with 100 %: give the {what} grain");
            findings.add(format_args!("{path}[{i}]"), message, &help);
            return None;
        }
    }
    let n = passing.len();
    if passing[1].1 == 0.0 || passing[n - 2].1 == 100.0 {
        let i = if passing[1].1 == 0.0 { 0 } else { n - 1 };
        let help = "leave it out: the curve ends at the first 0 % and the first 100 %";
        findings.add(format_args!("{path}[{i}]"), "a step without mass at an end", help);
        return None;
    }
    Some((0.5 * first.0, 0.5 * last.0))
}
