//! Maximum numbers in a scene.

/// Maximum magnitude of a number. Products of larger numbers could overflow.
pub(super) const MAX_NUMBER: f64 = 1e30;
/// Minimum magnitude of a number that must not be zero.
pub(super) const MIN_NUMBER: f64 = 1e-30;

/// Maximum number of particles in a specimen. Identities and run time set this limit;
/// [`memory`](super::memory) checks the memory of the machine.
pub const MAX_PARTICLES: u64 = 5_000_000;

/// Maximum memory of a scene on any machine, bytes: 5 million bonded disks take 50 GB.
pub const MAX_MEMORY: f64 = 100e9;
