//! A rig inside a bare `bevy_app::App`, without a scene: the sample of ARCHITECTURE.md.

// [sample]
use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// Two bonded disks; one is held, the other is pulled away by 1.25 um in every increment.
fn pulled_pair() -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins);
    app.add_systems(Update, |world: &mut World| world.run_schedule(Increment));

    let contact =
        ContactLaw { normal_compliance: 1.0 / 8.0e6, friction: 0.6, ..Default::default() };
    let bond = BondLaw {
        normal_compliance: 1.0 / 8.0e6,
        tangential_compliance: 1.0 / 4.0e6,
        friction: 0.6,
        rolling_friction: 0.1,
        cohesion: 4.0e3,
        tensile_strength: 2.0e3,
    };
    let sand = Material { name: "sand".into(), density: 2650.0, contact, bond: Some(bond) };
    app.insert_resource(Materials(vec![sand]));
    // Four increments, each tried as a whole at first.
    app.insert_resource(Progress { total: 4.0, fraction: 1.0, ..Default::default() });

    let world = app.world_mut();
    let mut disk = |id, x, motion| {
        let (place, held) = (DVec2::new(x, 0.0), Drive::Imposed(0.0));
        let drives = Drives([Drive::Imposed(motion), held, held]);
        let disk = Particle::disk(6.0e-3, 2650.0, 1.0);
        world.spawn((BodyId(id), disk, Position(place), Origin(place), drives)).id()
    };
    disk(0, 0.0, 0.0);
    let pulled = disk(1, 12.0e-3, 1.25e-6);
    let (a, b) = (BodyId(0), BodyId(1));
    world.spawn((BondId(0), Bond { a, b, initial_gap: 0.0, law: bond }));
    (app, pulled)
}
// [/sample]

#[test]
fn the_bond_stretches_breaks_and_is_gone() {
    let (mut app, pulled) = pulled_pair();
    // k_N u, then the tensile strength 2 r h sigma_t = 24 N, then nothing.
    for expected in [10.0, 20.0, 24.0, 0.0] {
        app.update();
        let world = app.world();
        let status = world.resource::<Observation>().status.name();
        assert_eq!(status, "solved");
        let force = world.get::<ExternalForce>(pulled).unwrap().0[0];
        assert!((force - expected).abs() < 1e-6, "{force} N instead of {expected} N");
    }
    let observation = app.world().resource::<Observation>();
    assert_eq!((observation.bonds, observation.broken), (0, [1, 0, 0]));
}

#[test]
fn the_sample_of_the_architecture_page_is_this_one() {
    let page = include_str!("../ARCHITECTURE.md");
    let sample = include_str!("embedding.rs").split("// [sample]\n").nth(1).unwrap();
    let sample = sample.split("// [/sample]").next().unwrap();
    assert!(page.contains(sample), "copy the sample of tests/embedding.rs to ARCHITECTURE.md");
}
