//! How far a solution turns contacts: the measure of whether its constant normals are valid.
//!
//! A program holds normals constant: those of the start, or in a [pass](crate::ending) those of the
//! guessed end. An error arises where the normal of a bond, or of a contact that carries load,
//! turns away from them. Only the relative motion of neighbours turns it: size and shape of a
//! specimen that moves, bends or strains as a whole do not count. With x the vector between the two
//! centres and t the tangent of their contact in the program, it turns by
//!
//! ```text
//! |t . (x + u_b - u_a)| / |x|                          rad
//! ```
//!
//! At a wall the normal turns with the wall, and at an arc or an end of a wall with x to the centre of
//! the circle.

use clastic_components::prelude::*;
use clastic_cone::program::{ConeSolution, Interaction};
use glam::DVec2;

use crate::solved::Solved;

/// Minimum force of a contact that carries load, over the maximum force.
const LOADED: f64 = 1e-3;

/// Which interactions carry load, in the order of the program. Moments do not count: a turn of the
/// contact does not change their axis.
pub fn carrying(solution: &ConeSolution) -> Vec<bool> {
    let maximum = solution.forces.iter().map(size).fold(0.0, f64::max);
    solution.forces.iter().map(|f| size(f) > LOADED * maximum).collect()
}

fn size(f: &[f64; 3]) -> f64 {
    f[0].hypot(f[1])
}

/// Turn, rad, beyond which a solution moves grains without support. It is never accepted, and its
/// grains would cross thousands of others.
const UNSUPPORTED: f64 = 5.0;

