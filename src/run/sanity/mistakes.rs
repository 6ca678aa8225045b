//! Likely mistakes of a scene: values that are possible and seldom meant.

use super::before::time_step;
use super::material::Grains;
use super::{OVERLAP, is_specimen};
use crate::run::wall_pieces::pieces;
use crate::scene::format::{
    Bond, Cement, LidLoad, Load, Material, Particle, Scene, Specimen, Stage, Strain, Table,
    WallControl,
};
use crate::scene::memory::mean_of;
use crate::text::shown::label;
use clastic_systems::detect_contacts::grid::pairs_within;
use glam::DVec2;

/// Coefficient of friction above which an angle in degrees was meant: the tangent of 63 degrees.
const TANGENT: f64 = 2.0;
/// Strength times thickness over stiffness, the stretch of a bond at its strength in m/m, of bonds
/// whose two units agree. Rock and sand have 1e-4 to 3e-2, the softest of the scenes that ship 1.
const STRETCH: std::ops::Range<f64> = 1e-6..2.0;
/// Stiffness over pressure and thickness above which a stress in kPa was given as one in Pa. Stresses
/// of 10 Pa on stiff grains have 1e6.
const STIFFEST: f64 = 1e7;
/// Gap of the longest bond that a stage makes, mean radii, above which it joins grains that are no
/// neighbours: a grain fits between two at a gap of two radii.
const LONG: f64 = 2.0;
/// Mean diameter of the grains of a test, m, above which they were given in mm. Those of laboratory
/// tests are below 0.1 m.
const LARGE: f64 = 0.1;

/// Time steps in a period below which a vibration is not resolved: chords of an arc of 36 degrees miss 5 % of the
/// amplitude.
const RESOLVED: f64 = 10.0;
/// Change of a value over its maximum that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Weight of grains, N/m^3, whose density is in kg/m^3 and whose gravity in m/s^2: from foam on Earth to sand in a
/// centrifuge at 380 g.
const WEIGHT: std::ops::Range<f64> = 1e2..1e7;
const EARTH: f64 = 9.81;

/// Warnings of values that are seldom meant.
pub(super) fn mistakes(
    scene: &Scene,
    grains: &Grains,
    seeds: &[Particle],
    pressure: Option<f64>,
) -> Vec<String> {
    let mut list = Vec::new();
    for (kind, name, contact, bond) in scene.laws() {
        let path = format!("{kind}s.{}", label(name));
        let frictions =
            [("contact", contact.map(|of| of.friction)), ("bond", bond.map(|of| of.friction))];
        for (law, friction) in frictions.into_iter().filter(|(_, of)| *of > Some(TANGENT)) {
            list.push(format!(
                "{path}.{law}.friction is {:?}, which looks like degrees: friction is the tangent of its angle, 1 for \
                 45 degrees",
                friction.unwrap_or_default()
            ));
        }
        // The glue of a wall may be as strong as it likes.
        let bond = bond.filter(|_| kind != "wall");
        let Some(Bond { cohesion, tensile_strength, normal_stiffness, .. }) = bond else {
            continue;
        };
        let strength = cohesion.max(tensile_strength) * scene.thickness;
        let stretch = normal_stiffness.map_or(0.0, |stiffness| strength / stiffness);
        if stretch > 0.0 && stretch.is_finite() && !STRETCH.contains(&stretch) {
            list.push(format!(
                "{path}.bond: at its strength a bond stretches by {stretch:.1e} times the thickness; strengths are in \
                 Pa and stiffnesses in N/m"
            ));
        }
    }
    if let Some(level) = grains.level(pressure).filter(|level| *level > STIFFEST) {
        let pressure = pressure.unwrap_or_default();
        list.push(format!(
            "a stress of {pressure:?} Pa is small beside the grains (k/(p h) is {level:.0e}): stresses are \
             in Pa, 100 kPa is 1e5"
        ));
    }
    let mean = 2.0 * seeds.iter().map(|seed| seed.radius).sum::<f64>() / seeds.len().max(1) as f64;
    if is_specimen(scene) && mean > LARGE {
        list.push(format!(
            "the grains of the test are {mean:.2} m in diameter: lengths are in m, 1 mm is 1e-3"
        ));
    }
    list.extend(overlap(scene, seeds));
    list.extend(loose_sides(scene));
    list.extend(unused_bonds(scene));
    list.extend(no_particles(scene));
    list.extend(of_stages(scene, mean));
    list
}

