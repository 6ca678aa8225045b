//! Choice of the frames of a page, and contents of its columns.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::PathBuf;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;

use super::choose::{File, choose};
use super::columns::{Columns, step};
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

/// The whole numbers of a column of `rows` rows that begins at this byte.
fn column(bytes: &[u8], at: usize, rows: usize) -> Vec<u32> {
    let row = |k: usize| [0, 1, 2, 3].map(|plane| bytes[at + plane * rows + k]);
    (0..rows).map(|k| u32::from_le_bytes(row(k))).collect()
}

#[test]
fn columns_have_planes_and_numbers_their_step() {
    let values = [0.0_f32, 1.0, -3.14159e7, 2.1e6, -1.234e6, 6.4321e-2, 6.4e13, f32::NAN];
    let step = step(3.14159e7, 1.0 / 16_384.0);
    assert_eq!(step, 1024.0);
    let mut columns = Columns::default();
    columns.counts([0x0403_0201, NONE]);
    columns.numbers(values, step);
    let bytes = unpacked(&columns.text());
    assert_eq!(bytes.len(), 8 + 4 * values.len());
    assert_eq!(bytes[..8], [1, 255, 2, 255, 3, 255, 4, 255]);
    for (bits, x) in column(&bytes, 8, values.len()).into_iter().zip(values) {
        let read = f32::from_bits(bits);
        assert!((read - x).abs() <= 0.5 * step || (read.is_nan() && x.is_nan()), "{x}: {read}");
    }
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
    // Nine numbers and the fragment of either body; state and three forces of the bond.
    let second = unpacked(&movie.blocks[2]);
    assert_eq!(second.len(), 4 * (2 * 10 + 4));
    let [moved, gone] = [0, 1].map(|k| f32::from_bits(column(&second, 0, 2)[k]));
    assert!(moved == 0.25 && gone.is_nan(), "{moved} {gone}");
    assert_eq!(column(&second, 80, 1), [255], "the bond is not there");
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
