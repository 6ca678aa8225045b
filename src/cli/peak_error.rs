//! Warning about a peak that depends on the size of the increments.

use crate::run::key_results::{PEAK_ERROR, Results};
use crate::scene::format::{RuptureOrder, Scene};
use crate::scene::one_round::one_round;

/// The warning, with what helps under the rule by which bonds broke.
pub(super) fn peak_error(scene: &Scene, results: &Results) -> Option<String> {
    let estimate = results.peak_error_estimate.filter(|e| *e > PEAK_ERROR)?;
    results.peak_stress_pa?;
    let events = scene.rupture.order == RuptureOrder::Events;
    let (why, remedy) = if events && one_round(scene).is_none() {
        (
            "many bonds broke together at the end of an increment",
            "let each bond break at its own load, `rupture: (density: 21.0, brittleness: 0.0)`, \
             which takes several solves a bond",
        )
    } else if events {
        ("bonds broke late", "remove the reason for which `Events` does not hold here")
    } else {
        (
            "bonds broke late",
            "`rupture: (order: Events)` (it holds for static stages and elastic bonds with strength that \
             do not break in rolling)",
        )
    };
    Some(format!(
        "WARNING: the peak depends on the size of the increments, by about {:.0} %: {why}; give smaller \
         increments, or {remedy}",
        100.0 * estimate
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warning(rupture: &str) -> String {
        let text = include_str!("../../scenes/uniaxial_small.ron");
        assert!(text.contains("rupture: (order: OneRound)"));
        let text = text.replacen("rupture: (order: OneRound)", &format!("rupture: {rupture}"), 1);
        let scene =
            crate::scene::from_str(&text, "s.ron".as_ref(), ".".as_ref(), &[]).unwrap().scene;
        let results = Results {
            peak_stress_pa: Some(1e6),
            peak_error_estimate: Some(0.03),
            ..Results::default()
        };
        peak_error(&scene, &results).unwrap()
    }

    #[test]
    fn the_warning_of_a_peak_does_not_advise_the_order_that_is_in_use() {
        let of_events = warning("(order: Events, rolling: Yields)");
        assert!(!of_events.contains("order: Events"), "{of_events}");
        assert!(of_events.contains("density: 21.0, brittleness: 0.0"), "{of_events}");
        assert!(warning("(order: OneRound)").contains("rupture: (order: Events)"));
    }
}
