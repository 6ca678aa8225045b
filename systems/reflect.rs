//! Reflection: the type registry of an app knows the components and resources of the engine.

use bevy_app::{App, Plugin};

use clastic_components::{
    attempt, body, bond, collision, contact, contact_history, energy, findings, increment, link,
    loads, material, measure, membrane, observation, particle, rigid_group, wall, wall_shape,
};
use clastic_cone::program;

use crate::identities::IdentityTable;
use crate::motion_settings::MotionSettings;
use crate::stepping::{
    ClasticHalted, ClasticRunning, ClasticStopped, IncrementDue, IncrementUndone,
};

/// Registers the components and resources of the engine, so that inspectors and scripts can show
/// and set them by name. `clastic::ClasticPlugins` contains it if the feature `reflect` is on.
///
/// Data of one attempt (contacts, program, findings) are made anew in the next one. Setting them
/// has no effect.
pub struct ReflectPlugin;

macro_rules! register {
    ($app:expr, $($type:ty),+ $(,)?) => { $( $app.register_type::<$type>(); )+ };
}

impl Plugin for ReflectPlugin {
    fn build(&self, app: &mut App) {
        register!(
            app,
            attempt::Attempt,
            body::BodyId,
            body::BodyPosition,
            body::BodyOrigin,
            body::BodyRotation,
            body::BodyVelocity,
            body::BodyAngularVelocity,
            body::LastMotion,
            body::BodyDrives,
            body::AppliedLoad,
            body::LoadControl,
            body::BodyExternalForce,
            body::Probe,
            body::Group,
            link::Link,
            link::LinkBetween,
            bond::BondId,
            bond::Bond,
            bond::Joint,
            bond::BondState,
            bond::BondBroken,
            bond::Rupture,
            collision::BodyHit,
            collision::Collision,
            contact::BodyTable,
            contact_history::KeptRows,
            contact::ContactTable,
            contact_history::DraftHistory,
            contact_history::ContactHistory,
            energy::EnergyLedger,
            energy::MotionEnergies,
            findings::AddedPairs,
            findings::Ruptures,
            findings::EventSearch,
            findings::Sliding,
            findings::Corrections,
            findings::Pushed,
            findings::Impacts,
            findings::Reached,
            findings::Centre,
            IdentityTable,
            increment::ClasticAnalysis,
            increment::FrictionLaw,
            increment::RuptureRules,
            increment::Acceptance,
            increment::ClasticProgress,
            loads::TrialLoads,
            material::ContactLaw,
            material::Materials,
            measure::CrackSums,
            measure::NamedMeasures,
            membrane::Membrane,
            membrane::MembraneShape,
            measure::Readings,
            measure::StrainPath,
            measure::StrainReference,
            observation::Measures,
            observation::Observation,
            observation::RuptureCount,
            observation::Timings,
            particle::MaterialIndex,
            particle::SetAside,
            rigid_group::RigidGroup,
            rigid_group::ContactForce,
            wall::Wall,
            wall::WallName,
            wall::WallControl,
            wall::WallDrive,
            wall::WallRotation,
            wall::WallSlide,
            wall::WallTable,
            wall_shape::WallShape,
            program::ConeProgram,
            program::ConeSolution,
            MotionSettings,
            IncrementDue,
            ClasticHalted,
            ClasticRunning,
            ClasticStopped,
            IncrementUndone,
        );
    }
}

#[cfg(test)]
mod tests {
    use bevy_ecs::prelude::*;
    use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
    use bevy_reflect::ReflectRef;
    use bevy_reflect::tuple_struct::DynamicTupleStruct;
    use glam::DVec2;

    use super::*;

    /// An inspector finds a component by name, reads its field and sets it.
    #[test]
    fn a_position_is_read_and_set_by_name() -> Result<(), Box<dyn std::error::Error>> {
        let mut app = App::new();
        app.add_plugins(ReflectPlugin);
        let disk = app.world_mut().spawn(body::BodyPosition(DVec2::new(1.0, 2.0))).id();
        let registry = app.world().resource::<AppTypeRegistry>().clone();
        let registry = registry.read();
        let known = registry.get_with_type_path("clastic_components::body::BodyPosition");
        let by_name = known.and_then(|t| t.data::<ReflectComponent>()).ok_or("not registered")?;

        let entity = app.world().entity(disk);
        let value = by_name.reflect(entity).ok_or("no position")?;
        let ReflectRef::TupleStruct(fields) = value.reflect_ref() else {
            return Err("a position is a tuple struct".into());
        };
        let place = fields.field(0).and_then(|field| field.try_downcast_ref::<DVec2>());
        assert_eq!(place, Some(&DVec2::new(1.0, 2.0)));

        let mut moved = DynamicTupleStruct::default();
        moved.insert(DVec2::new(3.0, 4.0));
        by_name.apply(app.world_mut().entity_mut(disk), &moved);
        assert_eq!(app.world().get(disk), Some(&body::BodyPosition(DVec2::new(3.0, 4.0))));
        Ok(())
    }
}
