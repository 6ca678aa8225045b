//! Lemke's method for linear complementarity problems: w = M z + b, w >= 0, z >= 0, w z = 0.
//!
//! With a covering vector d > 0 the problem w = M z + d t + b has the solution z = 0 for a large t.
//! Lemke (1965) lets t fall to zero along a path of pivots: the variable that has left the basis
//! determines the one that enters it. Ties are broken lexicographically, so that no basis is met
//! twice (Cottle, Pang and Stone 1992, section 4.4). If M is copositive the path ends at a solution
//! wherever b lets one exist in the sense of their theorem 4.4.12; otherwise it may end on a ray.

/// Smallest pivot, over the largest entry of the problem.
const PIVOT: f64 = 1e-10;
/// Two ratios that differ by less are tied.
const TIE: f64 = 1e-12;

/// The numbers of the variables that are above zero in a solution: k for w_k, m + k for z_k. `None`
/// if the path ends on a ray, or after `max` pivots.
pub fn basis(matrix: &[Vec<f64>], b: &[f64], cover: &[f64], max: usize) -> Option<Vec<usize>> {
    let m = b.len();
    if b.iter().all(|b| *b >= 0.0) {
        return Some((0..m).collect());
    }
    // Columns: w, z, t, right side.
    let (t, right) = (2 * m, 2 * m + 1);
    let mut rows: Vec<Vec<f64>> = (0..m)
        .map(|i| {
            let mut row = vec![0.0; 2 * m + 2];
            row[i] = 1.0;
            for k in 0..m {
                row[m + k] = -matrix[i][k];
            }
            row[t] = -cover[i];
            row[right] = b[i];
            row
        })
        .collect();
    let largest = matrix.iter().flatten().fold(1.0_f64, |a, x| a.max(x.abs()));
    let mut basic: Vec<usize> = (0..m).collect();
    // t enters where w is lowest in units of the cover.
    let lowest = |i: &usize, j: &usize| (b[*i] / cover[*i]).total_cmp(&(b[*j] / cover[*j]));
    let mut leaving = (0..m).min_by(lowest)?;
    let mut entering = t;
    for _ in 0..max {
        let out = basic[leaving];
        pivot(&mut rows, leaving, entering);
        basic[leaving] = entering;
        if out == t {
            return Some(basic);
        }
        entering = if out < m { out + m } else { out - m };
        let candidates: Vec<usize> =
            (0..m).filter(|i| rows[*i][entering] > PIVOT * largest).collect();
        leaving = first_to_vanish(&rows, &basic, &candidates, entering, m)?;
    }
    None
}

/// The row whose basic variable vanishes first as `entering` grows; t, if it is among them.
fn first_to_vanish(
    rows: &[Vec<f64>],
    basic: &[usize],
    candidates: &[usize],
    entering: usize,
    m: usize,
) -> Option<usize> {
    let mut left = candidates.to_vec();
    // The right side, then the columns of w, which hold the inverse of the basis.
    for column in std::iter::once(2 * m + 1).chain(0..m) {
        let ratio = |i: usize| rows[i][column] / rows[i][entering];
        let least = left.iter().map(|i| ratio(*i)).fold(f64::INFINITY, f64::min);
        left.retain(|i| ratio(*i) <= least + TIE * (1.0 + least.abs()));
        if let Some(row) = left.iter().find(|i| basic[**i] == 2 * m && column == 2 * m + 1) {
            return Some(*row);
        }
        if left.len() < 2 {
            break;
        }
    }
    left.first().copied()
}

fn pivot(rows: &mut [Vec<f64>], row: usize, column: usize) {
    let by = rows[row][column];
    rows[row].iter_mut().for_each(|x| *x /= by);
    let pivotal = rows[row].clone();
    for (i, other) in rows.iter_mut().enumerate() {
        let factor = other[column];
        if i != row && factor != 0.0 {
            for (x, y) in other.iter_mut().zip(&pivotal) {
                *x -= factor * y;
            }
        }
    }
}

/// A problem with one solution, by hand, and one whose matrix is not positive: Murty's example, on
/// which the path takes 2^n pivots, has b = -1 and ones below the diagonal.
#[test]
fn problems_with_known_solutions() {
    let matrix = vec![vec![2.0, 1.0], vec![1.0, 2.0]];
    let mut found = basis(&matrix, &[-5.0, -6.0], &[1.0; 2], 10).unwrap();
    found.sort_unstable();
    assert_eq!(found, [2, 3]);
    let n = 6;
    let murty: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|k| if k > i { 2.0 } else { f64::from(u8::from(k == i)) }).collect())
        .collect();
    let mut found = basis(&murty, &[-1.0; 6], &[1.0; 6], 1000).unwrap();
    found.sort_unstable();
    // z = (0, ..., 0, 1): w = 1 in all rows but the last.
    assert_eq!(found, [0, 1, 2, 3, 4, 2 * n - 1]);
    // w = -z - 1 has none.
    assert_eq!(basis(&[vec![-1.0]], &[-1.0], &[1.0], 10), None);
}
