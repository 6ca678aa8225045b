//! Scheduled systems of the clastic engine.
pub mod detect_contacts;
