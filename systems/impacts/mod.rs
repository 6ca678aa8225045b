//! Impacts of rigid bodies in time steps: what hits what, how it rebounds, and where it goes.

pub mod hits;
pub mod paths;
pub mod push_out;
pub mod reached;
pub mod rebounds;
