//! Bodies and bonds that come and go while a run is under way.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::components::contact_history::{ContactHistory, KeptRows};
use clastic::output::{self, OutputPlugin, RunOptions};
use clastic::prelude::*;
use clastic::run::WorldState;
use clastic::scene::format::Stage;
use clastic::scene::{self, LoadedScene};
use glam::DVec2;

/// Three disks on each other in a box, with friction and elastic contacts.
fn box_of_disks() -> LoadedScene {
    let text = r#"(
        version: 1, title: "box",
        analysis: Dynamic(dt: 1.0e-3, theta: 1.0),
        gravity: (0.0, -9.81),
        materials: { "stone": (density: 2650.0,
            contact: (normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5, friction: 0.4)) },
        specimen: Particles([
            (position: (0.00, 0.05), radius: 0.05),
            (position: (0.02, 0.15), radius: 0.05),
            (position: (-0.01, 0.25), radius: 0.05),
        ]),
        walls: [
            (name: "floor", start: (-0.1, 0.0), end: (0.1, 0.0),
                contact: (normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5, friction: 0.4)),
            (name: "left", start: (-0.1, 1.0), end: (-0.1, 0.0), contact: (normal_stiffness: 1.0e6)),
            (name: "right", start: (0.1, 0.0), end: (0.1, 1.0), contact: (normal_stiffness: 1.0e6)),
        ],
        stages: [
            Load(name: "fall", increments: 300),
            Load(name: "open", increments: 100, remove_walls: ["left"]),
        ],
    )"#;
    scene::from_str(text, "box.ron".as_ref(), "".as_ref(), &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn bytes(state: &WorldState) -> Vec<u8> {
    postcard::to_stdvec(state).unwrap()
}

fn steps(simulation: &mut Simulation, count: usize) {
    for _ in 0..count {
        assert_eq!(simulation.step(), Step::Increment);
        let record = simulation.world().resource::<Observation>();
        assert_eq!(record.status.name(), "solved", "increment {}", record.increment);
    }
}

fn particle(simulation: &mut Simulation, id: u32) -> Entity {
    let mut particles =
        simulation.world_mut().query_filtered::<(Entity, &BodyId), With<Particle>>();
    let found = particles.iter(simulation.world()).find(|(_, found)| found.0 == id);
    found.map(|(entity, _)| entity).unwrap_or_else(|| panic!("no particle {id}"))
}

#[test]
fn a_run_into_which_disks_are_poured_and_from_which_one_goes_resumes_to_the_same_bytes() {
    let loaded = box_of_disks();
    let mut simulation = Simulation::new(&loaded.scene, None);
    steps(&mut simulation, 150);
    // Walls have the identities 3, 4, 5: the new disk has 6, and its row is before theirs.
    let disk = Particle::disk(0.04, 2650.0, 1.0);
    let place = BodyPosition(DVec2::new(0.0, 0.6));
    let poured = simulation.world_mut().spawn((disk, place)).id();
    assert_eq!(simulation.world().get::<BodyId>(poured), Some(&BodyId(6)));
    steps(&mut simulation, 100);
    let ids: Vec<u32> =
        simulation.world().resource::<BodyTable>().ids.iter().map(|id| id.0).collect();
    assert_eq!(ids, [0, 1, 2, 6, 3, 4, 5]);

    let bottom = particle(&mut simulation, 0);
    simulation.world_mut().despawn(bottom);
    // In the middle of the gap that it leaves: the tables have the rows of before.
    let state = simulation.state().unwrap();
    let mut resumed = Simulation::resume(&loaded.scene, &state).unwrap();
    for run in [&mut simulation, &mut resumed] {
        // Beyond the end of the stage, in which a wall goes.
        steps(run, 100);
        let ids: Vec<u32> = run.world().resource::<KeptRows>().ids.iter().map(|id| id.0).collect();
        assert_eq!(ids, [1, 2, 6, 3, 5]);
    }
    assert!(bytes(&simulation.state().unwrap()) == bytes(&resumed.state().unwrap()));
}

#[test]
fn a_disk_far_away_that_comes_or_goes_changes_no_force() {
    let loaded = box_of_disks();
    let mut quiet = Simulation::new(&loaded.scene, None);
    let mut busy = Simulation::new(&loaded.scene, None);
    let shear = |run: &Simulation| {
        let history = &run.world().resource::<ContactHistory>().0;
        history.iter().map(|m| (m.p, m.q)).collect::<Vec<_>>()
    };
    for round in 0..10 {
        steps(&mut quiet, 20);
        steps(&mut busy, 20);
        let (expected, found) = (shear(&quiet), shear(&busy));
        assert_eq!(expected.len(), found.len(), "round {round}");
        for ((p, q), (r, s)) in expected.into_iter().zip(found) {
            assert!((p - r).abs() < 1e-6 && (q - s).abs() < 1e-6, "round {round}: {p} {q} {r} {s}");
        }
        // It falls freely beside the box, and is taken away every other round.
        if round % 2 == 0 {
            let disk = Particle::disk(0.01, 2650.0, 1.0);
            busy.world_mut().spawn((disk, BodyPosition(DVec2::new(0.0, 50.0))));
        } else {
            let id = busy.world().resource::<BodyTable>().ids[3].0;
            let far = particle(&mut busy, id);
            busy.world_mut().despawn(far);
        }
    }
}

#[test]
#[should_panic(expected = "body 1 is entity")]
fn a_second_body_of_an_identity_is_refused() {
    let mut simulation = Simulation::new(&box_of_disks().scene, None);
    let disk = Particle::disk(0.04, 2650.0, 1.0);
    simulation.world_mut().spawn((BodyId(1), disk, BodyPosition(DVec2::new(0.0, 0.6))));
}

#[test]
#[should_panic(expected = "a wall bonds to disks")]
fn a_bond_between_two_walls_is_refused() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let wall = Wall { tangent: DVec2::X, half_length: 1.0 };
    let [a, b] =
        [0.0, 1.0].map(|y| app.world_mut().spawn((wall, BodyPosition(DVec2::new(0.0, y)))).id());
    app.world_mut().spawn(Bond::between(a, b, BondLaw::default()));
}

