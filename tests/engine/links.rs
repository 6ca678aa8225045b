//! Hinges, rods, springs and motors between bodies, against what mechanics says of them.

use std::f64::consts::PI;

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

const G: f64 = 9.81;
const RADIUS: f64 = 0.1;

fn app(kind: AnalysisKind) -> App {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.insert_resource(ClasticAnalysis {
        kind,
        gravity: DVec2::new(0.0, -G),
        ..ClasticAnalysis::default()
    });
    app
}

fn dynamic(dt: f64, theta: f64) -> AnalysisKind {
    AnalysisKind::Dynamic { dt, theta }
}

/// A disk of 1 kg.
fn disk(x: f64, y: f64) -> (Particle, BodyPosition) {
    let density = 1.0 / (PI * RADIUS * RADIUS);
    (Particle::disk(RADIUS, density, 1.0), BodyPosition(DVec2::new(x, y)))
}

fn held(x: f64, y: f64) -> impl Bundle {
    (disk(x, y), BodyDrives::imposed([0.0; 3]))
}

fn place(app: &App, body: Entity) -> DVec2 {
    app.world().get::<BodyPosition>(body).map_or(DVec2::NAN, |x| x.0)
}

fn solved(app: &mut App) {
    app.update();
    let status = app.world().resource::<Observation>().status.name();
    assert_eq!(status, "solved", "{:?}", app.world().resource::<Attempt>());
    assert!(app.world().get_resource::<ClasticHalted>().is_none());
}

/// The energy of a disk that swings about a hinge 1 m away: m g y + (m l^2 + m r^2/2) w^2/2.
#[test]
fn a_disk_on_a_hinge_swings_without_drift_and_keeps_its_energy() {
    let mut app = app(dynamic(1.0e-3, 0.5));
    let world = app.world_mut();
    let (pin, bob) = (world.spawn(held(0.0, 0.0)).id(), world.spawn(disk(1.0, 0.0)).id());
    world.spawn(Link::hinge(pin, bob, DVec2::ZERO));
    let (mut lowest, mut fastest) = (0.0_f64, 0.0_f64);
    for _ in 0..10_000 {
        solved(&mut app);
        let x = place(&app, bob);
        assert!((x.length() - 1.0).abs() < 1e-7, "{} m from the hinge", x.length());
        let spin = app.world().get::<BodyAngularVelocity>(bob).map_or(0.0, |w| w.0);
        (lowest, fastest) = (lowest.min(x.y), fastest.max(spin.abs()));
    }
    let expected = (2.0 * G / (1.0 + 0.5 * RADIUS * RADIUS)).sqrt();
    assert!(lowest < -0.99999 && (fastest - expected).abs() < 1e-3 * expected, "{fastest}");
    assert!(place(&app, bob).y < 1e-3);
}

/// A crank of radius r that a motor turns, and a rod of length l to a slider on the x axis:
/// x = r cos + (l^2 - r^2 sin^2)^(1/2).
#[test]
fn a_motor_drives_a_slider_through_a_rod() {
    const STEPS: u32 = 720;
    let (r, l) = (0.5, 2.0);
    let mut app = app(AnalysisKind::Static);
    let world = app.world_mut();
    let turn = 2.0 * PI / f64::from(STEPS);
    let crank = world.spawn((disk(0.0, 0.0), BodyDrives::imposed([0.0, 0.0, turn]))).id();
    let rail = BodyDrives([BodyDrive::Free, BodyDrive::Imposed(0.0), BodyDrive::Imposed(0.0)]);
    let slider = world.spawn((disk(r + l, 0.0), rail)).id();
    world.spawn(Link::rod([crank, slider], [DVec2::new(r, 0.0), DVec2::new(r + l, 0.0)]));
    for n in 1..=2 * STEPS {
        solved(&mut app);
        let angle = turn * f64::from(n);
        let expected = r * angle.cos() + (l * l - (r * angle.sin()).powi(2)).sqrt();
        let x = place(&app, slider).x;
        assert!((x - expected).abs() < 2e-6, "{angle} rad: {x} m instead of {expected} m");
    }
}

/// Two free disks on a spring swing about their centre of mass with (2 k/m)^(1/2).
#[test]
fn a_spring_between_two_disks_has_its_period_and_conserves_momentum() {
    let (k, dt) = (100.0, 1.0e-3);
    let mut app = app(dynamic(dt, 0.5));
    app.world_mut().resource_mut::<ClasticAnalysis>().gravity = DVec2::ZERO;
    let world = app.world_mut();
    let [a, b] = [0.0, 1.0].map(|x| world.spawn(disk(x, 0.0)).id());
    world.entity_mut(b).insert(BodyVelocity(DVec2::new(0.1, 0.0)));
    world.spawn(Link::spring([a, b], [DVec2::ZERO, DVec2::X], k));
    let omega = (2.0 * k).sqrt();
    for n in 1..=2000 {
        solved(&mut app);
        let t = dt * f64::from(n);
        let stretch = place(&app, b).x - place(&app, a).x - 1.0;
        let expected = 0.1 / omega * (omega * t).sin();
        assert!((stretch - expected).abs() < 1e-3 * 0.1 / omega, "{t} s: {stretch} {expected}");
        let centre = 0.5 * (place(&app, a).x + place(&app, b).x);
        assert!((centre - 0.5 - 0.05 * t).abs() < 1e-9, "{t} s: {centre}");
    }
}

