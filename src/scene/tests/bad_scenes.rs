//! Scenes with mistakes, and all messages about each.

use super::read;
use super::samples::SMALL;

// Parts of the small scene that the cases replace.
const PARTICLE: &str = "(position: (2.0, 1.0), radius: 1.0)";
const CONTROL: &str = r#"walls: {"top": Force(1.0)}"#;
const VERSION: &str = "version: 1";
const TOP: &str = r#"(name: "top", start: (5.0, 2.0), end: (-5.0, 2.0))"#;
const FORCE: &str = "Force(1.0)";
const STAGES: &str = "stages: [";
const LOAD: &str = "Load(
";
const STAGES_LOAD: &str = "],
    stages: [
        Load(";
const SPECIMEN: &str = "Particles([
        (position: (0.0, 1.0), radius: 1.0),
        (position: (2.0, 1.0), radius: 1.0),
    ])";

/// An edit of [`SMALL`]: the replaced text, the new text, and all messages.
type Case<'a> = (&'a str, &'a str, &'a str);

#[track_caller]
fn check(cases: &[Case]) {
    let mut failures = String::new();
    for (old, new, expected) in cases {
        assert_eq!(SMALL.matches(old).count(), 1, "{old}");
        let said = match read(&SMALL.replace(old, new), &[]) {
            Ok(_) => "nothing".to_owned(),
            Err(error) => error.to_string().replace("s.ron:", ""),
        };
        if said != *expected {
            failures.push_str(&format!("{new}\n  says {said}\n  not  {expected}\n"));
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

#[test]
fn syntax() {
    check(&[
        (
            "density: 2650.0,",
            "density: 2650.0",
            "6:28: missing comma; put a comma between two values",
        ),
        ("friction: 0.5", "friction = 0.5", "7:32: `=` after a field name; write `:`"),
        (
            r#"title: "Small""#,
            r#"title: "Small"#,
            "3:12: this quote is not closed on its line; close the quote",
        ),
        (
            "increments: 4,",
            "increments: ,",
            "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found nothing",
        ),
        (
            "[
        Load",
            "(
        Load",
            "24:5: `]` where the `(` of line 18 wants its `)`; check the brackets",
        ),
        (
            FORCE,
            "Force(1.0",
            "22:37: `}` where the `(` of line 22 wants its `)`; check the brackets",
        ),
        ("density: 2650.0", "density: @", "6:22: unexpected character `@`; a value was due here"),
        (
            "density: 2650.0",
            r#""density": 2650.0"#,
            "6:13: materials.grain.density: a field name in quotes; leave the quotes out",
        ),
        (r#""grain""#, "grain", r#"5:9: materials.grain: a key without quotes; write `"grain"`"#),
        (
            "    ],
)
",
            "    ],
) )
",
            "25:3: `)` after the end; a file has one value: check the brackets",
        ),
    ]);
}

#[test]
fn fields() {
    check(&[
        (PARTICLE, "(position: (2.0, 1.0), raduis: 1.0)",
         "12:32: specimen[1].raduis: unknown field `raduis`; did you mean `radius`? the fields here are `position`, `radius`, `material`, `velocity`, `angular_velocity`, `group`, `probe`"),
        (PARTICLE, "(position: (2.0, 1.0), raduis: -1.0)",
         "12:32: specimen[1].raduis: unknown field `raduis`; did you mean `radius`? the fields here are `position`, `radius`, `material`, `velocity`, `angular_velocity`, `group`, `probe`
12:40: specimen[1].radius: negative (-1.0); give a radius in m greater than 0"),
        (PARTICLE, "(position: (2.0, 1.0), radius: 1.0, colour: 3)",
         "12:45: specimen[1].colour: unknown field `colour`; the fields here are `position`, `radius`, `material`, `velocity`, `angular_velocity`, `group`, `probe`"),
        (PARTICLE, "(position: (2.0, 1.0))",
         "12:9: specimen[1].radius: missing field `radius`; add `radius: ...`, in m"),
        (PARTICLE, r#"(raduis: "1", positon: 2.0, radius: 1.0)"#,
         "12:10: specimen[1].raduis: unknown field `raduis`; did you mean `radius`? the fields here are `position`, `radius`, `material`, `velocity`, `angular_velocity`, `group`, `probe`
12:23: specimen[1].positon: unknown field `positon`; did you mean `position`? the fields here are `position`, `radius`, `material`, `velocity`, `angular_velocity`, `group`, `probe`
12:32: specimen[1].position: expected 2 values in round brackets `(...)`, found `2.0`"),
        (PARTICLE, "(position: (2.0, 1.0), radius: 1.0, radius: 2.0)",
         "12:45: specimen[1].radius: `radius` is given twice; give it once"),
        (PARTICLE, "((2.0, 1.0), 1.0)",
         "12:9: specimen[1]: expected `(position: ...)`, found `((2.0, 1.0), 1.0)`; write `name: value`; the fields here are `position`, `radius`, `material`, `velocity`, `angular_velocity`, `group`, `probe`"),
        (PARTICLE, "(position: [2.0, 1.0], radius: 1.0)",
         "12:20: specimen[1].position: expected 2 values in round brackets `(...)`, found `[2.0, 1.0]`"),
        (PARTICLE, "(position: (2.0, 1.0, 0.0), radius: 1.0)",
         "12:20: specimen[1].position: expected 2 values in brackets, found `(2.0, 1.0, 0.0)`"),
        (PARTICLE, r#"(position: (2.0, 1.0), radius: "1.0")"#,
         r#"12:40: specimen[1].radius: expected a number, found `"1.0"`; leave the quotes out"#),
        ("increments: 4", "increments: 4.0",
         "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found `4.0`; write 4"),
        ("increments: 4", "increments: Some(4)",
         "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found `Some(4)`; write `4`, without `Some`"),
        ("increments: 4", "increments: 4.5",
         "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found `4.5`; write 4 or 5"),
        ("increments: 4", "increments: -4",
         "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found `-4`"),
        (r#"title: "Small""#, "title: Small",
         "3:12: title: expected a text in quotes, found `Small`; write `\"Small\"`"),
        ("    version: 1,
", "",
         "1:1: version: missing field `version`; add `version: 1`"),
        (STAGES, "analysis: Dynamic(),
    stages: [",
         "18:15: analysis.dt: missing field `dt`; add `dt: ...`, in s"),
        (STAGES, "analysis: Dinamic(dt: -1.0),
    stages: [",
         "18:15: analysis: unknown variant `Dinamic`; did you mean `Dynamic`? there are the variants `Static`, `Dynamic`
18:27: analysis.dt: negative (-1.0); give a time step in s greater than 0"),
        (STAGES, "analysis: Quick,
    stages: [",
         "18:15: analysis: unknown variant `Quick`; there are the variants `Static`, `Dynamic`"),
        (STAGES, "analysis: Static(1.0),
    stages: [",
         "18:15: analysis: expected plain `Static`, found `Static(1.0)`"),
        (STAGES, "analysis: Dynamic(1.0),
    stages: [",
         "18:15: analysis: expected `Dynamic(dt: ...)`, found `Dynamic(1.0)`; write `Dynamic(dt: 1.0)`"),
        (FORCE, "Force",
         "22:28: stages[0].walls.top: expected `Force(...)`, found `Force`"),
        (FORCE, "Force(1.0, 2.0)",
         "22:28: stages[0].walls.top: expected a number, found `Force(1.0, 2.0)`; give one number"),
        (FORCE, "Displacement(1.0)",
         "22:28: stages[0].walls.top: expected 2 values in brackets, found `Displacement(1.0)`"),
        (FORCE, "Stress(1.0)",
         "22:28: stages[0].walls.top: expected `Stress(stress: ...)`, found `Stress(1.0)`; write `Stress(stress: 1.0)`"),
        (FORCE, "Stress(1.0, 2.0)",
         "22:28: stages[0].walls.top: expected `Stress(stress: ...)`, found `Stress(1.0, 2.0)`; write `name: value`; the fields here are `stress`, `between`"),
        ("increments: 4", "increments: 0.5",
         "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found `0.5`"),
        ("increments: 4", "increments: Some(\"4\")",
         "21:25: stages[0].increments: expected a whole number from 0 to 4294967295, found `Some(\"4\")`"),
        (r#"title: "Small""#, "title: 'Small'",
         "3:12: title: expected a text in quotes, found `'Small'`; write `\"Small\"`"),
        (r#"title: "Small""#, r#"title: "C:\data""#,
         "3:12: title: expected a text in quotes, found `\"C:\\data\"`; a backslash in a text is written twice, `\\\\`; in paths `/` will do"),
        (r#"walls: {"top": Force(1.0)}"#, r#"walls: {"top": Force(1.0)}, remove_walls: ("top", "bottom")"#,
         "22:55: stages[0].remove_walls: expected a list `[...]`, found `(\"top\", \"bottom\")`; write `[` and `]` for `(` and `)`"),
        (VERSION, "version: 1,
    analysis: Dynamic",
         "3:15: analysis: expected `Dynamic(...)`, found `Dynamic`; its fields are `dt`, `theta`"),
        (r#"title: "Small""#, "title: 5",
         "3:12: title: expected a text in quotes, found `5`; write `\"5\"`"),
        (r#"{"top": Force(1.0)}"#, r#"("top": Force(1.0))"#,
         "22:20: stages[0].walls: expected a map `{\"name\": ...}`, found `(\"top\": Force(1.0))`; write `{` and `}` for `(` and `)`"),
        (r#"{"top": Force(1.0)}"#, r#"{"top", Force(1.0)}"#,
         "22:21: stages[0].walls: expected `\"name\": value`, found `\"top\"`; put a name and `:` before it
22:28: stages[0].walls: expected `\"name\": value`, found `Force(1.0)`; put a name and `:` before it"),
        (r#"(position: (2.0, 1.0), radius: 1.0)"#, r#"(position: {2.0, 1.0}, radius: 1.0)"#,
         "12:20: specimen[1].position: expected 2 values in round brackets `(...)`, found `{2.0, 1.0}`"),
        (FORCE, "Push(1.0)",
         "22:28: stages[0].walls.top: unknown variant `Push`; there are the variants `Fixed`, `Displacement`, `Velocity`, `Rotation`, `Spin`, `Force`, `Stress`, `Custom`, `Lid`, `Follow`"),
        (r#""grain": ("#, r#""grain": Grain("#,
         "5:18: materials.grain: expected `(density: ...)`, found `Grain(...)`"),
        (r#""top": Force(1.0)"#, r#""top": Force(1.0), "top": Fixed"#,
         "22:40: stages[0].walls.top: `top` is given twice; give it once"),
        ("contact: (friction: 0.5)", "contact: (friction: 0.5), bond: (friction: 0.1)",
         "7:45: materials.grain.bond.cohesion: missing field `cohesion`; add `cohesion: ...`, in Pa
7:45: materials.grain.bond.tensile_strength: missing field `tensile_strength`; add `tensile_strength: ...`, in Pa"),
        ("contact: (friction: 0.5)", "contact: (friction: 0.5), bond: ((cohesion: 1.0, tensile_strength: 1.0))",
         "7:45: materials.grain.bond: expected `(normal_stiffness: ...)`, found `((cohesion: 1.0, tensile_strength: 1.0))`; leave out one pair of brackets"),
        (r#"Load(
            name: "load",
            increments: 4,
            walls: {"top": Force(1.0)},
        )"#, r#"Compact(name: "c", wall: "tpo", step: -1.0)"#,
         "19:9: stages[0].target: missing field `target`; add `target: ...`
19:9: stages[0].base: missing field `base`; add `base: ...`
19:34: stages[0].wall: unknown wall (`tpo`); did you mean `top`? there are the walls `bottom`, `top`
19:47: stages[0].step: negative (-1.0); give a step in m greater than 0"),
    ]);
}

#[test]
fn settings() {
    check(&[
        (VERSION, "version: 3", "2:14: version: unknown version (3); this build reads version 1"),
        (
            VERSION,
            "version: 1, thickness: 0.0",
            "2:28: thickness: zero (0.0); give a thickness in m greater than 0",
        ),
        (
            VERSION,
            "version: 1, thickness: inf",
            "2:28: thickness: not finite (inf); give a thickness in m greater than 0",
        ),
        (
            VERSION,
            "version: 1, gravity: (0.0, NaN)",
            "2:32: gravity[1]: not finite (NaN); give an acceleration in m/s^2",
        ),
        (
            VERSION,
            "version: 1, analysis: Dynamic(dt: 0.0, theta: 1.5)",
            "2:39: analysis.dt: zero (0.0); give a time step in s greater than 0
2:51: analysis.theta: out of range (1.5); give a theta from 0.5 to 1: below, energy grows",
        ),
        (
            VERSION,
            "version: 1, analysis: Dynamic(dt: 1.0, theta: 0.0)",
            "2:51: analysis.theta: zero (0.0); give a theta from 0.5 to 1: below, energy grows",
        ),
        (
            VERSION,
            "version: 1, acceptance: (residual: 0.0, turn: -1.0, halvings: 99)",
            "2:40: acceptance.residual: zero (0.0); give a residual above 0 and up to 1e-2
2:51: acceptance.turn: negative (-1.0); give an angle in rad greater than 0
2:67: acceptance.halvings: out of range (99); give a number up to 30",
        ),
        (
            VERSION,
            "version: 1, rupture: (density: 0.0)",
            "2:36: rupture.density: zero (0.0); give a share of the bonds per relative change of force, above 0",
        ),
        (
            VERSION,
            "version: 1, rupture: (brittleness: -0.5)",
            "2:40: rupture.brittleness: negative (-0.5); give a multiple of the mean contact force, 0 or more",
        ),
        (
            VERSION,
            "version: 1, rupture: (order: OneRound, avalanche: Dynamic)",
            "2:55: rupture.avalanche: `Dynamic` has no effect: with `order: OneRound` there are no avalanches; \
             give `order: Events`, or leave `avalanche` out",
        ),
    ]);
}

#[test]
fn materials() {
    check(&[
        ("friction: 0.5", "friction: -0.5",
         "7:33: materials.grain.contact.friction: negative (-0.5); give a coefficient of 0 or more"),
        ("friction: 0.5", "friction: 1e999",
         "7:33: materials.grain.contact.friction: not finite (inf); give a coefficient of 0 or more"),
        ("friction: 0.5", "normal_stiffness: 0.0, tangential_stiffness: -1.0",
         "7:41: materials.grain.contact.normal_stiffness: zero (0.0); give a stiffness in N/m greater than 0, or leave it out for a rigid law
7:68: materials.grain.contact.tangential_stiffness: negative (-1.0); give a stiffness in N/m greater than 0, or leave it out for a rigid law"),
        ("friction: 0.5", "rolling_friction: 0.1, rolling_stiffness: 0.0",
         "7:65: materials.grain.contact.rolling_stiffness: zero (0.0); give a stiffness in N m/rad greater than 0, or leave it out for a rigid law"),
        ("friction: 0.5", "friction: 0.5, rolling_stiffness: 100.0",
         "7:57: materials.grain.contact.rolling_stiffness: a rolling stiffness without a rolling moment; \
give `rolling_friction` too, the coefficient of its limit mu_r r p, or leave it out"),
        ("friction: 0.5", "rolling_friction: 0.1, rolling_stiffness: 1.0e2, restitution: 0.5",
         "7:85: materials.grain.contact.restitution: restitution of an elastic contact (0.5); \
leave out the stiffnesses, for a rigid contact, or the restitution: the springs of a contact determine how it rebounds"),
        ("density: 2650.0", "density: 0.0",
         "6:22: materials.grain.density: zero (0.0); give a density in kg/m^3 greater than 0"),
        ("friction: 0.5)", "friction: 0.5), bond: (cohesion: -1.0, tensile_strength: NaN)",
         "7:56: materials.grain.bond.cohesion: negative (-1.0); give a cohesion in Pa of 0 or more
7:80: materials.grain.bond.tensile_strength: not finite (NaN); give a tensile strength in Pa of 0 or more"),
        (r#""grain": ("#, r#""sand": (), "grain": ("#,
         "11:9: specimen[0].material: missing material: the scene has several; name one of `grain`, `sand`
12:9: specimen[1].material: missing material: the scene has several; name one of `grain`, `sand`"),
    ]);
}

#[test]
fn specimen() {
    check(&[
        (PARTICLE, "(position: (2.0, 1.0), radius: 0.0)",
         "12:40: specimen[1].radius: zero (0.0); give a radius in m greater than 0"),
        (PARTICLE, "(position: (NaN, 1.0), radius: 1.0)",
         "12:21: specimen[1].position[0]: not finite (NaN); give a place in m"),
        (PARTICLE, "(position: (0.0, 1.0), radius: 0.5)",
         "12:20: specimen[1].position: the same place as particle 0 (0.0, 1.0); leave one of them out"),
        (PARTICLE, "(position: (2.0, -0.5), radius: 1.0)",
         "12:20: specimen[1].position: the centre is behind wall `bottom` (2.0, -0.5); move it inside; a wall has its inside on the left of start to end"),
        (PARTICLE, r#"(position: (2.0, 1.0), radius: 1.0, material: "grian")"#,
         "12:55: specimen[1].material: unknown material (`grian`); did you mean `grain`? there is only `grain`"),
        (PARTICLE, r#"(position: (2.0, 1.0), radius: 1.0, probe: "p"), (position: (4.0, 1.0), radius: 1.0, probe: "p")"#,
         "12:101: specimen[2].probe: name of a probe given twice (`p`); it is also that of specimen[1].probe"),
        (STAGES, "bonds: [(a: 0, b: 2), (a: 1, b: 1), (a: 0, b: 1)],
    stages: [",
         "18:23: bonds[0].b: no such particle (2); the particles are 0 to 1
18:27: bonds[1]: a bond of particle 1 to itself; name two particles
18:41: bonds[2]: material `grain` has no bond law; add `bond: (...)` to materials.grain"),
        ("friction: 0.5)", r#"friction: 0.5), bond: (cohesion: 1.0, tensile_strength: 1.0)),
 "other": (contact: ()"#,
         "12:9: specimen[0].material: missing material: the scene has several; name one of `grain`, `other`
13:9: specimen[1].material: missing material: the scene has several; name one of `grain`, `other`"),
        ("    walls: [
", "    bonds: [(a: 0, b: 1), (a: 1, b: 0)],
    walls: [
",
         "14:13: bonds[0]: material `grain` has no bond law; add `bond: (...)` to materials.grain
14:27: bonds[1]: a second bond of particles 1 and 0; the first is bonds[0]"),
    ]);
}

#[test]
fn recipes() {
    check(&[
        (SPECIMEN, "Lattice(columns: 3, rows: 0, radius: 1.0)",
         "10:41: specimen.rows: zero (0); give a number of 1 or more"),
        (SPECIMEN, "Lattice(columns: 3000000, rows: 3000000, radius: 1.0, origin: (0.0, 1.0))",
         "10:15: specimen: 8999998500000 particles, which take about 90.0 PB of memory; give at most 5000000"),
        (SPECIMEN, "Lattice(columns: 2, rows: 2, radius: 0.5, origin: (0.0, -0.5))",
         "10:15: specimen: particle 0 is behind wall `bottom` (0.0, -0.5); move it inside; a wall has its inside on the left of start to end"),
        (SPECIMEN, "Packing(count: 0, columns: 0, spacing: 1.0, sizes: Equal(radius: 0.5), seed: 1)",
         "10:30: specimen.count: zero (0); give a number of 1 or more
10:42: specimen.columns: zero (0); give a number of 1 or more"),
        (SPECIMEN, "Packing(count: 4, columns: 2, spacing: 1.0, sizes: Uniform(radius: (0.3, 0.6)), seed: 1)",
         "10:54: specimen.spacing: smaller than the maximum diameter (1.0); give a spacing in m of 1.2 or more"),
        (SPECIMEN, "Packing(count: 4, columns: 2, spacing: 2.0, sizes: Uniform(radius: (0.6, 0.3)), seed: -1)",
         "10:82: specimen.sizes.radius: minimum above maximum (0.6 > 0.3); give (minimum, maximum)
10:101: specimen.seed: expected a whole number from 0, found `-1`"),
        (SPECIMEN, "Packing(count: 4, columns: 2, spacing: 0.5, sizes: LogNormal(radius: 0.5, deviation: -1.0, limits: (0.1, 0.2)), seed: 1, origin: (0.0, 1.7))",
         "10:84: specimen.sizes.radius: the median is outside of the limits (0.5); give a median between the limits
10:100: specimen.sizes.deviation: negative (-1.0); give a standard deviation of ln(radius) of 0 or more"),
        (SPECIMEN, "Particles([(position: (0.0, 1.0), radius: 1.0),])]",
         "10:64: `]` where the `(` of line 1 wants its `)`; check the brackets"),
        (SPECIMEN, "Partices([])",
         "10:15: specimen: unknown variant `Partices`; did you mean `Particles`? there are the variants `Particles`, `Lattice`, `Packing`, `File`, `State`"),
        (SPECIMEN, "File(path: 3)",
         "10:26: specimen.path: expected a text in quotes, found `3`; write `\"3\"`"),
    ]);
}

#[test]
fn walls() {
    check(&[
        (TOP, r#"(name: "top", start: (5.0, 2.0), end: (5.0, 2.0))"#,
         "16:47: walls[1].end: a wall of zero length ((5.0, 2.0) to (5.0, 2.0)); move its end"),
        (TOP, r#"(name: "bottom", start: (5.0, 2.0), end: (-5.0, 2.0))"#,
         "16:16: walls[1].name: name of a wall given twice (`bottom`); it is also that of walls[0].name
22:21: stages[0].walls.top: unknown wall (`top`); there is only `bottom`"),
        (TOP, r#"(name: "top", start: (-5.0, 2.0), end: (5.0, 2.0))"#,
         "11:20: specimen[0].position: the centre is behind wall `top` (0.0, 1.0); move it inside; a wall has its inside on the left of start to end
12:20: specimen[1].position: the centre is behind wall `top` (2.0, 1.0); move it inside; a wall has its inside on the left of start to end"),
        (TOP, r#"(name: "top", start: (5.0, 2.0), end: (-5.0, 2.0), contact: (friction: -1.0))"#,
         "16:80: walls[1].contact.friction: negative (-1.0); give a coefficient of 0 or more"),
        (TOP, r#"(nmae: "top", start: (5.0, 2.0), end: (-5.0, NaN))"#,
         "16:10: walls[1].nmae: unknown field `nmae`; did you mean `name`? the fields here are `name`, `start`, `end`, `shape`, `contact`, `bond`, `present`, `touching`, `probe`
16:54: walls[1].end[1]: not finite (NaN); give a place in m"),
        (TOP, "(start: (5.0, 2.0), end: (-5.0, 2.0))",
         "16:9: walls[1].name: missing field `name`; add `name: ...`"),
        ("-5.0, 2.0)),
", r#"-5.0, 2.0)),
        (name: "", start: (0.0, 9.0), end: (0.0, 8.0), probe: ""),
"#,
         "17:16: walls[2].name: empty name of a wall; give a name
17:63: walls[2].probe: empty name of a probe; give a name"),
        (STAGES_LOAD, r#"    (name: "side", start: (-5.0, 2.0), end: (-5.0, 0.0)),
    ],
    stages: [
        Compact(name: "c", wall: "top", base: "side", target: Height(1.0), step: 0.1),
        Load("#,
         "20:47: stages[0].base: wall `side` does not face wall `top`; the two walls must be parallel, with their insides towards each other"),
    ]);
}

#[test]
fn stages() {
    check(&[
        ("increments: 4", "increments: 0",
         "21:25: stages[0].increments: zero (0); give a number of 1 or more"),
        (r#""top": Force"#, r#""tip": Force"#,
         "22:21: stages[0].walls.tip: unknown wall (`tip`); did you mean `top`? there are the walls `bottom`, `top`"),
        (r#""top": Force(1.0)"#, r#""top": Velocity(0.0, 1.0)"#,
         "22:28: stages[0].walls.top: a velocity in a static stage, which has no time; use `Displacement`, in every increment, or a dynamic analysis"),
        (CONTROL, "particles: [(select: All, x: Velocity(1.0))]",
         "22:42: stages[0].particles[0].x: a velocity in a static stage, which has no time; use `Displacement`, in every increment, or a dynamic analysis"),
        (r#""top": Force(1.0)"#, r#""top": Stress(stress: 1.0, between: ("top", "bottom"))"#,
         "22:58: stages[0].walls.top.between[0]: the wall itself (`top`); name the two walls that bound its loaded length"),
        (r#""top": Force(1.0)"#, r#""top": Stress(stress: NaN, between: ("bottom", "bottom"))"#,
         "22:43: stages[0].walls.top.stress: not finite (NaN); give a stress in Pa
22:57: stages[0].walls.top.between: a wall given twice; name two walls"),
        (CONTROL, r#"remove_walls: ["top"], walls: {"top": Fixed}"#,
         "22:51: stages[0].walls.top: wall `top` is not there in this stage; bring it in with `add_walls`"),
        (CONTROL, r#"remove_walls: ["top", "top"], add_walls: ["bottom"]"#,
         "22:35: stages[0].remove_walls[1]: wall `top` is not there; leave it out of this list
22:55: stages[0].add_walls[0]: wall `bottom` is already there; leave it out of this list"),
        ("-5.0, 2.0))", "-5.0, 2.0), present: false)",
         "22:28: stages[0].walls.top: wall `top` is not there in this stage; bring it in with `add_walls`"),
        (CONTROL, "stop: [Above(\"axial_strain\", 0.0), StressDrop(2.0), Rest(-1.0)]",
         "22:26: stages[0].stop[0][0]: unknown measure (`axial_strain`); there are no measures
22:48: stages[0].stop[1]: no axial stress is measured; add `axial_stress` to `measures`
22:59: stages[0].stop[1][0]: out of range (2.0); give a fraction between 0 and 1
22:65: stages[0].stop[2]: a stop by speed in a static stage, which has no time; use a dynamic analysis
22:70: stages[0].stop[2][0]: negative (-1.0); give a speed in m/s greater than 0"),
        (CONTROL, r#"particles: [(select: Group("g")), (select: Probe("p")), (select: Index([])), (select: Index([0, 7]))]"#,
         "22:40: stages[0].particles[0].select[0]: unknown group (`g`); there are no groups
22:62: stages[0].particles[1].select[0]: unknown probe (`p`); there are no probes
22:78: stages[0].particles[2].select: selects no particle; name particles by index, from 0
22:109: stages[0].particles[3].select[1]: no such particle (7); the particles are 0 to 1"),
        (CONTROL, "particles: [(select: Box(min: (1.0, 0.0), max: (0.0, 1.0)), x: Held, affine: ((0.0, inf), (0.0, 0.0)))]",
         "22:60: stages[0].particles[0].select.max: not above and to the right of min ((0.0, 1.0)); swap the corners
22:76: stages[0].particles[0].x: x is imposed twice; `affine` imposes x and y: leave it out here
22:97: stages[0].particles[0].affine[0][1]: not finite (inf); give a displacement gradient"),
        (LOAD, r#"Compact(name: "load", wall: "top", base: "top", target: Height(0.0), step: 0.0),
        Load(
"#,
         "19:50: stages[0].base: the wall that moves (`top`); name the fixed wall opposite
19:72: stages[0].target[0]: zero (0.0); give a height in m greater than 0
19:84: stages[0].step: zero (0.0); give a step in m greater than 0
21:19: stages[1].name: name of a stage given twice (`load`); it is also that of stages[0].name"),
        (LOAD, r#"Compact(name: "c", wall: "top", base: "bottm", target: Porosity(1.2), step: 0.1),
        Load(
"#,
         "19:47: stages[0].base: unknown wall (`bottm`); did you mean `bottom`? there are the walls `bottom`, `top`
19:73: stages[0].target[0]: out of range (1.2); give a porosity between 0 and 1"),
        (LOAD, r#"Compact(name: "c", wall: "top", base: "bottom", target: Height(1.0), by: Radii, step: 0.1),
        Load(
"#,
         "19:65: stages[0].target: a height, and no wall moves; write `target: Porosity(...)`"),
        (LOAD, r#"Cement(name: "c", length: -1.0),
        Load(
"#,
         "19:9: stages[0]: no material has a bond law; add `bond: (...)` to the material that is to be cemented
19:35: stages[0].length: negative (-1.0); give a bond length in m of 0 or more"),
        (LOAD, r#"Compact(name: "c", wall: "bottom", base: "bottom2", target: Height(inf), step: 0.1, agitation: -1.0),
        Load(
"#,
         "19:50: stages[0].base: unknown wall (`bottom2`); did you mean `bottom`? there are the walls `bottom`, `top`
19:76: stages[0].target[0]: not finite (inf); give a height in m greater than 0
19:104: stages[0].agitation: negative (-1.0); give a number of radii of 0 or more"),
    ]);
}

#[test]
fn measures() {
    check(&[
        (STAGES, r#"reference_stage: "laod", measures: [(name: "axial_strain", of: Strain(Walls("top", "top"))), (name: "lateral_strain", of: Strain(Particles(0, 2)))],
    stages: ["#,
         "18:22: reference_stage: unknown stage (`laod`); did you mean `load`? there is only `load`
18:68: measures[0].of: a wall given twice; name two walls
18:147: measures[1].of[1]: no such particle (2); the particles are 0 to 1"),
        (STAGES, r#"measures: [(name: "axial_stress", of: Stress(Walls(walls: [], length: Fixed(0.0)))), (name: "lateral_stress", of: Stress(Average(component: Xz, area: Fixed(-1.0))))],
    stages: ["#,
         "18:63: measures[0].of.walls: no walls; name one or more
18:81: measures[0].of.length[0]: zero (0.0); give a length in m greater than 0
18:145: measures[1].of.component: unknown variant `Xz`; there are the variants `Xx`, `Yy`, `Xy`, `Mean`, `Major`, `Minor`, `Shear`
18:161: measures[1].of.area[0]: negative (-1.0); give an area in m^2 greater than 0"),
    ]);
}
