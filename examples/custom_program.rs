//! The whole command line for a program with plugins of its own: `run`, `resume`, `check` and the
//! rest.
//!
//! `cargo run --release --example custom_program -- check SCENE` accepts a scene with the measure
//! `Custom("fabric")`, which the `clastic` program refuses.

use std::process::ExitCode;

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use clastic::run::plugin::Provide;

/// Deviator of the fabric of contacts with force: mean of n_y^2 - n_x^2 over their normals n.
#[derive(Resource, Default)]
struct Fabric(Option<f64>);

fn measure(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    solution: Res<ConeSolution>,
    mut fabric: ResMut<Fabric>,
) {
    let loaded =
        contacts.0.iter().zip(&solution.forces).filter(|(contact, force)| {
            (contact.b as usize) < bodies.particles && force[0] > 1.0e-6
        });
    let deviators: Vec<f64> =
        loaded.map(|(contact, _)| contact.normal.y.powi(2) - contact.normal.x.powi(2)).collect();
    let mean = deviators.iter().sum::<f64>() / deviators.len() as f64;
    fabric.0 = mean.is_finite().then_some(mean);
}

/// The plugin.
pub fn fabric(app: &mut App) {
    app.init_resource::<Fabric>()
        .provide_measure("fabric", |fabric: &Fabric| fabric.0)
        .add_systems(Increment, measure.after(IncrementSystems::Record));
}

/// Runs the program.
pub fn main() -> ExitCode {
    clastic::cli::main(fabric)
}