/// Warnings of bonds that are far longer than the grains, of weights that no grains have, and of time steps in which
/// grains go further than their diameter.
fn of_stages(scene: &Scene, mean: f64) -> Vec<String> {
    let mut list = Vec::new();
    let (mut strongest, mut counts) = (EARTH, false);
    for stage in &scene.stages {
        if let Stage::Cement(Cement { name, length: Some(length), particles: true, .. }) = stage
            && mean > 0.0
            && *length > LONG * 0.5 * mean
        {
            list.push(format!(
                "stages.{}.length is {length:?} m, {:.1} mean radii: bonds as long as that join grains that are no \
                 neighbours; lengths are in m, 1 mm is 1e-3",
                label(name),
                2.0 * length / mean
            ));
        }
        let Some(load) = stage.load() else { continue };
        let gravity = DVec2::from(load.gravity.unwrap_or(scene.gravity));
        strongest = gravity.length().max(strongest);
        counts |= gravity != DVec2::ZERO;
        list.extend(pulls(scene, load));
        if gravity.y > 0.0 {
            let stage = label(&load.name);
            list.push(format!("stages.{stage}: gravity points up; down is (0.0, -9.81)"));
        }
        let Some(dt) = time_step(scene, load) else { continue };
        counts = true;
        let diameter = match stage {
            Stage::Pour(pour) => 2.0 * mean_of(&pour.stream.sizes),
            _ => mean,
        };
        let speeds = load.walls.values().map(|control| match control {
            WallControl::Velocity(x, y) => x.hypot(*y),
            WallControl::Follow(Table::Displacement(points)) => {
                let speed = |(a, b): (&(f64, f64, f64), &(f64, f64, f64))| {
                    (b.1 - a.1).hypot(b.2 - a.2) / (b.0 - a.0)
                };
                points.iter().zip(points.iter().skip(1)).map(speed).fold(0.0, f64::max)
            }
            _ => 0.0,
        });
        let ways = speeds.fold(gravity.length() * dt, f64::max) * dt / diameter;
        if ways > 1.0 && ways.is_finite() {
            list.push(format!(
                "stages.{}: in a time step of {dt:?} s weight or a wall moves grains by {ways:.1} diameters; give a \
                 smaller `dt`, in s",
                label(&load.name)
            ));
        }
    }
    list.extend(coarse_vibrations(scene));
    for (name, Material { density, .. }) in scene.materials.iter().filter(|_| counts) {
        let weight = density * strongest;
        if !WEIGHT.contains(&weight) {
            list.push(format!(
                "materials.{}: a density of {density:?} under a gravity of {strongest:?} is a weight of {weight:.1e} \
                 N/m^3, and sand has 2.6e4; 1 g/cm^3 is 1000 kg/m^3, gravity is in m/s^2",
                label(name)
            ));
        }
    }
    list
}

/// Warning of a wall that a load pulls away from the specimen, though nothing is bonded to walls.
fn pulls(scene: &Scene, load: &Load) -> Option<String> {
    let glues = |stage: &Stage| {
        matches!(stage, Stage::Cement(Cement { walls: true, .. }) | Stage::Custom(_))
    };
    if scene.stages.iter().any(glues) || matches!(scene.specimen, Specimen::State { .. }) {
        return None;
    }
    let (name, value) = load.walls.iter().find_map(|(name, control)| match control {
        WallControl::Force(value)
        | WallControl::Stress { stress: value, .. }
        | WallControl::Lid {
            load: LidLoad::Force(value) | LidLoad::Stress { stress: value, .. },
            ..
        } => (*value < 0.0).then_some((name, *value)),
        _ => None,
    })?;
    Some(format!(
        "stages.{}.walls.{}: a load of {value:?} pulls the wall away from the specimen, and no bond holds it: compression \
         is positive",
        label(&load.name),
        label(name)
    ))
}

/// Warnings of vibrations that the time steps of their stage do not resolve.
fn coarse_vibrations(scene: &Scene) -> Vec<String> {
    let mut list = Vec::new();
    for load in scene.stages.iter().filter_map(Stage::load) {
        let Some(dt) = time_step(scene, load) else { continue };
        let scale = &load.scale;
        let factors =
            [("gravity", &scale.gravity), ("strength", &scale.strength), ("loads", &scale.loads)];
        let factors =
            factors.map(|(name, of)| (format!("scale.{name}"), of.clone().into_iter().collect()));
        let walls = load.walls.iter().map(|(name, control)| {
            let tables: Vec<Vec<_>> = match control {
                WallControl::Follow(Table::Displacement(of)) => vec![
                    of.iter().map(|(s, x, _)| (*s, *x)).collect(),
                    of.iter().map(|(s, _, y)| (*s, *y)).collect(),
                ],
                WallControl::Follow(
                    Table::Force(of)
                    | Table::Stress { stress: of, .. }
                    | Table::Rotation { angle: of, .. },
                ) => vec![of.clone()],
                _ => Vec::new(),
            };
            (format!("walls.{}", label(name)), tables)
        });
        for (path, tables) in walls.chain(factors) {
            let period = tables.iter().filter_map(|of| period(of)).min_by(f64::total_cmp);
            if let Some(period) = period.filter(|period| *period < RESOLVED * dt * (1.0 - 1e-6)) {
                list.push(format!(
                    "stages.{}.{path} turns back and forth in {:.1} time steps, which cut off its peaks and may show a \
                     slower vibration than is meant; give a `dt` of a tenth of the period or less",
                    label(&load.name),
                    period / dt
                ));
            }
        }
    }
    list
}

