//! Inputs of an app that have no meaning or no effect are refused by name.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::components::increment::Coulomb;
use clastic::components::rigid_group::{ContactForce, RigidGroup};
use clastic::prelude::*;
use glam::DVec2;

use super::in_an_app::{disk, falling, increments, two_disks};

/// Spawns a rigid group of these bodies.
fn group(app: &mut App, name: &str, members: &[u32]) {
    app.world_mut().spawn(RigidGroup {
        name: name.into(),
        members: members.iter().map(|id| BodyId(*id)).collect(),
        has_pivot: false,
        reference: 0.0,
    });
}

/// The reason for which an app halts in its next update, before it moves anything.
fn refusal(app: &mut App) -> String {
    app.update();
    let world = app.world();
    let running = *world.resource::<ClasticRunning>();
    assert_eq!(
        running,
        ClasticRunning::Stopped(StoppedBy::Halted),
        "{:?}",
        world.resource::<Attempt>()
    );
    let ClasticHalted(reason) = world.resource();
    assert!(
        reason.ends_with("then remove `ClasticHalted` and insert `ClasticRunning::Always`"),
        "{reason}"
    );
    reason.clone()
}

/// `dt: NaN` was committed, `dt < 0` ran backwards, and other values blamed "body 0".
#[test]
fn an_analysis_without_a_meaning_is_refused_by_name() {
    let gravity = DVec2::new(0.0, -9.81);
    let dynamic = |dt, theta| {
        let kind = AnalysisKind::Dynamic { dt, theta };
        ClasticAnalysis { kind, gravity, ..ClasticAnalysis::default() }
    };
    let time_step = "give a time step in s greater than 0";
    let theta = "give a theta from 0.5 to 1: below, energy grows";
    let cases = [
        (dynamic(f64::NAN, 1.0), format!("dt = NaN: {time_step}")),
        (dynamic(-1.0e-3, 1.0), format!("dt = -0.001: {time_step}")),
        (dynamic(0.0, 1.0), format!("dt = 0.0: {time_step}")),
        (dynamic(1.0e-3, -1.0), format!("theta = -1.0: {theta}")),
        (dynamic(1.0e-3, 0.0), format!("theta = 0.0: {theta}")),
        (dynamic(1.0e-3, 3.0), format!("theta = 3.0: {theta}")),
        (
            ClasticAnalysis { path_theta: Some(2.0), ..dynamic(1.0e-3, 1.0) },
            format!("path_theta = 2.0: {theta}"),
        ),
        (
            ClasticAnalysis { gravity: DVec2::new(0.0, f64::NAN), ..dynamic(1.0e-3, 1.0) },
            "gravity y = NaN: give an acceleration in m/s^2".to_owned(),
        ),
        (
            ClasticAnalysis { thickness: -1.0, ..ClasticAnalysis::default() },
            "thickness = -1.0: give a thickness in m greater than 0".to_owned(),
        ),
        (
            ClasticAnalysis { strength: f64::NAN, ..ClasticAnalysis::default() },
            "strength = NaN: give a factor greater than 0".to_owned(),
        ),
        (
            ClasticAnalysis {
                kind: AnalysisKind::Compaction { affine: true, agitation: -1.0, seed: 1 },
                ..ClasticAnalysis::default()
            },
            "agitation = -1.0: give a length in m of 0 or more".to_owned(),
        ),
    ];
    for (analysis, expected) in cases {
        let mut app = falling();
        app.insert_resource(analysis);
        app.world_mut().spawn(disk(0.0));
        let reason = refusal(&mut app);
        assert!(reason.starts_with(&format!("`ClasticAnalysis` has {expected}")), "{reason}");
        let world = app.world_mut();
        assert_eq!(world.resource::<ClasticProgress>(), &ClasticProgress::default());
        world.insert_resource(dynamic(1.0e-3, 1.0));
        world.remove_resource::<ClasticHalted>();
        world.insert_resource(ClasticRunning::Always);
        app.update();
        assert_eq!(increments(&app), 1);
    }
}

/// It had no effect: only one of the two carried force, and both said that they were intact.
#[test]
fn a_second_bond_of_a_pair_is_refused() {
    let mut app = falling();
    let [a, b] = two_disks(&mut app);
    let law = BondLaw { normal_compliance: 1.0e-7, tensile_strength: 1.0e6, ..Default::default() };
    app.world_mut().spawn(Bond::between(a, b, law));
    app.update();
    let second = app.world_mut().spawn((Bond::between(b, a, law), Name::new("weld"))).id();
    let reason = refusal(&mut app);
    let expected = "bond 1, `weld`, of particle 0 and particle 1 has bodies = [BodyId(0), BodyId(1)]: \
                    give one bond to a pair: bond 0 joins it already";
    assert!(reason.starts_with(expected), "{reason}");
    let world = app.world_mut();
    world.despawn(second);
    world.remove_resource::<ClasticHalted>();
    world.insert_resource(ClasticRunning::Always);
    app.update();
    assert_eq!(increments(&app), 2);
}

