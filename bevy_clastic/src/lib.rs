//! Draws worlds of [clastic](https://github.com/clastic-rs/clastic) with Bevy.
//!
//! - [`FollowPlugin`]: `Transform`s of your sprites and meshes follow the grains.
//! - [`DrawPlugin`](draw::DrawPlugin): draws a [`Picture`](picture::Picture) of a world: disks,
//!   bonds, forces, broken bonds, walls, membranes. With [`WatchPlugin`](draw::WatchPlugin) it is
//!   the world of the same app.
//! - [`Engine`](engine::Engine): the engine on a thread of its own. Pictures come from it, orders
//!   go to it.
//! - [`LivePlugin`](window::LivePlugin): the window of the program, with camera, keys, curve and
//!   slider.

pub mod draw;
pub mod engine;
mod follow;
pub mod picture;
pub mod window;

pub use follow::FollowPlugin;
