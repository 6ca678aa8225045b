//! Systems of an embedding program in the public sets: the samples of ARCHITECTURE.md.

// [sample]
use std::f64::consts::TAU;

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// A wall whose height is `rest + amplitude sin(2 pi n / period)` after n increments of a stage.
#[derive(Component)]
struct Sine {
    rest: f64,
    amplitude: f64,
    period: f64,
}

impl Sine {
    fn height(&self, n: f64) -> f64 {
        self.rest + self.amplitude * (TAU * n / self.period).sin()
    }
}

/// For `ControlSystems::Custom`: what the walls do in the increment that follows.
fn follow_sine(
    progress: Res<ClasticProgress>,
    mut walls: Query<(&Sine, &BodyPosition, &mut WallDrive)>,
) {
    for (sine, position, mut drive) in &mut walls {
        // A drive is for a whole increment. Where one had to be halved, only `left` of it is still
        // to come; measured from where the wall is, nothing adds up.
        let left = 1.0 - progress.done.fract();
        let motion = (sine.height(progress.done + left) - position.0.y) / left;
        *drive = WallDrive::Imposed(DVec2::new(0.0, motion));
    }
}

/// A particle on springs (N/m) that pull it back to its `BodyOrigin`.
#[derive(Component)]
struct Foundation(f64);

/// For `AddTrialLoads`: the force `-k (x + u - x_0)`, with x the place from which the trial starts.
/// Entities still hold the last committed state where an increment is halved or a motion is
/// followed; `BodyTable` holds the trial's.
fn support(
    springs: Query<(&BodyId, &Foundation, &BodyOrigin)>,
    bodies: Res<BodyTable>,
    mut loads: ResMut<TrialLoads>,
) {
    for (id, spring, origin) in &springs {
        let Some(row) = bodies.row(*id) else { continue };
        let stretched = bodies.positions[row] - origin.0;
        for k in 0..2 {
            loads.add_spring(*id, k, -spring.0 * stretched[k], spring.0);
        }
    }
}

/// A plugin, added after those of the engine.
fn custom_boundaries(app: &mut App) {
    app.add_systems(ControlWalls, follow_sine.in_set(ControlSystems::Custom));
    app.add_systems(AddTrialLoads, support);
}
// [/sample]

use std::path::Path;

use bevy_app::PluginGroup;
use clastic::cone::program::{Interaction, Limits};
use clastic::output::{self, OutputPlugin, RunOptions};
use clastic::run::spawn::spawn_scene;
use clastic::run::{ScenePlugin, advance};
use clastic::scene;
use clastic::systems::rupture::bonds::RuptureBondsPlugin;

const RADIUS: f64 = 6.0e-3;
const STIFFNESS: f64 = 8.0e6;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), custom_boundaries));
    let contact = ContactLaw { normal_compliance: 1.0 / STIFFNESS, ..Default::default() };
    let sand = material::Material { name: "sand".into(), density: 2650.0, contact, bond: None };
    app.insert_resource(material::Materials(vec![sand]));
    app
}

fn disk(y: f64) -> impl Bundle {
    let place = DVec2::new(0.0, y);
    (BodyId(0), Particle::disk(RADIUS, 2650.0, 1.0), BodyPosition(place), BodyOrigin(place))
}

fn wall(id: u32, tangent: DVec2, y: f64) -> impl Bundle {
    let law = ContactLaw { normal_compliance: 1.0 / STIFFNESS, ..Default::default() };
    let place = BodyPosition(DVec2::new(0.0, y));
    (BodyId(id), Wall { tangent, half_length: 0.05 }, place, law)
}

