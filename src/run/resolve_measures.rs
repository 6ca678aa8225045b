//! Measures of a scene: from names to bodies. Particles of the groups on which forces are measured
//! are selected when a stage begins, or in every increment.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use glam::DVec2;

use super::load_refusals::selects_none;
use super::membranes::find_membrane;
use super::script::Script;
use super::select::selected;
use super::walls::{find_pair, find_wall};
use crate::scene::format as scene;

/// Name of [`GroupMembers`] in a state.
pub(crate) const GROUP_MEMBERS: &str = "measures.groups";

/// Particles that the measures of the scene have selected when the stage began, by the name of the
/// measure. A scene without such measures has no such resource.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct GroupMembers(pub BTreeMap<String, Vec<BodyId>>);

/// Resolves the names in the scene's measures. A measure with a missing body or wall is left out.
pub fn resolve_measures(world: &mut World) {
    let scene = &world.resource::<Script>().scene;
    let strains = ["axial_strain", "lateral_strain"].map(|name| scene.strain(name).cloned());
    let stresses = ["axial_stress", "lateral_stress"].map(|name| scene.stress(name).cloned());
    let list: Vec<_> = scene.further_measures().cloned().collect();
    let [axial_strain, lateral_strain] = strains.map(|of| strain(world, &of?));
    let [axial_stress, lateral_stress] = stresses.map(|of| stress(world, &of?));
    let resolved = |of: scene::Measure| (of.name.clone(), quantity(world, &of.name, &of.of));
    let list = list.into_iter().map(resolved).collect();
    world.resource_mut::<NamedMeasures>().list = list;
    keep_what_is_needed(world);
    let mut measures = world.resource_mut::<Measures>();
    let reference = measures.reference;
    *measures = Measures { axial_strain, lateral_strain, axial_stress, lateral_stress, reference };
}

/// Adds the tables that the measures need, where they are not there yet.
fn keep_what_is_needed(world: &mut World) {
    for scene::Measure { of, .. } in world.resource::<Script>().scene.measures.clone() {
        match of {
            Quantity::Grains { moved, .. } if moved <= 0.0 => {}
            Quantity::Strain(StrainMeasure::Region { .. })
            | Quantity::Ring { .. }
            | Quantity::Grains { .. } => _ = world.init_resource::<StrainReference>(),
            Quantity::DilationAngle { .. } => _ = world.init_resource::<StrainPath>(),
            Quantity::Cracks { .. } => _ = world.init_resource::<CrackSums>(),
            _ => {}
        }
    }
}

fn particle(world: &mut World, index: u32) -> Option<Entity> {
    let mut particles = world.query_filtered::<(Entity, &BodyId), With<Particle>>();
    particles.iter(world).find(|(_, id)| id.0 == index).map(|(e, _)| e)
}

fn strain(world: &mut World, measure: &scene::Strain) -> Option<StrainMeasure> {
    Some(match measure {
        StrainMeasure::Walls(a, b) => {
            StrainMeasure::Walls(find_wall(world, a)?, find_wall(world, b)?)
        }
        StrainMeasure::Particles(a, b) => {
            StrainMeasure::Particles(particle(world, *a)?, particle(world, *b)?)
        }
        StrainMeasure::Membrane(name) => StrainMeasure::Membrane(find_membrane(world, name)?),
        StrainMeasure::Cell(of) => StrainMeasure::Cell(*of),
        &StrainMeasure::Region { component, min, max } => {
            StrainMeasure::Region { component, min, max }
        }
    })
}

fn quantity(world: &mut World, name: &str, of: &scene::Quantity) -> Option<Quantity> {
    Some(match of {
        Quantity::Strain(of) => Quantity::Strain(strain(world, of)?),
        Quantity::Stress(of) => Quantity::Stress(stress(world, of)?),
        Quantity::Porosity(of) => Quantity::Porosity(area(world, of)?),
        Quantity::WallForce { wall, along } => {
            Quantity::WallForce { wall: find_wall(world, wall)?, along: *along }
        }
        Quantity::GroupForce { select, along, live } => {
            let kept = world.get_resource::<GroupMembers>().and_then(|kept| kept.0.get(name));
            let select = kept.cloned().unwrap_or_else(|| members(world, select));
            Quantity::GroupForce { select, along: *along, live: *live }
        }
        Quantity::Membrane { membrane, value } => {
            Quantity::Membrane { membrane: find_membrane(world, membrane)?, value: *value }
        }
        // All others are without bodies.
        &Quantity::Coordination { rattlers } => Quantity::Coordination { rattlers },
        Quantity::Broken(modes) => Quantity::Broken(*modes),
        Quantity::BrokenShare(modes) => Quantity::BrokenShare(*modes),
        Quantity::VolumetricStrain => Quantity::VolumetricStrain,
        &Quantity::DilationAngle { over } => Quantity::DilationAngle { over },
        &Quantity::Fabric { component, network } => Quantity::Fabric { component, network },
        Quantity::Fragments(part) => Quantity::Fragments(*part),
        &Quantity::Cracks { part, mode } => Quantity::Cracks { part, mode },
        Quantity::KineticEnergy => Quantity::KineticEnergy,
        Quantity::ElasticEnergy => Quantity::ElasticEnergy,
        Quantity::KineticOverElastic => Quantity::KineticOverElastic,
        Quantity::Poured(amount) => Quantity::Poured(*amount),
        &Quantity::Grains { amount, min, max, moved } => {
            Quantity::Grains { amount, min, max, moved }
        }
        &Quantity::Front { along, share } => Quantity::Front { along, share },
        &Quantity::Ring { centre, radii, value } => Quantity::Ring { centre, radii, value },
        Quantity::Gravity => Quantity::Gravity,
        Quantity::StrengthFactor => Quantity::StrengthFactor,
        Quantity::Time => Quantity::Time,
        Quantity::Custom(name) => Quantity::Custom(name.clone()),
    })
}