/// A weight on two springs at 45 degrees: it sinks by m g/k, since k (cos^2 + cos^2) = k.
#[test]
fn a_weight_hangs_on_two_springs() {
    let k = 1.0e5;
    let mut app = app(AnalysisKind::Static);
    let world = app.world_mut();
    let bodies = [held(-1.0, 1.0), held(1.0, 1.0)].map(|body| world.spawn(body).id());
    let weight = world.spawn(disk(0.0, 0.0)).id();
    for (body, x) in bodies.into_iter().zip([-1.0, 1.0]) {
        world.spawn(Link::spring([body, weight], [DVec2::new(x, 1.0), DVec2::ZERO], k));
    }
    for _ in 0..3 {
        solved(&mut app);
    }
    let y = place(&app, weight).y;
    assert!((y + G / k).abs() < 1e-3 * G / k, "{y} m");
    let carried: f64 = bodies
        .iter()
        .filter_map(|body| app.world().get::<BodyExternalForce>(*body))
        .map(|f| f.0[1])
        .sum();
    // With the weight of the two that are held.
    assert!((carried - 3.0 * G).abs() < 1e-6, "{carried} N");
}

/// A wheel whose axle is a hinge in its centre turns under a moment M by M/I t.
#[test]
fn a_torque_spins_a_wheel_on_its_axle() {
    const MOMENT: f64 = 0.02;
    fn motor(mut loads: ResMut<TrialLoads>) {
        loads.add(BodyId(1), [0.0, 0.0, MOMENT]);
    }
    let mut app = app(dynamic(1.0e-3, 1.0));
    app.add_systems(AddTrialLoads, motor);
    let world = app.world_mut();
    let axle = world.spawn(held(0.0, 0.0)).id();
    let wheel = world.spawn(disk(0.0, 0.0)).id();
    world.spawn(Link::hinge(axle, wheel, DVec2::ZERO));
    for _ in 0..100 {
        solved(&mut app);
    }
    let spin = app.world().get::<BodyAngularVelocity>(wheel).map_or(0.0, |w| w.0);
    let expected = MOMENT / (0.5 * RADIUS * RADIUS) * 0.1;
    assert!((spin - expected).abs() < 1e-9, "{spin} rad/s instead of {expected}");
    // It overlaps the axle, and does not touch it; the axle carries both.
    assert!(place(&app, wheel).length() < 1e-12);
    let force = app.world().get::<BodyExternalForce>(axle).map_or([0.0; 3], |f| f.0);
    assert!((force[1] - 2.0 * G).abs() < 1e-9, "{force:?}");
}

#[test]
fn links_come_back_with_a_state_and_end_with_their_bodies() {
    let mut app = app(dynamic(1.0e-3, 1.0));
    let world = app.world_mut();
    let pin = world.spawn(held(0.0, 0.0)).id();
    let bob = world.spawn(disk(1.0, 0.0)).id();
    world.spawn(Link::hinge(pin, bob, DVec2::ZERO));
    for _ in 0..100 {
        solved(&mut app);
    }
    let state = WorldState::capture(app.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..100 {
        solved(&mut app);
    }
    let straight = place(&app, bob);
    let mut restored = self::app(dynamic(1.0e-3, 1.0));
    state.restore(restored.world_mut()).unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..100 {
        solved(&mut restored);
    }
    let world = restored.world_mut();
    let bob = world.resource::<IdentityTable>().body(BodyId(1)).unwrap_or_else(|| panic!("no bob"));
    assert_eq!(place(&restored, bob), straight);
    let world = restored.world_mut();
    let pin = world.resource::<IdentityTable>().body(BodyId(0)).unwrap_or_else(|| panic!("no pin"));
    world.despawn(pin);
    assert_eq!(world.query::<&Link>().iter(world).count(), 0);
    // And a state without links takes them away.
    let mut bare = self::app(dynamic(1.0e-3, 1.0));
    let world = bare.world_mut();
    let [a, b] = [0.0, 1.0].map(|x| world.spawn(disk(x, 0.0)).id());
    let without = WorldState::capture(world).unwrap_or_else(|e| panic!("{e}"));
    world.spawn(Link::hinge(a, b, DVec2::ZERO));
    without.rewind(world).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(world.query::<&Link>().iter(world).count(), 0);
}

/// A link with a bond beside it would put the bond out of action without a word.
#[test]
fn a_link_without_a_meaning_is_refused_by_name() {
    let law = BondLaw { normal_compliance: 1.0e-7, tensile_strength: 1.0e6, ..Default::default() };
    let link = |b, compliance| Link {
        a: BodyId(0),
        b: BodyId(b),
        on_a: DVec2::ZERO,
        on_b: DVec2::ZERO,
        kind: LinkKind::Hinge,
        compliance,
    };
    let cases = [
        (link(1, f64::NAN), "has compliance = NaN: give 1 over a stiffness"),
        (link(7, 0.0), "has b = BodyId(7): give the identity of a particle or wall"),
        (link(1, 0.0), "has a pair with bond = 0: give either a link or a bond to a pair"),
    ];
    for (link, expected) in cases {
        let mut app = app(AnalysisKind::Static);
        let world = app.world_mut();
        let [a, b] = [0.0, 0.2].map(|x| world.spawn(held(x, 0.0)).id());
        world.spawn(link);
        world.spawn(Bond::between(a, b, law));
        app.update();
        let Some(ClasticHalted(reason)) = app.world().get_resource() else {
            panic!("accepted {link:?}")
        };
        assert!(reason.contains(expected), "{reason}");
    }
}

#[test]
#[should_panic(expected = "these are one entity")]
fn a_link_of_a_body_with_itself_is_refused() {
    let mut app = app(AnalysisKind::Static);
    let world = app.world_mut();
    let body = world.spawn(disk(0.0, 0.0)).id();
    world.spawn(Link::hinge(body, body, DVec2::ZERO));
}