#[test]
fn a_wall_follows_a_sine_and_squeezes_a_disk() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(disk(RADIUS));
    world.spawn(wall(1, DVec2::X, 0.0));
    let sine = Sine { rest: 2.0 * RADIUS, amplitude: 1.0e-6, period: 12.0 };
    let lid = world.spawn((wall(2, DVec2::NEG_X, sine.rest), WallControl::Custom, sine)).id();
    for n in 1..=24 {
        world.run_schedule(Increment);
        let status = world.resource::<Observation>().status.name();
        assert_eq!(status, "solved", "increment {n}");
        let sine = world.get::<Sine>(lid).unwrap();
        let (sought, squeezed) = (sine.height(f64::from(n)), sine.rest - sine.height(f64::from(n)));
        let height = world.get::<BodyPosition>(lid).unwrap().0.y;
        assert!((height - sought).abs() < 1e-16, "increment {n}: {height} for {sought}");
        // Two equal springs in series under the lid, none above it; positive pushes downwards.
        let force = -world.get::<BodyExternalForce>(lid).unwrap().0[1];
        let expected = 0.5 * STIFFNESS * squeezed.max(0.0);
        assert!((force - expected).abs() < 1e-6, "increment {n}: {force} N for {expected} N");
    }
}

#[test]
fn the_wall_is_in_its_place_after_a_halved_increment() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(disk(RADIUS));
    world.spawn(wall(1, DVec2::X, 0.0));
    let sine = Sine { rest: 2.0 * RADIUS, amplitude: 1.0e-6, period: 12.0 };
    let sought = sine.height(1.0);
    let lid = world.spawn((wall(2, DVec2::NEG_X, sine.rest), WallControl::Custom, sine)).id();
    // As if the increment before had been quartered: fractions grow by doubling.
    world.resource_mut::<ClasticProgress>().tried = 0.25;
    for done in [0.5, 1.0] {
        world.run_schedule(Increment);
        assert_eq!(world.resource::<ClasticProgress>().done, done);
    }
    let height = world.get::<BodyPosition>(lid).unwrap().0.y;
    assert!((height - sought).abs() < 1e-16, "{height} for {sought}");
}

#[test]
fn extra_rows_hold_a_disk_on_springs() {
    let mut app = app();
    // A load goes to its target over the increments of a stage.
    app.insert_resource(ClasticProgress { total: 24.0, ..Default::default() });
    let load = LoadControl([(0.0, 0.0), (0.0, -24.0), (0.0, 0.0)]);
    let world = app.world_mut();
    let disk = world.spawn((disk(0.0), Foundation(1.0e6), load)).id();
    for n in 1..=24 {
        world.run_schedule(Increment);
        let y = world.get::<BodyPosition>(disk).unwrap().0.y;
        let expected = -1.0e-6 * f64::from(n);
        assert!(
            (y - expected).abs() < 1e-7 * expected.abs(),
            "increment {n}: {y} m for {expected} m"
        );
    }
}

/// A parameter of the contact law in three steps: a component with it, a system that writes it into
/// the interactions, and the line that adds this system.
#[derive(Component)]
struct Wet(f64);

fn lubricate(
    wet: Query<(&BodyId, &Wet)>,
    (bodies, contacts): (Res<BodyTable>, Res<ContactTable>),
    mut program: ResMut<ConeProgram>,
) {
    for (contact, c) in contacts.0.iter().zip(&mut program.interactions) {
        for (id, wet) in &wet {
            if contact.bond.is_none() && bodies.ids[contact.a as usize] == *id {
                c.limits.friction *= wet.0;
            }
        }
    }
}