/// The grain with the maximum turn, and this turn, rad: in the increment, or with `is_followed` from
/// the normals of the program.
pub fn furthest(solved: Solved, is_followed: bool) -> Option<(usize, f64)> {
    // The slip of a rigid bond is along the normal of the start, from which its turn counts.
    let has_no_memory = |c: &Interaction| c.tangential_compliance > 0.0 || !c.limits.has_shear();
    let normal = |k: usize| match &solved.program.interactions[k] {
        c if is_followed && has_no_memory(c) => c.normal,
        _ => solved.contacts.0[k].normal,
    };
    let turns = of_grains(solved, &of_pairs(solved, normal));
    turns.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The grain of [`furthest`], if its turn exceeds [`Acceptance::turn`], and this turn, rad. After
/// passes the turn counts from their normals, except for rigid bonds.
pub fn too_far(
    solved: Solved,
    acceptance: &Acceptance,
    passes: &Corrections,
) -> Option<(usize, f64)> {
    furthest(solved, passes.idle_motion.is_some()).filter(|(_, turn)| !(*turn <= acceptance.turn))
}

/// The maximum turn of bonds and of contacts that carry load, from the normals of the program, rad.
/// Grains whose whole translation is imposed do not count.
pub(crate) fn of_loaded(solved: Solved) -> f64 {
    let Solved { bodies, program, .. } = solved;
    let pairs = of_pairs(solved, |k| program.interactions[k].normal);
    let of_free = (0..bodies.particles).filter(|i| !is_imposed(bodies, *i));
    of_free.filter_map(|i| pairs.loaded[i]).fold(0.0, f64::max)
}

/// The turn of a grain that is bonded. Bonds turn in proportion to the increment as far as the
/// specimen bends; where a contact turns, a grain jumps to other support.
pub(crate) fn of_bonded(bodies: &BodyTable, (grain, turn): (usize, f64)) -> Option<f64> {
    let is_bonded = bodies.bonds.iter().any(|bond| [bond.a, bond.b].contains(&(grain as u32)));
    is_bonded.then_some(turn)
}

/// Whether a solution moves grains so far that they lack support.
pub(crate) fn is_unsupported(solved: Solved) -> bool {
    solved.solution.displacements.len() == solved.bodies.rows_in_program()
        && furthest(solved, false).is_some_and(|(_, turn)| turn > UNSUPPORTED)
}

/// By grain, the maximum turn in the increment of its bonds and of its contacts that carry load, rad.
/// A grain without any has the minimum turn of its pairs, since it may lie on any of them. A grain
/// without pairs, or whose whole translation is imposed, has none. A member of a rigid group turns by
/// at least as much as the group.
pub fn turns(solved: Solved) -> Vec<f64> {
    of_grains(solved, &of_pairs(solved, |k| solved.contacts.0[k].normal))
}

fn of_grains(Solved { bodies, solution, .. }: Solved, pairs: &PairTurns) -> Vec<f64> {
    let PairTurns { loaded, nearest } = pairs;
    let of_grain = |i: usize| {
        if is_imposed(bodies, i) {
            return 0.0;
        }
        let of_group = bodies
            .group(i)
            .map_or(0.0, |group| solution.displacements[group.body as usize][2].abs());
        let of_pairs = loaded[i].unwrap_or(nearest[i]);
        of_group.max(if of_pairs.is_finite() { of_pairs } else { 0.0 })
    };
    (0..bodies.particles).map(of_grain).collect()
}

/// Whether the whole motion of the centre of a grain is imposed, alone or with its rigid group.
pub(crate) fn is_imposed(bodies: &BodyTable, i: usize) -> bool {
    let imposes = |d: &BodyDrive| *d != BodyDrive::Free;
    match bodies.group(i) {
        Some(group) => group.drives.iter().all(imposes),
        None => bodies.drives[i][..2].iter().all(imposes),
    }
}

/// Turns by grain, rad.
pub(crate) struct PairTurns {
    /// Maximum of its bonds and of its contacts that carry load, if it has any.
    pub loaded: Vec<Option<f64>>,
    /// Minimum of all its pairs; infinite without any.
    pub nearest: Vec<f64>,
}

/// Turns of the pairs of each grain from the given normals.
pub(crate) fn of_pairs(solved: Solved, normal: impl Fn(usize) -> DVec2) -> PairTurns {
    let n = solved.bodies.particles;
    let carrying = carrying(solved.solution);
    let mut loaded = vec![None::<f64>; n];
    let mut nearest = vec![f64::INFINITY; n];
    for (k, contact) in solved.contacts.0.iter().enumerate() {
        let turn = turn(solved, contact, normal(k));
        let carries = contact.bond.is_some() || carrying.get(k).is_some_and(|carries| *carries);
        for i in [contact.a as usize, contact.b as usize].into_iter().filter(|i| *i < n) {
            if carries {
                loaded[i] = Some(loaded[i].map_or(turn, |other| other.max(turn)));
            }
            nearest[i] = nearest[i].min(turn);
        }
    }
    PairTurns { loaded, nearest }
}

/// Vector from a particle to the centre of the circle of the wall that it touches, m; `None` where
/// the wall is straight.
pub(crate) fn centre_of_curve(bodies: &BodyTable, contact: &Contact) -> Option<DVec2> {
    let wall = bodies.wall(contact.b).filter(|wall| !wall.is_line())?;
    let to_wall = bodies.positions[contact.b as usize] - bodies.positions[contact.a as usize];
    match wall.nearest(to_wall, DVec2::ZERO).curve {
        Curve::Round(centre) | Curve::Hollow(centre) => Some(to_wall + centre),
        Curve::Flat => None,
    }
}

/// Angle by which a solution turns the normal of a contact away from `normal`, to first order, rad.
fn turn(Solved { bodies, program, solution, .. }: Solved, contact: &Contact, normal: DVec2) -> f64 {
    let u = &solution.displacements;
    let [a, b] = [contact.a as usize, contact.b as usize];
    let moved = |i: usize| {
        let u = program.bodies[i].to_global(u[i]);
        DVec2::new(u[0], u[1])
    };
    if b >= bodies.particles {
        let around = centre_of_curve(bodies, contact)
            .map_or(0.0, |arm| contact.normal.perp().dot(moved(b) - moved(a)).abs() / arm.length());
        return u[b][2].abs().max(around);
    }
    let way = bodies.way(a, b);
    let mut relative = moved(b) - moved(a);
    if let (Some(cell), Some(of_program)) = (&bodies.cell, &program.cell) {
        let row = of_program.body as usize;
        let image = bodies.shift(a, b) / cell.length();
        relative += of_program.shift(image, program.bodies[row].to_global(u[row]));
    }
    (normal.perp().dot(relative) / way.length() + normal.perp().dot(contact.normal)).abs()
}
