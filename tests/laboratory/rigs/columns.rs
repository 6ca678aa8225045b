//! Bonded columns between platens, without side walls: compression and tension.

use super::{Cement, cell, compact, load, measure};
use crate::common::random::Random;
use crate::sample::{Sample, digits};
use crate::scenes::Rig;

/// Uniaxial compression. Four in five scenes impose a displacement, the others a stress above the
/// strength.
pub fn uniaxial(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let cement = Cement::draw(sample, random);
    let width = sample.width(random.pick(&[1.5, 2.0, 2.5]));
    let height = sample.height(width);
    let increments = random.pick(&[60, 80, 100]);
    let last = if random.chance(0.8) {
        // Bonds of the strongest orientation break in shear at some three times their tensile
        // strain.
        let step = digits(4.0 * cement.strain * height / f64::from(increments), 3);
        let stop = if random.chance(0.3) { ", stop: [StressDrop(0.5)]" } else { "" };
        load(
            "compress",
            increments,
            &[format!("\"top\": Displacement(0.0, {:?})", -step)],
            &format!("remove_walls: [\"left\", \"right\"]{stop}"),
        )
    } else {
        let stress = digits(6.0 * cement.tension, 2);
        load(
            "compress",
            increments,
            &[format!("\"top\": Stress(stress: {stress:?})")],
            "remove_walls: [\"left\", \"right\"]",
        )
    };
    column(sample, seed, "Uniaxial compression", &cement, width, &[cement.stage(), last])
}

/// Direct tension between glued platens. Three in four scenes impose a displacement, the others a
/// stress above the strength.
pub fn tension(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let cement = Cement::draw(sample, random);
    let width = sample.width(random.pick(&[1.0, 1.5, 2.0]));
    let height = sample.height(width);
    let increments = random.pick(&[40, 60, 80]);
    let control = if random.chance(0.75) {
        let step = digits(2.0 * cement.strain * height / f64::from(increments), 3);
        format!("\"top\": Displacement(0.0, {step:?})")
    } else {
        format!("\"top\": Stress(stress: {:?})", -digits(1.5 * cement.tension, 2))
    };
    let last = load("pull", increments, &[control], "remove_walls: [\"left\", \"right\"]");
    let mut rig =
        column(sample, seed, "Direct tension", &cement, width, &[cement.stage_with_walls(), last]);
    for wall in &mut rig.walls[..2] {
        *wall = format!("{}, bond: {})", &wall[..wall.len() - 1], cement.glue);
    }
    rig
}

/// A column that is compacted in a box. `stages` follow the compaction.
fn column(
    sample: &Sample,
    seed: u64,
    test: &str,
    cement: &Cement,
    width: f64,
    stages: &[String],
) -> Rig {
    let (specimen, height) = sample.packing(width, seed);
    Rig {
        title: format!("{test}, {} bonded disks", sample.count),
        settings: cement.settings(),
        material: cement.material(sample),
        specimen,
        walls: cell(width, height, &sample.walls()),
        stages: [&[compact(sample, seed)], stages].concat(),
        measures: vec![
            measure("axial_strain", "Strain(Walls(\"bottom\", \"top\"))"),
            measure(
                "axial_stress",
                &format!("Stress(Walls(walls: [\"bottom\", \"top\"], length: Fixed({width:?})))"),
            ),
        ],
        ..Rig::default()
    }
}
