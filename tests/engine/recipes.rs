//! Recipes of `docs/scenes.md`, as they stand there.

use std::f64::consts::PI;

use clastic::components::particle::Particle;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation};

use crate::common::{assert_relative, parse};

/// The scene of the page that begins with a comment.
fn recipe(comment: &str) -> String {
    let page = std::fs::read_to_string("docs/scenes.md").unwrap();
    let start = page.find(comment).unwrap();
    page[start..start + page[start..].find("```").unwrap()].to_owned()
}

#[test]
fn pluviated_sand_is_loaded_under_a_lid_under_either_law_of_friction() {
    let text = recipe("// Pluviation, lid, oedometer.");
    for law in ["Associated", "Coulomb()"] {
        let law = format!("version: 1, friction_law: {law},");
        let scene = parse(&text.replacen("version: 1,", &law, 1));
        let mut simulation = Simulation::new(&scene, None);
        assert_eq!(simulation.run(), Outcome::Completed, "{law}");
        let disks: Vec<Particle> =
            simulation.world_mut().query::<&Particle>().iter(simulation.world()).copied().collect();
        let value = |name: &str| reading(simulation.world(), name).unwrap();

        // Mass of the poured sand to half a grain, and of its part below the sieve of 6 mm.
        let mass: f64 = disks.iter().map(|disk| disk.mass).sum();
        assert_relative(value("poured_kg"), mass, 1e-12);
        assert!((mass - 8.0).abs() < 2650.0 * PI * 5.0e-3_f64.powi(2), "{mass}");
        let fine: f64 = disks.iter().filter(|d| d.radius <= 3.0e-3).map(|d| d.mass).sum();
        assert!((fine / mass - 0.4).abs() < 0.02, "{}", fine / mass);

        // The lid carries the pressure, the bottom the weight besides, and the sides each other.
        assert_relative(value("axial_stress"), 100.0e3, 1e-6);
        assert_relative(value("bottom_n"), 100.0e3 * 0.08 + mass * 9.81, 1e-6);
        assert_relative(value("left_n"), value("right_n"), 1e-6);
        // Love and Weber: half of the weight on average, with the branches at the walls.
        let mean = 100.0e3 + 0.5 * mass * 9.81 / 0.08;
        assert_relative(value("yy_pa"), mean, 0.02);
        let ratio = value("lateral_stress") / value("axial_stress");
        assert!((0.4..0.9).contains(&ratio), "{ratio}");
        assert!((0.17..0.26).contains(&value("porosity")), "{}", value("porosity"));
    }
}
