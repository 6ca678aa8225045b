//! Control of the periodic cell by stages, and its end.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use crate::scene::format as scene;

/// The cell of a scene where a run begins.
pub(crate) fn at_start(cell: &scene::Cell) -> PeriodicCell {
    PeriodicCell {
        width: cell.size.0,
        height: cell.size.1,
        tilt: 0.0,
        shear: 0.0,
        stress: [0.0; 3],
        controls: [CellControl::default(); 3],
        by_mean: false,
    }
}

/// Sets the controls of the cell for a loading stage.
pub fn control(world: &mut World, stage: &scene::Load) {
    let Some(mut cell) = world.get_resource_mut::<PeriodicCell>() else { return };
    let control = stage.cell.as_deref().copied().unwrap_or_default();
    let n = f64::from(stage.increments);
    let by_mean =
        control.is_by_mean() || (cell.by_mean && control.xx.is_none() && control.yy.is_none());
    if by_mean != cell.by_mean {
        // Earlier controls of the two sides end.
        cell.controls[..2].fill(CellControl::default());
        cell.by_mean = by_mean;
    }
    let length = cell.length();
    let stress = cell.controlled_stress(by_mean);
    let (first, second, lengths) = if by_mean {
        (control.mean, control.difference, [-length, -length, cell.height])
    } else {
        (control.xx, control.yy, [-cell.width, -cell.height, cell.height])
    };
    for (k, target) in [first, second, control.shear].into_iter().enumerate() {
        let (from, holds) = match cell.controls[k] {
            CellControl::Stress { to, .. } => (to, true),
            CellControl::Imposed(_) => (stress[k], false),
        };
        cell.controls[k] = match target {
            None if holds => CellControl::Stress { from, to: from },
            None | Some(scene::CellTarget::Fixed) => CellControl::Imposed(0.0),
            Some(scene::CellTarget::Strain(strain)) => {
                CellControl::Imposed(strain * lengths[k] / n)
            }
            Some(scene::CellTarget::Stress(to)) => CellControl::Stress { from, to },
        };
    }
}

/// Leaves stresses at the values that they have reached.
pub fn end(world: &mut World) {
    let progress = world.resource::<ClasticProgress>().clone();
    let Some(mut cell) = world.get_resource_mut::<PeriodicCell>() else { return };
    for control in &mut cell.controls {
        if let CellControl::Stress { from, to } = control {
            *to = progress.ramp(*from, *to).from;
        }
    }
}

/// Shrinks the cell in equal steps, without change of its shape, until the disks of this area have
/// a porosity. Returns the number of steps.
pub fn compact(world: &mut World, disks: f64, porosity: f64, step: f64) -> Option<f64> {
    let mut cell = world.get_resource_mut::<PeriodicCell>()?;
    let part = 1.0 - (disks / ((1.0 - porosity) * cell.area())).sqrt();
    cell.by_mean = false;
    let (width, height, tilt) = (cell.width, cell.height, cell.tilt);
    if part <= 0.0 {
        cell.controls = [CellControl::default(); 3];
        return None;
    }
    let steps = (part * width.max(height).max(tilt.abs()) / step).ceil().max(1.0);
    let by = [-part * width / steps, -part * height / steps, 0.0];
    cell.controls = by.map(CellControl::Imposed);
    Some(steps)
}

/// Ends the cell: particles are put back into it, and contacts and bonds across its sides go.
pub fn open(world: &mut World) {
    let Some(cell) = world.remove_resource::<PeriodicCell>() else { return };
    let (mut places, mut shifts) = (BTreeMap::new(), BTreeMap::new());
    let mut particles =
        world.query_filtered::<(&BodyId, &mut BodyPosition, &mut BodyOrigin), With<Particle>>();
    for (id, mut place, mut origin) in particles.iter_mut(world) {
        // The displacement since the start stays.
        let by = cell.wrapped(place.0) - place.0;
        place.0 += by;
        origin.0 += by;
        places.insert(*id, place.0);
        shifts.insert(*id, by);
    }
    // Strains of regions refer to these places.
    if let Some(mut start) = world.get_resource_mut::<StrainReference>() {
        for (id, place) in &mut start.0 {
            *place += shifts.get(id).copied().unwrap_or_default();
        }
    }
    let mut bonds = world.query::<(Entity, &Bond)>();
    let crosses = |a: BodyId, b: BodyId| {
        let apart = places.get(&b).zip(places.get(&a)).map(|(b, a)| *b - *a);
        apart.is_some_and(|apart| cell.shift(apart) != DVec2::ZERO)
    };
    let across = bonds.iter(world).filter(|(_, bond)| crosses(bond.a, bond.b));
    let across: Vec<_> = across.map(|(entity, _)| entity).collect();
    for bond in across {
        world.despawn(bond);
    }
    let ids = world.resource::<KeptRows>().ids.clone();
    let mut history = world.resource_mut::<ContactHistory>();
    history.0.retain(|m| !crosses(ids[m.a as usize], ids[m.b as usize]));
}

/// The cell stands still, without stress.
pub fn hold(world: &mut World) {
    if let Some(mut cell) = world.get_resource_mut::<PeriodicCell>() {
        cell.controls = [CellControl::default(); 3];
        cell.by_mean = false;
        cell.stress = [0.0; 3];
    }
}
