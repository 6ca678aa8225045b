//! Measures of a scene: from names to bodies, and the values that plugins provide.

use std::collections::BTreeMap;

use bevy_app::App;
use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::bond::RuptureMode;
use clastic_components::measure::{
    ForceComponent, MembraneValue, NamedMeasures, Quantity, Readings,
};
use clastic_components::observation::{
    MeasureArea, MeasureLength, Measures, Observation, StrainMeasure, StressComponent,
    StressMeasure,
};
use clastic_components::particle::Particle;

use super::group_members::{self, GroupMembers};
use super::membranes::find_membrane;
use super::spawn::find_wall;
use super::stages::Script;
use crate::scene::format as scene;

/// Reads the measure of a plugin.
type Read = Box<dyn Fn(&World) -> Option<f64> + Send + Sync>;

/// The measures that plugins provide, by name.
#[derive(Resource, Default)]
pub struct MeasureKinds(BTreeMap<&'static str, Read>);

impl MeasureKinds {
    /// The names.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.keys().copied()
    }

    /// Why a scene cannot run; `None` if plugins provide all its custom measures.
    #[must_use]
    pub fn refusal(&self, scene: &scene::Scene) -> Option<String> {
        let missing = scene.measures.further().find_map(|measure| match &measure.of {
            scene::Quantity::Custom(kind) => {
                (!self.0.contains_key(kind.as_str())).then_some((&measure.name, kind))
            }
            _ => None,
        });
        let (name, kind) = missing?;
        let known: Vec<_> = self.names().collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Some(format!(
            "measure `{name}` cannot be read: no plugin of this program provides the measure `{kind}`; \
             it provides {known}"
        ))
    }
}

/// Registers the measures that a plugin provides.
pub trait ProvideMeasure {
    /// Registers a measure: a scene refers to it by `Custom(name)`. It is read from the resource
    /// `R` after every increment, before the systems of
    /// [`StageSystems::Stop`](super::plugin::StageSystems::Stop). Without the resource, or with
    /// `None`, it is not defined.
    fn provide_measure<R: Resource>(
        &mut self,
        name: &'static str,
        read: impl Fn(&R) -> Option<f64> + Send + Sync + 'static,
    ) -> &mut Self;
}

impl ProvideMeasure for App {
    fn provide_measure<R: Resource>(
        &mut self,
        name: &'static str,
        read: impl Fn(&R) -> Option<f64> + Send + Sync + 'static,
    ) -> &mut Self {
        let read = move |world: &World| world.get_resource::<R>().and_then(&read);
        self.world_mut().get_resource_or_init::<MeasureKinds>().0.insert(name, Box::new(read));
        self
    }
}

/// Reads the measures of plugins. Exclusive, because they may be any resource.
pub(super) fn read_custom(world: &mut World) {
    let wanted: Vec<(usize, String)> = world
        .resource::<NamedMeasures>()
        .list
        .iter()
        .enumerate()
        .filter_map(|(k, (_, quantity))| match quantity {
            Some(Quantity::Custom(kind)) => Some((k, kind.clone())),
            _ => None,
        })
        .collect();
    for (k, kind) in wanted {
        let read = world.resource::<MeasureKinds>().0.get(kind.as_str());
        let reading = read.and_then(|read| read(world)).filter(|reading| reading.is_finite());
        if let Some(out) = world.resource_mut::<Readings>().0.get_mut(k) {
            *out = reading;
        }
    }
}

/// Reading of a measure of the scene after the last increment; `None` if it is not defined.
#[must_use]
pub fn reading(world: &World, name: &str) -> Option<f64> {
    let observation = world.resource::<Observation>();
    match name {
        "axial_strain" => observation.axial_strain,
        "lateral_strain" => observation.lateral_strain,
        "axial_stress" => observation.axial_stress,
        "lateral_stress" => observation.lateral_stress,
        _ => {
            let list = &world.resource::<NamedMeasures>().list;
            let k = list.iter().position(|(measure, _)| measure == name)?;
            world.resource::<Readings>().0.get(k).copied().flatten()
        }
    }
}

/// Resolves the names in the scene's measures. A measure with a missing body or wall is left out.
pub fn resolve_measures(world: &mut World) {
    let script = world.resource::<Script>();
    let wanted = script.scene.measures.clone();
    let list: Vec<_> = wanted.further().cloned().collect();
    let reference_stage = script.reference_stage();
    let axial_strain = wanted.axial_strain.and_then(|m| strain(world, &m));
    let lateral_strain = wanted.lateral_strain.and_then(|m| strain(world, &m));
    let axial_stress = wanted.axial_stress.and_then(|m| stress(world, &m));
    let lateral_stress = wanted.lateral_stress.and_then(|m| stress(world, &m));
    let list = list
        .into_iter()
        .map(|scene::Measure { name, of }| {
            let quantity = quantity(world, &name, &of);
            (name, quantity)
        })
        .collect();
    world.resource_mut::<NamedMeasures>().list = list;
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
        scene::Strain::Cell(scene::CellStrain::Width) => StrainMeasure::CellWidth,
        scene::Strain::Cell(scene::CellStrain::Height) => StrainMeasure::CellHeight,
        scene::Strain::Cell(scene::CellStrain::Shear) => StrainMeasure::CellShear,
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
        scene::Quantity::KineticEnergy => Quantity::KineticEnergy,
        scene::Quantity::ElasticEnergy => Quantity::ElasticEnergy,
        scene::Quantity::KineticOverElastic => Quantity::KineticOverElastic,
        scene::Quantity::WallForce { wall, along } => Quantity::WallForce {
            wall: find_wall(world, wall)?,
            along: match along {
                scene::Along::Normal => ForceComponent::Normal,
                scene::Along::Tangent => ForceComponent::Tangent,
                scene::Along::X => ForceComponent::X,
                scene::Along::Y => ForceComponent::Y,
            },
        },
        scene::Quantity::Membrane { membrane, value } => Quantity::Membrane {
            membrane: find_membrane(world, membrane)?,
            value: match value {
                scene::MembraneValue::Grains => MembraneValue::Grains,
                scene::MembraneValue::Area => MembraneValue::Area,
                scene::MembraneValue::Width => MembraneValue::Width,
            },
        },
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
        scene::Area::Box((a, b), (c, d)) => MeasureArea::Box([
            find_wall(world, a)?,
            find_wall(world, b)?,
            find_wall(world, c)?,
            find_wall(world, d)?,
        ]),
        scene::Area::Membrane(name) => MeasureArea::Membrane(find_membrane(world, name)?),
    })
}

fn component(component: scene::Component) -> StressComponent {
    match component {
        scene::Component::Xx => StressComponent::Xx,
        scene::Component::Yy => StressComponent::Yy,
        scene::Component::Xy => StressComponent::Xy,
        scene::Component::Shear => StressComponent::Shear,
    }
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
            StressMeasure::Average { component: component(*of), area: area(world, over)? }
        }
        scene::Stress::Region { component: of, min, max } => StressMeasure::Region {
            component: component(*of),
            min: (*min).into(),
            max: (*max).into(),
        },
        scene::Stress::Membrane(name) => StressMeasure::Membrane(find_membrane(world, name)?),
    })
}
