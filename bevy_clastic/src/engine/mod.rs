//! The engine on a thread of its own. Pictures come from it, orders go to it, and the window waits
//! for neither.

mod orders;
mod run;

pub use orders::Order;

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{JoinHandle, spawn};

use bevy::app::{App, Plugin, PreUpdate};
use bevy::ecs::prelude::*;

use crate::draw::Shown;
use crate::picture::{Picture, Series};

/// What the engine has left for the window.
#[derive(Default)]
struct Left {
    /// The last state, until the window takes it.
    picture: Option<Picture>,
    /// Values of the measures after every increment since the window last took some.
    rows: Vec<(u64, Vec<Option<f64>>)>,
}

/// The engine, as the app with the window sees it. The thread ends when this resource is dropped.
#[derive(Resource)]
pub struct Engine {
    left: Arc<Mutex<Left>>,
    orders: Sender<Order>,
    thread: JoinHandle<()>,
}

impl Engine {
    /// Starts a thread that makes an app with `ClasticPlugins` and makes its increments. It waits
    /// for [`Order::Run`].
    #[must_use]
    pub fn start(make: impl FnOnce() -> App + Send + 'static) -> Self {
        let left = Arc::new(Mutex::new(Left::default()));
        let (orders, received): (Sender<Order>, Receiver<Order>) = channel();
        let leave = left.clone();
        let thread = spawn(move || run::run(make(), &received, &leave));
        Self { left, orders, thread }
    }

    /// Gives an order. It is carried out between two increments.
    pub fn order(&self, order: Order) {
        // The thread has ended only if it panicked, which the window shows.
        let _ = self.orders.send(order);
    }

    /// Whether the thread has panicked.
    #[must_use]
    pub fn has_panicked(&self) -> bool {
        self.thread.is_finished()
    }
}

/// Neither side holds the lock for longer than it takes to move a picture.
fn lock(left: &Mutex<Left>) -> MutexGuard<'_, Left> {
    left.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes what the engine has left at the start of every frame. The app needs the resource
/// [`Engine`].
pub struct EnginePlugin;

impl Plugin for EnginePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Measured>().add_systems(PreUpdate, take);
    }
}

/// Values of the measures since the start.
#[derive(Resource, Default)]
pub struct Measured(pub Series);

fn take(engine: Res<Engine>, mut shown: ResMut<Shown>, mut measured: ResMut<Measured>) {
    let Left { picture, rows } = std::mem::take(&mut *lock(&engine.left));
    let Some(picture) = picture else { return };
    for (increment, row) in rows {
        measured.0.add(&picture.columns, increment, row);
    }
    measured.0.back_to(picture.frame.increment);
    shown.show(picture);
}
