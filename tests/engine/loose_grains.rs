//! Grains that lose their hold: solutions that throw them, falls that are followed, and grains that
//! are wedged and carry forces that nothing determines.

use bevy_ecs::prelude::*;
use clastic::components::attempt::Attempt;
use clastic::components::contact_history::ContactHistory;
use clastic::components::findings::AddedPairs;
use clastic::components::particle::SetAside;
use clastic::prelude::*;
use clastic::run::stages::Script;
use clastic::systems::schedule::{AttemptIncrement, AttemptSystems};
use clastic::systems::solved::SolvedTables;
use clastic::systems::turns::furthest;

use crate::common::{self, parse, step};
use crate::followed_motion::confinement;

/// Counts of the attempts at a confinement.
#[derive(Resource, Default)]
struct Throws {
    /// Solutions that turned a contact by more than 5 rad while an equilibrium was sought.
    seen: u32,
    /// Number of added pairs before the solution at hand.
    added: usize,
}

/// After the judges: neither such a solution nor the beginning of a motion leaves more pairs.
fn watch_throws(
    tables: SolvedTables,
    pairs: Res<AddedPairs>,
    attempt: Res<Attempt>,
    mut throws: ResMut<Throws>,
) {
    let before = std::mem::replace(&mut throws.added, pairs.0.len());
    let solved = tables.get();
    let far = furthest(solved, false).map_or(0.0, |(_, turn)| turn);
    // The mechanism of a collapse shows pairs near by.
    if attempt.effort().is_some() && solved.solution.certificate.is_none() && far > 5.0 {
        throws.seen += 1;
        assert!(pairs.0.len() <= before, "a turn by {far} rad adds {} pairs", pairs.0.len());
    }
    // Pairs of the step itself are within its reach.
    if attempt.motion().is_some() {
        assert!(pairs.0.len() < solved.bodies.particles / 4, "{} pairs in a motion", pairs.0.len());
    }
}

/// Solutions that throw grains over many radii added the pairs that these grains crossed, and the
/// motions that followed kept them: 1600 loose disks went from 2648 to 7738 contacts in three
/// solves.
#[test]
fn a_throw_adds_no_pairs_to_the_motion_that_follows() {
    let mut throws = 0;
    for (porosity, friction, seed) in [(0.25, 0.3, 9), (0.25, 0.5, 10), (0.25, 0.6, 11)] {
        let mut simulation = Simulation::new(&parse(&confinement(porosity, friction, seed)), None);
        let app = simulation.app_mut();
        app.init_resource::<Throws>();
        app.add_systems(AttemptIncrement, watch_throws.after(AttemptSystems::Judge));
        assert_eq!(simulation.run(), Outcome::Completed, "seed {seed}");
        throws += simulation.world().resource::<Throws>().seen;
    }
    assert!(throws > 0, "no solution threw a grain: the packings are too dense for this test");
}

/// A grain in the air ended a static stage as a collapse: nothing holds it, which a mechanism
/// proves. Near other grains it landed on them.
#[test]
fn a_loose_grain_falls_to_rest_and_ends_no_static_stage() {
    let radius = 5.0e-3;
    for gap in [1.0e-3, 10.0e-3, 60.0e-3] {
        // Nine grains side by side, six in the hollows between them; the last one falls into the
        // first hollow.
        let rest = radius * (1.0 + 3.0_f64.sqrt());
        let bottom = (0..9).map(|k| (radius * f64::from(2 * k + 1), radius));
        let upon = (2..8).map(|k| (radius * f64::from(2 * k + 2), rest));
        let heap: String = bottom
            .chain(upon)
            .map(|(x, y)| format!("(position: ({x:?}, {y:?}), radius: {radius:?}),"))
            .collect();
        let (x, y) = (2.0 * radius, rest + gap);
        let scene = parse(&format!(
            "(
                version: 1,
                title: \"loose grain\",
                gravity: (0.0, -9.81),
                materials: {{ \"stone\": (density: 2650.0, contact: (
                    normal_stiffness: 1.0e8)) }},
                specimen: Particles([{heap} (position: ({x:?}, {y:?}), radius: {radius:?})]),
                walls: [
                    (name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0)),
                    (name: \"left\", start: (0.0, 1.0), end: (0.0, 0.0)),
                    (name: \"right\", start: (0.09, 0.0), end: (0.09, 1.0)),
                ],
                stages: [Load(name: \"settle\", increments: 2)],
            )"
        ));
        let mut simulation = Simulation::new(&scene, None);
        assert_eq!(simulation.run(), Outcome::Completed, "gap {gap} m");
        let place = common::states(&mut simulation)[15].position;
        assert!((place.y - rest).abs() < 1e-3 * radius, "gap {gap} m: it lies at {place}");
    }
}

