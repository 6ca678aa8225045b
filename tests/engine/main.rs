//! The engine: analytic values, conservation laws, events, motions, and its use by other programs.
//! Each module is a subject; `cargo test --release --test engine restitution` runs one of them.

#[path = "../common/mod.rs"]
mod common;

mod accuracy;
mod analytic_bonds;
mod analytic_dynamics;
mod analytic_lattice;
mod avalanches;
mod biaxial;
mod cell_energy;
mod changed_stress;
mod column_collapse;
mod coming_and_going;
mod conservation;
mod curved_walls;
mod detection;
mod elastic_rolling;
mod embedding;
mod events;
mod extension;
mod followed_motion;
mod groups;
mod held_bodies;
mod hinged_walls;
mod hopper;
mod invariance;
mod landing;
mod language;
mod lids;
mod limit_load;
mod loose_grains;
mod measures;
mod measures_of_ten;
mod membrane_stress;
mod membranes;
mod near_rest;
mod periodic_cell;
mod pour;
mod radius_expansion;
mod recipes;
mod removal;
mod restitution;
mod rigid_groups;
mod rigs;
mod rupture;
mod shear_boxes;
mod sleeping;
mod specimens;
mod stages;
mod stopping;
mod stress;
mod swinging;
mod thin_walls;
mod turning_walls;
mod without_a_stage;
