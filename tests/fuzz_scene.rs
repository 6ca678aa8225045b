//! Fuzzing of scene text: the shipped scenes with tokens deleted, doubled, swapped and replaced. No
//! text makes the reader panic, loop or take much memory; every refusal has a message with a place
//! in the text; and accepted scenes run.
//!
//! A case is its number: the same on every machine. `CLASTIC_CASES=100000 cargo test --release
//! --test fuzz_scene` runs more of them. A text that fails is written to `tests/corpus/scenes`,
//! whose texts are replayed before anything else; keep it there with the fix.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use clastic::run::{Simulation, Step};
use clastic::scene::memory::Need;
use clastic::scene::{LoadError, from_str};
use clastic::scene::{MAX_MEMORY, MAX_PARTICLES};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const CORPUS: &str = "tests/corpus/scenes";
/// Cases of a normal run of the tests.
const CASES: u64 = 4000;
/// Maximum time of a case, on a machine with other load.
const LONGEST: Duration = Duration::from_secs(10);
/// Accepted scenes of at most this many particles are run for some increments.
const FEW: u64 = 60;

fn below(random: &mut ChaCha8Rng, n: usize) -> usize {
    (random.next_u64() % n.max(1) as u64) as usize
}

/// Words, numbers, quoted texts and single characters; what is blank stays with the token before.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut quoted = false;
    let inner = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '+');
    for c in text.chars() {
        let last = tokens.last_mut();
        match last {
            Some(token)
                if quoted
                    || c.is_whitespace()
                    || (inner(c) && token.chars().next_back().is_some_and(inner)) =>
            {
                token.push(c);
            }
            _ => tokens.push(c.to_string()),
        }
        if c == '"' {
            quoted = !quoted;
        }
    }
    tokens
}

/// An unusual number, or a likely one.
fn number(random: &mut ChaCha8Rng) -> String {
    const ODD: [&str; 18] = [
        "0",
        "-0.0",
        "1",
        "-1",
        "NaN",
        "inf",
        "-inf",
        "1e308",
        "1e-308",
        "1e30",
        "1e999",
        "0.5",
        "4294967295",
        "4294967296",
        "18446744073709551616",
        "1 MPa",
        "0x10",
        "1_000",
    ];
    match below(random, 3) {
        0 => {
            let exponent = below(random, 16) as i32 - 9;
            format!("{}.{}e{exponent}", below(random, 10), below(random, 1000))
        }
        _ => ODD[below(random, ODD.len())].to_owned(),
    }
}

/// The text of a case.
fn mutated(texts: &[String], case: u64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(case);
    let mut tokens = tokens(&texts[below(&mut random, texts.len())]);
    for _ in 0..=below(&mut random, 4) {
        let n = tokens.len();
        let (i, j) = (below(&mut random, n), below(&mut random, n));
        match below(&mut random, 8) {
            0 => drop(tokens.remove(i)),
            1 => tokens.insert(i, tokens[i].clone()),
            2 => tokens.swap(i, j),
            3 => tokens.insert(i, tokens[j].clone()),
            4 => {
                // A few tokens at once: a field, an entry, half a stage.
                let end = n.min(i + 1 + below(&mut random, 12));
                drop(tokens.drain(i..end));
            }
            _ => {
                // Most mistakes that get far are wrong numbers.
                let numeric = |token: &String| token.starts_with(|c: char| c.is_ascii_digit());
                let places: Vec<_> = (0..n).filter(|k| numeric(&tokens[*k])).collect();
                if !places.is_empty() {
                    let place = places[below(&mut random, places.len())];
                    tokens[place] = number(&mut random);
                }
            }
        }
        if tokens.is_empty() {
            break;
        }
    }
    tokens.concat()
}

/// Reads a text and runs what is accepted. Says whether it was.
fn try_text(text: &str) -> bool {
    let begun = Instant::now();
    let read = from_str(text, Path::new("fuzz.ron"), Path::new("scenes"), &[]);
    let accepted = match read {
        Err(LoadError::Scene(errors)) => {
            assert!(!errors.list.is_empty());
            for error in errors.list.iter().filter(|error| error.file.ends_with("fuzz.ron")) {
                let line = text.split('\n').nth(error.line - 1).expect("a line of the text");
                assert!(error.column <= line.chars().count() + 1, "{error}");
                assert!(!error.message.is_empty());
            }
            false
        }
        Err(other) => panic!("{other}"),
        Ok(loaded) => {
            let need = Need::of(&loaded.scene, loaded.specimen.as_ref());
            assert!(need.particles <= MAX_PARTICLES && need.bytes <= MAX_MEMORY, "{need:?}");
            if need.particles <= FEW {
                let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
                for _ in 0..2 {
                    if simulation.step() != Step::Increment {
                        break;
                    }
                }
            }
            true
        }
    };
    assert!(begun.elapsed() <= LONGEST, "it took {:?}", begun.elapsed());
    accepted
}

/// Maximum memory that this process has taken, bytes; none where the system does not say.
fn peak_memory() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(1024.0 * line.split_whitespace().nth(1)?.parse::<f64>().ok()?)
}

#[test]
fn kept_texts_are_read_or_refused() {
    let mut count = 0;
    for entry in fs::read_dir(CORPUS).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "ron") {
            let text = fs::read_to_string(&path).unwrap();
            let tried = catch_unwind(|| try_text(&text));
            assert!(tried.is_ok(), "{}", path.display());
            count += 1;
        }
    }
    assert!(count > 0, "the corpus is gone");
}

#[test]
fn mutated_scenes_are_read_or_refused() {
    let mut paths: Vec<_> =
        fs::read_dir("scenes").unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
    paths.sort();
    let texts: Vec<_> = paths.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    let cases = std::env::var("CLASTIC_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(CASES);
    let mut accepted = 0;
    let mut failed = Vec::new();
    for case in 0..cases {
        let text = mutated(&texts, case);
        match catch_unwind(AssertUnwindSafe(|| try_text(&text))) {
            Ok(was) => accepted += u64::from(was),
            Err(_) => {
                let path = format!("{CORPUS}/case_{case}.ron");
                fs::write(&path, &text).unwrap();
                failed.push(path);
            }
        }
    }
    println!("{cases} texts, {accepted} accepted, {:?} bytes at most", peak_memory());
    assert!(failed.is_empty(), "{failed:?}");
    // Mutations that are all refused, or all accepted, would test nothing.
    assert!(20 * accepted > cases && 20 * accepted < 19 * cases, "{accepted} of {cases} accepted");
    assert!(peak_memory().is_none_or(|bytes| bytes < 2e9), "{:?}", peak_memory());
}
