//! Directions of contacts and their forces.

use std::f64::consts::PI;

use glam::DVec2;

use super::moment::Moment;

/// Number of sectors of a rose over half a turn.
pub const SECTORS: usize = 18;

/// Directions of the contacts that carry compression between two disks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fabric {
    /// Number of contacts.
    pub contacts: usize,
    /// Mean number of contacts of a disk, 2 N_c / N.
    pub coordination: f64,
    /// Anisotropy a and its direction in rad, of E(t) = (1 + a cos 2(t - t_a)) / 2 pi.
    pub contact: (f64, f64),
    /// Anisotropy a_n and its direction in rad, of f(t) = f_0 (1 + a_n cos 2(t - t_n)).
    pub force: (f64, f64),
}

/// Contacts of a moment: direction of the normal in rad and normal force in N.
fn contacts(moment: &Moment) -> impl Iterator<Item = (f64, f64)> {
    moment
        .pairs
        .iter()
        .filter(|pair| pair.normal_force > 0.0 && moment.row(pair.b).is_some())
        .map(|pair| (pair.normal.to_angle(), pair.normal_force))
}

/// Sector of a direction; directions have no sign.
#[must_use]
pub fn sector(angle: f64) -> usize {
    let share = angle.rem_euclid(PI) / PI;
    ((share * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// Number of contacts and sum of their normal forces by sector.
#[must_use]
pub fn roses(moment: &Moment) -> [(usize, f64); SECTORS] {
    let mut roses = [(0, 0.0); SECTORS];
    for (angle, force) in contacts(moment) {
        let (number, sum) = &mut roses[sector(angle)];
        (*number, *sum) = (*number + 1, *sum + force);
    }
    roses
}

impl Fabric {
    /// The fabric of a moment; `None` without contacts between disks.
    ///
    /// The anisotropy of contacts follows from F = mean of n (x) n by a = 2 (F_1 - F_2), that of
    /// forces from the means of the sectors by a_n = 2 |mean of f(t) exp(2 i t)| / f_0, where f_0
    /// is the mean over the sectors (Rothenburg and Bathurst 1989).
    #[must_use]
    pub fn of(moment: &Moment) -> Option<Self> {
        let double = |angle: f64| DVec2::from_angle(2.0 * angle);
        let (mut number, mut sum) = (0, DVec2::ZERO);
        for (angle, _) in contacts(moment) {
            number += 1;
            sum += double(angle);
        }
        if number == 0 {
            return None;
        }
        let half_turn = |v: DVec2| (0.5 * v.to_angle()).rem_euclid(PI);
        // n (x) n = (1 + double angle) / 2, so that F_1 - F_2 is the length of the mean.
        let contact = sum / number as f64;
        let (mut mean, mut first) = (0.0, DVec2::ZERO);
        for (sector, (number, sum)) in roses(moment).into_iter().enumerate() {
            if number > 0 {
                let middle = (sector as f64 + 0.5) * PI / SECTORS as f64;
                mean += sum / number as f64;
                first += sum / number as f64 * double(middle);
            }
        }
        let force = 2.0 * first / mean;
        let disks = moment.disks.len().max(1) as f64;
        Some(Self {
            contacts: number,
            coordination: 2.0 * number as f64 / disks,
            contact: (2.0 * contact.length(), half_turn(contact)),
            force: (force.length(), half_turn(force)),
        })
    }
}
