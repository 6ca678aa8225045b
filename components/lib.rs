//! Components and plain data of the clastic engine.
//!
//! Behaviour is limited to arithmetic on one value or table: laws of mixed contacts, load ramps,
//! relabelling of rows, sums of loads. Systems and component hooks are in `clastic_systems`.
//!
//! Conventions that hold everywhere: SI units and `f64`; a plane problem of stated thickness;
//! anticlockwise rotation and compressive force positive.

pub mod analysis;
pub mod attempt;
pub mod body;
pub mod bond;
pub mod cell;
pub mod collision;
pub mod contact;
pub mod contact_history;
pub mod domain;
pub mod energy;
pub mod findings;
pub mod increment;
pub mod link;
pub mod loads;
pub mod material;
pub mod measure;
pub mod membrane;
pub mod motion;
pub mod observation;
pub mod particle;
pub mod poured;
pub mod prelude;
pub mod progress;
pub mod rigid_group;
pub mod rows;
pub mod wall;
pub mod wall_shape;
