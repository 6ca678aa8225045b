//! Scenes with `rupture.snap_back` in which it has no meaning.

use super::read;

const BONDED: &str = r#"(
    version: 1,
    title: "Bonded",
    rupture: (snap_back: true),
    materials: {
        "grain": (
            contact: (normal_stiffness: 1e8),
            bond: (normal_stiffness: 1e8, tangential_stiffness: 1e8, cohesion: 1e6, tensile_strength: 1e6),
        ),
    },
    specimen: Particles([
        (position: (0.0, 1.0), radius: 1.0),
        (position: (2.0, 1.0), radius: 1.0),
    ]),
    bonds: [(a: 0, b: 1)],
    walls: [
        (name: "bottom", start: (-5.0, 0.0), end: (5.0, 0.0)),
        (name: "top", start: (5.0, 2.0), end: (-5.0, 2.0)),
    ],
    stages: [
        Load(name: "load", increments: 4, walls: {
            "top": Displacement(0.0, -1e-5),
            "bottom": Fixed,
        }, particles: [
            (select: All, rotation: Held),
        ]),
    ],
)
"#;

const HELP: &str = "leave `snap_back` out, or load with one imposed displacement alone";

/// Edits of the scene, and the message about each.
#[test]
fn each_is_refused_where_it_stands() {
    let cases = [
        (
            "snap_back: true",
            "snap_back: true, order: OneRound",
            "4:26: rupture.snap_back: no effect with `order: OneRound`; give `order: Events`, or leave `snap_back` out",
        ),
        (
            "snap_back: true",
            "snap_back: true, avalanche: Gradual",
            "4:26: rupture.snap_back: does not go with `avalanche: Gradual`; leave one of the two out: the motion goes back before an avalanche begins",
        ),
        (
            "version: 1,",
            "version: 1, gravity: (0.0, -9.81),",
            "2:26: gravity: `rupture.snap_back` with gravity; HELP",
        ),
        (
            "increments: 4,",
            "increments: 4, gravity: (0.0, -9.81),",
            "21:52: stages[0].gravity: `rupture.snap_back` with gravity; HELP",
        ),
        (
            "version: 1,",
            "version: 1, analysis: Dynamic(dt: 1e-3, theta: 1.0),",
            "2:27: analysis: `rupture.snap_back` in a dynamic stage; HELP",
        ),
        (
            "\"bottom\": Fixed",
            "\"bottom\": Stress(stress: 1e3)",
            "23:23: stages[0].walls.bottom: `rupture.snap_back` with a load on wall `bottom`; HELP",
        ),
        (
            "\"bottom\": Fixed",
            "\"bottom\": Displacement(0.0, 1e-5)",
            "22:20: stages[0].walls.top: `rupture.snap_back` with a second imposed motion: `walls.bottom` moves too; HELP",
        ),
        (
            "\"bottom\": Fixed",
            "\"bottom\": Rotation(about: (0.0, 0.0), angle: 0.01)",
            "23:23: stages[0].walls.bottom: `rupture.snap_back` with a motion that cannot go back: `Displacement` can; HELP",
        ),
        (
            "rotation: Held",
            "rotation: Held, force: (1.0, 0.0)",
            "25:13: stages[0].particles[0]: `rupture.snap_back` with loads on particles; HELP",
        ),
        (
            "rotation: Held",
            "rotation: Held, x: Displacement(1e-6)",
            "25:13: stages[0].particles[0]: `rupture.snap_back` with a second imposed motion: `walls.top` moves too; HELP",
        ),
    ];
    assert!(read(BONDED, &[]).is_ok());
    let mut failures = String::new();
    for (old, new, expected) in cases {
        assert_eq!(BONDED.matches(old).count(), 1, "{old}");
        let said = match read(&BONDED.replace(old, new), &[]) {
            Ok(_) => "nothing".to_owned(),
            Err(error) => error.to_string().replace("s.ron:", ""),
        };
        let expected = expected.replace("HELP", HELP);
        if said != expected {
            failures.push_str(&format!("{new}\n  says {said}\n  not  {expected}\n"));
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}
