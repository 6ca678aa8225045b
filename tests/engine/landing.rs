//! `Until`: where stages land, against hand calculations, and traces of an increment that is
//! undone.

use bevy_app::App;
use bevy_ecs::prelude::{Entity, With};
use bevy_ecs::schedule::IntoScheduleConfigs as _;
use clastic::components::body::BodyId;
use clastic::components::measure::Readings;
use clastic::components::observation::Observation;
use clastic::components::particle::Particle;
use clastic::prelude::*;
use clastic::run::stages::Script;
use clastic::run::{Outcome, StateError, WorldState};
use clastic::systems::schedule::{Increment, IncrementSystems};
use clastic::systems::state::RegisterState;

use crate::common::*;

/// A disk between two platens, each contact a spring of 1e7 N/m, loaded in steps of 10 um.
fn column(law: &str, stages: &str) -> String {
    format!(
        r#"(version: 1, title: "column", friction_law: {law},
        materials: {{ "m": (density: 2000.0) }},
        specimen: Particles([(position: (0.0, 0.01), radius: 0.01)]),
        walls: [
            (name: "bottom", start: (-0.01, 0.0), end: (0.01, 0.0), contact: (normal_stiffness: 1.0e7)),
            (name: "top", start: (0.01, 0.02), end: (-0.01, 0.02), contact: (normal_stiffness: 1.0e7)),
        ],
        stages: [{stages}],
        reference_stage: "load",
        measures: [
            (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
            (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Fixed(0.02)))),
        ])"#
    )
}

const UP_AND_DOWN: &str = r#"
    Load(name: "load", increments: 20, walls: { "top": Displacement(0.0, -1.0e-5) },
        stop: [Until("axial_stress", 33.0e3)]),
    Load(name: "unload", increments: 20, walls: { "top": Displacement(0.0, 1.0e-5) },
        stop: [Until("axial_stress", 0.0)]),"#;

fn of_stage<'a>(records: &'a [Observation], stage: &str) -> Vec<&'a Observation> {
    records.iter().filter(|record| record.stage == stage).collect()
}

/// Two springs of 1e7 N/m in a row: 33 kPa on 0.02 m are 660 N and 132 um. The platen leaves the
/// disk where the stress comes to zero, and the stage ends there and not where its increment would
/// end.
#[test]
fn a_column_lands_where_the_springs_say_and_shortens_one_increment() {
    for law in ["Associated", "Coulomb()"] {
        let (records, outcome) = run(&parse(&column(law, UP_AND_DOWN)));
        assert_eq!(outcome, Outcome::Completed);
        for (stage, stress, closing) in [("load", 33.0e3, 1.32e-4), ("unload", 0.0, 0.0)] {
            let rows = of_stage(&records, stage);
            let last = rows[rows.len() - 1];
            let [strain, found] = [last.axial_strain, last.axial_stress].map(Option::unwrap);
            assert_within(found, stress, 1e-6 * 33.0e3);
            assert_within(0.02 * strain, closing, 1e-5 * 1.0e-5);
            let shortened: Vec<f64> =
                rows.iter().map(|r| r.fraction).filter(|f| *f < 1.0).collect();
            assert!(rows.len() == 14 && shortened.len() == 1, "{law} {stage}: {shortened:?}");
            assert_within(shortened[0], 0.2, 1e-4);
        }
    }
}

/// The first increment of a run would pass the value: 33 kPa are reached after 132 um of 500.
#[test]
fn the_first_increment_of_a_run_lands() {
    let stages = UP_AND_DOWN.replace("Displacement(0.0, -1.0e-5)", "Displacement(0.0, -5.0e-4)");
    for law in ["Associated", "Coulomb()"] {
        let (records, outcome) = run(&parse(&column(law, &stages)));
        assert_eq!(outcome, Outcome::Completed);
        let rows = of_stage(&records, "load");
        assert_eq!(rows.len(), 1, "{law}");
        assert_within(rows[0].fraction, 1.32e-4 / 5.0e-4, 1e-5);
        assert_within(rows[0].axial_stress.unwrap(), 33.0e3, 1e-6 * 33.0e3);
    }
}

