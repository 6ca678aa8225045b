//! Whether a scene fits into the memory of this machine.

use crate::scene::LoadedScene;
use crate::scene::memory::{Need, size};
use sysinfo::{MemoryRefreshKind, System};

use super::exit::{Exit, Failure};

/// Refuses a scene that needs more than the free memory.
///
/// # Errors
/// With the estimate and the free memory.
pub fn fits(loaded: &LoadedScene) -> Result<(), Failure> {
    let need = Need::of(&loaded.scene, loaded.specimen.as_ref());
    let Some(free) = free().filter(|free| need.bytes > *free) else { return Ok(()) };
    let message = format!(
        "{}: specimen: {} particles with about {:.1e} contacts and bonds take about {} of memory, \
         and {} are free; take a smaller specimen or free some memory",
        loaded.path.display(),
        need.particles,
        need.pairs,
        size(need.bytes),
        size(free),
    );
    Err(Failure::new(Exit::Scene, message))
}

/// Memory that this process can still allocate, bytes; `None` if the system does not tell.
fn free() -> Option<f64> {
    let mut system = System::new();
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    let machine = system.available_memory();
    let group = system.cgroup_limits().map(|limits| limits.free_memory);
    let free = group.map_or(machine, |group| group.min(machine));
    (free > 0).then_some(free as f64)
}
