//! Controls of particles in a stage.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// Control of the selected particles in a stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ParticleControl {
    /// The selected particles.
    pub select: Select,
    /// Motion along x.
    #[serde(default)]
    pub x: Motion,
    /// Motion along y.
    #[serde(default)]
    pub y: Motion,
    /// Rotation.
    #[serde(default)]
    pub rotation: Motion,
    /// Displacement gradient ((ux_x, ux_y), (uy_x, uy_y)) in every increment, about the origin, of
    /// positions at the start of the stage. It imposes the motion along x and y.
    pub affine: Option<((f64, f64), (f64, f64))>,
    /// Force (x, y) at the end of the stage, N. It varies linearly from its value at the start.
    pub force: Option<(f64, f64)>,
    /// Moment at the end of the stage, N m. It varies linearly from its value at the start.
    pub moment: Option<f64>,
    /// Share of the force and the moment at the start of the stage that is left at its end, 0 to 1.
    pub remains: Option<f64>,
}

impl ParticleControl {
    /// Whether it brings a load of the particles to a target.
    pub(crate) fn is_load(&self) -> bool {
        self.force.is_some() || self.moment.is_some() || self.remains.is_some()
    }

    /// Motions along x, along y, and of the rotation, with their fields and units.
    pub fn motions(&self) -> [(&'static str, Motion, &'static str); 3] {
        [("x", self.x, "m"), ("y", self.y, "m"), ("rotation", self.rotation, "rad")]
    }
}

/// A selection of particles.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Select {
    /// Every particle.
    All,
    /// By index in the specimen, from 0.
    Index(Vec<u32>),
    /// By index in the specimen, from the first to the last.
    Range(u32, u32),
    /// By material.
    Material(String),
    /// By the name of a group: of the scene, or of the specimen.
    Group(String),
    /// By the name of the probe.
    Probe(String),
    /// Particles with centres in a box at the start of the stage.
    Box {
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
    /// Particles with centres in a circle at the start of the stage.
    Circle {
        /// Centre, m.
        centre: (f64, f64),
        /// Radius, m.
        radius: f64,
    },
    /// Particles with centres between two parallel lines at the start of the stage.
    Layer {
        /// Direction across the layer, of any length.
        normal: (f64, f64),
        /// Lower distance from the origin in this direction, m.
        from: f64,
        /// Upper distance, m.
        to: f64,
    },
    /// Particles with centres in a polygon at the start of the stage: its corners, m.
    Polygon(Vec<(f64, f64)>),
    /// Particles with fewer contacts and bonds that carry force than this, also once others of them are
    /// gone.
    Loose(u32),
    /// Particles that any of these has.
    Union(Vec<Select>),
    /// Particles that all of these have.
    Intersection(Vec<Select>),
    /// Particles that the first has and the second has not.
    Except(Box<Select>, Box<Select>),
}

impl Select {
    /// Corners of the rectangle around what is left of a specimen that loses this selection, m, if it
    /// is all but a box or a circle, or a part of these.
    pub fn left(&self) -> Option<[(f64, f64); 2]> {
        let corners = |of: &Self| match of {
            Self::Box { min, max } => Some([*min, *max]),
            Self::Circle { centre: (x, y), radius: r } => Some([(x - r, y - r), (x + r, y + r)]),
            _ => None,
        };
        match self {
            Self::Except(all, kept) if **all == Self::All => match &**kept {
                Self::Intersection(list) => list.iter().find_map(corners),
                one => corners(one),
            },
            Self::Union(list) => list.iter().find_map(Self::left),
            _ => None,
        }
    }

    /// Whether it, or a group of the scene that it names, depends on the forces of contacts.
    pub(crate) fn needs_forces(&self, groups: &BTreeMap<String, Self>) -> bool {
        self.all(groups).iter().any(|part| matches!(part, Self::Loose(_)))
    }

    /// This selection, those that it is made of, and those of the groups of the scene that it names.
    pub(crate) fn all<'a>(&'a self, groups: &'a BTreeMap<String, Self>) -> Vec<&'a Self> {
        let (mut all, mut named) = (vec![self], BTreeSet::new());
        let mut k = 0;
        while let Some(select) = all.get(k).copied() {
            all.extend(select.parts());
            if let Self::Group(name) = select
                && named.insert(name)
            {
                all.extend(groups.get(name));
            }
            k += 1;
        }
        all
    }

    /// The selections that it is made of.
    pub fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Union(list) | Self::Intersection(list) => list.iter().collect(),
            Self::Except(from, without) => vec![from, without],
            _ => Vec::new(),
        }
    }
}

/// Imposed motion along one degree of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Motion {
    /// Free: the motion is an unknown.
    #[default]
    Free,
    /// Held.
    Held,
    /// Displacement (m) or rotation (rad) in every increment.
    Displacement(f64),
    /// Velocity (m/s) or angular velocity (rad/s).
    Velocity(f64),
}