/// A disk that does not turn is pushed along a floor: the floor resists by mu m g, mu halved by
/// water.
#[test]
fn a_parameter_of_the_contact_law_of_a_plugin_changes_the_friction() {
    let mut app = app();
    app.add_systems(AttemptIncrement, lubricate.in_set(AttemptSystems::AssembleExtra));
    app.world_mut().resource_mut::<ClasticAnalysis>().gravity = DVec2::new(0.0, -9.81);
    let law = ContactLaw {
        normal_compliance: 1.0 / STIFFNESS,
        tangential_compliance: 1.0 / STIFFNESS,
        friction: 0.5,
        ..Default::default()
    };
    let world = app.world_mut();
    world.spawn((Wall::between(DVec2::new(-1.0, 0.0), DVec2::new(1.0, 0.0)), law));
    let push = BodyDrives([BodyDrive::Imposed(1.0e-4), BodyDrive::Free, BodyDrive::Imposed(0.0)]);
    let wet = world.spawn((Particle::disk(RADIUS, 2650.0, 1.0), push, Wet(0.5))).id();
    world.entity_mut(wet).insert(BodyPosition(DVec2::new(0.0, RADIUS)));
    let dry = world.spawn((Particle::disk(RADIUS, 2650.0, 1.0), push)).id();
    world.entity_mut(dry).insert(BodyPosition(DVec2::new(0.1, RADIUS)));
    for _ in 0..3 {
        world.run_schedule(Increment);
        assert_eq!(world.resource::<Observation>().status.name(), "solved");
    }
    let weight = world.get::<Particle>(wet).unwrap().mass * 9.81;
    for (disk, friction) in [(wet, 0.25), (dry, 0.5)] {
        let push = world.get::<BodyExternalForce>(disk).unwrap().0[0];
        assert!((push - friction * weight).abs() < 1e-6 * weight, "{push} N with {friction}");
    }
}

/// Rows that a plugin appends free the degrees of freedom on which they act.
#[test]
fn appended_interactions_free_their_bodies() {
    fn glue(mut program: ResMut<ConeProgram>) {
        let glue = Interaction {
            normal: DVec2::Y,
            normal_compliance: 1.0e-6,
            limits: Limits { tension: 1.0e6, ..Limits::default() },
            ..Interaction::between(0, 1)
        };
        program.interactions.push(glue);
    }
    let mut app = app();
    app.add_systems(AttemptIncrement, glue.in_set(AttemptSystems::AssembleExtra));
    let world = app.world_mut();
    let free = world.spawn(disk(0.0)).id();
    let lift = BodyDrives::imposed([0.0, 1.0e-6, 0.0]);
    let place = BodyPosition(DVec2::new(0.0, 1.0));
    world.spawn((Particle::disk(RADIUS, 2650.0, 1.0), place, lift));
    world.run_schedule(Increment);
    assert_eq!(world.resource::<Observation>().status.name(), "solved");
    // Nothing else acts on it: it follows the other disk without force.
    let y = world.get::<BodyPosition>(free).unwrap().0.y;
    assert!((y - 1.0e-6).abs() < 1e-12, "{y} m");
}

#[test]
fn loads_of_several_systems_add_up_in_any_order() {
    fn push(mut loads: ResMut<TrialLoads>) {
        loads.add(BodyId(0), [0.1, 0.0, 0.0]);
    }
    fn pull(mut loads: ResMut<TrialLoads>) {
        loads.add(BodyId(0), [-0.3, 7.0e7, 0.0]);
    }
    let place = |reversed: bool| {
        let mut app = app();
        // Neither states an order, and the schedule accepts both.
        if reversed {
            app.add_systems(AddTrialLoads, (pull, push));
        } else {
            app.add_systems(AddTrialLoads, (push, pull));
        }
        let world = app.world_mut();
        let disk = world.spawn((disk(0.0), Foundation(1.0e9))).id();
        world.run_schedule(Increment);
        assert_eq!(world.resource::<Observation>().status.name(), "solved");
        world.get::<BodyPosition>(disk).unwrap().0
    };
    let found = place(false);
    assert!((found - DVec2::new(-0.2e-9, 0.07)).length() < 1e-12, "{found}");
    assert_eq!(found, place(true));
}

#[test]
#[should_panic(expected = "conflicting data access")]
fn an_order_that_nobody_stated_is_refused() {
    fn lift(mut walls: Query<&mut WallDrive>) {
        for mut drive in &mut walls {
            *drive = WallDrive::Imposed(DVec2::Y);
        }
    }
    let mut app = app();
    // Both write WallDrive, and neither is before the other.
    app.add_systems(ControlWalls, lift.in_set(ControlSystems::Custom));
    app.world_mut().run_schedule(ControlWalls);
}

