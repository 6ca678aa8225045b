//! Choice of the frames of a page, and contents of its columns.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::PathBuf;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use half::f16;
use serde_json::Value;

use super::choose::{File, choose};
use super::columns::{Columns, most_steps, scale};
use super::contacts::Contacts;
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
    let typical = 3.14159e7_f32;
    let values = [0.0_f32, 1.0, -3.14159e7, 2.1e6, -1.234e6, 6.4321e-2, 6.4e13];
    let mut columns = Columns::default();
    columns.counts(&[0x0403_0201, NONE]);
    columns.changing_halves(&values, scale(typical));
    let (text, codes) = columns.text();
    let bytes = unpacked(&text);
    assert_eq!(bytes.len(), 8 + 2 * values.len());
    assert_eq!(bytes[..8], [1, 255, 2, 255, 3, 255, 4, 255]);
    for (code, x) in codes[0].iter().zip(values) {
        let bits = if *code < 0 { 0x8000 - code } else { *code };
        let read = f16::from_bits(bits as u16).to_f64() * scale(typical);
        let x = f64::from(x);
        let is_large = x.abs() >= f64::from(typical) / 16.0;
        let error = if is_large { x.abs() / 2048.0 } else { f64::from(typical) / 32_768.0 };
        assert!((read - x).abs() <= error, "{x}: {read}");
    }
}

/// The whole numbers of a column of `width` bytes at this place, after those of the frame before.
fn changed(bytes: &[u8], at: usize, width: usize, before: &[i32]) -> Vec<i32> {
    let n = before.len();
    let one = |row: usize| {
        let byte = |plane: usize| u32::from(bytes[at + plane * n + row]) << (8 * plane);
        let code: u32 = (0..width).map(byte).sum();
        let change = (code >> 1) as i32 ^ -((code & 1) as i32);
        let beyond = 32 - 8 * width as u32;
        (before[row].wrapping_add(change) << beyond) >> beyond
    };
    (0..n).map(one).collect()
}

#[test]
fn columns_that_change_are_differences_and_lose_nothing() {
    let (most, wide) = (most_steps(2), most_steps(3));
    let mut before = Vec::new();
    let mut read = [[0; 3], [0; 3], [0; 3], [0; 3], [0; 3]].map(Vec::from);
    let steps = [[0.5, f32::NAN, -9.0], [f32::NAN, 1e9, -1e9], [0.0, -0.25, f32::NAN]];
    let halves = [[0.0, 1.0, -2.5], [-60_000.0, 1.0, 60_000.0], [60_000.0, -1e-7, -60_000.0]];
    let counts = [[0, NONE, 7], [NONE, 0, 8], [1, u32::MAX / 2, u32::MAX / 2 + 1]];
    let states = [[255_u8, 1, 0], [0, 255, 128], [127, 0, 255]];
    for k in 0..3 {
        let mut columns = Columns::after(before);
        columns.changing_steps(&steps[k], 0.25, 2);
        columns.changing_steps(&steps[k], 1e-9, 3);
        columns.changing_halves(&halves[k], 1.0);
        columns.changing(counts[k].iter().map(|x| x.cast_signed()).collect(), 4);
        columns.changing(states[k].iter().map(|x| i32::from(*x)).collect(), 1);
        let (text, codes) = columns.text();
        let bytes = unpacked(&text);
        assert_eq!(bytes.len(), 3 * (2 + 3 + 2 + 4 + 1));
        for (column, (at, width)) in [(0, 2), (6, 3), (15, 2), (21, 4), (33, 1)].iter().enumerate()
        {
            read[column] = changed(&bytes, *at, *width, &read[column]);
        }
        let whole = |x: f32, most: i32, step: f64| match x.is_nan() {
            true => -most - 1,
            false => (f64::from(x) / step).round().clamp(-f64::from(most), most.into()) as i32,
        };
        assert_eq!(read[0], steps[k].map(|x| whole(x, most, 0.25)), "{k}");
        assert_eq!(read[1], steps[k].map(|x| whole(x, wide, 1e-9)), "{k}");
        let bits = |code: &i32| if *code < 0 { 0x8000 - code } else { *code } as u16;
        let floats: Vec<_> = read[2].iter().map(|code| f16::from_bits(bits(code))).collect();
        assert_eq!(floats, halves[k].map(f16::from_f32), "{k}");
        assert_eq!(read[3], counts[k].map(u32::cast_signed), "{k}");
        assert_eq!(read[4].iter().map(|x| *x as u8).collect::<Vec<_>>(), states[k], "{k}");
        before = codes;
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
    let second = unpacked(&movie.blocks[2]);
    // Two rows of displacement (x, y), rotation, two stresses in two bytes each, the fragment in
    // four; the bond's state and two forces.
    assert_eq!(second.len(), 2 * (5 * 2 + 4) + 1 + 2 * 2);
    // Differences from the first frame, in which nothing has moved and the bond is whole.
    let moved = changed(&second, 0, 2, &[0, 0]);
    assert_eq!(moved, [most_steps(2), -most_steps(2) - 1]);
    let state = changed(&second, 28, 1, &[1])[0] as u8;
    assert_eq!(state, 255, "the bond is not there");
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

#[test]
fn contacts_have_a_row_from_one_whole_frame_to_the_next() {
    let pairs = |pairs: &[(u32, u32, f32)]| FramePairs {
        a: pairs.iter().map(|pair| pair.0).collect(),
        b: pairs.iter().map(|pair| pair.1).collect(),
        bond: vec![NONE; pairs.len()],
        p_n: pairs.iter().map(|pair| pair.2).collect(),
        ..FramePairs::default()
    };
    // Bodies 0, 4, 7 and 9 are particles, 2 is a wall, which comes after them in the page. Two
    // images of a body touch another one in the last frame.
    let index = |id: u32| [0, 4, 7, 9, 2].iter().position(|k| *k == id).unwrap() as u32;
    let frames = [
        pairs(&[(4, 2, 1.0), (4, 7, 2.0)]),
        pairs(&[(0, 9, 3.0), (4, 7, 4.0)]),
        pairs(&[(0, 4, 5.0), (4, 7, 6.0), (4, 7, 7.0)]),
    ];
    let contacts = Contacts::of(frames.iter(), index);
    // (0, 4), (0, 9), (4, 7), (4, 7) once more, (4, 2)
    let column = |of: &FramePairs| contacts.column(of, &of.p_n, index);
    assert_eq!(column(&frames[0]), [0.0, 0.0, 2.0, 0.0, 1.0]);
    assert_eq!(column(&frames[1]), [0.0, 3.0, 4.0, 0.0, 0.0]);
    assert_eq!(column(&frames[2]), [5.0, 0.0, 6.0, 7.0, 0.0]);
    let mut columns = Columns::default();
    contacts.bodies(&mut columns);
    let bytes = unpacked(&columns.text().0);
    assert_eq!(bytes.len(), 2 * 5 * 4);
    assert_eq!((&bytes[..5], &bytes[20..25]), (&[0, 0, 1, 0, 0][..], &[1, 3, 1, 1, 3][..]));
}
