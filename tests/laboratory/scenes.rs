//! The list of scenes: the kind of every seed, and the text of its scene.

use crate::common::random::Random;
use crate::rigs;
use crate::sample::Sample;

/// Number of scenes. Their seeds are 0 to 199.
pub const SCENES: u64 = 200;

/// The kind of test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Bonded column between platens, compressed without lateral stress.
    Uniaxial,
    /// Sand under constant lateral stress, compressed.
    Biaxial,
    /// Cemented sand under constant lateral stress, compressed.
    CementedBiaxial,
    /// Sand between fixed side walls, loaded and unloaded.
    Oedometer,
    /// Equal stress from all sides, raised in steps and lowered.
    Isotropic,
    /// Sheared by platens, by a rough lid, or by hinged flaps.
    Shear,
    /// Bonded column glued to platens, pulled apart.
    Tension,
    /// Grains are poured into a container, or a loose packing settles under its weight.
    Deposition,
    /// A bank loses the wall that retains it.
    Slope,
    /// Grains fill a hopper of fixed grains, and flow out of it.
    Hopper,
}

/// All kinds, in the order of the table.
pub const KINDS: [Kind; 10] = [
    Kind::Uniaxial,
    Kind::Biaxial,
    Kind::CementedBiaxial,
    Kind::Oedometer,
    Kind::Isotropic,
    Kind::Shear,
    Kind::Tension,
    Kind::Deposition,
    Kind::Slope,
    Kind::Hopper,
];

/// Kinds of the seeds 0 to 19. They repeat after 20 seeds.
const PERIOD: [Kind; 20] = [
    Kind::Biaxial,
    Kind::Uniaxial,
    Kind::Oedometer,
    Kind::CementedBiaxial,
    Kind::Isotropic,
    Kind::Shear,
    Kind::Tension,
    Kind::Deposition,
    Kind::Slope,
    Kind::Biaxial,
    Kind::Hopper,
    Kind::Biaxial,
    Kind::Uniaxial,
    Kind::Oedometer,
    Kind::Isotropic,
    Kind::Shear,
    Kind::CementedBiaxial,
    Kind::Deposition,
    Kind::Biaxial,
    Kind::Tension,
];

impl Kind {
    /// Name in tables, and in `LABORATORY`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Biaxial => "biaxial",
            Self::CementedBiaxial => "cemented biaxial",
            Self::Oedometer => "oedometer",
            Self::Isotropic => "isotropic",
            Self::Shear => "shear",
            Self::Tension => "tension",
            Self::Deposition => "deposition",
            Self::Slope => "slope",
            Self::Hopper => "hopper",
        }
    }

    /// Whether a collapse in the stage is a valid result. It is not where walls hold the specimen
    /// on all sides: a packing that gives way there gets denser until it carries the load.
    pub fn may_collapse_in(self, stage: &str) -> bool {
        match self {
            Self::Uniaxial => stage == "compress",
            Self::Tension => stage == "pull",
            Self::Biaxial | Self::CementedBiaxial | Self::Shear => stage == "shear",
            Self::Slope => ["relieve", "stand"].contains(&stage),
            Self::Oedometer | Self::Isotropic | Self::Deposition | Self::Hopper => false,
        }
    }
}

/// A scene of the list.
#[derive(Clone, Debug)]
pub struct Plan {
    pub seed: u64,
    pub kind: Kind,
    pub sample: Sample,
    /// The scene as RON.
    pub text: String,
}

impl Plan {
    /// The scene of a seed.
    pub fn new(seed: u64) -> Self {
        let kind = PERIOD[(seed % PERIOD.len() as u64) as usize];
        let mut random = Random::new(seed);
        // Scenes that run in every `cargo test` are small.
        let sample = Sample::draw(&mut random, seed.is_multiple_of(crate::STRIDE));
        let draw = match kind {
            Kind::Uniaxial => rigs::columns::uniaxial,
            Kind::Tension => rigs::columns::tension,
            Kind::Biaxial => rigs::cells::biaxial,
            Kind::CementedBiaxial => rigs::cells::cemented_biaxial,
            Kind::Oedometer => rigs::cells::oedometer,
            Kind::Isotropic => rigs::cells::isotropic,
            Kind::Shear => rigs::shear::shear,
            Kind::Deposition => rigs::gravity::deposition,
            Kind::Slope => rigs::gravity::slope,
            Kind::Hopper => rigs::hopper::hopper,
        };
        let mut rig = draw(&sample, seed, &mut random);
        rig.coulomb = sample.coulomb;
        rig.heading = format!("{} of the laboratory suite, seed {seed}", kind.name());
        Self { seed, kind, sample, text: rig.text() }
    }
}

/// The parts of a scene as RON.
#[derive(Clone, Debug, Default)]
pub struct Rig {
    /// First comment of the file.
    pub heading: String,
    pub title: String,
    /// Further fields of the scene (gravity, analysis, rupture), one per line.
    pub settings: Vec<String>,
    pub coulomb: bool,
    /// Fields of the only material.
    pub material: String,
    pub specimen: String,
    pub walls: Vec<String>,
    pub stages: Vec<String>,
    pub measures: Vec<String>,
}

impl Rig {
    /// The scene as RON.
    pub fn text(&self) -> String {
        let lines = |items: &[String], indent: &str| {
            items.iter().map(|item| format!("{indent}{item},\n")).collect::<String>()
        };
        let mut settings = self.settings.clone();
        if self.coulomb {
            settings.push("friction_law: Coulomb()".to_owned());
        }
        format!(
            "// {}.\n(\n    version: 1,\n    title: {:?},\n{}    materials: {{ \"grains\": ({}) }},\n    \
             specimen: {},\n    walls: [\n{}    ],\n    stages: [\n{}    ],\n    measures: [\n{}    ],\n)\n",
            self.heading,
            self.title,
            lines(&settings, "    "),
            self.material,
            self.specimen,
            lines(&self.walls, "        "),
            lines(&self.stages, "        "),
            lines(&self.measures, "        "),
        )
    }
}
