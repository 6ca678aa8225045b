//! With the feature `reflect` an app knows the types of the engine.

use bevy_app::App;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::ReflectRef;
use bevy_reflect::tuple_struct::DynamicTupleStruct;
use clastic_components::body::BodyPosition;
use glam::DVec2;

/// An inspector finds a component by name, reads its field and sets it.
#[test]
fn a_position_is_read_and_set_by_name() -> Result<(), Box<dyn std::error::Error>> {
    let mut app = App::new();
    let disk = app.world_mut().spawn(BodyPosition(DVec2::new(1.0, 2.0))).id();
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
    assert_eq!(app.world().get(disk), Some(&BodyPosition(DVec2::new(3.0, 4.0))));
    Ok(())
}
