//! A moment from a frame.

use clastic_components::bond::RuptureMode;
use glam::DVec2;

use super::{Disk, Link, Moment, Pair, Piece};
use crate::frames::{Frame, NONE};

impl Moment {
    /// The moment of a frame.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Self {
        Self {
            increment: frame.increment,
            stage: frame.stage.clone(),
            time: frame.time_s,
            strain: frame.axial_strain,
            materials: frame.materials.clone(),
            cell: frame.cell_m,
            disks: (0..frame.bodies.id.len()).map(|row| disk(frame, row)).collect(),
            walls: (0..frame.walls.id.len()).flat_map(|row| pieces(frame, row)).collect(),
            pairs: (0..frame.pairs.a.len()).filter_map(|row| pair(frame, row)).collect(),
            bonds: bonds(frame),
            membranes: links(frame),
        }
    }
}

fn vector([x, y]: [f32; 2]) -> DVec2 {
    DVec2::new(x.into(), y.into())
}

fn disk(frame: &Frame, row: usize) -> Disk {
    let bodies = &frame.bodies;
    Disk {
        id: bodies.id[row],
        position: frame.centre(row).into(),
        radius: bodies.radius_m[row].into(),
        displacement: vector(bodies.displacement_m[row]),
        rotation: bodies.rotation_rad[row].into(),
        velocity: vector(bodies.velocity_m_s[row]),
        spin: bodies.angular_velocity_rad_s[row].into(),
        material: bodies.material[row],
        stress: bodies.stress_pa[row].map(f64::from),
        fragment: bodies.fragment[row],
    }
}

fn pieces(frame: &Frame, row: usize) -> Vec<Piece> {
    let walls = &frame.walls;
    let points = walls.first_point[row] as usize..walls.first_point[row + 1] as usize;
    let piece = |ends: &[[f64; 2]]| Piece {
        id: walls.id[row],
        name: walls.name[row].clone(),
        ends: [ends[0].into(), ends[1].into()],
        is_line: !walls.is_thin[row],
        force: walls.force[row],
    };
    walls.point_m[points].windows(2).map(piece).collect()
}

/// The links of the chains of membranes.
fn links(frame: &Frame) -> Vec<[DVec2; 2]> {
    let chains = &frame.membranes;
    let of_chain = |chain: usize| {
        let points: Vec<DVec2> =
            chains.point_m[chains.points(chain)].iter().map(|x| DVec2::from(*x)).collect();
        let back = points.first().filter(|_| chains.is_closed[chain]).copied();
        let next = points.iter().skip(1).copied().chain(back).collect::<Vec<_>>();
        points.into_iter().zip(next).map(|(a, b)| [a, b]).collect::<Vec<_>>()
    };
    (0..chains.name.len()).flat_map(of_chain).collect()
}

/// The pair in a row; `None` if it carries no force.
fn pair(frame: &Frame, row: usize) -> Option<Pair> {
    let pairs = &frame.pairs;
    let [p, q, tau] = [pairs.p_n[row], pairs.q_n[row], pairs.tau_nm[row]].map(f64::from);
    let intact = pairs.state[row] == 1;
    (p != 0.0 || q != 0.0 || tau != 0.0).then(|| Pair {
        a: pairs.a[row],
        b: pairs.b[row],
        normal_force: p,
        shear_force: q,
        moment: tau,
        normal: DVec2::from_angle(pairs.angle_rad[row].into()),
        gap: pairs.gap_m[row].into(),
        bond: Some(pairs.bond[row]).filter(|bond| intact && *bond != NONE),
    })
}

fn bonds(frame: &Frame) -> Vec<Link> {
    let pairs = &frame.pairs;
    let rows = (0..pairs.a.len()).filter(|row| pairs.bond[*row] != NONE);
    let link = |row: usize| Link {
        id: pairs.bond[row],
        a: pairs.a[row],
        b: pairs.b[row],
        broken: mode(pairs.state[row]),
    };
    let mut bonds: Vec<Link> = rows.map(link).collect();
    bonds.sort_unstable_by_key(|bond| bond.id);
    bonds
}

/// Mode of a broken bond, from the code of its pair.
fn mode(state: u8) -> Option<RuptureMode> {
    match state {
        2 => Some(RuptureMode::Tension),
        3 => Some(RuptureMode::Shear),
        4 => Some(RuptureMode::Rolling),
        _ => None,
    }
}
