//! Which remedy helps an undecided increment. The message of the engine proposes only those that
//! help here (`src/run/advice.rs`, table in `docs/reliability.md`).
//!
//! Every random scene that ends undecided runs again from its start with one thing changed. The
//! change helps if the run then ends without an undecided increment.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use clastic::run::{Outcome, Simulation};
use clastic::scene::{self, format::*};

use crate::common::parse;
use crate::random::seeds;
use crate::random_scenes::{random_scene, text};

type Change = fn(&mut Scene, usize);

/// Names of the changes. Each gets the scene and the index of the stage that was undecided.
const REMEDIES: [(&str, Change); 9] = [
    ("residual 1e-6", |scene, _| scene.acceptance.residual = 1e-6),
    ("halvings 12", |scene, _| scene.acceptance.halvings = 12),
    ("turn 1", |scene, _| scene.acceptance.turn = 1.0),
    ("ten times the increments", |scene, stage| each_load(scene, stage, finer)),
    ("associated law", |scene, _| scene.friction_law = FrictionLaw::Associated),
    ("stiffness", |scene, _| stiffen(scene)),
    ("a force on walls at rest", |scene, stage| each_load(scene, stage, free)),
    ("greater height", heighten),
    ("dynamic stage before", settle),
];

fn each_load(scene: &mut Scene, stage: usize, change: fn(&mut Load)) {
    if let Some(Stage::Load(load)) = scene.stages.get_mut(stage) {
        change(load);
    }
}

/// The same motion in ten times the increments.
fn finer(load: &mut Load) {
    load.increments *= 10;
    for wall in load.walls.values_mut() {
        if let WallControl::Displacement(x, y) = wall {
            (*x, *y) = (0.1 * *x, 0.1 * *y);
        }
    }
    for control in &mut load.particles {
        for motion in [&mut control.x, &mut control.y, &mut control.rotation] {
            if let Motion::Displacement(u) = motion {
                *u *= 0.1;
            }
        }
        if let Some((x, y)) = &mut control.affine {
            for e in [&mut x.0, &mut x.1, &mut y.0, &mut y.1] {
                *e *= 0.1;
            }
        }
    }
    if let Some(Analysis::Dynamic { dt, .. }) = &mut load.analysis {
        *dt *= 0.1;
    }
}

/// Walls that stand still may give way.
fn free(load: &mut Load) {
    for wall in load.walls.values_mut().filter(|wall| **wall == WallControl::Fixed) {
        *wall = WallControl::Force(1e2);
    }
}

/// A compaction ends at twice its height.
fn heighten(scene: &mut Scene, stage: usize) {
    if let Some(Stage::Compact(compact)) = scene.stages.get_mut(stage)
        && let CompactTarget::Height(height) = &mut compact.target
    {
        *height *= 2.0;
    }
}

fn stiffen(scene: &mut Scene) {
    let materials = scene.materials.values_mut().map(|m| &mut m.contact);
    for contact in materials.chain(scene.walls.iter_mut().map(|w| &mut w.contact)) {
        contact.normal_stiffness.get_or_insert(1e8);
        contact.tangential_stiffness.get_or_insert(1e8);
    }
}

/// A dynamic stage under the same loads, without imposed motion, before the one that failed.
fn settle(scene: &mut Scene, stage: usize) {
    let Some(Stage::Load(load)) = scene.stages.get(stage) else { return };
    let mut before = load.clone();
    before.name = "settle".into();
    before.increments = 200;
    before.analysis = Some(Analysis::Dynamic { dt: 1e-3, theta: 1.0 });
    let is_moved = |wall: &WallControl| {
        matches!(wall, WallControl::Displacement(..) | WallControl::Velocity(..))
    };
    before.walls.values_mut().filter(|wall| is_moved(wall)).for_each(|w| *w = WallControl::Fixed);
    for control in &mut before.particles {
        for motion in [&mut control.x, &mut control.y, &mut control.rotation] {
            if matches!(motion, Motion::Displacement(_) | Motion::Velocity(_)) {
                *motion = Motion::Held;
            }
        }
        control.affine = None;
    }
    scene.stages.insert(stage, Stage::Load(before));
}

/// What was found in the undecided increment.
fn finding(message: &str, stage: &Stage) -> &'static str {
    if matches!(stage, Stage::Compact(_)) {
        return "compaction";
    }
    let found = [
        ("moved into each other", "two rigid bodies moved into each other"),
        ("locked", "locked"),
        ("Coulomb's law", "no solution of Coulomb's law"),
        ("turns the contacts", "turned too far"),
        ("no solution was found", "no solution"),
        ("cannot prove", "a collapse without proof"),
        ("step of the motion", "a step of the motion"),
    ];
    found.iter().find(|(words, _)| message.contains(words)).map_or("else", |(_, name)| name)
}

/// The message and the stage of an undecided increment, if the scene ends with one.
fn undecided(scene: &Scene) -> Option<(String, usize)> {
    let scene = parse(&text(scene));
    let mut simulation = Simulation::new(&scene, None);
    let outcome = simulation.run();
    let progress = simulation.world().resource::<clastic::components::increment::ClasticProgress>();
    match outcome {
        Outcome::Undecided { message, .. } => Some((message, progress.stage)),
        _ => None,
    }
}

#[test]
#[ignore = "repeats every undecided scene ten times"]
fn remedies_of_undecided_increments() {
    let mut table: BTreeMap<(&str, bool), (usize, [usize; REMEDIES.len()])> = BTreeMap::new();
    for seed in seeds(600) {
        let scene = random_scene(seed, 30);
        let reads = |scene: &Scene| {
            scene::from_str(&text(scene), Path::new("r.ron"), Path::new(""), &[]).is_ok()
        };
        if !reads(&scene) {
            continue;
        }
        let Some((message, stage)) = undecided(&scene) else { continue };
        let analysis = match &scene.stages[stage] {
            Stage::Load(load) => load.analysis.unwrap_or(scene.analysis),
            _ => Analysis::Static,
        };
        let is_dynamic = matches!(analysis, Analysis::Dynamic { .. });
        println!("CLASTIC_SEED={seed}: {message}");
        let row = table.entry((finding(&message, &scene.stages[stage]), is_dynamic)).or_default();
        row.0 += 1;
        for (helps, (_, change)) in row.1.iter_mut().zip(REMEDIES) {
            let mut changed = scene.clone();
            change(&mut changed, stage);
            let helped = text(&changed) != text(&scene)
                && reads(&changed)
                && catch_unwind(AssertUnwindSafe(|| undecided(&changed)))
                    .is_ok_and(|u| u.is_none());
            *helps += usize::from(helped);
        }
    }
    let names: Vec<&str> = REMEDIES.iter().map(|(name, _)| *name).collect();
    println!("| finding | analysis | scenes | {} |", names.join(" | "));
    for ((finding, is_dynamic), (scenes, helps)) in &table {
        let analysis = if *is_dynamic { "dynamic" } else { "static" };
        let helps: Vec<String> = helps.iter().map(ToString::to_string).collect();
        println!("| {finding} | {analysis} | {scenes} | {} |", helps.join(" | "));
    }
    assert!(!table.is_empty(), "no scene was undecided");
}
