//! Rupture of bonds: which bonds break, when, and with how many others.

pub mod bonds;
pub mod brittleness;
pub mod dense;
pub mod density;
pub mod event_search;
pub mod events;
