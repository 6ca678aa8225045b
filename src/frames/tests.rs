//! Frames against quantities that the engine keeps otherwise: forces of walls, average stress,
//! the saved state.

use std::path::Path;

use clastic_components::body::BodyPosition;
use clastic_components::contact::BodyTable;
use clastic_systems::measures::stress::average_stress;
use clastic_systems::solved::Solved;

use super::*;
use crate::run::Simulation;
use crate::scene::load;

/// 400 cemented disks under uniaxial compression, at the end of the test: some bonds are broken.
fn compressed() -> (Simulation, Frame) {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/uniaxial_small.ron");
    let loaded = load(Path::new(scene), &[]).unwrap();
    let mut simulation = Simulation::new(&loaded.scene, None);
    simulation.run();
    let frame = Frame::take(simulation.world_mut());
    (simulation, frame)
}

#[test]
fn a_frame_has_the_bodies_forces_and_stresses_of_the_engine() {
    let (mut simulation, frame) = compressed();
    let world = simulation.world_mut();
    let bodies = world.resource::<BodyTable>().clone();
    assert_eq!(frame.bodies.id.len(), 400);
    // Centres to half a unit in the last place of the distance from the origin.
    for i in 0..400 {
        let place = bodies.positions[i];
        let [x, y] = frame.centre(i);
        let size = (place.x - frame.origin_m[0]).hypot(place.y - frame.origin_m[1]);
        assert!((x - place.x).hypot(y - place.y) <= 1e-7 * size, "{i}");
    }
    let mut places = world.query::<&BodyPosition>();
    assert!(places.iter(world).count() >= 400);

    // The forces of the contacts at a wall are what it exerts, which the record has from elsewhere.
    let largest = frame.walls.force.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(largest > 0.0);
    for (wall, id) in frame.walls.id.iter().enumerate() {
        let mut sum = [0.0_f64; 2];
        for k in (0..frame.pairs.a.len()).filter(|k| frame.pairs.b[*k] == *id) {
            let (p, q) = (f64::from(frame.pairs.p_n[k]), f64::from(frame.pairs.q_n[k]));
            let (sin, cos) = f64::from(frame.pairs.angle_rad[k]).sin_cos();
            sum[0] += p * cos - q * sin;
            sum[1] += p * sin + q * cos;
        }
        for k in 0..2 {
            let outside = frame.walls.force[wall][k];
            assert!((sum[k] + outside).abs() <= 1e-5 * largest, "{wall} {k}: {sum:?} {outside}");
        }
    }

    // Mean stress of the grains by volume: that of all contacts. The two differ by the motion in
    // one increment, since the engine's average refers to its start.
    let thickness = frame.thickness_m;
    let mut sum = [0.0_f64; 3];
    for (stress, r) in frame.bodies.stress_pa.iter().zip(&frame.bodies.radius_m) {
        let volume = std::f64::consts::PI * f64::from(*r).powi(2) * thickness;
        (0..3).for_each(|k| sum[k] += volume * f64::from(stress[k]));
    }
    let all = average_stress(Solved::of(world), 1.0, 1.0);
    let expected = [all[0][0], all[1][1], 0.5 * (all[0][1] + all[1][0])];
    for k in 0..3 {
        assert!((sum[k] - expected[k]).abs() < 1e-3 * expected[1].abs(), "{sum:?} {expected:?}");
    }
}

#[test]
fn bonds_and_fragments_are_those_of_the_world() {
    let (mut simulation, frame) = compressed();
    let world = simulation.world_mut();
    let mut query = world.query::<(
        &clastic_components::bond::BondId,
        &clastic_components::bond::Bond,
        &clastic_components::bond::BondState,
    )>();
    let mut expected: Vec<_> =
        query.iter(world).map(|(id, b, s)| (id.0, b.a.0, b.b.0, pairs::code(*s))).collect();
    expected.sort_unstable();
    let pairs = &frame.pairs;
    let rows = (0..pairs.a.len()).filter(|k| pairs.bond[*k] != NONE);
    let mut found: Vec<_> =
        rows.map(|k| (pairs.bond[k], pairs.a[k], pairs.b[k], pairs.state[k])).collect();
    found.sort_unstable();
    assert_eq!(found, expected);
    assert!(expected.iter().any(|(.., state)| *state > 1), "no bond broke");

    // Spread the lowest identity along intact bonds until nothing changes.
    let mut lowest: Vec<u32> = (0..400).collect();
    loop {
        let before = lowest.clone();
        for (_, a, b, _) in expected.iter().filter(|(.., b, state)| *state == 1 && *b < 400) {
            let least = lowest[*a as usize].min(lowest[*b as usize]);
            (lowest[*a as usize], lowest[*b as usize]) = (least, least);
        }
        if before == lowest {
            break;
        }
    }
    assert_eq!(frame.bodies.fragment, lowest);
}

