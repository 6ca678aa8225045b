//! Runs a scene of the repository without files and reads its record increment by increment.
//!
//! Two bonded disks are pulled apart: the bond breaks in tension when it carries 24 N.

use clastic::prelude::*;
use clastic::scene::load;

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tension.ron");
    let loaded = load(path.as_ref(), &[])?;
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let mut maximum: f64 = 0.0;
    let outcome = loop {
        match simulation.step() {
            Step::Finished(outcome) => break outcome,
            Step::Increment => {
                let record = simulation.world().resource::<Observation>();
                let tension = record.ruptures.iter().map(|rupture| -rupture.p);
                maximum = tension.fold(maximum, f64::max);
            }
        }
    };
    println!("{outcome:?}; the bond broke at {maximum:.3} N");
    assert_eq!(outcome, Outcome::Completed);
    assert!((maximum - 24.0).abs() < 0.1);
    Ok(())
}
