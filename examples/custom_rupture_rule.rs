//! A rule of rupture of one's own: every bond breaks in increment 10 of the run, whatever force it
//! carries.
//!
//! The plugin of the engine's rule is left out of the group, and a system takes its place. The rule
//! sets the state of the bond and adds the rupture to the record, from which messages and events
//! follow.

use bevy_app::{App, PluginGroup};
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use clastic::systems::rupture::bonds::RuptureBondsPlugin;
use glam::DVec2;

const AGE: u64 = 10;

fn break_old_bonds(
    (contacts, bodies): (Res<ContactTable>, Res<BodyTable>),
    (progress, solution): (Res<ClasticProgress>, Res<ConeSolution>),
    mut bonds: Query<&mut BondState>,
    mut record: ResMut<Observation>,
) {
    if progress.increment < AGE {
        return;
    }
    for (contact, [p, q, tau]) in contacts.0.iter().zip(&solution.forces) {
        let Some(row) = contact.bond.map(|k| bodies.bonds[k as usize]) else { continue };
        let Ok(mut state) = bonds.get_mut(row.entity) else { continue };
        *state = BondState::Broken(RuptureMode::Tension);
        record.ruptures.push(Rupture {
            increment: progress.increment,
            bond: row.id,
            a: bodies.ids[row.a as usize],
            b: bodies.ids[row.b as usize],
            mode: RuptureMode::Tension,
            position: contact.point(&bodies),
            normal: contact.normal,
            p: *p,
            q: *q,
            tau: *tau,
        });
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default().build().disable::<RuptureBondsPlugin>());
    app.add_systems(Increment, break_old_bonds.in_set(IncrementSystems::Rupture));
    let bond = BondLaw { normal_compliance: 1.0e-7, tensile_strength: 1.0e6, ..Default::default() };
    let world = app.world_mut();
    let [a, b] = [(0.0, 0.0), (2.0, 1.0e-6)].map(|(x, pull)| {
        let place = BodyPosition(DVec2::new(x, 0.0));
        let drives = BodyDrives::imposed([pull, 0.0, 0.0]);
        world.spawn((Particle::disk(1.0, 2650.0, 1.0), place, drives)).id()
    });
    world.spawn(Bond::between(a, b, bond));

    for increment in 1..=12 {
        app.update();
        let record = app.world().resource::<Observation>();
        println!("increment {increment}: {:?} broken", record.broken);
        assert_eq!(record.broken[0], usize::from(increment >= AGE));
        assert_eq!(record.ruptures.len(), usize::from(increment == AGE));
    }
}
