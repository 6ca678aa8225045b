//! Valid scenes for the tests.

use super::read;

/// A scene with every feature of the format.
pub(super) const FULL: &str = r##"#![enable(implicit_some)]
// A comment with a ( bracket and a "quote.
Scene(
    version: 1,
    title: r#"Everything "at once" (and more)"#,
    thickness: 0.5, /* nested /* comment ) */ here */
    gravity: (0.0, -9.81),
    analysis: Dynamic(dt: 1e-4, theta: 0.5),
    friction_law: Coulomb(),
    rupture: (rolling: Yields, order: OneRound, density: 5.0),
    solver: Clarabel(),
    acceptance: (residual: 1e-8, turn: 0.2, halvings: 6),
    materials: {
        "grain": Material(
            density: 2_650.0,
            contact: (normal_stiffness: 1e8, tangential_stiffness: 5e7, friction: 0.5),
            bond: (normal_stiffness: 1e9, friction: 0.3, cohesion: 1e5, tensile_strength: 5e4),
        ),
        "fine sand": (contact: (rolling_friction: 0.1)),
    },
    specimen: Particles([
        (position: (0.25, 0.25), radius: 0.25, material: "grain", group: "low", probe: "p"),
        (position: (0.75, 0.25), radius: 0.25, material: "grain", velocity: (0.0, 1.0)),
        (position: (0.5, 0.75), radius: 0.2, material: Some("fine sand"), angular_velocity: -1.0),
    ]),
    bonds: [(a: 0, b: 1)],
    walls: [
        (name: "bottom", start: (0.0, 0.0), end: (1.0, 0.0), contact: (friction: 0.2), probe: "w"),
        (name: "top", start: (1.0, 1.0), end: (0.0, 1.0),
            bond: (normal_stiffness: 1e9, cohesion: 2e5, tensile_strength: 1e5)),
        (name: "left", start: (0.0, 1.0), end: (0.0, 0.0)),
        (name: "right", start: (1.0, 0.0), end: (1.0, 1.0)),
        (name: "lid", start: (1.0, 2.0), end: (0.0, 2.0), present: false),
        (name: "plate", start: (2.0, 0.0), end: (3.0, 0.0), shape: Segment),
        (name: "chute", start: (2.0, 0.0), end: (3.0, 0.0), shape: Polyline([(2.0, 1.0), (3.0, 1.0)])),
        (name: "bowl", start: (2.0, 0.0), end: (4.0, 0.0), shape: Arc(through: (3.0, -1.0))),
    ],
    groups: {
        "heap": Union([Circle(centre: (0.0, 0.0), radius: 9.0), Polygon([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])]),
        "few": Except(Group("heap"), Intersection([Index([1, 2]), Material("fine sand")])),
    },
    stages: [
        Compact(
            name: "press", wall: "top", base: "bottom", target: Porosity(0.2), step: 1e-3,
            agitation: 0.1, seed: 3,
        ),
        Cement(name: "glue", length: 0.01, walls: true),
        Cement(
            name: "foot", length: 0.01, walls: true, particles: false,
            select: Layer(normal: (0.0, 1.0), from: 0.0, to: 0.5),
            bond: (cohesion: 1e5, tensile_strength: 5e4),
        ),
        Load(
            name: "shear",
            increments: 10,
            analysis: Static,
            gravity: (0.0, 0.0),
            walls: {
                "top": Stress(stress: 1e5, between: ("left", "right")),
                "left": Displacement(1e-3, 0.0),
                "right": Force(2.0),
                "bottom": Fixed,
                "lid": Custom,
            },
            add_walls: ["lid"],
            particles: [
                (select: All, rotation: Held),
                (select: Index([0, 2]), x: Displacement(1e-3), force: (1.0, 2.0), moment: 3.0),
                (select: Group("low"), affine: ((0.1, 0.0), (0.0, -0.1))),
                (select: Probe("p"), y: Free),
                (select: Box(min: (0.0, 0.0), max: (1.0, 1.0))),
                (select: Group("few"), y: Held),
            ],
            stop: [Above("axial_strain", 0.05), StressDrop(0.5)],
        ),
        Load(
            name: "let go",
            increments: 10,
            walls: {
                "left": Velocity(0.1, 0.0),
                "top": Fixed,
                "bottom": Follow(Displacement([(0.0, 0.0, 0.0), (1.0, 0.0, -1e-3)])),
                "plate": Lid(load: Force(2.0), slide: Velocity(0.1)),
                "bowl": Follow(Stress(stress: [(0.0, 0.0), (0.5, 1e3)])),
            },
            remove_walls: ["right"],
            membranes: {
                "skin": (pressure: 1e5, between: ("bottom", "top"), sides: Right, ball: 0.5),
            },
            particles: [(select: Index([1]), x: Velocity(0.5))],
            stop: [Rest(1e-6)],
        ),
    ],
    reference_stage: "shear",
    measures: [
        (name: "axial_strain", of: Strain(Walls("top", "bottom"))),
        (name: "lateral_strain", of: Strain(Particles(0, 1))),
        (name: "axial_stress", of: Stress(Walls(walls: ["top"], length: Between("left", "right")))),
        (name: "lateral_stress", of: Stress(Average(component: Xx, area: Box(("left", "right"), ("top", "bottom"))))),
    ],
    output: (frames_every: 5, plots: false),
)
"##;

/// A small scene for edits; each field on a line of its own.
pub(super) const SMALL: &str = r#"(
    version: 1,
    title: "Small",
    materials: {
        "grain": (
            density: 2650.0,
            contact: (friction: 0.5),
        ),
    },
    specimen: Particles([
        (position: (0.0, 1.0), radius: 1.0),
        (position: (2.0, 1.0), radius: 1.0),
    ]),
    walls: [
        (name: "bottom", start: (-5.0, 0.0), end: (5.0, 0.0)),
        (name: "top", start: (5.0, 2.0), end: (-5.0, 2.0)),
    ],
    stages: [
        Load(
            name: "load",
            increments: 4,
            walls: {"top": Force(1.0)},
        ),
    ],
)
"#;

#[test]
fn samples_are_valid() {
    for text in [FULL, SMALL] {
        if let Err(error) = read(text, &[]) {
            panic!("{error}");
        }
    }
}
