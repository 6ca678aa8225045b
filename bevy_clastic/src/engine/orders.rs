//! Orders to the engine.

use crate::picture::Load;

/// What is to be done between two increments.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Make increments, or wait.
    Run(bool),
    /// Make this number of increments, after those that are left of an order before, then wait.
    Step(u32),
    /// Make at most this number of increments in a second; `None` makes as many as there is time
    /// for.
    Pace(Option<f64>),
    /// Give a load of the pictures another value.
    Load(Load),
    /// Keep the present state.
    Keep,
    /// Go back to the state that was kept, or to the start where none was.
    Restore,
    /// Go back to the start.
    Restart,
}
