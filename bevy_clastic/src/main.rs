//! Runs any scene in a window: `cargo run -- ../scenes/biaxial_small.ron`.

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_clastic::engine::{Engine, Order};
use bevy_clastic::window::{LivePlugin, window};
use clastic::prelude::{ClasticPlugins, ScenePlugin};
use clastic::run::spawn::spawn_scene;

const USAGE: &str = "\
Usage: bevy_clastic SCENE.ron [--set PATH=VALUE]... [--paused]

Runs a scene in a window. H lists the keys.

  --set PATH=VALUE   changes a value of the scene, as in `clastic run`
  --paused           waits for the space bar";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (mut path, mut sets, mut is_paused) = (None, Vec::new(), false);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--help" | "-h" => {
                println!("{USAGE}");
                return ExitCode::SUCCESS;
            }
            "--paused" => is_paused = true,
            "--set" => match arguments.next() {
                Some(set) => sets.push(set),
                None => return usage("--set needs PATH=VALUE"),
            },
            option if option.starts_with('-') => {
                return usage(&format!("there is no option {option}"));
            }
            _ if path.is_some() => return usage("give one scene"),
            scene => path = Some(scene.to_owned()),
        }
    }
    let Some(path) = path else { return usage("give a scene") };
    let loaded = match clastic::scene::load(path.as_ref(), &sets) {
        Ok(loaded) => loaded,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let window = Some(window(format!("clastic: {path}")));
    let engine = Engine::start(move || {
        let mut app = App::new();
        app.add_plugins((ClasticPlugins::default(), ScenePlugin));
        spawn_scene(app.world_mut(), &loaded.scene, loaded.specimen.as_ref());
        app
    });
    if !is_paused {
        engine.order(Order::Run(true));
    }
    let exit = App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: window, ..default() }))
        .insert_resource(engine)
        .add_plugins(LivePlugin)
        .run();
    if exit.is_success() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn usage(what: &str) -> ExitCode {
    eprintln!("{what}\n\n{USAGE}");
    ExitCode::FAILURE
}
