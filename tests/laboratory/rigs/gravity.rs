//! Tests under gravity: deposition in a container, and banks that lose their wall.

use super::{Cement, cell, compact, load};
use crate::common::random::Random;
use crate::sample::{Sample, digits};
use crate::scenes::Rig;

/// Acceleration of gravity, m/s².
pub const G: f64 = 9.81;
/// Default density of grains, kg/m³.
const DENSITY: f64 = 2650.0;
/// Increments of a static stage under gravity.
const SETTLE: u32 = 10;

/// Grains fall into a container, or a loose packing settles statically under its weight.
pub fn deposition(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let width = sample.width(random.pick(&[0.5, 1.0, 1.5]));
    let (specimen, top) = sample.packing(width, seed);
    let mut rig = Rig {
        material: format!("contact: {}", grains(sample, sample.height(width), random)),
        specimen,
        ..Rig::default()
    };
    let law = sample.law(None, sample.platen, 0.0);
    rig.walls = cell(width, top, &law);
    if random.chance(0.6) {
        rig.title = format!("{} disks poured into a container", sample.count);
        rig.settings = vec![weight(), dynamic(sample)];
        rig.walls.remove(1);
        let stop = format!("stop: [Rest({:?})]", slow(sample));
        rig.stages = vec![load("pour", fall(sample, top), &[], &stop)];
    } else {
        rig.title = format!("Settling of {} disks", sample.count);
        rig.stages = vec![compact(sample, seed)];
        rig.stages.extend(weigh(random));
    }
    rig
}

/// A gate retains a bank. The gate is removed at once (dynamic), or its force is reduced to zero
/// (static). The static bank is of sand or of cemented sand; the gate of cemented sand is removed
/// at the end.
pub fn slope(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let width = sample.width(random.pick(&[0.7, 1.0, 2.0]));
    let height = sample.height(width);
    let (specimen, top) = sample.packing(width, seed);
    let mut rig = Rig { specimen, ..Rig::default() };
    // The floor is as rough as the grains.
    rig.walls = [
        &cell(width, top, &sample.law(None, sample.friction, 0.0))[..1],
        &cell(width, top, &sample.law(None, sample.platen, 0.0))[1..],
    ]
    .concat();
    rig.material = format!("contact: {}", grains(sample, height, random));
    let lid = "remove_walls: [\"top\"]";
    let gate = "remove_walls: [\"right\"]";
    match random.below(3) {
        0 => {
            rig.title = format!("Collapse of a bank of {} disks", sample.count);
            rig.settings = vec![weight(), dynamic(sample)];
            rig.stages = vec![
                compact(sample, seed),
                load("settle", 50, &[], lid),
                load("release", 250, &[], gate),
            ];
        }
        1 => {
            rig.title = format!("Active earth pressure of {} disks", sample.count);
            rig.stages = vec![compact(sample, seed)];
            rig.stages.extend(weigh(random));
            rig.stages.push(load("relieve", 20, &["\"right\": Force(0.0)".to_owned()], ""));
        }
        _ => {
            let mut cement = Cement::draw(sample, random);
            // Between a bank that falls and one that stands.
            let strength = digits(DENSITY * G * height * random.pick(&[0.2, 1.0, 5.0]), 2);
            let stiffness = digits(1e3 * DENSITY * G * height, 2);
            cement.law = format!(
                "(normal_stiffness: {stiffness:?}, tangential_stiffness: {:?}, friction: {:?}, cohesion: {:?}, \
                 tensile_strength: {strength:?})",
                digits(0.5 * stiffness, 2),
                sample.friction,
                2.0 * strength
            );
            rig.title = format!("Bank of {} cemented disks", sample.count);
            rig.settings = cement.settings();
            let contact = sample.law(Some(stiffness), sample.friction, sample.rolling);
            rig.material = format!("contact: {contact}, bond: {}", cement.law);
            rig.stages = vec![compact(sample, seed), cement.stage()];
            rig.stages.extend(weigh(random));
            rig.stages.push(load("relieve", 20, &["\"right\": Force(0.0)".to_owned()], ""));
            rig.stages.push(load("stand", 5, &[], gate));
        }
    }
    rig
}

/// Stages that remove the lid and apply gravity: at once, or as a tenth, a third and all of it.
fn weigh(random: &mut Random) -> Vec<String> {
    let stage = |name: &str, share: f64, more: &str| {
        load(name, SETTLE, &[], &format!("gravity: (0.0, {:?}){more}", -digits(share * G, 3)))
    };
    let lid = ", remove_walls: [\"top\"]";
    if random.chance(0.5) {
        vec![stage("settle", 1.0, lid)]
    } else {
        vec![stage("a tenth", 0.1, lid), stage("a third", 0.33, ""), stage("settle", 1.0, "")]
    }
}

/// Contact law of rigid grains, or of elastic grains that the weight of the bed compresses by at
/// most a thousandth of their diameter.
fn grains(sample: &Sample, height: f64, random: &mut Random) -> String {
    let stiffness = 1e3 * DENSITY * G * height;
    let stiffness = random.maybe(0.5, |r| digits(stiffness * r.decades(1.0, 100.0), 2));
    sample.law(stiffness, sample.friction, sample.rolling)
}

/// Gravity of a scene.
pub fn weight() -> String {
    format!("gravity: (0.0, {:?})", -G)
}

/// Time step of a dynamic scene, s: about 6 % of the time in which a grain falls by its radius.
pub fn time_step(sample: &Sample) -> f64 {
    digits(0.09 * (sample.radius / G).sqrt(), 2)
}

/// Analysis of a dynamic scene.
pub fn dynamic(sample: &Sample) -> String {
    format!("analysis: Dynamic(dt: {:?}, theta: 1.0)", time_step(sample))
}

/// A speed that counts as rest, m/s.
pub fn slow(sample: &Sample) -> f64 {
    digits(0.01 * (2.0 * G * sample.radius).sqrt(), 2)
}

/// Number of increments in which grains fall from a height (m) and come to rest.
pub fn fall(sample: &Sample, height: f64) -> u32 {
    let time = 1.5 * (2.0 * height / G).sqrt() / time_step(sample);
    10 * ((time / 10.0).ceil() as u32 + 4)
}
