//! Measures of a scene: from names to bodies.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::BodyId;
use clastic_components::bond::RuptureMode;
use clastic_components::measure::{
    CrackSums, NamedMeasures, Quantity, StrainPath, StrainReference,
};
use clastic_components::observation::{
    MeasureArea, MeasureLength, Measures, StrainMeasure, StressMeasure,
};
use clastic_components::particle::Particle;

use super::group_members::{self, GroupMembers};
use super::membranes::find_membrane;
use super::script::Script;
use super::walls::find_wall;
use crate::scene::format as scene;

/// Resolves the names in the scene's measures. A measure with a missing body or wall is left out.
pub fn resolve_measures(world: &mut World) {
    let script = world.resource::<Script>();
    let reference_stage = script.reference_stage();
    let scene = &script.scene;
    let strains = ["axial_strain", "lateral_strain"].map(|name| scene.strain(name).cloned());
    let stresses = ["axial_stress", "lateral_stress"].map(|name| scene.stress(name).cloned());
    let list: Vec<_> = scene.further_measures().cloned().collect();
    let [axial_strain, lateral_strain] = strains.map(|of| strain(world, &of?));
    let [axial_stress, lateral_stress] = stresses.map(|of| stress(world, &of?));
    let list = list
        .into_iter()
        .map(|scene::Measure { name, of }| {
            let quantity = quantity(world, &name, &of);
            (name, quantity)
        })
        .collect();
    world.resource_mut::<NamedMeasures>().list = list;
    keep_what_is_needed(world, [axial_strain, lateral_strain]);
    let mut measures = world.resource_mut::<Measures>();
    let reference = measures.reference;
    *measures = Measures {
        reference_stage,
        axial_strain,
        lateral_strain,
        axial_stress,
        lateral_stress,
        reference,
    };
}

/// Adds the tables that the measures need, where they are not there yet.
fn keep_what_is_needed(world: &mut World, roles: [Option<StrainMeasure>; 2]) {
    let list = &world.resource::<NamedMeasures>().list;
    let has = |needs: fn(&Quantity) -> bool| list.iter().filter_map(|(_, q)| q.as_ref()).any(needs);
    let region = |strain: &StrainMeasure| matches!(strain, StrainMeasure::Region { .. });
    let regions = has(|q| {
        matches!(q, Quantity::Strain(StrainMeasure::Region { .. }))
            || matches!(q, Quantity::Grains { moved, .. } if *moved > 0.0)
            || matches!(q, Quantity::Ring { .. })
    }) || roles.iter().flatten().any(region);
    let path = has(|q| matches!(q, Quantity::DilationAngle { .. }));
    let cracks = has(|q| matches!(q, Quantity::Cracks { .. }));
    if regions {
        world.init_resource::<StrainReference>();
    }
    if path {
        world.init_resource::<StrainPath>();
    }
    if cracks {
        world.init_resource::<CrackSums>();
    }
}

fn particle(world: &mut World, index: u32) -> Option<Entity> {
    let mut particles = world.query_filtered::<(Entity, &BodyId), With<Particle>>();
    particles.iter(world).find(|(_, id)| id.0 == index).map(|(e, _)| e)
}

fn strain(world: &mut World, measure: &scene::Strain) -> Option<StrainMeasure> {
    Some(match measure {
        scene::Strain::Walls(a, b) => {
            StrainMeasure::Walls(find_wall(world, a)?, find_wall(world, b)?)
        }
        scene::Strain::Particles(a, b) => {
            StrainMeasure::Particles(particle(world, *a)?, particle(world, *b)?)
        }
        scene::Strain::Membrane(name) => StrainMeasure::Membrane(find_membrane(world, name)?),
        scene::Strain::Cell(of) => StrainMeasure::Cell(*of),
        scene::Strain::Region { component, min, max } => {
            StrainMeasure::Region { component: *component, min: (*min).into(), max: (*max).into() }
        }
    })
}

