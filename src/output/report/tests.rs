//! Which frames a page has, and what its columns say.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::PathBuf;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use half::f16;
use serde_json::Value;

use super::choose::{File, choose};
use super::columns::{Columns, most_steps, scale};
use super::movie::Movie;
use super::run::Run;
use super::*;
use crate::frames::{Frame, FrameBodies, FramePairs, FrameWalls, NONE};

fn unpacked(text: &str) -> Vec<u8> {
    let packed = BASE64_STANDARD.decode(text).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn columns_have_planes_and_stated_digits() {
    let values = [0.0_f32, 1.0, -3.14159e7, 6.6e4, 6.4321e-2];
    let largest = scale(3.14159e7);
    let mut columns = Columns::default();
    columns.halves(&values, largest);
    columns.steps(&[0.5, f32::NAN, -9.0], 0.25, 2);
    columns.steps(&[1e9, -70_000.0], 1.0, 3);
    columns.counts(&[0x0403_0201, NONE]);
    let bytes = unpacked(&columns.text());
    assert_eq!(bytes.len(), 10 + 6 + 6 + 8);
    for (k, x) in values.into_iter().enumerate() {
        let half = f16::from_le_bytes([bytes[k], bytes[5 + k]]);
        let read = half.to_f64() * largest;
        assert!((read - f64::from(x)).abs() <= 5e-4 * f64::from(x).abs(), "{x}: {read}");
    }
    let steps = |k: usize| i16::from_le_bytes([bytes[10 + k], bytes[13 + k]]);
    assert_eq!([steps(0), steps(1), steps(2)], [2, i16::MIN, -36]);
    let steps =
        |k: usize| i32::from_le_bytes([0, bytes[16 + k], bytes[18 + k], bytes[20 + k]]) >> 8;
    assert_eq!([steps(0), steps(1)], [most_steps(3), -70_000]);
    assert_eq!(bytes[22..], [1, 255, 2, 255, 3, 255, 4, 255]);
}

fn run(strains: &[(u64, Option<f64>)], ruptures: &[(u64, usize)]) -> Run {
    let ruptures: BTreeMap<_, _> = ruptures.iter().copied().collect();
    Run { value: Value::Null, strains: strains.to_vec(), ruptures }
}

fn files(number: u64, always: &[u64]) -> Vec<File> {
    let file = |increment: u64| {
        let path = PathBuf::from(increment.to_string());
        File { increment, is_always: always.contains(&increment), is_start: false, path }
    };
    (0..number).map(file).collect()
}

#[test]
fn frames_of_a_long_run_are_spread_over_strain_with_start_peak_events_and_end() {
    // A hundred increments of preparation, then 900 in which the strain grows.
    let strains: Vec<_> =
        (1..1000).map(|n| (n, (n >= 100).then(|| 1e-5 * (n - 100) as f64))).collect();
    let ruptures = [(517, 40), (518, 1), (803, 30)];
    let run = run(&strains, &ruptures);
    let all = files(1000, &[100, 611]);
    let chosen: Vec<u64> = choose(&all, &run, 50).iter().map(|file| file.increment).collect();
    assert_eq!(chosen.len(), 50);
    for increment in [0, 100, 517, 611, 803, 999] {
        assert!(chosen.contains(&increment), "{increment}: {chosen:?}");
    }
    assert!(chosen.is_sorted());
    let widest = chosen.windows(2).filter(|gap| gap[0] >= 100).map(|gap| gap[1] - gap[0]).max();
    assert!(widest <= Some(40), "{chosen:?}");
    assert_eq!(choose(&all, &run, 1000), all);
}

/// Two bonded grains, of which the second is gone in the second frame.
fn frames() -> [Frame; 2] {
    let pairs = FramePairs {
        a: vec![0],
        b: vec![3],
        bond: vec![7],
        state: vec![1],
        p_n: vec![-2.5],
        q_n: vec![0.5],
        tau_nm: vec![0.0],
        gap_m: vec![0.0],
        angle_rad: vec![0.0],
    };
    let frame = |bodies: usize, increment, moved: f32, pairs| Frame {
        increment,
        materials: vec!["sand".into()],
        bodies: FrameBodies {
            id: [0, 3][..bodies].to_vec(),
            offset_m: [[moved, 0.0], [2.0 + moved, 0.0]][..bodies].to_vec(),
            displacement_m: vec![[moved, 0.0]; bodies],
            radius_m: vec![1.0; bodies],
            rotation_rad: vec![0.0; bodies],
            velocity_m_s: vec![[0.0; 2]; bodies],
            angular_velocity_rad_s: vec![0.0; bodies],
            material: vec![0; bodies],
            group: vec![NONE; bodies],
            stress_pa: vec![[1.0, 3.0, 0.0]; bodies],
            fragment: vec![0; bodies],
        },
        pairs,
        walls: FrameWalls { first_point: vec![0], ..FrameWalls::default() },
        ..Frame::default()
    };
    [frame(2, 0, 0.0, pairs), frame(1, 5, 0.25, FramePairs::default())]
}

#[test]
fn bodies_and_bonds_have_a_row_over_the_whole_run() {
    let movie = Movie::of(frames().to_vec(), 0).unwrap();
    assert_eq!((&movie.description["bodies"], &movie.description["bonds"]), (&2.into(), &1.into()));
    assert_eq!(movie.description["frames"][1]["increment"], 5);
    assert_eq!(movie.blocks.len(), 3);
    // Places without displacement, radii, identities, materials, groups; bodies of the bond, bond.
    let still = unpacked(&movie.blocks[0]);
    assert_eq!(still.len(), 2 * 6 * 4 + 3 * 4);
    let second = unpacked(&movie.blocks[2]);
    // Two rows of displacement (x, y), rotation, two stresses in two bytes each, the fragment in
    // four; the bond's state and two forces.
    assert_eq!(second.len(), 2 * (5 * 2 + 4) + 1 + 2 * 2);
    let step = |k: usize| i16::from_le_bytes([second[k], second[2 + k]]);
    assert_eq!([step(0), step(1)], [i16::MAX, i16::MIN]);
    assert_eq!(second[28], 255, "the bond is not there");
}

#[test]
fn a_page_holds_any_text() {
    let record = json!({ "title": "</script> & <b>" });
    let data = json!({ "runs": [{ "record": record }], "movie": Value::Null });
    let page = page(&data, None);
    assert!(page.contains("<title>&lt;/script&gt; &amp; &lt;b&gt;</title>"));
    let start = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let end = start + page[start..].find("</script>").unwrap();
    assert_eq!(serde_json::from_str::<Value>(&page[start..end]).unwrap(), data);
    assert!(!page.contains("{{"), "a place is not filled");
    for outside in ["http://", "https://", "//cdn", "@import", "url("] {
        let found = page.replace("http://www.w3.org/2000/svg", "").contains(outside);
        assert!(!found, "the page refers to {outside}");
    }
}