#[test]
fn a_run_ends_in_the_same_state_without_output() {
    let loaded = box_of_disks();
    let mut silent = Simulation::new(&loaded.scene, None);
    let mut written = Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, None);
    let parent = tempfile::tempdir().unwrap();
    let options = RunOptions { directory: parent.path().join("run"), ..Default::default() };
    output::begin(written.world_mut(), options, &loaded).unwrap();
    assert_eq!(silent.run(), written.run());
    let (silent, mut written) = (silent.state().unwrap(), written.state().unwrap());
    written.retain(|name| !name.starts_with("output."));
    assert!(bytes(&silent) == bytes(&written));
    let history = std::fs::read_to_string(parent.path().join("run/history.csv")).unwrap();
    assert_eq!(history.lines().count(), 401);
}

#[test]
fn a_disk_that_cannot_be_written_halts_the_run_and_panics_not() {
    let loaded = box_of_disks();
    let mut simulation = Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, None);
    let parent = tempfile::tempdir().unwrap();
    let directory = parent.path().join("run");
    let options = RunOptions { directory: directory.clone(), ..Default::default() };
    output::begin(simulation.world_mut(), options, &loaded).unwrap();
    simulation.step();
    std::fs::remove_file(directory.join("history.csv")).unwrap();
    let Step::Finished(Outcome::Halted(halted)) = simulation.step() else { panic!("it went on") };
    assert!(halted.contains("history.csv"), "{halted}");
    // Nothing goes on from there.
    let increment = simulation.world().resource::<ClasticProgress>().increment;
    assert_eq!(simulation.run(), Outcome::Halted(halted));
    assert_eq!(simulation.world().resource::<ClasticProgress>().increment, increment);
}

#[test]
fn a_wall_that_comes_after_a_disk_was_poured_has_an_identity_of_its_own() {
    let loaded = box_of_disks();
    let mut scene = loaded.scene;
    let lid = scene.walls.iter_mut().find(|wall| wall.name == "right").unwrap();
    // Far from where the disks roll until it comes.
    (lid.present, lid.start.0, lid.end.0) = (false, 3.0, 3.0);
    let Stage::Load(stage) = &mut scene.stages[1] else { panic!() };
    stage.add_walls.push("right".to_owned());
    let mut simulation = Simulation::new(&scene, None);
    steps(&mut simulation, 20);
    let disk = Particle::disk(0.04, 2650.0, 1.0);
    simulation.world_mut().spawn((disk, BodyPosition(DVec2::new(0.0, 0.6))));
    assert_eq!(simulation.run(), Outcome::Completed);
    let ids: Vec<u32> =
        simulation.world().resource::<BodyTable>().ids.iter().map(|id| id.0).collect();
    assert_eq!(ids, [0, 1, 2, 6, 3, 5]);
}

#[test]
fn tables_lose_the_bonds_that_broke_whatever_their_rows() {
    // Identities 1, 2, 3 in rows 0, 1, 2.
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let world = app.world_mut();
    let disks = [0.0, 2.0, 4.0, 6.0].map(|x| {
        let place = BodyPosition(DVec2::new(x, 0.0));
        world.spawn((Particle::disk(1.0, 2650.0, 1.0), place, BodyDrives::imposed([0.0; 3]))).id()
    });
    let law = BondLaw { normal_compliance: 1.0e-6, tensile_strength: 1.0, ..Default::default() };
    let bonds = [1, 2].map(|k| world.spawn(Bond::between(disks[k], disks[k + 1], law)).id());
    world.despawn(disks[0]);
    app.update();
    let first = *app.world().get::<BondId>(bonds[0]).unwrap();
    let mut bodies = app.world_mut().resource_mut::<BodyTable>();
    bodies.break_bonds(&[first]);
    let left: Vec<_> = bodies.bonds.iter().map(|bond| (bond.a, bond.b)).collect();
    assert_eq!(left, [(1, 2)]);
    assert_eq!(bodies.broken[0].id, first);
}

#[test]
fn a_wall_under_a_stress_whose_length_is_gone_halts_the_run() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let world = app.world_mut();
    let mut wall = |tangent, x, y| {
        let place = BodyPosition(DVec2::new(x, y));
        world.spawn((Wall { tangent, half_length: 1.0 }, place)).id()
    };
    let (left, right) = (wall(DVec2::NEG_Y, -1.0, 0.0), wall(DVec2::Y, 1.0, 0.0));
    let lid = wall(DVec2::NEG_X, 0.0, 1.0);
    wall(DVec2::X, 0.0, -1.0);
    let length = LoadedLength::Between(left, right);
    world.entity_mut(lid).insert(WallControl::Stress { from: 1.0, to: 1.0, length });
    world.spawn((Particle::disk(1.0, 2650.0, 1.0), BodyPosition::default()));
    app.update();
    assert!(!app.world().contains_resource::<ClasticHalted>());
    app.world_mut().despawn(right);
    app.update();
    assert!(app.world().resource::<ClasticHalted>().0.contains("a removed wall"));
}
