//! Scenes with mistakes, and what is said about them.

use super::read;
use super::samples::SMALL;

const PARTICLE: &str = "(position: (2.0, 1.0), radius: 1.0)";
const STAGE: &str = "walls: {\"top\": Force(1.0)}";
const INSIDE: &str = "move it inside; a wall has its inside on the left of start to end";

/// An edit of [`SMALL`]: what is replaced, by what, and all that is then reported.
type Case<'a> = (&'a str, &'a str, &'a str);

#[track_caller]
fn check(cases: &[Case]) {
    let mut failures = String::new();
    for (old, new, expected) in cases {
        assert_eq!(SMALL.matches(old).count(), 1, "{old}");
        let said = match read(&SMALL.replace(old, new), &[]) {
            Ok(_) => "nothing".to_owned(),
            Err(error) => error.to_string().replace("s.ron:", ""),
        };
        if said != *expected {
            failures.push_str(&format!("{new}\n  says {said}\n  not  {expected}\n"));
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

#[test]
fn syntax() {
    check(&[]);
}
pub(super) fn dump(g: &str, i: usize, old: &str, new: &str) {
    let said = match read(&SMALL.replace(old, new), &[]) {
        Ok(_) => "nothing".to_owned(),
        Err(error) => error.to_string().replace("s.ron:", ""),
    };
    println!("CASE\t{g}\t{i}\t{new:?}\t{said:?}");
}
