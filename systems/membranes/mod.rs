//! Flexible membranes: a pressure on the chains of the outermost grains, as a follower load.
//!
//! A link of a chain goes from x_a to x_b with the specimen on its left. The pressure p acts on it
//! along the inward normal with the force `p h R (x_b - x_a)`, with the thickness h and the
//! rotation R by +90 degrees. Each end takes half of it, which is the resultant and the moment of
//! the uniform pressure. A link to a wall, along the normal of the wall, acts on its grain alone: a
//! smooth wall would carry nothing along itself, and the specimen between two of them would have no
//! equilibrium. The sum over a closed chain is zero, and over an open one that of the straight line
//! from its first point to its last.
//!
//! The plugin uses public sets only: [`AddTrialLoads`], which runs for every trial, so that the
//! chains and their forces are those of the place from which a halved increment or a step of a
//! followed motion starts. It is the example of a boundary condition in `ARCHITECTURE.md`.

mod rolling_ball;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;

use self::rolling_ball::{Line, RollingBall};
use crate::schedule::{AddTrialLoads, ClasticHalted};
use crate::state::{RegisterState, StateOf, despawn_if};

/// Adds [`press`]. The record runs [`renew_shapes`].
pub struct MembranesPlugin;

impl Plugin for MembranesPlugin {
    fn build(&self, app: &mut App) {
        app.register_state::<MembraneStates>(MEMBRANES).add_systems(AddTrialLoads, press);
    }
}

/// Name of [`MembraneStates`] in a state.
pub const MEMBRANES: &str = "membranes";

/// The membranes by name. A world without membranes has no such state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MembraneStates(pub Vec<Membrane>);

impl StateOf for MembraneStates {
    fn take(world: &mut World) -> Option<Self> {
        let mut list: Vec<Membrane> = world.query::<&Membrane>().iter(world).cloned().collect();
        list.sort_unstable_by(|a, b| a.name.cmp(&b.name));
        (!list.is_empty()).then_some(Self(list))
    }

    fn put(self, world: &mut World) {
        Self::forget(world);
        world.spawn_batch(self.0);
    }

    fn forget(world: &mut World) {
        despawn_if(world, |_: &Membrane| true);
    }
}

/// Finds the chains of every membrane at the start of the trial, and adds their forces at the
/// pressure at its end. A followed motion may go through states in which no chain reaches from wall
/// to wall. The grains of the last chain then continue to carry the pressure.
pub fn press(
    bodies: Res<BodyTable>,
    progress: Res<ClasticProgress>,
    analysis: Res<ClasticAnalysis>,
    mut membranes: Query<(&Membrane, &mut MembraneShape)>,
    mut loads: ResMut<TrialLoads>,
) {
    for (membrane, mut shape) in &mut membranes {
        let pressure = membrane.ramp(&progress).at(progress.fraction);
        let found = find_shape(membrane, pressure, &bodies);
        *shape = if found.chains.is_empty() { moved(&shape, pressure, &bodies) } else { found };
        for chain in &shape.chains {
            add_forces(chain, pressure * analysis.thickness, &mut loads);
        }
    }
}

/// The chains of a shape, at the present places of their bodies.
fn moved(shape: &MembraneShape, pressure: f64, bodies: &BodyTable) -> MembraneShape {
    let mut shape = MembraneShape { pressure, ..shape.clone() };
    for chain in &mut shape.chains {
        for (id, point) in chain.bodies.iter().zip(&mut chain.points) {
            if let Some(row) = bodies.row(*id).filter(|row| *row < bodies.particles) {
                *point = bodies.positions[row];
            }
        }
        let n = chain.points.len();
        if chain.closed || n < 3 {
            continue;
        }
        for (wall, next) in [(0, 1), (n - 1, n - 2)] {
            if let Some(line) = wall_line(bodies, chain.bodies[wall]) {
                chain.points[wall] = line.foot(chain.points[next]);
            }
        }
    }
    shape
}

/// Adds the forces of the links at a pressure times thickness, N/m. A link to a wall acts on its
/// grain alone.
fn add_forces(chain: &Chain, pressure: f64, loads: &mut TrialLoads) {
    for (a, b) in chain.links() {
        let force = pressure * (chain.points[b] - chain.points[a]).perp();
        let [on_a, on_b] = chain.shares(a, b);
        for (end, share) in [(a, on_a), (b, on_b)] {
            if share > 0.0 {
                loads.add(chain.bodies[end], [share * force.x, share * force.y, 0.0]);
            }
        }
    }
}

/// Finds the chains at the end of an increment, for measures and pictures. A membrane without a
/// chain halts the run, because its grains are no longer between its walls.
pub fn renew_shapes(
    bodies: Res<BodyTable>,
    mut membranes: Query<(&Membrane, &mut MembraneShape)>,
    mut commands: Commands,
) {
    for (membrane, mut shape) in &mut membranes {
        *shape = find_shape(membrane, shape.pressure, &bodies);
        if shape.chains.is_empty() {
            commands.insert_resource(ClasticHalted(format!(
                "membrane `{0}` finds no chain of grains to press on: the specimen does not reach \
                 from one of its walls to the other; end the stage earlier, or remove the membrane \
                 (`remove_membranes: [\"{0}\"]`)",
                membrane.name
            )));
        }
    }
}

/// The chains of a membrane where the bodies are; none if no chain reaches from wall to wall.
pub fn find_shape(membrane: &Membrane, pressure: f64, bodies: &BodyTable) -> MembraneShape {
    let positions = &bodies.positions[..bodies.particles];
    let ball = RollingBall::new(positions, &bodies.radii, membrane.ball);
    let grains = |chain: &[usize]| -> Chain {
        Chain {
            bodies: chain.iter().map(|i| bodies.ids[*i]).collect(),
            points: chain.iter().map(|i| positions[*i]).collect(),
            radii: chain.iter().map(|i| bodies.radii[*i]).collect(),
            closed: true,
        }
    };
    let open = |(first, from): (BodyId, Line), (second, to): (BodyId, Line)| {
        let mut chain = grains(&ball.between(&from, &to)?);
        let (start, end) = (from.foot(*chain.points.first()?), to.foot(*chain.points.last()?));
        chain.bodies.insert(0, first);
        chain.bodies.push(second);
        chain.points.insert(0, start);
        chain.points.push(end);
        chain.radii.insert(0, 0.0);
        chain.radii.push(0.0);
        Some(Chain { closed: false, ..chain })
    };
    let (chains, height) = match membrane.course {
        Course::Closed => (ball.around().map(|chain| vec![grains(&chain)]), 0.0),
        Course::Between { first, second, sides } => {
            let (Some(a), Some(b)) = (wall_line(bodies, first), wall_line(bodies, second)) else {
                return MembraneShape { pressure, ..MembraneShape::default() };
            };
            let right = || open((first, a), (second, b));
            let left = || open((second, b), (first, a));
            let chains = match sides {
                Sides::Both => right().zip(left()).map(|(a, b)| vec![a, b]),
                Sides::Right => right().map(|chain| vec![chain]),
                Sides::Left => left().map(|chain| vec![chain]),
            };
            (chains, (b.point - a.point).dot(a.inward))
        }
    };
    MembraneShape { chains: chains.unwrap_or_default(), height, pressure }
}

fn wall_line(bodies: &BodyTable, wall: BodyId) -> Option<Line> {
    let row = bodies.row(wall)?;
    Some(Line { point: bodies.positions[row], inward: bodies.wall(row as u32)?.inward })
}
