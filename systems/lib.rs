//! Scheduled systems of the clastic engine, one per file, in the order of an increment: control
//! walls and loads, gather bodies and check their values, make attempts, update the state, break
//! bonds, record. An attempt detects contacts, assembles the cone program, solves it, and judges
//! the solution. See [`schedule`].

pub mod announce;
pub mod assemble_program;
pub mod assign_identities;
pub mod attempt;
pub mod check_values;
pub mod contact_laws;
pub mod control_walls;
pub mod detect_contacts;
pub mod ending;
pub mod energy_ledger;
pub mod gather_bodies;
pub mod identities;
pub mod impacts;
pub mod kinetic_damping;
pub mod links;
pub mod load_stage;
pub mod material_names;
pub mod measures;
pub mod mechanism;
pub mod membranes;
pub mod motion_settings;
mod moved;
mod passing_walls;
mod places;
pub mod record;
#[cfg(all(test, feature = "reflect"))]
mod reflect;
pub mod rigid_groups;
pub mod rupture;
pub mod schedule;
pub mod solve_program;
pub mod solved;
pub mod state;
pub mod stepping;
pub mod tractions;
pub mod travel;
pub mod turns;
pub mod update_state;
pub mod wall_states;
