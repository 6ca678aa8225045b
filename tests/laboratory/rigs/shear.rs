//! Simple shear without periodic boundaries: platens of glued grains, a rough lid, or hinged flaps.

use super::disks::{Disk, area, grid, listed};
use super::{Cement, box_measures, cell, compact, load, measure, stress};
use crate::common::random::Random;
use crate::sample::{Sample, digits, pascal};
use crate::scenes::Rig;

/// One of the three shear boxes.
pub fn shear(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    match random.below(10) {
        0..4 => platens(sample, seed, random),
        4..7 => lid(sample, seed, random),
        _ => flaps(sample, random),
    }
}

/// Rows of grains are glued to the platens. The lower row is held; the upper row moves sideways
/// under a constant normal stress. Since the side walls are fixed, the upper row is shorter than
/// the box by its displacement.
fn platens(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let width = sample.width(0.5);
    let height = sample.height(width);
    let strain = random.pick(&[0.03, 0.05, 0.08]);
    let way = strain * height;
    let r = sample.radius;
    let places = (width / (2.05 * r)).floor();
    let pitch = width / places;
    let row = |count: f64, y: f64, group: &'static str| -> Vec<Disk> {
        let x = |k| (f64::from(k) + 0.5) * pitch;
        (0..count as u32).map(|k| Disk { x: x(k), y, radius: r, group }).collect()
    };
    let (grains, top) = grid(sample, width, 2.1 * r, random);
    let upper = ((width - way) / pitch).floor();
    let disks = [row(places, r, "lower"), grains, row(upper, top + 1.05 * r, "upper")].concat();
    let confinement = sample.stress(random.pick(&[0.3, 1.0]));
    let increments: u32 = random.pick(&[40, 60, 100]);
    let step = digits(way / f64::from(increments), 3);
    let glued = |motion: &str| {
        format!(
            "particles: [\n            (select: Group(\"lower\"), x: Held, y: Held, rotation: Held),\n            \
             (select: Group(\"upper\"), x: {motion}, rotation: Held),\n        ]"
        )
    };
    let stages = vec![
        compact(sample, seed),
        load("confine", 20, &[stress("top", confinement)], &glued("Held")),
        load("shear", increments, &[], &glued(&format!("Displacement({step:?})"))),
    ];
    Rig {
        title: format!(
            "Shear between rough platens, {} disks, {}",
            sample.count,
            pascal(confinement)
        ),
        material: format!("contact: {}", sample.grains()),
        specimen: listed(&disks),
        // Platens and sides are smooth: the glued grains are what is rough.
        walls: cell(width, top + 2.1 * r, &sample.law(Some(sample.stiffness), 0.0, 0.0)),
        stages,
        measures: box_measures(),
        ..Rig::default()
    }
}

/// A rough lid first compresses the sand, then moves sideways at constant height.
fn lid(sample: &Sample, seed: u64, random: &mut Random) -> Rig {
    let width = sample.width(0.5);
    let height = sample.height(width);
    let (specimen, top) = sample.packing(width, seed);
    let strain = random.pick(&[0.02, 0.03, 0.05]);
    let increments: u32 = random.pick(&[40, 60, 100]);
    let step = digits(strain * height / f64::from(increments), 3);
    let confinement = sample.stress(random.pick(&[0.3, 1.0]));
    let rough = sample.law(Some(sample.stiffness), 0.8, 0.0);
    let smooth = sample.law(Some(sample.stiffness), 0.0, 0.0);
    let walls = [&cell(width, top, &rough)[..2], &cell(width, top, &smooth)[2..]].concat();
    let lateral = format!("\"top\": Displacement({step:?}, 0.0)");
    Rig {
        title: format!("Shear below a rough lid, {} disks, {}", sample.count, pascal(confinement)),
        material: format!("contact: {}", sample.grains()),
        specimen,
        walls,
        stages: vec![
            compact(sample, seed),
            load("confine", 20, &[stress("top", confinement)], ""),
            load("shear", increments, &[lateral], ""),
        ],
        measures: box_measures(),
        ..Rig::default()
    }
}

/// Cemented sand whose outermost grains are glued to four hinged flaps: simple shear at constant
/// volume.
fn flaps(sample: &Sample, random: &mut Random) -> Rig {
    let cement = Cement::draw(sample, random);
    let width = sample.width(1.0);
    let (grains, top) = grid(sample, width, 0.0, random);
    // Sizes are known one by one: the height is exact, so that the outermost grains can be selected
    // by it.
    let height = digits(area(&grains) / ((1.0 - sample.porosity) * width), 5);
    let increments: u32 = random.pick(&[40, 60, 80]);
    // Twice the tensile strain of the bonds.
    let step = digits(4.0 * cement.strain / f64::from(increments), 2);
    let edge = digits(1.4 * sample.radius, 3);
    let (far, right, upper) = (10.0 * (width + height), width - edge, height - edge);
    let boxes = [
        ((-far, -far), (far, edge)),
        ((-far, upper), (far, far)),
        ((-far, -far), (edge, far)),
        ((right, -far), (far, far)),
    ];
    let glued: Vec<String> = boxes
        .iter()
        .map(|(min, max)| {
            format!(
                "(select: Box(min: {min:?}, max: {max:?}), rotation: Held, affine: ((0.0, {step:?}), (0.0, 0.0)))"
            )
        })
        .collect();
    let compact = format!(
        "Compact(name: \"compact\", wall: \"top\", base: \"bottom\", target: Height({height:?}), step: {:?}, \
         agitation: 0.1, seed: 1)",
        digits(sample.radius, 2)
    );
    let area = digits(width * height, 4);
    Rig {
        title: format!("Simple shear between flaps, {} bonded disks", sample.count),
        settings: cement.settings(),
        material: cement.material(sample),
        specimen: listed(&grains),
        walls: cell(width, top, "()"),
        stages: vec![
            compact,
            cement.stage(),
            load(
                "shear",
                increments,
                &[],
                &format!(
                    "remove_walls: [\"bottom\", \"top\", \"left\", \"right\"], particles: [\n            {},\n        ]",
                    glued.join(",\n            ")
                ),
            ),
        ],
        measures: vec![measure(
            "axial_stress",
            &format!("Stress(Average(component: Xy, area: Fixed({area:?})))"),
        )],
        ..Rig::default()
    }
}
