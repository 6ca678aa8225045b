//! The rigs: walls and platens around a sample, and the stages of its test.

pub mod cells;
pub mod columns;
pub mod disks;
pub mod gravity;
pub mod hopper;
pub mod shear;

use crate::common::random::Random;
use crate::sample::{Sample, digits};

/// Four walls of a box with the same contact law: bottom, top, left, right.
fn cell(width: f64, height: f64, law: &str) -> Vec<String> {
    let wall = |name: &str, start: (f64, f64), end: (f64, f64)| {
        format!("(name: {name:?}, start: {start:?}, end: {end:?}, contact: {law})")
    };
    vec![
        wall("bottom", (0.0, 0.0), (width, 0.0)),
        wall("top", (width, height), (0.0, height)),
        wall("left", (0.0, height), (0.0, 0.0)),
        wall("right", (width, 0.0), (width, height)),
    ]
}

/// The compaction without friction that every box starts with.
fn compact(sample: &Sample, seed: u64) -> String {
    format!(
        "Compact(name: \"compact\", wall: \"top\", base: \"bottom\", target: Porosity({:?}), step: {:?}, \
         agitation: 0.1, seed: {seed})",
        sample.porosity,
        digits(sample.radius, 2)
    )
}

/// Control of a wall of a box by a stress (Pa) on its current length.
fn stress(wall: &str, stress: f64) -> String {
    let between = if wall == "left" || wall == "right" {
        "(\"bottom\", \"top\")"
    } else {
        "(\"left\", \"right\")"
    };
    format!("{wall:?}: Stress(stress: {stress:?}, between: {between})")
}

/// A loading stage: controls of walls, and further fields as text.
fn load(name: &str, increments: u32, walls: &[String], more: &str) -> String {
    let walls = if walls.is_empty() {
        String::new()
    } else {
        format!(", walls: {{\n            {},\n        }}", walls.join(",\n            "))
    };
    let more = if more.is_empty() { String::new() } else { format!(", {more}") };
    format!("Load(name: {name:?}, increments: {increments}{walls}{more})")
}

/// A measure as the scene writes it.
fn measure(name: &str, of: &str) -> String {
    format!("(name: {name:?}, of: {of})")
}

/// Strains and wall stresses of a box, from the start of the last stage.
fn box_measures() -> Vec<String> {
    vec![
        measure("axial_strain", "Strain(Walls(\"bottom\", \"top\"))"),
        measure("lateral_strain", "Strain(Walls(\"left\", \"right\"))"),
        measure(
            "axial_stress",
            "Stress(Walls(walls: [\"bottom\", \"top\"], length: Between(\"left\", \"right\")))",
        ),
        measure(
            "lateral_stress",
            "Stress(Walls(walls: [\"left\", \"right\"], length: Between(\"bottom\", \"top\")))",
        ),
    ]
}

/// Cement between grains.
#[derive(Clone, Debug)]
struct Cement {
    /// Tensile strength, Pa.
    tension: f64,
    /// Its tensile strain: strength over stiffness.
    strain: f64,
    /// Rules of rupture as the scene writes them; empty for the default.
    rupture: String,
    /// Bond law as the scene writes it.
    law: String,
    /// Law of bonds to platens: ten times the strength.
    glue: String,
    /// Bond length, m.
    length: f64,
}

impl Cement {
    fn draw(sample: &Sample, random: &mut Random) -> Self {
        let stiffness = digits(sample.stiffness * random.pick(&[1.0, 1.0, 2.0]), 2);
        let strain = random.pick(&[5e-4, 1e-3, 2e-3]);
        let tension = digits(strain * stiffness, 2);
        let cohesion = digits(tension * random.pick(&[1.0, 1.4, 2.0]), 2);
        let friction = digits(random.between(0.4, 0.8), 2);
        let rolling = random.pick(&[0.0, 0.0, 0.05]);
        let tangential = digits(sample.ratio * stiffness, 2);
        let law = |times: f64| {
            format!(
                "(normal_stiffness: {stiffness:?}, tangential_stiffness: {tangential:?}, friction: {friction:?}, \
                 rolling_friction: {rolling:?}, cohesion: {:?}, tensile_strength: {:?})",
                times * cohesion,
                times * tension
            )
        };
        let mut rules = Vec::new();
        if rolling > 0.0 {
            rules.push("rolling: Yields");
        }
        if random.chance(0.3) {
            rules.push("order: OneRound");
        }
        let rupture = if rules.is_empty() {
            String::new()
        } else {
            format!("rupture: ({})", rules.join(", "))
        };
        let length = digits(sample.radius * random.pick(&[0.1, 0.2, 0.4]), 2);
        Self { tension, strain, rupture, law: law(1.0), glue: law(10.0), length }
    }

    fn settings(&self) -> Vec<String> {
        if self.rupture.is_empty() { Vec::new() } else { vec![self.rupture.clone()] }
    }

    fn material(&self, sample: &Sample) -> String {
        format!("contact: {}, bond: {}", sample.grains(), self.law)
    }

    fn stage(&self) -> String {
        format!("Cement(name: \"cement\", length: {:?})", self.length)
    }

    /// Stage that bonds grains to each other and to platens.
    fn stage_with_walls(&self) -> String {
        format!("Cement(name: \"cement\", length: {:?}, walls: true)", self.length)
    }
}