/// A stage that ends below its value, one whose measure stays at the value of the stage, and one
/// whose measure has no value.
#[test]
fn a_stage_knows_the_until_that_it_has_not_reached() {
    let stage = |name: &str, measure: &str, value: f64| {
        format!(
            "Load(name: \"{name}\", increments: 3, walls: {{ \"top\": Displacement(0.0, 1.0e-5) }},
                stop: [Until(\"{measure}\", {value:?})]),"
        )
    };
    let stages = stage("load", "axial_stress", 33.0e3)
        + &stage("hold", "axial_stress", 0.0)
        + &stage("read", "fabric", 0.5);
    let text = column("Associated", &stages).replace(
        "measures: [",
        "measures: [(name: \"fabric\", of: Fabric(component: Yy, network: All)),",
    );
    let mut simulation = Simulation::new(&parse(&text), None);
    while step(&mut simulation).is_some() {}
    let ends = &simulation.world().resource::<Script>().ends;
    let missed: Vec<_> = ends.iter().map(|end| end.warning().unwrap_or_default()).collect();
    assert!(missed[0].contains("did not reach Until(\"axial_stress\", 33000.0)"), "{missed:?}");
    assert_eq!(missed[1], "");
    assert!(missed[2].contains("did not reach Until(\"fabric\", 0.5)"), "{missed:?}");
}

/// A measure without a value shortens no increment: there is no contact between particles.
#[test]
fn a_measure_that_is_not_defined_shortens_no_increment() {
    let stage = r#"Load(name: "load", increments: 5, walls: { "top": Displacement(0.0, -1.0e-5) },
        stop: [Until("fabric", 0.5)]),"#;
    let text = column("Associated", stage).replace(
        "measures: [",
        "measures: [(name: \"fabric\", of: Fabric(component: Yy, network: All)),",
    );
    let (records, outcome) = run(&parse(&text));
    assert_eq!(outcome, Outcome::Completed);
    assert!(records.len() == 5 && records.iter().all(|record| record.fraction == 1.0));
}

/// One increment lifts the platen far off. The stress at its end is zero, as it would be anywhere
/// beyond 132 um, so that the increment is undone and repeated.
#[test]
fn a_platen_that_leaves_within_the_first_increment_lands_where_it_leaves() {
    let stages = UP_AND_DOWN.replace("Displacement(0.0, 1.0e-5)", "Displacement(0.0, 5.0e-4)");
    let (records, outcome) = run(&parse(&column("Associated", &stages)));
    assert_eq!(outcome, Outcome::Completed);
    let rows = of_stage(&records, "unload");
    assert_eq!(rows.len(), 1);
    assert_within(0.02 * rows[0].axial_strain.unwrap(), 0.0, 1e-5 * 5.0e-4);
    let increments = records.iter().map(|record| record.increment);
    assert!(increments.eq(1..=records.len() as u64), "undone increments have no numbers");
}

/// A bond of 1e6 N/m and 20 N is pulled by 3 um an increment, and breaks at 20 um.
#[test]
fn the_number_of_broken_bonds_lands_at_the_rupture() {
    for order in ["Events", "OneRound"] {
        let text = format!(
            r#"(version: 1, title: "pull", rupture: (order: {order}),
            materials: {{ "m": (density: 2000.0, bond: (normal_stiffness: 1.0e6,
                tangential_stiffness: 1.0e6, cohesion: 1.0e6, tensile_strength: 1.0e3)) }},
            specimen: Particles([(position: (0.0, 0.0), radius: 0.01),
                (position: (0.02, 0.0), radius: 0.01)]),
            bonds: [(a: 0, b: 1)], probes: {{ "pulled": 1 }},
            stages: [Load(name: "pull", increments: 20, particles: [
                (select: Index([0]), x: Held, y: Held, rotation: Held),
                (select: Index([1]), x: Displacement(3.0e-6), y: Held, rotation: Held),
            ], stop: [Until("broken", 1.0)])],
            measures: [(name: "broken", of: Broken(All))])"#
        );
        let scene = parse(&text);
        let mut simulation = Simulation::new(&scene, None);
        while simulation.step() == Step::Increment {}
        let end = simulation.world().resource::<Script>().ends[0].clone();
        assert_eq!((end.passed, end.stop.is_some()), (None, true), "{order}: {end:?}");
        let record = simulation.world().resource::<Observation>();
        assert_eq!(record.broken.iter().sum::<usize>(), 1, "{order}");
        let at = probe(record, "pulled").motion[0];
        // A bond may break within the tolerance of its limit.
        assert!(at > 20.0e-6 * (1.0 - 6e-4) && at < 20.0e-6 + 2e-5 * 3.0e-6, "{order}: {at}");
    }
}