/// It panicked in an index of the tables.
#[test]
#[should_panic(expected = "is two of Particle, Wall and RigidGroup")]
fn an_entity_that_is_two_bodies_is_refused() {
    let mut app = falling();
    let wall = Wall { tangent: DVec2::X, half_length: 1.0 };
    app.world_mut().spawn((disk(0.0), wall));
}

/// All of these were accepted and had no effect.
#[test]
fn an_input_without_an_effect_is_refused_by_name() {
    type Fill = fn(&mut App, [Entity; 2]);
    fn loads(app: &mut App, add: fn(ResMut<TrialLoads>)) {
        app.add_systems(AddTrialLoads, add);
    }
    fn wall(app: &mut App, of: impl Bundle) {
        let wall = Wall::between(DVec2::new(-1.0, -0.3), DVec2::new(1.0, -0.3));
        app.world_mut().spawn((wall, WallName("floor".to_owned()), of));
    }
    fn link(kind: LinkKind) -> Link {
        Link {
            a: BodyId(0),
            b: BodyId(1),
            on_a: DVec2::ZERO,
            on_b: DVec2::ZERO,
            kind,
            compliance: 0.0,
        }
    }
    let cases: [(Fill, &str); 25] = [
        (
            |app, [_, b]| {
                app.world_mut().entity_mut(b).insert(Particle::disk(0.1, 2650.0, 0.5));
            },
            "particle 1, ENTITY, has thickness = 0.5: give that of `ClasticAnalysis`, 1.0 m, or set that one",
        ),
        (
            |app, _| loads(app, |mut l| l.add_spring(BodyId(1), 7, 1.0, 1.0e3)),
            "a load of `AddTrialLoads` on particle 1, ENTITY, has degree of freedom = 7: give 0, 1 or 2",
        ),
        (
            |app, _| loads(app, |mut l| l.add(BodyId(77), [1.0; 3])),
            "a load of `AddTrialLoads` has body = BodyId(77): give the identity of a body",
        ),
        (
            |app, _| loads(app, |mut l| l.add_spring(BodyId(1), 0, 1.0, -1.0e3)),
            "a load of `AddTrialLoads` on particle 1, ENTITY, has stiffness = -1000.0: give N/m",
        ),
        (
            |app, _| loads(app, |mut l| l.add(BodyId(1), [f64::NAN; 3])),
            "a load of `AddTrialLoads` on particle 1, ENTITY, has force = NaN: give a force in N",
        ),
        (
            |app, _| wall(app, WallControl::Velocity(DVec2::Y)),
            "wall `floor` has WallControl = Velocity(DVec2(0.0, 1.0)): give `Displacement`",
        ),
        (
            |app, _| wall(app, WallControl::Table(TableOf::Displacement)),
            "wall `floor` has WallTable = \"missing\": give the points",
        ),
        (
            |app, _| wall(app, WallSlide::Displacement(1.0e-6)),
            "wall `floor` has WallSlide = Displacement(1e-6): give a control by `Force`",
        ),
        (
            |app, [_, b]| _ = app.world_mut().entity_mut(b).remove::<BodyVelocity>(),
            "ENTITY has BodyVelocity = \"missing\": give one",
        ),
        (
            |app, [_, b]| _ = app.world_mut().entity_mut(b).remove::<LoadControl>(),
            "ENTITY has LoadControl = \"missing\": give one",
        ),
        (
            |app, [_, b]| {
                let load = LoadControl::constant([0.0, f64::INFINITY, 0.0]);
                app.world_mut().entity_mut(b).insert(load);
            },
            "particle 1, ENTITY, has LoadControl = inf: give forces in N",
        ),
        (
            |app, [_, b]| {
                app.insert_resource(material::Materials(vec![material::Material {
                    name: "sand".into(),
                    density: 2650.0,
                    contact: ContactLaw::default(),
                    bond: None,
                }]));
                app.world_mut().entity_mut(b).insert(MaterialIndex(1));
            },
            "particle 1, ENTITY, has MaterialIndex = 1: give an index below 1",
        ),
        (
            |app, _| {
                let law = BondLaw::default();
                let (a, b) = (BodyId(1), BodyId(99));
                app.world_mut().spawn((Bond { a, b, initial_gap: 0.0, law }, Name::new("weld")));
            },
            "bond 0, `weld`, of bodies 1 and 99 has b = BodyId(99): give the identity of a body",
        ),
        (
            |app, _| _ = app.insert_resource(Acceptance { residual: -1.0, ..Default::default() }),
            "`Acceptance` has residual = -1.0: give a residual above 0",
        ),
        (
            |app, _| {
                let law = Some(Coulomb { factorisations: 0 });
                app.insert_resource(FrictionLaw { in_statics: law, ..Default::default() });
            },
            "`FrictionLaw` has factorisations = 0: give a number of factorisations of 1 or more",
        ),
        (
            |app, _| app.world_mut().resource_mut::<RuptureRules>().slack = f64::NAN,
            "`RuptureRules` has slack = NaN: give a part from 0 to 1",
        ),
        (
            |app, [_, b]| _ = app.world_mut().entity_mut(b).insert(ContactLaw::default()),
            "ENTITY has ContactLaw = \"a component\": give none",
        ),
        (
            |app, _| wall(app, (Name::new("bed"), BodyVelocity::default())),
            "`bed` has BodyVelocity = \"a component\": give none",
        ),
        (
            |app, _| {
                let link = Link { a: BodyId(0), b: BodyId(1), ..link(LinkKind::Length(0.0)) };
                app.world_mut().spawn(link);
            },
            "the link of particle 0 and particle 1, entity",
        ),
        (
            |app, _| {
                let link = Link { a: BodyId(1), b: BodyId(1), ..link(LinkKind::Hinge) };
                app.world_mut().spawn(link);
            },
            "the link of particle 1 and particle 1, entity",
        ),
        (
            |app, _| {
                let law = BondLaw::default();
                let (a, b) = (BodyId(1), BodyId(1));
                app.world_mut().spawn((Bond { a, b, initial_gap: 0.0, law }, Name::new("weld")));
            },
            "bond 0, `weld`, of particle 1 and particle 1 has b = BodyId(1): give another body",
        ),
        (
            |app, _| {
                group(app, "raft", &[1]);
                loads(app, |mut l| l.add_spring(BodyId(1), 0, 1.0, 1.0e3));
            },
            "a load of `AddTrialLoads` on particle 1, ENTITY, has stiffness = 1000.0: give 0",
        ),
        (
            |app, _| group(app, "raft", &[1, 88]),
            "rigid group `raft` has a member = BodyId(88): give the identity of a particle or wall",
        ),
        (
            |app, _| {
                group(app, "raft", &[1]);
                group(app, "tender", &[1]);
            },
            "rigid group `tender` has a member = BodyId(1): give a body that is a member of no other",
        ),
        (
            |app, _| {
                let course = Course::Closed;
                let pressure = (0.0, -1.0);
                let skin = Membrane { name: "skin".into(), pressure, course, ball: None };
                app.world_mut().spawn(skin);
            },
            "membrane `skin` has pressure at the end = -1.0: give a pressure in Pa, not below 0",
        ),
    ];
    for (fill, expected) in cases {
        let mut app = App::new();
        app.add_plugins(ClasticPlugins::default());
        let bodies = two_disks(&mut app);
        fill(&mut app, bodies);
        let expected = expected.replace("ENTITY", &format!("entity {}", bodies[1]));
        let reason = refusal(&mut app);
        assert!(reason.starts_with(&expected), "{reason}\ninstead of\n{expected}");
        assert_eq!(
            app.world().resource::<ClasticProgress>(),
            &ClasticProgress::default(),
            "{expected}"
        );
    }
}

/// A group is controlled by its drives, not as a wall is.
#[test]
fn a_rigid_group_with_the_control_of_a_wall_is_refused() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    two_disks(&mut app);
    group(&mut app, "raft", &[1]);
    let mut rafts = app.world_mut().query_filtered::<Entity, With<RigidGroup>>();
    let raft = rafts.single(app.world()).unwrap();
    app.world_mut().entity_mut(raft).insert(WallControl::Velocity(DVec2::Y));
    let reason = refusal(&mut app);
    let expected = format!("entity {raft} has WallControl = \"a component\": give none");
    assert!(reason.starts_with(&expected), "{reason}");
}

/// A program asks for the force of the contacts on a body by a component, which is filled.
#[test]
fn a_particle_may_have_the_force_of_its_contacts() {
    let mut app = falling();
    app.world_mut().spawn(disk(0.0));
    app.update();
    let mut particles = app.world_mut().query_filtered::<Entity, With<Particle>>();
    let body = particles.iter(app.world()).next().unwrap();
    app.world_mut().entity_mut(body).insert(ContactForce([f64::NAN; 3]));
    app.update();
    assert_eq!(increments(&app), 2);
    assert_eq!(app.world().get::<ContactForce>(body), Some(&ContactForce([0.0; 3])));
}
