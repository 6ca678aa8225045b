//! Increments on a thread of their own: no frame waits for one, however long it takes.
//!
//! The engine is an app of its own on the thread. After each increment it leaves a copy of what is
//! drawn, and the frame takes it if it is there. What the user does goes to the engine as a closure
//! that has its world between two increments: loads, pause, bodies that come and go.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex};
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use bevy_time::{Time, TimePlugin, TimeUpdateStrategy};
use clastic::prelude::*;
use glam::DVec2;

/// Number of frames that an increment takes here.
const FRAMES: usize = 10;

/// What is drawn of an increment.
#[derive(Default)]
struct Picture {
    increment: u64,
    disks: Vec<(BodyId, DVec2)>,
}

/// What is to be done between two increments.
type Order = Box<dyn FnOnce(&mut World) + Send>;

/// The engine, as the app with the window sees it.
#[derive(Resource)]
struct Engine {
    latest: Arc<Mutex<Option<Picture>>>,
    orders: Sender<Order>,
    thread: JoinHandle<()>,
}

impl Engine {
    /// Starts a thread that fills an app by `fill` and makes increments until the engine is
    /// dropped.
    fn start(fill: impl FnOnce(&mut App) + Send + 'static) -> Self {
        let latest = Arc::new(Mutex::new(None));
        let (orders, received) = channel::<Order>();
        let left = latest.clone();
        let thread = spawn(move || {
            let mut app = App::new();
            app.add_plugins(ClasticPlugins::default());
            fill(&mut app);
            loop {
                match received.try_recv() {
                    Ok(order) => order(app.world_mut()),
                    Err(TryRecvError::Disconnected) => break,
                    Err(TryRecvError::Empty) => {
                        app.update();
                        let picture = picture(app.world_mut());
                        // Neither side holds the lock for longer than a move takes.
                        left.lock().unwrap_or_else(|e| panic!("{e}")).replace(picture);
                    }
                }
            }
        });
        Self { latest, orders, thread }
    }
}

/// A copy of what is drawn.
fn picture(world: &mut World) -> Picture {
    let mut disks = world.query_filtered::<(&BodyId, &BodyPosition), With<Particle>>();
    Picture {
        increment: world.resource::<ClasticProgress>().increment,
        disks: disks.iter(world).map(|(id, position)| (*id, position.0)).collect(),
    }
}

/// What the window shows, and the number of frames since it has changed.
#[derive(Resource, Default)]
struct Shown {
    picture: Picture,
    frames: usize,
}

/// A system of every frame: it takes what has come, and goes on with what it has otherwise.
fn draw(engine: Res<Engine>, mut shown: ResMut<Shown>) {
    assert!(!engine.thread.is_finished(), "the engine has stopped");
    shown.frames += 1;
    if let Ok(mut latest) = engine.latest.try_lock()
        && let Some(picture) = latest.take()
    {
        *shown = Shown { picture, frames: 0 };
    }
}

/// Stands for a large specimen: the increment goes on when this number of frames has been drawn. If
/// a frame waited for the increment, both would wait for ever.
struct Slow(Receiver<()>);

/// Runs the example.
pub fn main() {
    let (drawn, slow) = channel();
    let engine = Engine::start(move |app| {
        app.insert_resource(ClasticAnalysis {
            kind: AnalysisKind::Dynamic { dt: 5.0e-3, theta: 1.0 },
            gravity: DVec2::new(0.0, -9.81),
            ..ClasticAnalysis::default()
        });
        app.world_mut().spawn(Particle::disk(0.1, 2650.0, 1.0));
        app.insert_non_send(Slow(slow));
        let wait = |slow: NonSend<Slow>| (0..FRAMES).for_each(|_| slow.0.recv().unwrap_or(()));
        let before = IncrementSystems::Attempts;
        app.add_systems(Increment, wait.after(IncrementSystems::Draft).before(before));
    });
    let mut app = App::new();
    app.add_plugins(TimePlugin)
        .insert_resource(engine)
        .init_resource::<Shown>()
        .add_systems(Update, draw)
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(16)));
    let mut frames = 0;
    for increment in 1..=3 {
        for _ in 0..FRAMES {
            app.update();
            frames += 1;
            assert_eq!(app.world().resource::<Shown>().picture.increment, increment - 1);
            drawn.send(()).unwrap_or_else(|e| panic!("{e}"));
        }
        // The increment ends some frames later.
        while app.world().resource::<Shown>().picture.increment < increment {
            app.update();
            frames += 1;
        }
    }
    let time = app.world().resource::<Time>().elapsed_secs();
    println!("{frames} frames and 3 increments in {time:.2} s");
    // Implicit Euler: g dt^2 (1 + 2 + 3).
    let [(_, disk)] = app.world().resource::<Shown>().picture.disks[..] else { panic!("no disk") };
    assert!((disk.y + 9.81 * 25.0e-6 * 6.0).abs() < 1e-12, "{disk}");

    // Gravity is turned off between two increments; the disk then keeps its speed.
    let engine = app.world().resource::<Engine>();
    let order: Order =
        Box::new(|world| world.resource_mut::<ClasticAnalysis>().gravity = DVec2::ZERO);
    engine.orders.send(order).unwrap_or_else(|e| panic!("{e}"));
    drop(drawn);
    let fall = |app: &mut App| {
        let last = app.world().resource::<Shown>().picture.increment;
        while app.world().resource::<Shown>().picture.increment < last + 10 {
            app.update();
        }
        let Picture { increment, disks } = &app.world().resource::<Shown>().picture;
        (*increment as f64, disks[0].1.y)
    };
    let ((n, y), (later, below)) = (fall(&mut app), fall(&mut app));
    let speed = (y - below) / (5.0e-3 * (later - n));
    println!("{speed:.4} m/s");
    // That of a whole number of increments under gravity.
    let under_gravity = speed / (9.81 * 5.0e-3);
    assert!(under_gravity > 2.5 && (under_gravity - under_gravity.round()).abs() < 1e-6);
    if let Some(Engine { orders, thread, .. }) = app.world_mut().remove_resource() {
        drop(orders);
        thread.join().unwrap_or_else(|_| panic!("the engine has panicked"));
    }
}
