//! A rig inside a bare `bevy_app::App`, without a scene: the sample of ARCHITECTURE.md.

// [sample]
use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// Two bonded disks; one is held, the other is pulled away by 1.25 um in every increment.
fn pulled_pair() -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());

    let contact =
        ContactLaw { normal_compliance: 1.0 / 8.0e6, friction: 0.6, ..Default::default() };
    let bond = BondLaw {
        normal_compliance: 1.0 / 8.0e6,
        tangential_compliance: 1.0 / 4.0e6,
        rolling_compliance: 0.0,
        friction: 0.6,
        rolling_friction: 0.1,
        cohesion: 4.0e3,
        tensile_strength: 2.0e3,
    };
    let sand =
        material::Material { name: "sand".into(), density: 2650.0, contact, bond: Some(bond) };
    app.insert_resource(material::Materials(vec![sand]));

    let world = app.world_mut();
    let mut disk = |x, motion| {
        let held = BodyDrive::Imposed(0.0);
        let drives = BodyDrives([BodyDrive::Imposed(motion), held, held]);
        let disk = Particle::disk(6.0e-3, 2650.0, 1.0);
        world.spawn((disk, BodyPosition(DVec2::new(x, 0.0)), drives)).id()
    };
    let (held, pulled) = (disk(0.0, 0.0), disk(12.0e-3, 1.25e-6));
    world.spawn(Bond::between(held, pulled, bond));
    (app, pulled)
}
// [/sample]

use clastic::run::spawn::spawn_scene;
use clastic::run::{ScenePlugin, advance};

#[test]
fn the_bond_stretches_breaks_and_is_gone() {
    let (mut app, pulled) = pulled_pair();
    // k_N u, then the tensile strength 2 r h sigma_t = 24 N, then nothing.
    for expected in [10.0, 20.0, 24.0, 0.0] {
        app.update();
        let world = app.world();
        let status = world.resource::<Observation>().status.name();
        assert_eq!(status, "solved");
        let force = world.get::<BodyExternalForce>(pulled).unwrap().0[0];
        assert!((force - expected).abs() < 1e-6, "{force} N instead of {expected} N");
    }
    let observation = app.world().resource::<Observation>();
    assert_eq!((observation.bonds, observation.broken), (0, [1, 0, 0]));
}

/// Sets a value of a body, a bond or a material, and returns what puts the old one back.
type Spoil = fn(&mut World, Entity) -> Box<dyn Fn(&mut World)>;

fn spoil<C: Component + Clone>(
    world: &mut World,
    entity: Entity,
    change: impl Fn(&mut C),
) -> Box<dyn Fn(&mut World)> {
    let before = world.get::<C>(entity).unwrap().clone();
    let mut after = before.clone();
    change(&mut after);
    world.entity_mut(entity).insert(after);
    Box::new(move |world| {
        world.entity_mut(entity).insert(before.clone());
    })
}

fn bond_of(world: &mut World) -> Entity {
    world.query_filtered::<Entity, With<Bond>>().single(world).unwrap()
}

/// An app that had a value without meaning was told of an increment without a solution, or of
/// nothing. It is told the body and the value, nothing is computed with it, and once it is mended
/// the app goes on as if nothing had been.
#[test]
fn a_value_without_meaning_stops_the_app_and_is_named() {
    let cases: [(Spoil, &str); 6] = [
        (
            |world, disk| spoil(world, disk, |x: &mut BodyPosition| x.0.y = f64::NAN),
            "particle 1, ENTITY, has BodyPosition y = NaN: give a place in m",
        ),
        (
            |world, disk| spoil(world, disk, |p: &mut Particle| p.radius = -6.0e-3),
            "particle 1, ENTITY, has radius = -0.006: give a radius in m greater than 0",
        ),
        (
            |world, disk| spoil(world, disk, |p: &mut Particle| p.mass = f64::INFINITY),
            "particle 1, ENTITY, has mass = inf: give a mass in kg, not below 0",
        ),
        (
            |world, disk| {
                spoil(world, disk, |d: &mut BodyDrives| d.0[0] = BodyDrive::Imposed(f64::NAN))
            },
            "particle 1, ENTITY, has BodyDrives = NaN: give displacements in m and an angle in rad",
        ),
        (
            |world, _| {
                let bond = bond_of(world);
                spoil(world, bond, |bond: &mut Bond| bond.law.normal_compliance = 1.0 / 0.0)
            },
            "bond 0, ENTITY, of particle 0 and particle 1 has normal_compliance = inf: give 1 over a \
             stiffness above 0, or 0 for a rigid one",
        ),
        (
            |world, _| {
                let mut materials = world.resource_mut::<material::Materials>();
                materials.0[0].contact.friction = -0.5;
                Box::new(|world| {
                    world.resource_mut::<material::Materials>().0[0].contact.friction = 0.6;
                })
            },
            "material 0 (`sand`) has contact.friction = -0.5: give a coefficient of 0 or more",
        ),
    ];
    for (spoil, message) in cases {
        let (mut app, pulled) = pulled_pair();
        let named = if message.starts_with("bond") { bond_of(app.world_mut()) } else { pulled };
        let message = message.replace("ENTITY", &format!("entity {named}"));
        app.update();
        let mend = spoil(app.world_mut(), pulled);
        for _ in 0..2 {
            app.update();
        }
        let world = app.world_mut();
        let Some(ClasticHalted(reason)) = world.remove_resource::<ClasticHalted>() else {
            panic!("not said: {message}")
        };
        assert_eq!(
            reason,
            format!("{message}, then remove `ClasticHalted` and insert `ClasticRunning::Always`")
        );
        assert_eq!(*world.resource::<ClasticRunning>(), ClasticRunning::Stopped(StoppedBy::Halted));
        assert_eq!(world.resource::<ClasticProgress>().increment, 1, "{message}");
        mend(world);
        world.insert_resource(ClasticRunning::Always);
        app.update();
        let force = app.world().get::<BodyExternalForce>(pulled).unwrap().0[0];
        assert!((force - 20.0).abs() < 1e-6, "{message}: {force} N after it");
    }
}

