//! A hopper of fixed grains. It fills above a plug; the plug is released, and the grains flow onto
//! a floor.

use std::f64::consts::FRAC_PI_2;

use super::disks::{Disk, grain, listed};
use super::gravity::{dynamic, fall, weight};
use super::load;
use crate::common::random::Random;
use crate::sample::{Sample, digits};
use crate::scenes::Rig;

/// Two inclined rows of fixed grains with an outlet between them.
pub fn hopper(sample: &Sample, _seed: u64, random: &mut Random) -> Rig {
    let r = sample.radius;
    let steepness: f64 = FRAC_PI_2 * random.pick(&[0.5, 0.6, 0.7]);
    let outlet = 2.0 * sample.largest * random.pick(&[5.0, 7.0, 9.0]);
    let (sine, cosine) = steepness.sin_cos();
    // Fixed grains are rigid: not so close that rounded places overlap.
    let pitch = 2.02 * r;
    let disks = fill(sample, outlet, steepness, random);
    let top = disks.iter().map(|d| d.y).fold(0.0, f64::max);
    let length = (top / (pitch * sine)).ceil() as u32 + 2;
    let (mut hopper, mut plug) = (Vec::new(), Vec::new());
    for k in 0..length {
        let along = pitch * f64::from(k);
        let (x, y) = (0.5 * outlet + r + along * cosine, along * sine);
        hopper.push(Disk { x, y, radius: r, group: "hopper" });
        hopper.push(Disk { x: -x, y, radius: r, group: "hopper" });
    }
    let grains = (outlet / pitch).floor();
    for k in 0..grains as u32 {
        let x = pitch * (f64::from(k) + 0.5 - 0.5 * grains);
        plug.push(Disk { x, y: 0.0, radius: r, group: "plug" });
    }
    let drop = digits(outlet + 20.0 * r, 3);
    let reach = digits(hopper.last().map_or(outlet, |d| -d.x), 3);
    let hold = |groups: &[&str]| {
        let entries: Vec<String> = groups
            .iter()
            .map(|g| format!("(select: Group({g:?}), x: Held, y: Held, rotation: Held)"))
            .collect();
        format!("particles: [{}]", entries.join(", "))
    };
    let filling = fall(sample, top - outlet.min(0.5 * top));
    // The floor is as rough as the grains.
    let floor = sample.law(None, sample.friction, 0.0);
    Rig {
        title: format!("Hopper with {} disks", sample.count),
        settings: vec![weight(), dynamic(sample)],
        material: format!("contact: {}", sample.law(None, sample.friction, sample.rolling)),
        specimen: listed(&[hopper, plug, disks].concat()),
        walls: vec![format!(
            "(name: \"floor\", start: ({:?}, {:?}), end: ({reach:?}, {:?}), contact: {floor})",
            -reach, -drop, -drop
        )],
        stages: vec![
            load("fill", filling, &[], &hold(&["hopper", "plug"])),
            load("empty", fall(sample, drop) + 100, &[], &hold(&["hopper"])),
        ],
        ..Rig::default()
    }
}

/// Grains on a loose grid between the rows, from just above the plug upwards.
fn fill(sample: &Sample, outlet: f64, steepness: f64, random: &mut Random) -> Vec<Disk> {
    let spacing = sample.spacing();
    let base = sample.radius;
    let mut disks = Vec::new();
    for row in 0.. {
        let low = base + f64::from(row) * spacing;
        // Clear of the fixed grains, measured square to their row.
        let half =
            0.5 * outlet + sample.radius + low / steepness.tan() - sample.radius / steepness.sin();
        let columns = (2.0 * half / spacing).floor();
        for column in 0..columns as u32 {
            if disks.len() == sample.count as usize {
                return disks;
            }
            let x = spacing * (f64::from(column) + 0.5 - 0.5 * columns);
            disks.push(grain(sample, x, low + 0.5 * spacing, random));
        }
    }
    disks
}
