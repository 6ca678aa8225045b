//! A scene inside a Bevy app of your own: `ScenePlugin`, `spawn_scene`, and one increment in every
//! update.
//!
//! Two bonded disks are pulled apart by 1 um in every increment. A system of the app listens to the
//! ruptures. The bond breaks when it carries 24 N.

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use clastic::run::script::Script;
use clastic::run::spawn::spawn_scene;

/// Tension (N) of the bonds that have broken.
#[derive(Resource, Default)]
struct Broken(Vec<f64>);

fn listen(mut ruptures: MessageReader<Rupture>, mut broken: ResMut<Broken>) {
    broken.0.extend(ruptures.read().map(|rupture| -rupture.p));
}

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tension.ron");
    let loaded = clastic::scene::load(path.as_ref(), &[])?;
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin))
        .init_resource::<Broken>()
        .add_systems(Update, listen.after(ClasticStepping));
    spawn_scene(app.world_mut(), &loaded.scene, loaded.specimen.as_ref());

    // Updates after the last stage make no increment.
    let outcome = loop {
        app.update();
        if let Some(outcome) = &app.world().resource::<Script>().outcome {
            break outcome.clone();
        }
    };
    let broken = &app.world().resource::<Broken>().0;
    println!("{outcome:?}; bonds broke at {broken:.3?} N");
    assert_eq!(outcome, Outcome::Completed);
    assert!(broken.len() == 1 && (broken[0] - 24.0).abs() < 0.1);
    Ok(())
}