/// A wall that a program spawns has a law of its own.
#[test]
fn a_wall_with_a_negative_compliance_is_named() {
    let (mut app, _) = pulled_pair();
    let place = BodyPosition(DVec2::new(0.0, -6.0e-3));
    let wall = Wall { tangent: DVec2::X, half_length: 0.05 };
    let law = ContactLaw { normal_compliance: -1.0e-8, ..Default::default() };
    app.world_mut().spawn((wall, place, law, Name::new("anvil")));
    app.update();
    let reason = &app.world().resource::<ClasticHalted>().0;
    assert!(
        reason.starts_with("wall (body 2), `anvil`, has normal_compliance = -1e-8: give"),
        "{reason}"
    );
}

/// A world with the scene of two free disks, as an embedding program fills it.
fn world_of_two_disks() -> (App, clastic::scene::format::Scene) {
    let text = r#"(
        version: 1, title: "two disks",
        materials: { "stone": () },
        specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (3.0, 0.0), radius: 1.0)]),
        stages: [Load(name: "rest", increments: 2)],
    )"#;
    let loaded = clastic::scene::from_str(text, "test.ron".as_ref(), "".as_ref(), &[]);
    let scene = loaded.unwrap_or_else(|e| panic!("{e}")).scene;
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin));
    spawn_scene(app.world_mut(), &scene, None);
    (app, scene)
}

#[test]
#[should_panic(expected = "the world has 2 bodies already")]
fn a_second_scene_in_one_world_is_refused() {
    let (mut app, scene) = world_of_two_disks();
    spawn_scene(app.world_mut(), &scene, None);
}

#[test]
fn a_scene_goes_on_without_a_despawned_particle() {
    let (mut app, _) = world_of_two_disks();
    let world = app.world_mut();
    assert_eq!(advance(world), Step::Increment);
    let mut particles = world.query_filtered::<(Entity, &BodyId), With<Particle>>();
    let first = particles.iter(world).find(|(_, id)| id.0 == 0).map(|(entity, _)| entity).unwrap();
    world.despawn(first);
    assert_eq!(advance(world), Step::Increment);
    assert_eq!(world.resource::<BodyTable>().ids, [BodyId(1)]);
    assert_eq!(advance(world), Step::Finished(Outcome::Completed));
}

#[test]
fn a_bond_ends_with_its_wall() {
    let (mut app, _) = pulled_pair();
    let world = app.world_mut();
    let law = world.query::<&Bond>().iter(world).next().unwrap().law;
    let place = BodyPosition(DVec2::new(-6.0e-3, 0.0));
    let wall = Wall { tangent: DVec2::NEG_Y, half_length: 0.05 };
    let wall = world.spawn((wall, place, ContactLaw::default())).id();
    let bond = |b| Bond { a: BodyId(0), b: BodyId(b), initial_gap: 0.0, law };
    world.spawn(bond(2));
    let count = |app: &mut App| {
        app.update();
        app.world().resource::<Observation>().bonds
    };
    assert_eq!(count(&mut app), 2);
    // The bond ends with the wall.
    app.world_mut().despawn(wall);
    assert_eq!(count(&mut app), 1);
}

#[test]
fn the_sample_of_the_architecture_page_is_this_one() {
    let page = include_str!("../../ARCHITECTURE.md");
    let sample = include_str!("embedding.rs").split("// [sample]\n").nth(1).unwrap();
    let sample = sample.split("// [/sample]").next().unwrap();
    assert!(
        page.contains(sample),
        "copy the sample of tests/engine/embedding.rs to ARCHITECTURE.md"
    );
}
