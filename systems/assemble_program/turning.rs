//! Contacts with walls that turn in the increment: arms of the forces about the wall's position,
//! and offsets with which the gap at the end is exact for a disk that stays.
//!
//! A wall turns about a point by a finite angle, and its program has the rotation to first order.
//! At a distance L from the wall's position the two differ by `L alpha^2/2`. The difference is
//! known and goes into the offset, so that a disk in front of a wall does not overlap with it after
//! the rotation. The rotation of a wall in a rigid group is an unknown of the program: its contacts
//! have arms alone, and [`groups`](super::groups) moves them to the group.

use glam::DVec2;

use clastic_components::contact::{BodyTable, Contact, WallRow};
use clastic_components::wall::WallDrive;
use clastic_cone::program::Interaction;

use super::Trial;

/// A wall that turns in a trial, the displacement of its position, m, and its rotation, rad.
type Turning<'a> = (&'a WallRow, DVec2, f64);

/// Gives the contacts of walls that turn in this fraction of the increment their arms and offsets.
/// Other interactions stay as they are.
pub(super) fn carry(trial: &Trial, interactions: &mut [Interaction]) {
    let Trial { bodies, contacts, progress, corrections, .. } = trial;
    let turning: Vec<Turning> = bodies
        .walls
        .iter()
        .filter_map(|wall| {
            let WallDrive::Turning { about, angle } = bodies.wall_drive(wall) else { return None };
            let angle = progress.fraction * angle;
            Some((wall, bodies.swing(wall, about, angle), angle))
        })
        .collect();
    if turning.is_empty() && bodies.groups.is_empty() {
        return;
    }
    for (contact, c) in contacts.0.iter().zip(interactions) {
        let b = contact.b as usize;
        let lever = contact.point(bodies) - bodies.positions[b];
        if b >= bodies.particles && bodies.group(b).is_some() {
            *c = c.carried_by(false, contact.b, lever);
            continue;
        }
        let Ok(k) = turning.binary_search_by_key(&contact.b, |(wall, ..)| wall.body) else {
            continue;
        };
        *c = c.carried_by(false, contact.b, lever);
        // A pass has the exact gap already.
        if corrections.of((contact.a, contact.b)).is_none() {
            c.offset += beyond_first_order(bodies, contact, lever, turning[k]).unwrap_or(0.0);
        }
    }
}

/// Gap at the end of the trial between the turned wall and a disk that stays, less the gap to first
/// order, m. `None` where the wall passes over its centre.
fn beyond_first_order(
    bodies: &BodyTable,
    contact: &Contact,
    lever: DVec2,
    (wall, u, angle): Turning,
) -> Option<f64> {
    let a = contact.a as usize;
    let start = bodies.positions[a] - bodies.positions[contact.b as usize];
    let finish = start - u;
    let back = DVec2::from_angle(-angle).rotate(finish);
    if wall.shape.is_crossed(wall.inward, wall.half_length, [start, back]) {
        return None;
    }
    let near = wall.turned(angle).nearest(DVec2::ZERO, finish);
    let linear = contact.gap + contact.normal.dot(u + angle * lever.perp());
    Some(near.distance - bodies.radii[a] - linear)
}