fn quantity(world: &mut World, name: &str, of: &scene::Quantity) -> Option<Quantity> {
    Some(match of {
        scene::Quantity::GroupForce { select, along, .. } => {
            let kept = world.get_resource::<GroupMembers>().and_then(|kept| kept.0.get(name));
            let members = match kept.cloned() {
                Some(members) => members,
                None => group_members::members(world, select),
            };
            let component = match along {
                scene::GroupAlong::X => 0,
                scene::GroupAlong::Y => 1,
                scene::GroupAlong::Moment => 2,
            };
            Quantity::GroupForce { members, component }
        }
        scene::Quantity::Strain(of) => Quantity::Strain(strain(world, of)?),
        scene::Quantity::Stress(of) => Quantity::Stress(stress(world, of)?),
        scene::Quantity::Porosity(of) => Quantity::Porosity(area(world, of)?),
        scene::Quantity::Coordination { rattlers } => {
            Quantity::Coordination { rattlers: *rattlers }
        }
        scene::Quantity::Broken(modes) => Quantity::Broken { mode: mode(*modes), share: false },
        scene::Quantity::BrokenShare(modes) => Quantity::Broken { mode: mode(*modes), share: true },
        scene::Quantity::VolumetricStrain => Quantity::VolumetricStrain,
        scene::Quantity::DilationAngle { over } => Quantity::DilationAngle { over: *over },
        scene::Quantity::Fabric { component, network } => {
            Quantity::Fabric { component: *component, network: *network }
        }
        scene::Quantity::Fragments(part) => Quantity::Fragments(*part),
        scene::Quantity::Cracks { part, mode: modes } => {
            Quantity::Cracks { mode: mode(*modes), part: *part }
        }
        scene::Quantity::KineticEnergy => Quantity::KineticEnergy,
        scene::Quantity::ElasticEnergy => Quantity::ElasticEnergy,
        scene::Quantity::KineticOverElastic => Quantity::KineticOverElastic,
        scene::Quantity::WallForce { wall, along } => {
            Quantity::WallForce { wall: find_wall(world, wall)?, along: *along }
        }
        scene::Quantity::Membrane { membrane, value } => {
            Quantity::Membrane { membrane: find_membrane(world, membrane)?, value: *value }
        }
        scene::Quantity::Poured(amount) => {
            Quantity::Poured { mass: *amount == scene::Amount::Mass }
        }
        scene::Quantity::Grains { amount, min, max, moved } => {
            let corner = |corner: Option<(f64, f64)>, none: f64| {
                corner.map_or(DVec2::splat(none), DVec2::from)
            };
            Quantity::Grains {
                amount: *amount,
                min: corner(*min, f64::NEG_INFINITY),
                max: corner(*max, f64::INFINITY),
                moved: *moved,
            }
        }
        scene::Quantity::Ring { centre, radii, value } => {
            Quantity::Ring { centre: (*centre).into(), radii: [radii.0, radii.1], value: *value }
        }
        scene::Quantity::Gravity => Quantity::Gravity,
        scene::Quantity::StrengthFactor => Quantity::StrengthFactor,
        scene::Quantity::Time => Quantity::Time,
        scene::Quantity::Custom(name) => Quantity::Custom(name.clone()),
    })
}

fn mode(modes: scene::Modes) -> Option<RuptureMode> {
    match modes {
        scene::Modes::All => None,
        scene::Modes::Tension => Some(RuptureMode::Tension),
        scene::Modes::Shear => Some(RuptureMode::Shear),
        scene::Modes::Rolling => Some(RuptureMode::Rolling),
    }
}

fn area(world: &mut World, area: &scene::Area) -> Option<MeasureArea> {
    Some(match area {
        scene::Area::Fixed(area) => MeasureArea::Fixed(*area),
        scene::Area::Cell => MeasureArea::Cell,
        scene::Area::Membrane(name) => MeasureArea::Membrane(find_membrane(world, name)?),
        scene::Area::Box((a, b), (c, d)) => MeasureArea::Box([
            find_wall(world, a)?,
            find_wall(world, b)?,
            find_wall(world, c)?,
            find_wall(world, d)?,
        ]),
    })
}

fn stress(world: &mut World, measure: &scene::Stress) -> Option<StressMeasure> {
    Some(match measure {
        scene::Stress::Walls { walls, length } => StressMeasure::Walls {
            walls: walls.iter().map(|w| find_wall(world, w)).collect::<Option<_>>()?,
            length: match length {
                scene::Length::Fixed(length) => MeasureLength::Fixed(*length),
                scene::Length::Between(a, b) => {
                    MeasureLength::Between(find_wall(world, a)?, find_wall(world, b)?)
                }
                scene::Length::Membrane(name) => {
                    MeasureLength::Membrane(find_membrane(world, name)?)
                }
            },
        },
        scene::Stress::Average { component: of, area: over } => {
            StressMeasure::Average { component: *of, area: area(world, over)? }
        }
        scene::Stress::Membrane(name) => StressMeasure::Membrane(find_membrane(world, name)?),
        scene::Stress::Region { component: of, min, max } => {
            StressMeasure::Region { component: *of, min: (*min).into(), max: (*max).into() }
        }
    })
}
