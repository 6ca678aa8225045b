//! Second check of the mechanism that proves a collapse. It follows sections 2, 4 and 9 of
//! `docs/formulation.md` and shares no code with the engine's own check. It reads the cone program,
//! the mechanism and the positions of the bodies.

use std::collections::BTreeSet;

use clastic::components::body::{BodyId, BodyPosition};
use clastic::components::particle::Particle;
use clastic::components::wall::Wall;
use clastic::cone::program::{ConeProgram, Dof, Interaction};
use clastic::run::Simulation;
use glam::DVec2;

/// Threshold of the margin, relative to the work of the loads, and tolerance of a negative opening,
/// relative to the maximum motion (section 9).
const TOLERANCE: f64 = 1e-6;

/// Whether the mechanism proves that no forces within the limits balance the loads of the program.
pub fn check(program: &ConeProgram, mechanism: &[[f64; 3]]) -> Result<(), String> {
    let bodies = &program.bodies;
    if mechanism.len() != bodies.len() {
        return Err(format!("a mechanism of {} of {} bodies", mechanism.len(), bodies.len()));
    }
    if mechanism.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a mechanism that is not finite".to_owned());
    }
    let length = program.scales.length;
    let size = |u: &[f64; 3]| u[0].abs().max(u[1].abs()).max(length * u[2].abs());
    let motion = mechanism.iter().map(size).fold(0.0, f64::max);
    if motion == 0.0 {
        return Err("a mechanism without motion".to_owned());
    }
    let mut work = 0.0;
    for (i, (body, u)) in bodies.iter().zip(mechanism).enumerate() {
        for (dof, u) in body.dofs.iter().zip(u) {
            match dof {
                Dof::Fixed(_) if *u != 0.0 => {
                    return Err(format!("body {i} moves where its motion is imposed"));
                }
                Dof::Free(free) if free.inertia != 0.0 && *u != 0.0 => {
                    return Err(format!("body {i} moves where it has inertia"));
                }
                Dof::Free(free) => work += free.load * u,
                Dof::Fixed(_) => {}
            }
        }
    }
    let mut dissipation = 0.0;
    for c in &program.interactions {
        let [closing, slip, roll] = kinematics(program, c, mechanism);
        let l = &c.limits;
        // A contact without a shear force slips freely; one without a rolling moment rolls freely.
        let slip = if l.cohesion > 0.0 || l.friction > 0.0 { slip.abs() } else { 0.0 };
        let roll = if l.rolling > 0.0 { roll.abs() } else { 0.0 };
        let opening = -closing - l.friction * slip - l.rolling * roll;
        if opening < -TOLERANCE * motion {
            return Err(format!(
                "bodies {} and {} close by {:.1e} of the maximum motion",
                c.a,
                c.b,
                -opening / motion
            ));
        }
        let apex = if l.friction > 0.0 { l.cohesion / l.friction } else { f64::INFINITY };
        dissipation += l.cohesion * slip + l.moment * roll + l.tension.min(apex) * opening.max(0.0);
    }
    if !(work > 0.0 && work - dissipation > TOLERANCE * work) {
        return Err(format!("the loads do {work:e} J, the limits dissipate {dissipation:e} J"));
    }
    Ok(())
}

/// Closing, slip and relative rotation (section 2).
fn kinematics(program: &ConeProgram, c: &Interaction, u: &[[f64; 3]]) -> [f64; 3] {
    let (ua, ub) = (global(program, c.a, u), global(program, c.b, u));
    let (n, t) = (c.normal, DVec2::new(-c.normal.y, c.normal.x));
    let (turn_a, turn_b) = (u[c.a as usize][2], u[c.b as usize][2]);
    let d = ua - ub;
    [
        n.x * d.x + n.y * d.y + c.normal_arm_a * turn_a + c.normal_arm_b * turn_b,
        t.x * d.x + t.y * d.y + c.arm_a * turn_a + c.arm_b * turn_b,
        turn_a - turn_b,
    ]
}

/// Translation of a body in the axes of the scene.
fn global(program: &ConeProgram, body: u32, u: &[[f64; 3]]) -> DVec2 {
    let (axis, u) = (program.bodies[body as usize].axis, u[body as usize]);
    DVec2::new(axis.x * u[0] - axis.y * u[1], axis.y * u[0] + axis.x * u[1])
}

