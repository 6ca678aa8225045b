//! The `clastic` program: commands, exit codes, files of a run.

#[path = "../common/mod.rs"]
mod common;

mod bad_scenes;
mod call;
mod commands;
mod dumps;
mod emission;
mod exit_codes;
mod export;
mod files;
mod measures;
mod new;
mod practice;
mod report;
mod results;
mod rigs;
mod several_runs;
mod states;
mod stopped;
mod sweep;
