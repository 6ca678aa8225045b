//! A stage of loads in a program without a scene.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

/// Begins a stage of this number of increments. Loads on particles and rigid groups, forces and
/// stresses of walls, pressures of membranes and stresses of a periodic cell start from the values
/// that they have reached. Set their new targets, and spawn loaded bodies, after this call: loads
/// go to their targets over the stage, linearly unless you give [`ClasticProgress::course`], and stay
/// where they are when it is over. A load that was
/// spawned before the first stage is at its target already. Tables of walls begin anew.
pub fn begin_stage(world: &mut World, increments: u32) {
    let progress = world.resource::<ClasticProgress>().clone();
    let begin = |from: &mut f64, to: f64| *from = progress.ramp(*from, to).from;
    for mut control in world.query::<&mut LoadControl>().iter_mut(world) {
        for (from, to) in &mut control.0 {
            begin(from, *to);
        }
    }
    for mut control in world.query::<&mut WallControl>().iter_mut(world) {
        if let WallControl::Force { from, to } | WallControl::Stress { from, to, .. } =
            &mut *control
        {
            begin(from, *to);
        }
    }
    for mut membrane in world.query::<&mut Membrane>().iter_mut(world) {
        let (from, to) = &mut membrane.pressure;
        begin(from, *to);
    }
    if let Some(mut cell) = world.get_resource_mut::<PeriodicCell>() {
        for control in cell.controls.iter_mut() {
            if let CellControl::Stress { from, to } = control {
                begin(from, *to);
            }
        }
    }
    let mut progress = world.resource_mut::<ClasticProgress>();
    (progress.done, progress.total) = (0.0, f64::from(increments));
    progress.course.clear();
}
