//! Drives the app of a scene: steps that wait, keys, clicks, and screenshots.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::mouse::MouseButtonInput;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::window::PrimaryWindow;
use bevy_clastic::draw::{Shown, UnitsPerMetre};
use bevy_clastic::engine::Engine;
use bevy_clastic::picture::Picture;
use bevy_clastic::window::{self, LivePlugin};
use clastic::prelude::{ClasticPlugins, ScenePlugin};
use clastic::run::spawn::spawn_scene;
use glam::DVec2;

/// Time after which a step that still waits has failed.
const PATIENCE: Duration = Duration::from_secs(120);
const FOLDER: &str = "screenshots";

/// Called in every frame until it is true. The next step follows.
type Step = Box<dyn FnMut(&mut World) -> bool + Send + Sync>;

/// Steps in their order.
#[derive(Resource, Default)]
pub struct Steps {
    list: Vec<(String, Step)>,
    at: usize,
    since: Option<Instant>,
}

/// Screenshots by name.
#[derive(Resource, Default)]
struct Shots(BTreeMap<String, Image>);

impl Steps {
    /// Something that is done at once.
    pub fn act(&mut self, what: &str, mut act: impl FnMut(&mut World) + Send + Sync + 'static) {
        self.each_frame(what, move |world| {
            act(world);
            true
        });
    }

    /// Waits until something holds.
    pub fn wait(&mut self, what: &str, mut is: impl FnMut(&World) -> bool + Send + Sync + 'static) {
        self.each_frame(what, move |world| is(world));
    }

    /// Calls something in every frame until it is true.
    pub fn each_frame(
        &mut self,
        what: &str,
        act: impl FnMut(&mut World) -> bool + Send + Sync + 'static,
    ) {
        self.list.push((what.to_owned(), Box::new(act)));
    }

    /// Waits for a number of frames.
    pub fn frames(&mut self, number: u32) {
        let mut left = number;
        self.wait("frames", move |_| {
            left = left.saturating_sub(1);
            left == 0
        });
    }

    /// Presses and releases a key, with or without shift.
    pub fn key(&mut self, key: KeyCode, shift: bool) {
        let press = |world: &mut World, key: KeyCode, state: ButtonState| {
            let window = main_window(world);
            world.write_message(KeyboardInput {
                key_code: key,
                logical_key: Key::Character(" ".into()),
                state,
                text: None,
                repeat: false,
                window,
            });
        };
        self.act("press", move |world| {
            if shift {
                press(world, KeyCode::ShiftLeft, ButtonState::Pressed);
            }
            press(world, key, ButtonState::Pressed);
        });
        self.act("release", move |world| {
            press(world, key, ButtonState::Released);
            press(world, KeyCode::ShiftLeft, ButtonState::Released);
        });
        self.frames(2);
    }

    /// Clicks on a place of the specimen, m.
    pub fn click(&mut self, at: impl Fn(&World) -> DVec2 + Send + Sync + 'static) {
        self.act("cursor", move |world| {
            let at = on_screen(world, at(world));
            let window = main_window(world);
            if let Some(mut window) = world.get_mut::<Window>(window) {
                window.set_cursor_position(Some(at));
            }
        });
        self.frames(3);
        for state in [ButtonState::Pressed, ButtonState::Released] {
            self.act("button", move |world| {
                let window = main_window(world);
                let button = MouseButton::Left;
                world.write_message(MouseButtonInput { button, state, window });
            });
            self.frames(2);
        }
    }

    /// Takes a screenshot, which [`pixel`] reads.
    pub fn shot(&mut self, name: &str) {
        let key = name.to_owned();
        self.frames(4);
        self.act("screenshot", move |world| {
            let (key, path) = (key.clone(), format!("{FOLDER}/{key}.png"));
            world.spawn(Screenshot::primary_window()).observe(save_to_disk(path)).observe(
                move |shot: On<ScreenshotCaptured>, mut shots: ResMut<Shots>| {
                    shots.0.insert(key.clone(), shot.image.clone());
                },
            );
        });
        let key = name.to_owned();
        self.wait("screenshot", move |world| world.resource::<Shots>().0.contains_key(&key));
    }
}

/// The picture that is drawn.
pub fn picture(world: &World) -> &Picture {
    &world.resource::<Shown>().now
}

fn main_window(world: &mut World) -> Entity {
    let mut windows = world.query_filtered::<Entity, With<PrimaryWindow>>();
    windows.single(world).expect("a window")
}

/// Pixel of a place of the specimen, m.
pub fn on_screen(world: &mut World, at: DVec2) -> Vec2 {
    let scale = f64::from(world.resource::<UnitsPerMetre>().0);
    let mut cameras = world.query_filtered::<(&Camera, &GlobalTransform), With<Camera2d>>();
    let (camera, place) = cameras.single(world).expect("a camera");
    let at = (scale * at).as_vec2().extend(0.0);
    camera.world_to_viewport(place, at).expect("a place in the view")
}

/// Colour of a pixel of a screenshot, 0 to 255.
pub fn pixel(world: &World, name: &str, at: Vec2) -> [u8; 3] {
    let image = &world.resource::<Shots>().0[name];
    let colour = image.get_color_at(at.x as u32, at.y as u32).expect("a pixel").to_srgba();
    colour.to_u8_array_no_alpha()
}

/// Runs the window of a scene with these steps.
pub fn run(scene: &str, add: impl FnOnce(&mut Steps)) -> ExitCode {
    let path = format!("../scenes/{scene}.ron");
    let loaded = clastic::scene::load(path.as_ref(), &[]).unwrap_or_else(|e| panic!("{e}"));
    let engine = Engine::start(move || {
        let mut app = App::new();
        app.add_plugins((ClasticPlugins::default(), ScenePlugin));
        spawn_scene(app.world_mut(), &loaded.scene, loaded.specimen.as_ref());
        app
    });
    let window = Some(window::window(scene.to_owned()));
    let mut app = App::new();
    app.add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: window, ..default() }))
        .insert_resource(engine)
        .add_plugins(LivePlugin);
    let mut steps = Steps::default();
    steps.wait("the first picture", |world| !picture(world).frame.bodies.id.is_empty());
    steps.frames(10);
    add(&mut steps);
    drive(app, steps)
}

/// Runs an app with these steps.
pub fn drive(mut app: App, steps: Steps) -> ExitCode {
    std::fs::create_dir_all(FOLDER).expect("the folder of the screenshots");
    app.insert_resource(steps).init_resource::<Shots>().add_systems(Last, step);
    if app.run().is_success() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// One step in a frame. A step that panics ends the program with its message.
fn step(world: &mut World) {
    let mut steps = std::mem::take(&mut *world.resource_mut::<Steps>());
    let since = *steps.since.get_or_insert_with(Instant::now);
    let at = steps.at;
    match steps.list.get_mut(at) {
        Some((what, step)) => {
            if step(world) {
                (steps.at, steps.since) = (at + 1, None);
            } else if since.elapsed() > PATIENCE {
                panic!("step {at} still waits: {what}; {:?}", picture(world).motion);
            }
        }
        None => {
            world.write_message(AppExit::Success);
        }
    }
    world.insert_resource(steps);
}