fn area(world: &mut World, area: &scene::Area) -> Option<MeasureArea> {
    Some(match area {
        MeasureArea::Fixed(area) => MeasureArea::Fixed(*area),
        MeasureArea::Cell => MeasureArea::Cell,
        MeasureArea::Membrane(name) => MeasureArea::Membrane(find_membrane(world, name)?),
        MeasureArea::Box((a, b), (c, d)) => {
            let ([a, b], [c, d]) = (find_pair(world, a, b)?, find_pair(world, c, d)?);
            MeasureArea::Box((a, b), (c, d))
        }
    })
}

fn stress(world: &mut World, measure: &scene::Stress) -> Option<StressMeasure> {
    Some(match measure {
        StressMeasure::Walls { walls, length } => StressMeasure::Walls {
            walls: walls.iter().map(|w| find_wall(world, w)).collect::<Option<_>>()?,
            length: match length {
                MeasureLength::Fixed(length) => MeasureLength::Fixed(*length),
                MeasureLength::Between(a, b) => {
                    MeasureLength::Between(find_wall(world, a)?, find_wall(world, b)?)
                }
                MeasureLength::Membrane(name) => {
                    MeasureLength::Membrane(find_membrane(world, name)?)
                }
            },
        },
        StressMeasure::Average { component, area: over } => {
            StressMeasure::Average { component: *component, area: area(world, over)? }
        }
        StressMeasure::Membrane(name) => StressMeasure::Membrane(find_membrane(world, name)?),
        &StressMeasure::Region { component, min, max } => {
            StressMeasure::Region { component, min, max }
        }
    })
}

/// Name and selection of the measures of groups of the scene that are live, or of the others.
fn wanted(world: &World, are_live: bool) -> Vec<(String, scene::Select)> {
    let of = |measure: &scene::Measure| match &measure.of {
        scene::Quantity::GroupForce { select, live, .. } if *live == are_live => {
            Some((measure.name.clone(), select.clone()))
        }
        _ => None,
    };
    world.resource::<Script>().scene.measures.iter().filter_map(of).collect()
}

/// The particles of a selection, in the order of identities.
fn members(world: &mut World, select: &scene::Select) -> Vec<BodyId> {
    selected(world, select).into_iter().map(|(id, _)| id).collect()
}

/// Why the reference stage cannot begin: a measure of particles that has none. It would never read
/// anything.
pub(super) fn of_nothing(world: &mut World) -> Option<String> {
    let measures = world.resource::<Script>().scene.measures.clone();
    measures.iter().enumerate().find_map(|(k, scene::Measure { name, of })| match of {
        Quantity::GroupForce { select, live: false, .. } => {
            members(world, select).is_empty().then(|| {
                let none = selects_none(select);
                format!(
                    "measures[{k}].of.select, of `{name}`, {none}, or select live (`live: true`)"
                )
            })
        }
        Quantity::Ring { centre, radii, .. } => {
            let mut centres = world.query_filtered::<&BodyPosition, With<Particle>>();
            let is_inside = |x: &BodyPosition| {
                (radii.0..=radii.1).contains(&x.0.distance(DVec2::from(*centre)))
            };
            (!centres.iter(world).any(is_inside)).then(|| {
                format!(
                    "measures[{k}].of.radii, of `{name}`: no particle has its centre between the \
                     two circles; give a ring that holds particles where they are by then"
                )
            })
        }
        _ => None,
    })
}

/// Selects the particles of the groups for the stage that begins.
pub(super) fn select_groups(world: &mut World) {
    let fixed = wanted(world, false).into_iter();
    let all: BTreeMap<_, _> = fixed.map(|(name, select)| (name, members(world, &select))).collect();
    if !all.is_empty() {
        world.insert_resource(GroupMembers(all));
    }
}

/// Selects the particles of the live groups for the increment that begins. Exclusive, because a
/// selection reads every particle of the world.
pub(super) fn select_live_groups(world: &mut World) {
    for (name, select) in wanted(world, true) {
        let now = members(world, &select);
        let mut named = world.resource_mut::<NamedMeasures>();
        let found = named.list.iter_mut().find(|(measure, _)| *measure == name);
        if let Some((_, Some(Quantity::GroupForce { select, .. }))) = found {
            *select = now;
        }
    }
}
