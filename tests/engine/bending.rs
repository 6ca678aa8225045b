//! Slender specimens that bend far without breaking.

use clastic::run::Outcome;

use crate::common::*;

/// A cantilever whose tip moved by more than 0.3 radii counted as collapsed, although its bonds held.
///
/// By hand, with m = 5 joints of the stiffness k_R at (i + 1/2) a from the root: joint i turns by
/// P a (m - i - 1/2)/k_R, and the tip sinks by the sum of P a^2 (m - i - 1/2)^2/k_R, and by m P/k_T in
/// shear. The sine of the turns is neglected, which is 1e-3 of it here.
#[test]
fn a_cantilever_that_bends_far_does_not_collapse_whatever_the_increments() {
    let (m, a, p, k_t, k_r) = (5, 0.1, 500.0, 4.0e8, 2.0e4);
    let joints = (0..m).map(|i| f64::from(m - i) - 0.5);
    let bending: f64 = joints.map(|arm| p * a * a * arm * arm / k_r).sum();
    let sinks = bending + f64::from(m) * p / k_t;
    let disks: String = (0..=m)
        .map(|i| {
            let probe = if i == m { ", probe: \"tip\"" } else { "" };
            format!("(position: ({:?}, 0.0), radius: 0.05{probe}),", a * f64::from(i))
        })
        .collect();
    for increments in [1, 3, 10, 40] {
        let scene = parse(&format!(
            "(
                version: 1,
                title: \"Cantilever of disks\",
                materials: {{ \"a\": (bond: (normal_stiffness: 1.0e9, tangential_stiffness: {k_t:e},
                    rolling_stiffness: {k_r:e}, rolling_friction: 1.0, cohesion: 1.0e9,
                    tensile_strength: 1.0e7)) }},
                specimen: Particles([{disks}]),
                stages: [
                    Cement(name: \"bond\", length: 1.0e-6),
                    Load(name: \"load\", increments: {increments}, particles: [
                        (select: Index([0]), x: Held, y: Held, rotation: Held),
                        (select: Index([{m}]), force: (0.0, {:?})),
                    ]),
                ],
            )",
            -p
        ));
        let (records, outcome) = run(&scene);
        assert_eq!(outcome, Outcome::Completed, "{increments} increments");
        let tip = probe(records.last().unwrap(), "tip").motion[1];
        assert_relative(-tip, sinks, 1e-3);
    }
}

/// Two bars, each a bond of the length L_0 and the stiffness k from a held disk at (±b, 0) to one at (0, h),
/// which carries the load P. At the height y the bars have the length L = sqrt(b^2 + y^2), and
///
/// ```text
/// P(y) = 2 k (L_0/L - 1) y,      maximum where L^3 = L_0 b^2
/// ```
///
/// Just above the maximum the steps of the motion are small at first, and "undecided" was the verdict.
#[test]
fn two_bars_snap_through_just_above_their_limit_load() {
    let (b, k) = (1.0_f64, 1.0e7);
    for h in [0.1_f64, 0.3, 1.0] {
        let rest = b.hypot(h);
        let load = |y: f64| 2.0 * k * (rest / b.hypot(y) - 1.0) * y;
        let highest = (rest * b * b).cbrt();
        let limit = load((highest * highest - b * b).sqrt());
        for (factor, increments) in
            [1.0003, 1.003, 1.01, 1.03].into_iter().flat_map(|f| [(f, 1), (f, 3), (f, 10)])
        {
            let (mut low, mut high) = (-2.0 * h - b, -h);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let is_above = load(middle) > factor * limit;
                *(if is_above { &mut low } else { &mut high }) = middle;
            }
            let scene = parse(&format!(
                "(version: 1, title: \"two bars\",
                  materials: {{ \"bar\": (bond: (normal_stiffness: {k:e}, tangential_stiffness: {k:e},
                      cohesion: 1.0e12, tensile_strength: 1.0e12)) }},
                  specimen: Particles([
                      (position: ({:?}, 0.0), radius: {:?}),
                      (position: (0.0, {h:?}), radius: {:?}, probe: \"top\"),
                      (position: ({b:?}, 0.0), radius: {:?})]),
                  stages: [
                      Cement(name: \"bond\", length: 1.0e-6),
                      Load(name: \"load\", increments: {increments}, particles: [
                          (select: Index([0, 2]), x: Held, y: Held),
                          (select: Index([1]), force: (0.0, {:?}))])])",
                -b,
                0.5 * rest,
                0.5 * rest,
                0.5 * rest,
                -factor * limit
            ));
            let (records, outcome) = run(&scene);
            assert_eq!(outcome, Outcome::Completed, "{h} {factor} {increments}");
            let top = probe(records.last().unwrap(), "top").motion[1];
            assert_relative(h + top, low, 1e-5);
        }
    }
}