/// 196 disks in a sheared periodic cell: pairs across its sides have the near image.
#[test]
fn a_frame_holds_its_periodic_cell() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/simple_shear_periodic.ron");
    let loaded = load(Path::new(scene), &["stages.shear.increments=4".to_owned()]).unwrap();
    let mut simulation = Simulation::new(&loaded.scene, None);
    simulation.run();
    let frame = Frame::take(simulation.world_mut());
    let cell = frame.cell_m.unwrap();
    assert!(cell[2] > 0.0, "{cell:?}");
    let (mut across, pairs) = (0, &frame.pairs);
    for k in 0..pairs.a.len() {
        let [a, b] = [pairs.a[k], pairs.b[k]].map(|id| frame.row(id).unwrap());
        let [from, to] = [a, b].map(|row| glam::DVec2::from(frame.centre(row)));
        let shift = clastic_components::cell::shift(cell, to - from);
        across += usize::from(shift != glam::DVec2::ZERO);
        let radii = f64::from(frame.bodies.radius_m[a]) + f64::from(frame.bodies.radius_m[b]);
        let gap = (to + shift - from).length() - radii;
        assert!((gap - f64::from(pairs.gap_m[k])).abs() < 1e-7, "{k}: {gap}");
    }
    assert!(across > 20, "{across}");
    assert_eq!(Frame::from_tables(&frame.tables()).unwrap(), frame);
}

#[test]
fn a_frame_without_anything_reads_back() {
    let empty = Frame {
        walls: FrameWalls { first_point: vec![0], ..FrameWalls::default() },
        membranes: FrameMembranes { first_point: vec![0], ..FrameMembranes::default() },
        axial_strain: Some(0.25),
        ..Frame::default()
    };
    assert_eq!(Frame::from_tables(&empty.tables()).unwrap(), empty);
}

#[test]
fn a_frame_reads_back_and_damage_is_named() {
    use crate::tables::{Array, Tables};

    let (_, frame) = compressed();
    let bytes = frame.tables().encode().unwrap();
    assert_eq!(Frame::from_tables(&Tables::decode(&bytes).unwrap()).unwrap(), frame);
    let said = |tables: &Tables| Frame::from_tables(tables).unwrap_err().to_string();
    let mut tables = frame.tables();
    tables.put("pairs.state", Array::column(vec![9_u8; frame.pairs.a.len()]));
    assert_eq!(said(&tables), "array `pairs.state`: the value in row 0 is out of range");
    tables.put("format", Array::single("clastic state 1".to_owned()));
    assert!(said(&tables).starts_with("not a frame"), "{}", said(&tables));
    tables.put("format", Array::single("clastic frame 9".to_owned()));
    assert!(said(&tables).contains("format 9"), "{}", said(&tables));
}

#[test]
fn frames_are_listed_in_order() {
    let run = tempfile::tempdir().unwrap();
    assert!(list(run.path()).unwrap().is_empty());
    let frames = run.path().join("frames");
    std::fs::create_dir(&frames).unwrap();
    let names = ["end.npz", "frame_1000000.npz", "peak.npz", "frame_000020.npz", "start.npz"];
    for name in names.into_iter().chain(["frame_000020.csv", "end.npz.part", "notes.npz"]) {
        std::fs::write(frames.join(name), "").unwrap();
    }
    let listed = list(run.path()).unwrap();
    let listed: Vec<_> = listed.iter().map(|path| path.file_name().unwrap()).collect();
    let expected = ["start.npz", "frame_000020.npz", "frame_1000000.npz", "peak.npz", "end.npz"];
    assert_eq!(listed, expected);
}