/// A lattice of rigid disks just fits between two walls: what its rows carry along them is not
/// determined. It took the scale of its forces from the last increment, so that they grew until no
/// solution was found: 16 N in the first increment, 2e12 N in the sixteenth.
#[test]
fn forces_of_a_wedged_lattice_do_not_grow() {
    let (columns, rows, radius) = (12, 7, 5.0e-3);
    let scene = parse(
        "(
            version: 1,
            title: \"wedged\",
            analysis: Dynamic(dt: 0.5e-3, theta: 1.0),
            gravity: (0.0, -9.81),
            materials: { \"stone\": (density: 2650.0, contact: (friction: 0.3)) },
            specimen: Lattice(columns: 12, rows: 7, radius: 5.0e-3, origin: (5.0e-3, 5.0e-3)),
            walls: [
                (name: \"floor\", start: (0.0, 0.0), end: (0.12, 0.0), contact: (friction: 0.3)),
                (name: \"left\", start: (0.0, 0.2), end: (0.0, 0.0)),
                (name: \"right\", start: (0.12, 0.0), end: (0.12, 0.2)),
            ],
            stages: [Load(name: \"settle\", increments: 200)],
        )",
    );
    let weight = 2650.0 * std::f64::consts::PI * radius * radius * 9.81;
    let all = weight * f64::from(rows * columns - rows / 2);
    let mut simulation = Simulation::new(&scene, None);
    let start = common::states(&mut simulation);
    let mut increments = 0;
    while let Some(record) = step(&mut simulation) {
        increments += 1;
        assert_eq!(record.fraction, 1.0, "increment {increments} was halved");
        let contacts = &simulation.world().resource::<ContactHistory>().0;
        let maximum = contacts.iter().map(|contact| contact.p).fold(0.0, f64::max);
        assert!(maximum < 1e4 * all, "{maximum} N in increment {increments}; weight {all} N");
    }
    assert_eq!(increments, 200);
    let moved = common::states(&mut simulation)
        .iter()
        .zip(&start)
        .map(|(now, before)| now.position.distance(before.position))
        .fold(0.0, f64::max);
    assert!(moved < 1e-9 * radius, "{moved} m");
}

/// A rigid group that turns about its centre, beside a grain that it pushes away, is no loose
/// grain: the moment on it is a load that nothing carries.
#[test]
fn a_group_that_turns_beside_a_grain_is_no_loose_grain() {
    let far: String = (0..8).map(|k| format!("(position: ({k}.5, 1.0), radius: 0.01),")).collect();
    let scene = parse(&format!(
        "(
            version: 1,
            title: \"turning\",
            materials: {{ \"stone\": (contact: (normal_stiffness: 1.0e8)) }},
            specimen: Particles([
                (position: (0.0, 0.0), radius: 0.01), (position: (0.02, 0.0), radius: 0.01),
                (position: (0.02, 0.02), radius: 0.01), {far}
            ]),
            stages: [Load(name: \"turn\", increments: 1, rigid: {{
                \"clump\": (select: Index([0, 1]), moment: 1.0) }})],
        )"
    ));
    let mut simulation = Simulation::new(&scene, None);
    let outcome = simulation.run();
    let Outcome::Collapsed(collapse) = outcome else { panic!("{outcome:?}") };
    assert_eq!(collapse.by, clastic::run::stages::CollapsedBy::Proof, "{collapse:?}");
}

/// A disk hangs from a ceiling while its bond loses strength and nothing moves. The motion that follows
/// once took its inertia from these displacements of zero, found the disk at rest in the air, and called
/// its fall a collapse.
#[test]
fn a_disk_that_loses_its_bond_after_idle_increments_falls_to_the_floor() {
    let scene = parse(
        "(version: 1, title: \"hanging disk\", gravity: (0.0, -9.81),
          materials: { \"rock\": (density: 2000.0,
            contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5),
            bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 4.0e4, tensile_strength: 4.0e4)) },
          specimen: Particles([(position: (0.0, -0.5), radius: 0.5)]),
          walls: [
            (name: \"ceiling\", start: (3.0, 0.0), end: (-3.0, 0.0), contact: (normal_stiffness: 1.0e8)),
            (name: \"floor\", start: (-3.0, -5.5), end: (3.0, -5.5),
                contact: (normal_stiffness: 1.0e8, friction: 0.5)),
          ],
          stages: [Cement(name: \"cement\", length: 1.0e-6, walls: true),
            Load(name: \"weight\", increments: 1),
            Load(name: \"ramp\", increments: 20, scale: (strength: [(0.0, 1.0), (1.0, 0.2)]))])",
    );
    let mut simulation = Simulation::new(&scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let world = simulation.world_mut();
    let place = world.query_filtered::<&BodyPosition, With<Particle>>().single(world).unwrap().0;
    let weight = 2000.0 * std::f64::consts::PI * 0.25 * 9.81;
    assert!((place.y - (-5.0 - weight / 1.0e8)).abs() < 1e-9, "{place}");
}

/// Three stacked disks under a lid of 1 kN, on a floor that ends beside them, and one disk without
/// support beside the stack; `stages` follow.
fn beside_a_stack(stages: &str) -> clastic::scene::format::Scene {
    parse(&format!(
        "(version: 1, title: \"a disk beside a stack\", gravity: (0.0, -9.81),
          materials: {{ \"rock\": (density: 2000.0, contact: (
            normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5, rolling_friction: 0.1)) }},
          specimen: Particles([
            (position: (0.0, 0.1), radius: 0.1), (position: (0.0, 0.3), radius: 0.1),
            (position: (0.0, 0.5), radius: 0.1), (position: (1.0, 0.5), radius: 0.1)]),
          walls: [
            (name: \"floor\", start: (-0.3, 0.0), end: (0.3, 0.0), shape: Segment,
                contact: (normal_stiffness: 1.0e8, friction: 0.5)),
            (name: \"lid\", start: (0.3, 0.6), end: (-0.3, 0.6), shape: Segment, probe: \"lid\",
                contact: (normal_stiffness: 1.0e8, friction: 0.5))],
          stages: [{stages}])"
    ))
}

/// A grain with nothing below it fell for ever, and its fall ended the test of the specimen beside it
/// as a collapse. It is set aside without its weight.
#[test]
fn a_grain_that_falls_out_of_the_specimen_ends_no_static_stage() {
    let lid = "walls: { \"lid\": Force(1000.0) }";
    let scene = beside_a_stack(&format!(
        "Load(name: \"weight\", increments: 4, {lid}), Load(name: \"more\", increments: 4)"
    ));
    let mut simulation = Simulation::new(&scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let states = common::states(&mut simulation);
    // Out of reach: a radius and more below the lowest point of all others.
    assert!(states[3].position.y < -0.1, "{}", states[3].position);
    let world = simulation.world_mut();
    let aside: Vec<_> =
        world.query_filtered::<&BodyId, With<SetAside>>().iter(world).copied().collect();
    assert_eq!(aside, [BodyId(3)]);
    // The floor carries the lid and three of the four disks.
    let weight = 2000.0 * std::f64::consts::PI * 0.01 * 9.81;
    let floor =
        world.resource::<ContactHistory>().0.iter().find(|m| (m.a, m.b) == (0, 4)).unwrap().p;
    assert!((floor - (1000.0 + 3.0 * weight)).abs() < 1e-6 * floor, "{floor}");
    let script = world.resource::<Script>();
    assert!(script.ends.iter().all(|end| end.set_aside == 1), "{:?}", script.ends);
    assert!(
        script.ends[0].warning().unwrap().contains("1 particle that carries nothing is set aside")
    );
}

/// Where more than loose grains fall, the specimen collapses: a stack loses its floor.
#[test]
fn a_stack_without_its_floor_is_a_collapse() {
    let scene = beside_a_stack("Load(name: \"weight\", increments: 1, remove_walls: [\"floor\"])");
    let outcome = Simulation::new(&scene, None).run();
    assert!(matches!(outcome, Outcome::Collapsed(_)), "{outcome:?}");
}

/// A grain that is set aside gets its weight back where something lifts it, and in a dynamic stage.
#[test]
fn a_grain_that_is_set_aside_has_its_weight_again_when_it_is_touched_or_falls_in_time() {
    let scene = beside_a_stack(
        "Load(name: \"weight\", increments: 1),
         Load(name: \"time\", increments: 10, analysis: Dynamic(dt: 1.0e-3))",
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut heights = Vec::new();
    while step(&mut simulation).is_some() {
        heights.push(common::states(&mut simulation)[3].position.y);
    }
    // The theta method of a fall from rest: y = -g t^2/2 to first order in dt.
    let fallen = heights[0] - heights[10];
    assert!((fallen - 0.5 * 9.81 * 1e-4).abs() < 0.11 * 0.5 * 9.81 * 1e-4, "{fallen}");
    let world = simulation.world_mut();
    assert_eq!(world.query_filtered::<(), With<SetAside>>().iter(world).count(), 0);
}
