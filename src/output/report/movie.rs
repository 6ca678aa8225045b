//! The frames of a run as the page has them.
//!
//! Bodies and bonds have one row each over the whole run, contacts without a bond in their frame
//! alone. A frame is read without others.

use glam::DVec2;
use serde_json::{Value, json};

use super::choose::File;
use super::columns::Columns;
use super::distinct;
use super::scales::{Scales, mean, shear, view};
use crate::frames::{Frame, FramePairs, NONE, STATES, strains};
use crate::output::OutputError;
use crate::output::corners::joined;

/// State of a bond that is not in a frame.
const NO_BOND: u32 = 255;

/// Maximum shear strains of the particles of a frame since the start of the test, and since the
/// frame before. Not a number where there is none.
pub type Strains = [Vec<f32>; 2];

/// Frames in a page.
pub(crate) struct Movie {
    /// Names of the columns, scales, times.
    pub description: Value,
    /// Columns that do not change, then those of every frame.
    pub blocks: Vec<String>,
}

/// Rows of a page, from all frames.
struct Rows {
    bodies: Vec<u32>,
    walls: Vec<u32>,
    /// Bodies and bond.
    bonds: Vec<(u32, u32, u32)>,
}

impl Movie {
    /// Reads frames; `None` if there are none.
    pub fn read(files: &[File]) -> Result<Option<Self>, OutputError> {
        let frames = files.iter().map(|file| Frame::read(&file.path)).collect::<Result<_, _>>()?;
        let start = files.iter().position(|file| file.is_start).unwrap_or(0);
        Ok(Self::of(frames, start))
    }

    /// The frames of a run in the order of increments; the test starts at the one with the index
    /// `start`.
    pub fn of(mut frames: Vec<Frame>, start: usize) -> Option<Self> {
        since(&mut frames, start);
        let frames = frames.as_slice();
        let first = frames.first()?;
        let rows = Rows::of(frames);
        let strains: Vec<Strains> = (0..frames.len())
            .map(|k| [Some(start), k.checked_sub(1)].map(|from| shears(frames, k, from)))
            .collect();
        let scales = Scales::of(frames, &strains, start);
        let mut still = Columns::default();
        rows.still(frames, first.origin_m, &mut still);
        let mut blocks = vec![still.text()];
        let mut described = Vec::new();
        for (frame, strains) in frames.iter().zip(&strains) {
            let mut columns = Columns::default();
            rows.frame(frame, strains, &scales, &mut columns);
            blocks.push(columns.text());
            described.push(json!({
                "increment": frame.increment,
                "stage": frame.stage,
                "time": frame.time_s,
                "strain": frame.axial_strain,
                "stress": frame.axial_stress_pa,
                "contacts": contacts(&frame.pairs).count(),
                "walls": walls(frame, first.origin_m),
                "cell": frame.cell_m,
                "membranes": rows.chains(frame),
            }));
        }
        let description = json!({
            "bodies": rows.bodies.len(),
            "bonds": rows.bonds.len(),
            "walls": rows.walls,
            "origin": first.origin_m,
            "materials": first.materials,
            "groups": groups(frames),
            "ranges": scales.ranges,
            "view": view(&frames[start.min(frames.len() - 1)..], first.origin_m),
            "states": STATES,
            "start": start,
            "frames": described,
        });
        Some(Self { description, blocks })
    }
}

impl Rows {
    fn of(frames: &[Frame]) -> Self {
        let bonds = |FramePairs { a, b, bond, .. }: &FramePairs| -> Vec<_> {
            let rows = (0..a.len()).filter(|k| bond[*k] != NONE);
            rows.map(|k| (a[k], b[k], bond[k])).collect()
        };
        Self {
            bodies: distinct(frames.iter().flat_map(|frame| frame.bodies.id.clone())),
            walls: distinct(frames.iter().flat_map(|frame| frame.walls.id.clone())),
            bonds: distinct(frames.iter().flat_map(|frame| bonds(&frame.pairs))),
        }
    }

    /// Index of a body in the page: particles, then walls.
    fn index(&self, id: u32) -> u32 {
        let particle = self.bodies.binary_search(&id).ok();
        let wall = || self.walls.binary_search(&id).ok().map(|k| self.bodies.len() + k);
        particle.or_else(wall).map_or(NONE, |k| k as u32)
    }

    /// The chains of the membranes of a frame, as indices of their bodies.
    fn chains(&self, frame: &Frame) -> Vec<Value> {
        let chains = &frame.membranes;
        let chain = |k: usize| {
            let bodies = &chains.body[chains.points(k)];
            let bodies: Vec<u32> = bodies.iter().map(|id| self.index(*id)).collect();
            json!({ "bodies": bodies, "closed": chains.is_closed[k] })
        };
        (0..chains.name.len()).map(chain).collect()
    }

    /// What does not change: of bodies place without displacement, radius, identity, material,
    /// group; of bonds bodies and identity.
    fn still(&self, frames: &[Frame], origin: [f64; 2], to: &mut Columns) {
        // The first frame with a body decides.
        let first = |id: &u32| frames.iter().find_map(|frame| Some((frame, frame.row(*id)?)));
        let first: Vec<_> = self.bodies.iter().filter_map(first).collect();
        for axis in 0..2 {
            let place = |(frame, row): &(&Frame, usize)| {
                let moved = f64::from(frame.bodies.displacement_m[*row][axis]);
                (frame.centre(*row)[axis] - origin[axis] - moved) as f32
            };
            to.numbers(first.iter().map(place), 0.0);
        }
        to.numbers(first.iter().map(|(frame, row)| frame.bodies.radius_m[*row]), 0.0);
        to.counts(self.bodies.iter().copied());
        to.counts(first.iter().map(|(frame, row)| frame.bodies.material[*row]));
        let names = groups(frames);
        let group = |(frame, row): &(&Frame, usize)| {
            let group = frame.groups.get(frame.bodies.group[*row] as usize)?;
            names.iter().position(|name| name == group)
        };
        to.counts(first.iter().map(|first| group(first).map_or(NONE, |k| k as u32)));
        to.counts(self.bonds.iter().map(|bond| self.index(bond.0)));
        to.counts(self.bonds.iter().map(|bond| self.index(bond.1)));
        to.counts(self.bonds.iter().map(|bond| bond.2));
    }

