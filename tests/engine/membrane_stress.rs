//! Stresses of specimens between plates within a membrane, under loads whose stress is known.

use std::f64::consts::FRAC_PI_4;

use clastic::components::observation::Observation;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation};

use crate::common::{assert_relative, load_with_specimen, next, parse};

const RADIUS: f64 = 5.0e-3;
const PRESSURE: f64 = 150.0e3;
const THICKNESS: f64 = 0.3;

/// Columns of disks under an isotropic load: the plates carry the pressure times the width of the
/// whole disks, the membrane the pressure. Both stresses, and those of Love and Weber in all
/// directions, are the pressure; the width is that of whole disks, not that through the centres.
#[test]
fn an_isotropic_load_on_plates_is_read_as_the_pressure() {
    let (columns, rows) = (6, 8);
    let (width, height) = (2.0 * RADIUS * 6.0, 2.0 * RADIUS * 8.0);
    let disks: Vec<_> = (0..columns * rows)
        .map(|k| {
            let at = |i: i32| RADIUS * f64::from(2 * i + 1);
            format!(
                "(position: ({:?}, {:?}), radius: {RADIUS:?})",
                at(k % columns),
                at(k / columns)
            )
        })
        .collect();
    // A contact carries p h d = 450 N, and gives way by 7.5e-9 m: 7.5e-7 of a diameter.
    let scene = parse(&format!(
        r#"(
        version: 1, title: "isotropic", thickness: {THICKNESS:?},
        materials: {{ "m": (contact: (normal_stiffness: 6.0e10, tangential_stiffness: 3.0e10,
            friction: 0.5, rolling_friction: 0.05)) }},
        specimen: Particles([{}]),
        walls: [
            (name: "bottom", start: (-0.1, 0.0), end: (0.2, 0.0), contact: (normal_stiffness: 6.0e10)),
            (name: "top", start: (0.2, {height:?}), end: (-0.1, {height:?}),
                contact: (normal_stiffness: 6.0e10)),
        ],
        stages: [Load(name: "press", increments: 4, walls: {{ "top": Force({:?}) }},
            membranes: {{ "skin": (pressure: {PRESSURE:?}, between: ("bottom", "top")) }})],
        measures: [
            (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Membrane("skin")))),
            (name: "lateral_stress", of: Stress(Membrane("skin"))),
            (name: "xx", of: Stress(Average(component: Xx, area: Membrane("skin")))),
            (name: "yy", of: Stress(Average(component: Yy, area: Membrane("skin")))),
            (name: "xy", of: Stress(Average(component: Xy, area: Membrane("skin")))),
            (name: "minor", of: Stress(Average(component: Minor, area: Membrane("skin")))),
            (name: "top_n", of: WallForce(wall: "top")),
            (name: "width", of: Membrane(membrane: "skin", value: Width)),
            (name: "outer", of: Membrane(membrane: "skin", value: OuterWidth)),
            (name: "area", of: Membrane(membrane: "skin", value: OuterArea)),
            (name: "grains", of: Membrane(membrane: "skin", value: Grains)),
            (name: "porosity", of: Porosity(Membrane("skin"))),
        ])"#,
        disks.join(", "),
        PRESSURE * width * THICKNESS,
    ));
    let mut simulation = Simulation::new(&scene, None);
    for k in 1..=4 {
        next(&mut simulation).unwrap();
        let value = |name: &str| reading(simulation.world(), name).unwrap();
        let pressure = PRESSURE * f64::from(k) / 4.0;
        assert_relative(value("lateral_stress"), pressure, 1e-12);
        for name in ["axial_stress", "xx", "yy", "minor"] {
            assert_relative(value(name), pressure, 2e-6);
        }
        assert!(value("xy").abs() < 1e-6 * pressure);
        assert_relative(value("top_n"), pressure * width * THICKNESS, 1e-9);
        assert_relative(value("outer"), width, 2e-6);
        assert_relative(value("width"), width - 2.0 * RADIUS, 2e-6);
        assert_relative(value("area"), width * height, 4e-6);
        // Two sides of eight grains.
        assert_eq!(value("grains"), 16.0);
        assert_relative(value("porosity"), 1.0 - FRAC_PI_4, 1e-4);
    }
}

/// The isotropic state that rigid walls have brought stays as it is where a membrane takes the place
/// of two of them: it read p (1 + d/W), 8 % more for eleven disks.
#[test]
fn a_membrane_in_place_of_walls_keeps_the_isotropic_stress() {
    let mut loaded = load_with_specimen("biaxial_membrane_small");
    loaded.scene.stages.pop();
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    assert_eq!(simulation.run(), Outcome::Completed);
    let record = simulation.world().resource::<Observation>();
    assert_eq!(record.stage, "wrap");
    assert_relative(record.lateral_stress.unwrap(), 200.0e3, 1e-12);
    assert_relative(record.axial_stress.unwrap(), 200.0e3, 0.01);
}
