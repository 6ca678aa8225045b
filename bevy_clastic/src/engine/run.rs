//! The loop of the engine's thread.

use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use bevy::app::{App, Update};
use bevy::ecs::prelude::*;
use clastic::components::increment::ClasticProgress;
use clastic::run::state::{capture, rewind};
use clastic::systems::gather_bodies::gather_bodies;
use clastic::systems::state::{StateError, WorldState};
use clastic::systems::stepping::{ClasticRunning, ClasticStepping, ClasticStopped, StoppedBy};

use super::{Left, Order, lock};
use crate::picture::{Picture, forget_loads, set_load, settle_loads};

/// States to go back to, and the pace.
struct Session {
    start: Result<WorldState, StateError>,
    kept: Option<(u64, WorldState)>,
    /// Time between the beginnings of two increments.
    pause: Duration,
    answer: String,
}

/// Why the app has stopped, in words.
#[derive(Resource, Default)]
struct Reason(String);

fn hear(mut stops: MessageReader<ClasticStopped>, mut reason: ResMut<Reason>) {
    for stopped in stops.read() {
        reason.0.clone_from(&stopped.reason);
    }
}

/// Makes increments and carries out orders until nobody can give one any more.
pub(super) fn run(mut app: App, orders: &Receiver<Order>, left: &Mutex<Left>) {
    app.init_resource::<Reason>().add_systems(Update, hear.after(ClasticStepping));
    app.insert_resource(ClasticRunning::Paused);
    app.finish();
    app.cleanup();
    // Systems of `Startup` fill the world.
    app.update();
    let world = app.world_mut();
    // A world that has made no increment has no tables yet.
    let _ = world.run_system_cached(gather_bodies);
    let start = capture(world);
    let mut session = Session { start, kept: None, pause: Duration::ZERO, answer: String::new() };
    leave(world, &session, left, false);
    let mut next = Instant::now();
    loop {
        let goes_on = matches!(
            app.world().resource::<ClasticRunning>(),
            ClasticRunning::Always | ClasticRunning::Times(_)
        );
        let order = match goes_on {
            true => orders.recv_timeout(next.saturating_duration_since(Instant::now())),
            false => orders.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        match order {
            Ok(order) => {
                session.carry_out(app.world_mut(), order);
                // A slider gives many.
                for order in orders.try_iter() {
                    session.carry_out(app.world_mut(), order);
                }
                leave(app.world_mut(), &session, left, false);
            }
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {
                next = Instant::now() + session.pause;
                app.update();
                settle_loads(app.world_mut());
                leave(app.world_mut(), &session, left, true);
            }
        }
    }
}

/// Leaves a picture for the window; with a row of the measures if an increment was made.
fn leave(world: &mut World, session: &Session, left: &Mutex<Left>, increment: bool) {
    let mut picture = Picture::take(world);
    picture.kept = session.kept.as_ref().map(|(increment, _)| *increment);
    picture.answer.clone_from(&session.answer);
    if let ClasticRunning::Stopped(by) = *world.resource::<ClasticRunning>()
        && by != StoppedBy::Completed
    {
        picture.answer.clone_from(&world.resource::<Reason>().0);
    }
    let mut left = lock(left);
    if increment {
        left.rows.push((picture.frame.increment, picture.row.clone()));
    }
    left.picture = Some(picture);
}

impl Session {
    fn carry_out(&mut self, world: &mut World, order: Order) {
        self.answer.clear();
        let running = *world.resource::<ClasticRunning>();
        let ended = matches!(
            running,
            ClasticRunning::Stopped(StoppedBy::Completed | StoppedBy::Halted | StoppedBy::Refused)
        );
        match order {
            // A collapse or an undecided increment is tried again: the loads may have changed.
            Order::Run(_) | Order::Step(_) if ended => {}
            Order::Run(true) => world.insert_resource(ClasticRunning::Always),
            Order::Run(false) => world.insert_resource(ClasticRunning::Paused),
            Order::Step(n) => {
                let left = if let ClasticRunning::Times(left) = running { left } else { 0 };
                world.insert_resource(ClasticRunning::Times(left + n));
            }
            Order::Pace(pace) => {
                let seconds = pace.map_or(0.0, |pace| 1.0 / pace);
                self.pause = Duration::try_from_secs_f64(seconds).unwrap_or_default();
            }
            Order::Load(load) => set_load(world, &load),
            Order::Keep => match capture(world) {
                Ok(state) => {
                    let increment = world.resource::<ClasticProgress>().increment;
                    self.answer = format!("kept the state of increment {increment}");
                    self.kept = Some((increment, state));
                }
                Err(error) => self.answer = error.to_string(),
            },
            Order::Restore | Order::Restart => {
                let kept = self.kept.as_ref().filter(|_| order == Order::Restore);
                let state = kept.map(|(_, state)| state).ok_or(()).or(self.start.as_ref());
                let back = state.map_err(Clone::clone).and_then(|state| rewind(world, state));
                forget_loads(world);
                world.insert_resource(ClasticRunning::Paused);
                let increment = world.resource::<ClasticProgress>().increment;
                self.answer = match back {
                    Ok(()) => format!("back at increment {increment}"),
                    Err(error) => error.to_string(),
                };
            }
        }
    }
}