    /// What changes.
    fn frame(&self, frame: &Frame, strains: &Strains, scales: &Scales, to: &mut Columns) {
        let of = &frame.bodies;
        let at: Vec<_> = self.bodies.iter().map(|id| frame.row(*id)).collect();
        // A body that is not in the frame has no displacement.
        let mut column = |step: f32, none: f32, value: &dyn Fn(usize) -> f32| {
            to.numbers(at.iter().map(|row| row.map_or(none, value)), step);
        };
        column(scales.displacement, f32::NAN, &|row| of.displacement_m[row][0]);
        column(scales.displacement, f32::NAN, &|row| of.displacement_m[row][1]);
        column(scales.rotation, 0.0, &|row| of.rotation_rad[row]);
        column(scales.stress, 0.0, &|row| mean(of.stress_pa[row]));
        column(scales.stress, 0.0, &|row| shear(of.stress_pa[row]));
        column(scales.velocity, 0.0, &|row| of.velocity_m_s[row][0]);
        column(scales.velocity, 0.0, &|row| of.velocity_m_s[row][1]);
        column(scales.strain, f32::NAN, &|row| strains[0][row]);
        column(scales.strain, f32::NAN, &|row| strains[1][row]);
        to.counts(at.iter().map(|row| row.map_or(0, |row| self.index(of.fragment[row]))));

        let pairs = &frame.pairs;
        let forces = [
            (&pairs.p_n, scales.force),
            (&pairs.q_n, scales.force),
            (&pairs.tau_nm, scales.moment),
        ];
        let mut rows = vec![None; self.bonds.len()];
        for k in 0..pairs.a.len() {
            let bond = (pairs.a[k], pairs.b[k], pairs.bond[k]);
            if let Ok(row) = self.bonds.binary_search(&bond) {
                rows[row] = Some(k);
            }
        }
        let state = |row: &Option<usize>| row.map_or(NO_BOND, |k| pairs.state[k].into());
        to.counts(rows.iter().map(state));
        for (force, step) in forces {
            to.numbers(rows.iter().map(|row| row.map_or(0.0, |k| force[k])), step);
        }
        for ids in [&pairs.a, &pairs.b] {
            to.counts(contacts(pairs).map(|k| self.index(ids[k])));
        }
        for (force, step) in forces {
            to.numbers(contacts(pairs).map(|k| force[k]), step);
        }
    }
}

/// Rows of the contacts without a bond.
fn contacts(pairs: &FramePairs) -> impl Iterator<Item = usize> + '_ {
    (0..pairs.a.len()).filter(|row| pairs.bond[*row] == NONE)
}

/// Maximum shear strains of the particles of frame `k` since another one.
fn shears(frames: &[Frame], k: usize, from: Option<usize>) -> Vec<f32> {
    let now = frames[k].disks();
    let Some(from) = from.and_then(|from| frames.get(from)) else {
        return vec![f32::NAN; now.len()];
    };
    let strains = strains(&now, &from.disks()).into_iter();
    strains.map(|strain| strain.map_or(f32::NAN, |strain| strain.shear as f32)).collect()
}

/// Displacements and rotations since the start of the test, in place of those since the start of
/// the run. Those of bodies that came later stay.
fn since(frames: &mut [Frame], start: usize) {
    let Some(from) = frames.get(start).cloned() else { return };
    for frame in frames {
        for row in 0..frame.bodies.id.len() {
            let Some(then) = from.row(frame.bodies.id[row]) else { continue };
            let moved = from.bodies.displacement_m[then];
            let now = &mut frame.bodies.displacement_m[row];
            *now = [now[0] - moved[0], now[1] - moved[1]];
            frame.bodies.rotation_rad[row] -= from.bodies.rotation_rad[then];
        }
    }
}

fn groups(frames: &[Frame]) -> Vec<&str> {
    distinct(frames.iter().flat_map(|frame| frame.groups.iter().map(String::as_str)))
}

/// The walls of a frame, with the points of their lines from the origin, m. Straight lines are
/// joined at their corners.
fn walls(frame: &Frame, origin: [f64; 2]) -> Vec<Value> {
    let number = frame.walls.id.len();
    let mut points: Vec<Vec<DVec2>> = (0..number)
        .map(|k| frame.wall_line(k).iter().map(|x| DVec2::from(*x) - DVec2::from(origin)).collect())
        .collect();
    let lines: Vec<usize> =
        (0..number).filter(|k| !frame.walls.is_thin[*k] && points[*k].len() == 2).collect();
    let ends: Vec<_> = lines.iter().map(|k| [points[*k][0], points[*k][1]]).collect();
    for (k, ends) in lines.into_iter().zip(joined(&ends)) {
        points[k] = ends.to_vec();
    }
    let wall = |(k, points): (usize, &Vec<DVec2>)| {
        let line: Vec<f32> = points.iter().flat_map(|x| [x.x as f32, x.y as f32]).collect();
        json!({
            "id": frame.walls.id[k],
            "name": frame.walls.name[k],
            "thin": frame.walls.is_thin[k],
            "force": frame.walls.force[k].map(|f| f as f32),
            "line": line,
        })
    };
    points.iter().enumerate().map(wall).collect()
}
