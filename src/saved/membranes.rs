//! The membranes of a saved state. A state without any has no such arrays.

use clastic_components::body::BodyId;
use clastic_components::increment::ClasticProgress;
use clastic_components::membrane::{Course, Membrane, Sides};
use clastic_systems::membranes::{MEMBRANES, MembraneStates};
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::{StateError, WorldState};

use super::SavedError;
use super::columns::{bad, none_of};
use crate::scene::StoredMembrane;
use crate::scene::format::Wall;
use crate::tables::{Array, Tables};

pub(super) const ENTRIES: [&str; 1] = [MEMBRANES];

/// No wall: the membrane is closed.
const NONE: u32 = u32::MAX;

pub(super) fn write(state: &WorldState, tables: &mut Tables) -> Result<(), SavedError> {
    let list = of(state)?;
    if list.is_empty() {
        return Ok(());
    }
    let progress: ClasticProgress = state.get(PROGRESS)?;
    let text = |of: fn(&Membrane) -> String| Array::text(list.iter().map(of));
    tables.put("membranes.name", text(|membrane| membrane.name.clone()));
    // A pressure stays at what it has reached.
    let pressures = list.iter().map(|membrane| membrane.ramp(&progress).from);
    tables.put("membranes.pressure_pa", Array::f64(pressures.collect()));
    let course = |membrane: &Membrane| match membrane.course {
        Course::Closed => ("closed", [NONE; 2]),
        Course::Between { first, second, sides } => {
            let sides = match sides {
                Sides::Both => "both",
                Sides::Left => "left",
                Sides::Right => "right",
            };
            (sides, [first.0, second.0])
        }
    };
    let (sides, walls): (Vec<_>, Vec<_>) = list.iter().map(course).unzip();
    tables.put("membranes.sides", Array::text(sides.into_iter().map(str::to_owned)));
    for (k, name) in ["membranes.first_wall", "membranes.second_wall"].into_iter().enumerate() {
        tables.put(name, Array::u32(walls.iter().map(|walls| walls[k]).collect()));
    }
    let balls = list.iter().map(|membrane| membrane.ball.unwrap_or(f64::NAN));
    tables.put("membranes.ball_m", Array::f64(balls.collect()));
    Ok(())
}

/// Reads the membranes; `walls` are those that are there.
pub(super) fn read(
    tables: &Tables,
    walls: &[u32],
    state: &mut WorldState,
) -> Result<(), SavedError> {
    if !tables.has("membranes.name") {
        return none_of(tables, "membranes.", "membranes.name");
    }
    let n = tables.rows("membranes.name")?;
    let names = tables.text("membranes.name", &[n])?;
    let pressures = tables.f64("membranes.pressure_pa", &[n])?;
    let sides = tables.text("membranes.sides", &[n])?;
    let ends = ["membranes.first_wall", "membranes.second_wall"];
    let [first, second] = [tables.u32(ends[0], &[n])?, tables.u32(ends[1], &[n])?];
    let balls = tables.f64("membranes.ball_m", &[n])?;
    let mut list = Vec::new();
    for k in 0..n {
        let pressure = pressures[k];
        if !(pressure >= 0.0 && pressure.is_finite()) {
            return Err(bad("membranes.pressure_pa", format!("{pressure:?} in row {k}")));
        }
        if balls[k] <= 0.0 || balls[k].is_infinite() {
            return Err(bad("membranes.ball_m", format!("{:?} in row {k}", balls[k])));
        }
        let wall = |id: u32, name: &str| {
            let there = walls.contains(&id).then_some(BodyId(id));
            there.ok_or_else(|| bad(name, format!("no wall {id} is there (row {k})")))
        };
        let between = |sides| -> Result<Course, SavedError> {
            let (first, second) = (wall(first[k], ends[0])?, wall(second[k], ends[1])?);
            Ok(Course::Between { first, second, sides })
        };
        let course = match sides[k].as_str() {
            "closed" => Course::Closed,
            "both" => between(Sides::Both)?,
            "left" => between(Sides::Left)?,
            "right" => between(Sides::Right)?,
            other => return Err(bad("membranes.sides", format!("`{other}` in row {k}"))),
        };
        let ball = Some(balls[k]).filter(|ball| !ball.is_nan());
        list.push(Membrane {
            name: names[k].clone(),
            pressure: (pressure, pressure),
            course,
            ball,
        });
    }
    state.set(MEMBRANES, &MembraneStates(list))?;
    Ok(())
}

/// The membranes of a state.
fn of(state: &WorldState) -> Result<Vec<Membrane>, StateError> {
    match state.bytes(MEMBRANES) {
        Some(_) => Ok(state.get::<MembraneStates>(MEMBRANES)?.0),
        None => Ok(Vec::new()),
    }
}

/// The membranes of a state as a scene sees them: names, and the walls between which they lie.
/// `first` is the identity of the first wall of the catalogue.
pub(super) fn names(
    state: &WorldState,
    first: u32,
    walls: &[Wall],
) -> Result<Vec<StoredMembrane>, StateError> {
    let name = |id: BodyId| {
        let mut next = first;
        let is_of = |wall: &&Wall| {
            next += crate::run::wall_pieces::count(wall);
            id.0 < next
        };
        walls.iter().find(is_of).map_or_else(String::new, |wall| wall.name.clone())
    };
    let seen = of(state)?.into_iter().map(|membrane| {
        let between = match membrane.course {
            Course::Closed => None,
            Course::Between { first, second, .. } => Some((name(first), name(second))),
        };
        StoredMembrane { name: membrane.name, between }
    });
    Ok(seen.collect())
}
