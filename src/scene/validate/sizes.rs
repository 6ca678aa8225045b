//! Distributions of radii.

use crate::scene::format::Sizes;

use super::findings::At;

/// Checks a size distribution. Returns its minimum and maximum radius.
pub(super) fn check_sizes(at: &mut At, sizes: &Sizes) -> Option<(f64, f64)> {
    let what = "a radius in m";
    let fine = match sizes {
        Sizes::Equal { radius } => at.positive("radius", *radius, what),
        Sizes::Uniform { radius } => at.range("radius", *radius, what),
        Sizes::Sieve { passing } => sieve(&mut at.field("passing"), passing),
        &Sizes::LogNormal { radius: median, deviation, limits } => {
            let ranged = at.range("limits", limits, what);
            at.not_negative("deviation", deviation, "a standard deviation of ln(radius)");
            let positive = at.positive("radius", median, what);
            let is_outside = positive && ranged && !(limits.0..=limits.1).contains(&median);
            let message = format!("the median is outside of the limits ({median:?})");
            at.refuse(is_outside, "radius", message, "give a median between the limits");
            ranged
        }
    };
    sizes.limits().filter(|_| fine && at.is_sure(""))
}

fn sieve(at: &mut At, passing: &[(f64, f64)]) -> bool {
    let mut fine = true;
    for (i, (diameter, percent)) in passing.iter().enumerate() {
        let at = &mut at.item("", i);
        fine &= at.positive("[0]", *diameter, "a diameter in m");
        let allowed = |percent| (0.0..=100.0).contains(&percent);
        fine &= at.number("[1]", *percent, allowed, "the per cent by mass that pass, 0 to 100");
    }
    fine && at.is_sure("") && curve(at, passing)
}

/// Checks that the numbers of a sieve curve are those of a curve.
fn curve(at: &mut At, passing: &[(f64, f64)]) -> bool {
    let n = passing.len();
    if n < 2 {
        let help = "give (diameter, per cent) from 0 to 100 %, two points or more";
        at.add("", "a curve of fewer than two points", help);
        return false;
    }
    let ascends = |step: &[(f64, f64)]| step[0].0 < step[1].0 && step[0].1 <= step[1].1;
    if let Some(i) = passing.windows(2).position(|step| !ascends(step)) {
        let (before, here) = (passing[i], passing[i + 1]);
        let message = format!("not above the point before it ({here:?} after {before:?})");
        let help = "order the points by diameter; more per cent pass a larger one";
        at.add(format_args!("[{}]", i + 1), message, help);
        return false;
    }
    let ends = [(0, 1, 0.0, "smallest"), (n - 1, n - 2, 100.0, "largest")];
    for (i, _, wanted, what) in ends {
        let percent = passing[i].1;
        if percent != wanted {
            let message = format!("{percent:?} % pass the {what} diameter");
            let help = format!("begin with 0 % and end with 100 %: give the {what} grain");
            at.add(format_args!("[{i}]"), message, help);
            return false;
        }
    }
    for (i, next, wanted, _) in ends {
        if passing[next].1 == wanted {
            let help = "leave it out: the curve ends at the first 0 % and the first 100 %";
            at.add(format_args!("[{i}]"), "a step without mass at an end", help);
            return false;
        }
    }
    true
}
