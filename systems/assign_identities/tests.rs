use std::sync::Mutex;

use bevy_ecs::error::{BevyError, ErrorContext, FallbackErrorHandler};
use clastic_components::material::BondLaw;
use glam::DVec2;

use super::*;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins(AssignIdentitiesPlugin);
    app
}

fn disk(x: f64) -> (Particle, BodyPosition) {
    (Particle::disk(1.0, 2650.0, 1.0), BodyPosition(DVec2::new(x, 0.0)))
}

#[test]
fn identities_follow_the_order_of_insertion_and_are_not_used_again() {
    let mut app = app();
    let world = app.world_mut();
    let [a, b] = [0.0, 2.0].map(|x| world.spawn(disk(x)).id());
    assert_eq!(world.get::<BodyId>(a), Some(&BodyId(0)));
    assert_eq!(world.get::<BodyOrigin>(b), Some(&BodyOrigin(DVec2::new(2.0, 0.0))));
    world.despawn(b);
    let c = world.spawn(disk(4.0)).id();
    assert_eq!(world.get::<BodyId>(c), Some(&BodyId(2)));
    let d = world.spawn((disk(6.0), BodyId(9))).id();
    let e = world.spawn(disk(8.0)).id();
    assert_eq!(world.get::<BodyId>(e), Some(&BodyId(10)));
    assert_eq!(world.resource::<IdentityTable>().body(BodyId(9)), Some(d));
    assert_eq!(world.resource::<IdentityTable>().body(BodyId(1)), None);
}

#[test]
fn a_batch_of_commands_holds_two_disks_and_their_bond() {
    let mut app = app();
    let world = app.world_mut();
    let mut commands = world.commands();
    let [a, b] = [2.5, 0.0].map(|x| commands.spawn(disk(x)).id());
    let bond = commands.spawn(Bond::between(b, a, BondLaw::default())).id();
    world.flush();
    let found = world.get::<Bond>(bond).copied().unwrap_or_else(|| panic!("no bond"));
    assert_eq!((found.a, found.b), (BodyId(0), BodyId(1)));
    assert!((found.initial_gap - 0.5).abs() < 1e-15);
    assert_eq!(world.get::<BondId>(bond), Some(&BondId(0)));
    assert!(world.get::<Joint>(bond).is_none());
    // Removing the body removes the bond.
    world.despawn(a);
    assert!(world.get_entity(bond).is_err());
}

#[test]
fn a_second_body_of_one_identity_is_refused() {
    let mut app = app();
    let world = app.world_mut();
    static SAID: Mutex<String> = Mutex::new(String::new());
    fn hear(error: BevyError, _: ErrorContext) {
        SAID.lock().unwrap_or_else(|e| panic!("{e}")).push_str(&error.to_string());
    }
    world.insert_resource(FallbackErrorHandler(hear));
    let first = world.spawn((disk(0.0), BodyId(3))).id();
    let second = world.spawn((disk(2.0), BodyId(3))).id();
    assert_eq!(world.resource::<IdentityTable>().body(BodyId(3)), Some(first));
    assert!(world.get::<Particle>(second).is_none());
    let said = SAID.lock().unwrap_or_else(|e| panic!("{e}")).clone();
    assert!(said.contains("body 3") && said.contains("BodyId"), "{said}");
}

#[test]
#[should_panic(expected = "add ClasticPlugins before the first of them")]
fn a_body_before_the_plugin_is_refused() {
    let mut app = App::new();
    app.world_mut().spawn(disk(0.0));
    app.add_plugins(AssignIdentitiesPlugin);
}
