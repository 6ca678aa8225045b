//! Right side and solution of the bodies of a task, then of those beyond: the task adds to the
//! right side of those, and needs their solution.

use super::fronts::Fronts;

/// Sets the work of a task to the right side, with the contributions of the tasks below it one
/// after the other. `work_of` has the work of those by their number.
pub fn gather_below<'a>(
    fronts: &Fronts,
    task: usize,
    right: &[[f64; 3]],
    work_of: impl Fn(usize) -> &'a [[f64; 3]],
    work: &mut [[f64; 3]],
) {
    let places = &fronts.tasks[task].places;
    let (own, beyond) = work.split_at_mut(places.len());
    own.copy_from_slice(&right[places.clone()]);
    beyond.fill([0.0; 3]);
    for &other in &fronts.below[task] {
        let of_other = &fronts.tasks[other];
        let contributions = &work_of(other)[of_other.places.len()..];
        let at = &fronts.beyond_above[of_other.beyond.clone()];
        for (place, contribution) in at.iter().zip(contributions) {
            for (x, y) in work[*place as usize].iter_mut().zip(contribution) {
                *x += y;
            }
        }
    }
}

/// Copies the solution of the bodies beyond a task from the work of the task above it.
pub fn copy_from_above(fronts: &Fronts, task: usize, above: &[[f64; 3]], work: &mut [[f64; 3]]) {
    let task = &fronts.tasks[task];
    let places = &fronts.beyond_above[task.beyond.clone()];
    for (x, place) in work[task.places.len()..].iter_mut().zip(places) {
        *x = above[*place as usize];
    }
}