/// Grains that an undone increment has poured are gone, and come again as they are due.
#[test]
fn an_increment_that_pours_is_undone_with_its_grains() {
    let text = |stop: &str| {
        parse(&format!(
            r#"(version: 1, title: "bin", analysis: Dynamic(dt: 0.02), gravity: (0.0, -9.81),
            materials: {{ "m": (density: 1000.0) }},
            specimen: Particles([]),
            walls: [(name: "floor", start: (-0.5, 0.0), end: (0.5, 0.0))],
            stages: [
                Pour(name: "pour", increments: 20, through: Box(min: (-0.4, 0.5), max: (0.4, 1.0)),
                    rate: Number(200.0), sizes: Uniform(radius: (0.006, 0.01)), seed: 7,
                    stop: [{stop}]),
                Pour(name: "more", increments: 2, through: Box(min: (-0.4, 0.5), max: (0.4, 1.0)),
                    rate: Number(100.0), sizes: Equal(radius: 0.01), seed: 7),
            ],
            measures: [(name: "grains", of: Poured(Number))])"#
        ))
    };
    let scene = text("Until(\"grains\", 7.0)");
    let mut simulation = Simulation::new(&scene, None);
    let mut poured = Vec::new();
    while simulation.step() == Step::Increment {
        let world = simulation.world_mut();
        let named = world.resource::<Readings>().0[0];
        poured.push(named.unwrap() as u32);
        let mut ids: Vec<u32> =
            world.query_filtered::<&BodyId, With<Particle>>().iter(world).map(|id| id.0).collect();
        ids.sort_unstable();
        // The floor has the identity 0.
        assert_eq!(ids, (1..=poured[poured.len() - 1]).collect::<Vec<_>>());
    }
    // The four grains of an increment come at its start, so that their number jumps from 4 to 8.
    let stage_end = poured.iter().position(|n| *n == 8).unwrap();
    assert!(poured[..stage_end].iter().all(|n| *n == 4), "{poured:?}");
    assert_eq!(poured[poured.len() - 1], 12, "two more increments of two grains: {poured:?}");
    let end = simulation.world().resource::<Script>().ends[0].clone();
    assert_eq!((end.increments, end.passed), (stage_end as u64 + 1, Some(8.0)));
}

#[derive(bevy_ecs::prelude::Resource, Default, serde::Serialize, serde::Deserialize)]
struct Made(u64);

/// State that a plugin has registered goes back as well, and a run that is resumed between any two
/// increments lands with the same bytes.
#[test]
fn undone_increments_leave_no_trace_in_states_of_plugins() -> Result<(), StateError> {
    fn counts(app: &mut App) {
        app.register_resource::<Made>("test.made").init_resource::<Made>().add_systems(
            Increment,
            (|mut made: bevy_ecs::prelude::ResMut<Made>| made.0 += 1)
                .in_set(IncrementSystems::Update),
        );
    }
    for law in ["Associated", "Coulomb()"] {
        let scene = parse(&column(law, UP_AND_DOWN));
        let mut whole = Simulation::in_app(clastic::run::app(counts), &scene, None);
        let mut states: Vec<WorldState> = Vec::new();
        while whole.step() == Step::Increment {
            states.push(whole.state()?);
        }
        assert_eq!(whole.world().resource::<Made>().0, states.len() as u64);
        let end = whole.state()?;
        for state in &states {
            let mut resumed = Simulation::resume_in(clastic::run::app(counts), &scene, state)?;
            resumed.run();
            assert!(resumed.state()? == end, "{law}");
        }
    }
    Ok(())
}

/// A position that is not a number halts the app before an increment that reads the measure at the
/// start of a stage, before one of full length, or before one that is shortened to land. With the
/// position of before the app makes the increments of an app that was not halted.
#[test]
fn an_app_that_is_halted_within_the_search_goes_on_with_the_length_of_before() {
    /// Halts the app before an increment and repairs it.
    fn halt(app: &mut App) {
        let disk =
            app.world_mut().query_filtered::<Entity, With<Particle>>().single(app.world()).unwrap();
        let before = app.world().resource::<ClasticProgress>().increment;
        let place = *app.world().get::<BodyPosition>(disk).unwrap();
        app.world_mut().get_mut::<BodyPosition>(disk).unwrap().0.y = f64::NAN;
        app.update();
        let running = *app.world().resource::<ClasticRunning>();
        assert_eq!(running, ClasticRunning::Stopped(StoppedBy::Halted));
        let now = app.world().resource::<ClasticProgress>();
        // The increments before were whole, and a stage begins with a whole one.
        assert_eq!((now.increment, now.tried), (before, 1.0));
        *app.world_mut().get_mut::<BodyPosition>(disk).unwrap() = place;
        app.world_mut().remove_resource::<ClasticHalted>();
        app.insert_resource(ClasticRunning::Always);
    }
    /// Fractions and stresses of a run that is halted after this number of increments, and its last
    /// state.
    fn follow(halted_after: Option<usize>) -> (Vec<(f64, Option<f64>)>, WorldState) {
        let scene = parse(&column("Associated", UP_AND_DOWN));
        let mut app = App::new();
        app.add_plugins((ClasticPlugins::default(), ScenePlugin));
        let mut simulation = Simulation::in_app(app, &scene, None);
        let mut records = Vec::new();
        while simulation.world().resource::<Script>().outcome.is_none() {
            if halted_after == Some(records.len()) {
                halt(simulation.app_mut());
            }
            simulation.app_mut().update();
            let record = simulation.world().resource::<Observation>();
            records.push((record.fraction, record.axial_stress));
            assert!(records.len() < 40);
        }
        (records, simulation.state().unwrap())
    }
    let (whole, end) = follow(None);
    assert!(whole[13].0 < 0.5 && whole[12].0 == 1.0, "{whole:?}");
    for halted_after in [0, 5, 13, 14] {
        let (records, state) = follow(Some(halted_after));
        assert_eq!(records, whole, "{halted_after}");
        assert!(state == end, "{halted_after}");
    }
}