/// Checks that the mechanism presses no two bodies into each other that have no interaction in the
/// program. The mechanism is scaled so that its maximum motion is `reach` (m).
pub fn check_absent_pairs(
    simulation: &mut Simulation,
    mechanism: &[[f64; 3]],
    reach: f64,
) -> Result<(), String> {
    let world = simulation.world_mut();
    let mut query = world.query::<(&BodyId, &Particle, &BodyPosition)>();
    let mut disks: Vec<(u32, f64, DVec2)> =
        query.iter(world).map(|(id, p, x)| (id.0, p.radius, x.0)).collect();
    disks.sort_by_key(|disk| disk.0);
    let mut query = world.query::<(&BodyId, &Wall, &BodyPosition)>();
    let mut walls: Vec<(u32, DVec2, DVec2)> =
        query.iter(world).map(|(id, wall, x)| (id.0, wall.inward(), x.0)).collect();
    walls.sort_by_key(|wall| wall.0);
    // The program has one row per body, disks before walls; identities have gaps where a wall has
    // gone.
    for (row, id) in
        disks.iter_mut().map(|d| &mut d.0).chain(walls.iter_mut().map(|w| &mut w.0)).enumerate()
    {
        *id = row as u32;
    }
    let program = world.resource::<ConeProgram>();
    let present: BTreeSet<(u32, u32)> =
        program.interactions.iter().map(|c| (c.a.min(c.b), c.a.max(c.b))).collect();
    let length = program.scales.length;
    let size = |u: &[f64; 3]| u[0].abs().max(u[1].abs()).max(length * u[2].abs());
    let factor = reach / mechanism.iter().map(size).fold(0.0, f64::max);
    let way = |body: u32| factor * global(program, body, mechanism);
    let touches = 1e-6 * length;
    for (k, (a, radius_a, x_a)) in disks.iter().enumerate() {
        for (b, radius_b, x_b) in &disks[k + 1..] {
            let (between, sum) = (*x_b - *x_a, radius_a + radius_b);
            // Further apart than any motion can bring together.
            if between.length_squared() > (sum + 3.0 * reach).powi(2) || present.contains(&(*a, *b))
            {
                continue;
            }
            let after = (between + way(*b) - way(*a)).length() - sum;
            if after < -touches && after < between.length() - sum - touches {
                return Err(format!("disks {a} and {b} would overlap by {:e} m", -after));
            }
        }
        for (wall, inward, x_w) in &walls {
            if present.contains(&(*a, *wall)) {
                continue;
            }
            let gap = inward.dot(*x_a - *x_w) - radius_a;
            let after = gap + inward.dot(way(*a) - way(*wall));
            if after < -touches && after < gap - touches {
                return Err(format!("disk {a} and wall {wall} would overlap by {:e} m", -after));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clastic::cone::program::{FreeDof, Limits, ProgramBody, Scales};

    /// A disk on a plane under a vertical load, with a bond of the given tensile strength.
    fn lifted(load: f64, tension: f64) -> ConeProgram {
        let free = |load| Dof::Free(FreeDof { load, ..FreeDof::default() });
        let fixed = Dof::Fixed(0.0);
        let disk = ProgramBody { axis: DVec2::X, dofs: [free(0.0), free(load), free(0.0)] };
        let wall = ProgramBody { axis: DVec2::X, dofs: [fixed; 3] };
        let contact = Interaction {
            normal: DVec2::NEG_Y,
            arm_a: 0.01,
            limits: Limits { friction: 0.5, tension, ..Limits::default() },
            ..Interaction::between(0, 1)
        };
        ConeProgram {
            bodies: vec![disk, wall],
            interactions: vec![contact],
            scales: Scales { length: 0.01, displacement: 1e-6, force: 1.0 },
            ..ConeProgram::default()
        }
    }

    #[test]
    fn a_lift_proves_that_nothing_holds_a_disk() {
        let up = [[0.0, 1.0, 0.0], [0.0; 3]];
        assert_eq!(check(&lifted(1.0, 0.0), &up), Ok(()));
        assert!(check(&lifted(-1.0, 0.0), &up).is_err(), "against the load");
        assert!(check(&lifted(1.0, 0.0), &[[0.0, -1.0, 0.0], [0.0; 3]]).is_err(), "into the wall");
        assert!(
            check(&lifted(1.0, 0.0), &[[0.0, 1.0, 0.0], [0.0, 0.5, 0.0]]).is_err(),
            "a held wall"
        );
        assert!(
            check(&lifted(1.0, 0.0), &[[1.0, 0.1, 0.0], [0.0; 3]]).is_err(),
            "less than mu times slip"
        );
    }

    #[test]
    fn a_bond_that_is_strong_enough_holds_a_disk() {
        let up = [[0.0, 1.0, 0.0], [0.0; 3]];
        let bonded = |strength| {
            let mut program = lifted(1.0, strength);
            program.interactions[0].limits.cohesion = 10.0;
            program
        };
        assert_eq!(check(&bonded(0.9), &up), Ok(()));
        assert!(check(&bonded(1.1), &up).is_err());
    }
}