/// Mean period of a table, from its first turn to its last; `None` of one that does not turn twice.
fn period(points: &[(f64, f64)]) -> Option<f64> {
    let most = points.iter().map(|(_, value)| value.abs()).fold(0.0, f64::max);
    let (mut turns, mut last) = (Vec::new(), 0.0);
    for ((s, a), (_, b)) in points.iter().zip(points.iter().skip(1)) {
        let way = b - a;
        if way.abs() > ROUND_OFF * most {
            if way * last < 0.0 {
                turns.push(*s);
            }
            last = way;
        }
    }
    let [first, .., last] = turns[..] else { return None };
    Some(2.0 * (last - first) / (turns.len() - 1) as f64)
}

/// Warning of a material with bonds in a scene that makes none.
fn unused_bonds(scene: &Scene) -> Option<String> {
    let is_made = scene.has_bonds(scene.stages.len());
    let (name, _) =
        scene.materials.iter().filter(|_| !is_made).find(|(_, of)| of.bond.is_some())?;
    Some(format!(
        "no bond has the law materials.{}.bond: `bonds` is empty, and no stage `Cement` makes any",
        label(name)
    ))
}

/// Warning of a scene that never has a particle.
fn no_particles(scene: &Scene) -> Option<String> {
    let brings = |stage: &Stage| matches!(stage, Stage::Pour(_) | Stage::Custom(_));
    let is_empty = matches!(&scene.specimen, Specimen::Particles(list) if list.is_empty());
    (is_empty && !scene.stages.iter().any(brings)).then(|| {
        "specimen: no particles; list some, write a `Lattice` or a `Packing`, or add a stage `Pour`".to_owned()
    })
}

/// Warning of disks that overlap at the start by more than linear contacts assume, with each other
/// or with a wall.
fn overlap(scene: &Scene, seeds: &[Particle]) -> Option<String> {
    if matches!(scene.specimen, Specimen::State { .. }) {
        return None;
    }
    let (places, radii): (Vec<DVec2>, Vec<_>) =
        seeds.iter().map(|seed| (DVec2::from(seed.position), seed.radius)).unzip();
    let mut pairs = pairs_within(&places, &radii, 0.0);
    let of_pair = |(a, b): (u32, u32)| {
        let (a, b) = (a as usize, b as usize);
        let gap = places[a].distance(places[b]) - radii[a] - radii[b];
        (-gap / radii[a].min(radii[b]), format!("particle {a} and particle {b}"))
    };
    let all: Vec<_> = scene.walls.iter().filter(|wall| wall.present).collect();
    let of_walls = all.iter().flat_map(|wall| {
        pieces(wall).into_iter().flat_map(move |piece| {
            seeds.iter().enumerate().map(move |(i, seed)| {
                let overlap = 1.0 - piece.distance(seed.position.into()) / seed.radius;
                (overlap, format!("particle {i} and wall {}", label(&wall.name)))
            })
        })
    });
    // Grains of one group may be a rigid body.
    let group = |i: u32| seeds[i as usize].group.as_ref();
    pairs.retain(|(a, b)| group(*a).is_none() || group(*a) != group(*b));
    let all = pairs.into_iter().map(of_pair).chain(of_walls);
    let (most, names) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (most > OVERLAP)
        .then(|| format!("{names} overlap by {:.0} % of a radius at the start", 100.0 * most))
}

/// Warning of a strain that is measured from walls under no load, which do not follow the specimen.
fn loose_sides(scene: &Scene) -> Option<String> {
    let Some(Strain::Walls(a, b)) = scene.strain("lateral_strain") else { return None };
    let stages = scene.stages.iter().take(scene.reference_stage() + 1).filter_map(Stage::load);
    let last = |name: &String| stages.clone().filter_map(|load| load.walls.get(name)).next_back();
    let is_loose = |name: &&String| {
        let control = last(name);
        matches!(control, Some(WallControl::Force(p) | WallControl::Stress { stress: p, .. }) if *p == 0.0)
    };
    let wall = [a, b].into_iter().find(is_loose)?;
    Some(format!(
        "`lateral_strain` is measured from wall {}, which carries no load and does not follow the \
         specimen; measure `Strain(Region(...))`, or take the wall away",
        label(wall)
    ))
}
