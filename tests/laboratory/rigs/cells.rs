//! Boxes of four walls: biaxial, oedometric and isotropic compression.

use super::{Cement, box_measures, cell, compact, load, stress};
use crate::common::random::Random;
use crate::sample::{Sample, digits, pascal};
use crate::scenes::Rig;

/// Increments of a confining stage.
const CONFINE: u32 = 20;

/// Low, medium and high confinement, as multiples of the stress that suits the stiffness.
const CONFINEMENTS: [f64; 3] = [0.3, 1.0, 2.0];

/// Biaxial compression of sand.
pub fn biaxial(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    // Four seeds of twenty are biaxial: the confinement changes with every one of them.
    let confinement = sample.stress(CONFINEMENTS[(seed / 2 % 3) as usize]);
    let width = sample.width(random.pick(&[1.5, 2.0]));
    let strain = random.pick(&[0.02, 0.03, 0.05]);
    let stages = vec![confine(confinement, random), shear(sample, width, strain, random)];
    let mut rig = sand(sample, seed, "Biaxial compression", width, stages);
    rig.title += &format!(", {}", pascal(confinement));
    rig
}

/// Biaxial compression of cemented sand, confined by half to twice its tensile strength.
pub fn cemented_biaxial(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let cement = Cement::draw(sample, random);
    let confinement = digits(cement.tension * [0.5, 1.0, 2.0][(seed / 2 % 3) as usize], 2);
    let width = sample.width(random.pick(&[1.5, 2.0]));
    let strain = random.pick(&[0.01, 0.02, 0.03]);
    let stages =
        vec![cement.stage(), confine(confinement, random), shear(sample, width, strain, random)];
    let mut rig = sand(sample, seed, "Biaxial compression of cemented sand", width, stages);
    rig.title += &format!(", {}", pascal(confinement));
    rig.settings = cement.settings();
    rig.material = cement.material(sample);
    rig
}

/// Oedometer test: the top loads and unloads the specimen between fixed side walls.
pub fn oedometer(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let first = sample.stress(0.3);
    let width = sample.width(random.pick(&[0.5, 1.0]));
    let mut stages = vec![load("load", CONFINE, &[stress("top", first)], "")];
    if random.chance(0.6) {
        let second = sample.stress(1.5);
        stages.push(load("load further", 40, &[stress("top", second)], ""));
        stages.push(load("unload", 20, &[stress("top", first)], ""));
    } else {
        // Compressed by displacement: twice the strain that the stress above would bring about.
        let step = digits(4.0 * sample.strain * sample.height(width) / 40.0, 3);
        stages.push(load(
            "load further",
            40,
            &[format!("\"top\": Displacement(0.0, {:?})", -step)],
            "",
        ));
        let back = format!("\"top\": Displacement(0.0, {:?})", digits(0.25 * step, 3));
        stages.push(load("unload", 20, &[back], ""));
    }
    let mut rig = sand(sample, seed, "Oedometer test", width, stages);
    rig.settings.push("reference_stage: \"load\"".to_owned());
    rig
}

/// Isotropic compression in two stages, and unloading.
pub fn isotropic(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let width = sample.width(random.pick(&[1.0, 1.5]));
    let first = sample.stress(0.3);
    let second = sample.stress(random.pick(&[1.0, 2.0]));
    let all = |s: f64| ["top", "left", "right"].map(|wall| stress(wall, s));
    let stages = vec![
        load("confine", CONFINE, &all(first), ""),
        load("compress", 40, &all(second), ""),
        load("unload", 20, &all(first), ""),
    ];
    let mut rig = sand(sample, seed, "Isotropic compression", width, stages);
    rig.settings.push("reference_stage: \"confine\"".to_owned());
    rig
}

/// Confining stage. All four walls are under stress, or the bottom is fixed.
fn confine(confinement: f64, random: &mut Random) -> String {
    let mut walls = vec!["top", "left", "right"];
    if random.chance(0.5) {
        walls.push("bottom");
    }
    let controls: Vec<_> = walls.iter().map(|wall| stress(wall, confinement)).collect();
    load("confine", CONFINE, &controls, "")
}

/// Shearing stage. The top moves down by the axial strain while the side walls keep their stress.
fn shear(sample: &Sample, width: f64, strain: f64, random: &mut Random) -> String {
    let increments: u32 = random.pick(&[40, 60, 100]);
    let step = digits(strain * sample.height(width) / f64::from(increments), 3);
    let controls =
        ["\"bottom\": Fixed".to_owned(), format!("\"top\": Displacement(0.0, {:?})", -step)];
    let stop = if random.chance(0.3) {
        format!("stop: [Above(\"axial_strain\", {:?})]", 0.8 * strain)
    } else {
        String::new()
    };
    load("shear", increments, &controls, &stop)
}

/// Sand in a box. `stages` follow the compaction.
fn sand(sample: &Sample, seed: u64, test: &str, width: f64, stages: Vec<String>) -> Rig {
    let (specimen, height) = sample.packing(width, seed);
    Rig {
        title: format!("{test}, {} disks", sample.count),
        material: format!("contact: {}", sample.grains()),
        specimen,
        walls: cell(width, height, &sample.walls()),
        stages: [vec![compact(sample, seed)], stages].concat(),
        measures: box_measures(),
        ..Rig::default()
    }
}
