//! Anderson's method: the next guess of the end of an increment from the last ones.
//!
//! A pass maps a guess v of the displacements to the solution u about it, and the end is a fixed
//! point of this map. With `r = u - v`, the changes `dv_i`, `dr_i` of the last passes and the weights
//! that minimise `|r - sum w_i dr_i|`, the next guess is
//!
//! ```text
//! v + r - sum w_i (dv_i + dr_i)
//! ```
//!
//! It replaces the geometric stiffness, which the program does not have: the closer a buckling
//! load, the more slowly the plain map converges, while this one takes a few passes. See D. G.
//! Anderson, J. ACM 12 (1965) 547.
//!
//! A change that grows by g >= 1 from guess to solution leads away from a fixed point that is not
//! stable: a straight column beyond its buckling load. Anderson's step along it, `1/(1 - g)` times what
//! the guess missed, would lead back there. The guess therefore moves by `1/(g - 1)` times the
//! miss, as in a Newton method for a minimum that uses the absolute values of the curvatures.

use clastic_components::findings::Guesses;

/// Number of changes that a guess takes into account.
const DEPTH: usize = 2;

/// Takes over the solution `u` about the last guess, and makes the next guess: the first one is `u`
/// with the linear response `idle`. `growth` is that of the last change. A rotation counts with the
/// length `radius`, m.
pub fn next(guesses: &mut Guesses, u: &[[f64; 3]], idle: &[[f64; 3]], growth: f64, radius: f64) {
    if guesses.last.len() != u.len() {
        guesses.last = vec![[0.0; 3]; u.len()];
    }
    let missed = difference(u, &guesses.last);
    let dot = |x: &[[f64; 3]], y: &[[f64; 3]]| dot(x, y, radius);
    if let Some([_, change]) = guesses.changes.last_mut() {
        // The guess of this change was made when the miss before it was known.
        *change = difference(&missed, &guesses.missed);
    }
    let mut guess: Vec<[f64; 3]> = u.to_vec();
    let mut add = |factor: f64, step: &[[f64; 3]]| {
        for (x, du) in guess.iter_mut().zip(step) {
            *x = [0, 1, 2].map(|k| x[k] + factor * du[k]);
        }
    };
    let weights = match &guesses.changes[..] {
        [] => {
            add(1.0, idle);
            vec![]
        }
        [.., [dv, _]] if growth >= 1.0 => {
            let along = over(dot(dv, &missed), dot(dv, dv));
            add(along / (growth - 1.0).max(f64::EPSILON) - along, dv);
            guesses.begin_anew();
            vec![]
        }
        [[_, a]] => vec![over(dot(a, &missed), dot(a, a))],
        [.., [_, a], [_, b]] => {
            let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
            let (ar, br) = (dot(a, &missed), dot(b, &missed));
            let determinant = aa * bb - ab * ab;
            if determinant > SINGULAR * aa * bb {
                vec![(bb * ar - ab * br) / determinant, (aa * br - ab * ar) / determinant]
            } else {
                vec![0.0, over(br, bb)]
            }
        }
    };
    for (w, [dv, dr]) in weights.iter().zip(&guesses.changes) {
        for ((x, dv), dr) in guess.iter_mut().zip(dv).zip(dr) {
            *x = [0, 1, 2].map(|k| x[k] - w * (dv[k] + dr[k]));
        }
    }
    if guesses.changes.len() == DEPTH {
        guesses.changes.remove(0);
    }
    guesses.changes.push([difference(&guess, &guesses.last), Vec::new()]);
    (guesses.missed, guesses.last) = (missed, guess);
}

/// Reduces the last step of the guess to a part of it.
pub fn shorten(guesses: &mut Guesses, part: f64) {
    let Some([step, _]) = guesses.changes.last_mut() else { return };
    for (x, step) in guesses.last.iter_mut().zip(step) {
        for k in 0..3 {
            x[k] -= (1.0 - part) * step[k];
            step[k] *= part;
        }
    }
    guesses.begin_anew();
}

/// Growth of the last change of the guess in the map from guess to solution, `dv . du / dv . dv`, where
/// `u` is the solution about the last guess. Near a buckling load it is the load over the buckling load.
/// At 1 and above, the end on the line of the change is not stable. 0 before the second pass.
pub fn growth(guesses: &Guesses, u: &[[f64; 3]], radius: f64) -> f64 {
    let Some([dv, _]) = guesses.changes.last() else { return 0.0 };
    let dr = difference(&difference(u, &guesses.last), &guesses.missed);
    let squared = dot(dv, dv, radius);
    if squared > 0.0 { 1.0 + dot(dv, &dr, radius) / squared } else { 0.0 }
}

/// Scalar product of two motions. A rotation counts with the length `radius`, m.
pub fn dot(x: &[[f64; 3]], y: &[[f64; 3]], radius: f64) -> f64 {
    let of =
        |(x, y): (&[f64; 3], &[f64; 3])| x[0] * y[0] + x[1] * y[1] + radius * radius * x[2] * y[2];
    x.iter().zip(y).map(of).sum()
}

/// Square of the sine of two changes below which they count as one.
const SINGULAR: f64 = 1e-10;

/// `x - y`, by body.
pub fn difference(x: &[[f64; 3]], y: &[[f64; 3]]) -> Vec<[f64; 3]> {
    x.iter().zip(y).map(|(x, y)| [0, 1, 2].map(|k| x[k] - y[k])).collect()
}

fn over(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { numerator / denominator } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear map of two unknowns has its fixed point after two changes, even where the plain map
    /// diverges.
    #[test]
    fn a_linear_map_of_two_unknowns_ends_after_two_changes() {
        let map =
            |v: &[[f64; 3]]| vec![[0.9 * v[0][0] + 0.3 * v[0][1] + 1.0, -1.4 * v[0][1] + 2.0, 0.0]];
        let mut guesses = Guesses::default();
        next(&mut guesses, &map(&[[0.0; 3]]), &[], 0.0, 1.0);
        for _ in 0..3 {
            let u = map(&guesses.last);
            next(&mut guesses, &u, &[], 0.0, 1.0);
        }
        let end = [12.5, 2.0 / 2.4, 0.0];
        assert!((guesses.last[0][0] - end[0]).abs() < 1e-9, "{guesses:?}");
        assert!((guesses.last[0][1] - end[1]).abs() < 1e-9, "{guesses:?}");
    }
}
