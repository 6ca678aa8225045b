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

/// An edit of the scene, and the message about it.
#[test]
fn each_is_refused_where_it_stands() {
    let cases = [
        ("snap_back: true", "snap_back: true, order: OneRound", "?"),
        ("snap_back: true", "snap_back: true, avalanche: Gradual", "?"),
        ("version: 1,", "version: 1, gravity: (0.0, -9.81),", "?"),
        ("increments: 4,", "increments: 4, gravity: (0.0, -9.81),", "?"),
        ("version: 1,", "version: 1, analysis: Dynamic(dt: 1e-3, theta: 1.0),", "?"),
        ("\"bottom\": Fixed", "\"bottom\": Stress(stress: 1e3)", "?"),
        ("\"bottom\": Fixed", "\"bottom\": Displacement(0.0, 1e-5)", "?"),
        ("\"bottom\": Fixed", "\"bottom\": Rotation(about: (0.0, 0.0), angle: 0.01)", "?"),
        ("rotation: Held", "rotation: Held, force: (1.0, 0.0)", "?"),
        ("rotation: Held", "rotation: Held, x: Displacement(1e-6)", "?"),
    ];
    assert!(read(BONDED, &[]).is_ok());
    let mut failures = String::new();
    for (old, new, expected) in cases {
        assert_eq!(BONDED.matches(old).count(), 1, "{old}");
        let said = match read(&BONDED.replace(old, new), &[]) {
            Ok(_) => "nothing".to_owned(),
            Err(error) => error.to_string().replace("s.ron:", ""),
        };
        if said != expected {
            failures.push_str(&format!("{new}\n  says {said}\n  not  {expected}\n"));
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}