#[test]
fn a_stated_order_is_accepted() {
    fn still(mut walls: Query<&mut WallDrive>) {
        for mut drive in &mut walls {
            *drive = WallDrive::default();
        }
    }
    let mut app = app();
    app.add_systems(ControlWalls, still.in_set(ControlSystems::Custom).after(follow_sine));
    app.world_mut().run_schedule(ControlWalls);
}

#[test]
fn the_sample_of_the_architecture_page_is_this_one() {
    let page = include_str!("../../ARCHITECTURE.md");
    let sample = include_str!("extension.rs").split("// [sample]\n").nth(1).unwrap();
    let sample = sample.split("// [/sample]").next().unwrap();
    assert!(
        page.contains(sample),
        "copy the sample of tests/engine/extension.rs to ARCHITECTURE.md"
    );
}

/// A rule of rupture that replaces that of the engine: bonds break at a tension of 10 N.
fn break_at_10_newtons(
    (contacts, bodies): (Res<ContactTable>, Res<BodyTable>),
    solution: Res<ConeSolution>,
    progress: Res<ClasticProgress>,
    mut bonds: Query<&mut BondState>,
    mut record: ResMut<Observation>,
) {
    for (contact, [p, q, tau]) in contacts.0.iter().zip(&solution.forces) {
        let Some(row) = contact.bond.map(|k| bodies.bonds[k as usize]).filter(|_| *p < -10.0)
        else {
            continue;
        };
        let mode = RuptureMode::Tension;
        *bonds.get_mut(row.entity).unwrap() = BondState::Broken(mode);
        record.ruptures.push(Rupture {
            increment: progress.increment,
            bond: row.id,
            a: bodies.ids[row.a as usize],
            b: bodies.ids[row.b as usize],
            mode,
            position: contact.point(&bodies),
            normal: contact.normal,
            p: *p,
            q: *q,
            tau: *tau,
        });
    }
}

#[test]
fn ruptures_by_a_rule_of_an_embedding_program_are_events() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tension.ron");
    let loaded = scene::load(Path::new(path), &[]).unwrap();
    let mut app = App::new();
    let engine = ClasticPlugins::default().build().disable::<RuptureBondsPlugin>();
    app.add_plugins((engine, ScenePlugin, OutputPlugin));
    app.add_systems(Increment, break_at_10_newtons.in_set(IncrementSystems::Rupture));
    spawn_scene(app.world_mut(), &loaded.scene, None);
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { directory: out.path().to_owned(), ..Default::default() };
    output::begin(app.world_mut(), options, &loaded).unwrap();
    let mut broke = None;
    while advance(app.world_mut()) == Step::Increment {
        let record = app.world().resource::<Observation>();
        if let [rupture] = record.ruptures.as_slice() {
            assert_eq!(broke.replace((record.increment, *rupture)), None, "it broke twice");
        }
        assert_eq!(record.broken, [usize::from(broke.is_some()), 0, 0]);
    }
    output::finish(app.world_mut(), Some(&Outcome::Completed)).unwrap();
    // The engine's own rule breaks the bond at 24 N.
    let (increment, rupture) = broke.unwrap();
    assert!(rupture.p < -10.0 && rupture.p > -12.0, "{rupture:?}");
    let read = |name: &str| std::fs::read_to_string(out.path().join(name)).unwrap();
    let events = read("events.csv");
    let rows: Vec<_> = events.lines().skip(1).collect();
    assert_eq!(rows.len(), 1, "{events}");
    assert!(rows[0].starts_with(&format!("{increment},pull,0,0,1,tension,")), "{events}");
    let record: serde_json::Value = serde_json::from_str(&read("run.json")).unwrap();
    let broken = &record["results"]["bonds_broken"];
    assert_eq!((&broken["tension"], &broken["shear"]), (&1.into(), &0.into()));
    assert_eq!(record["results"]["bonds_intact"], 0);
}
