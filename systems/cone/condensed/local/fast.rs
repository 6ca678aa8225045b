//! Steps without the fast bodies.

use super::super::newton::Step;
use super::super::scaled::Local;
use super::Elimination;

impl Elimination<'_> {
    /// The fast bodies, and a step without them. Where a few loose bodies move far, the state of
    /// their contacts changes at once. These contacts would shorten a step that all other bodies
    /// could make, and their kinematics are not counted: they are zero.
    ///
    /// A body is fast if its step exceeds `settings.fast` times the `fast_quantile` of all steps and
    /// it is not held. `None` where no body is fast.
    pub(super) fn slow_part<const F: usize>(&self, step: &Step<F>) -> Option<(Vec<bool>, Step<F>)> {
        let (Step { du, de, length }, program) = (step, self.program);
        let size = |du: &[f64; 3]| du[0].hypot(du[1]).max(du[2].abs());
        let bodies = &du[..program.free.len()];
        let mut sizes: Vec<f64> = bodies.iter().map(size).collect();
        let last = sizes.len() - 1;
        let place = ((self.settings.fast_quantile * sizes.len() as f64) as usize).min(last);
        let (_, quantile, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
        let threshold = self.settings.fast * *quantile;
        let is_fast = |i: usize| size(&du[i]) > threshold && !self.is_held(i);
        let fast: Vec<bool> = (0..bodies.len()).map(is_fast).collect();
        if !fast.contains(&true) {
            return None;
        }
        let slow = |(du, fast): (&[f64; 3], &bool)| if *fast { [0.0; 3] } else { *du };
        let both_slow = |l: &Local| !program.pair(l).iter().any(|i| fast[*i]);
        let mut du: Vec<_> = du.iter().zip(&fast).map(slow).collect();
        program.images.extend(&mut du);
        let counted = |(de, l): (&[f64; F], &Local)| if both_slow(l) { *de } else { [0.0; F] };
        let de = de.iter().zip(&program.locals).map(counted).collect();
        Some((fast, Step { du, de, length: *length }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::newton::Goal;
    use super::super::super::samples::column;
    use super::super::super::scaled::Scaled;
    use super::super::super::settings::LocalSettings;
    use super::*;

    /// One of 100 bodies moves ten times further than all others, or none does.
    #[test]
    fn a_body_beyond_the_quantile_is_fast() {
        let scaled = Scaled::natural(&column(99, 0.1));
        let settings = LocalSettings::default();
        let goal = Goal { unbalance: 0.0, min_force: 0.0 };
        let elimination = Elimination::new(&scaled, &settings, goal, false);
        let mut step =
            Step { du: vec![[0.0, 1.0, 0.0]; 100], de: vec![[1.0, 0.0]; 99], length: 0.1 };
        assert!(elimination.slow_part(&step).is_none());
        step.du[7] = [0.0, 10.0, 0.0];
        let (fast, slow) = elimination.slow_part(&step).unwrap();
        for i in 0..100 {
            assert_eq!(fast[i], i == 7);
            assert_eq!(slow.du[i], if i == 7 { [0.0; 3] } else { step.du[i] });
        }
        // Interactions 6 and 7 join body 7 to its neighbours.
        for k in 0..99 {
            assert_eq!(slow.de[k][0], if k == 6 || k == 7 { 0.0 } else { 1.0 });
        }
    }
}
