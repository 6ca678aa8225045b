//! Steps without the fast bodies.

use super::super::newton::Step;
use super::super::scaled::{Local, Scaled};
use super::super::settings::LocalSettings;
use super::patches::is_wall;
use crate::adjacency::Adjacency;

/// A step without its fast bodies. Where a few loose bodies move far, the state of their contacts
/// changes at once. These contacts would shorten a step that all other bodies could make.
pub struct SlowPart<const F: usize> {
    /// Which bodies are fast.
    pub fast: Vec<bool>,
    /// The step, zero for fast bodies.
    pub du: Vec<[f64; 3]>,
    /// Kinematics of the step. They are zero for interactions of fast bodies, which are not
    /// counted.
    pub de: Vec<[f64; F]>,
}

impl<const F: usize> SlowPart<F> {
    /// A body is fast if its step exceeds `settings.fast` times the `fast_quantile` of all steps
    /// and it is no wall. `None` where no body is fast.
    pub fn of(
        program: &Scaled,
        adjacency: &Adjacency,
        settings: &LocalSettings,
        step: &Step<F>,
    ) -> Option<Self> {
        let Step { du, de, .. } = step;
        let size = |du: &[f64; 3]| du[0].hypot(du[1]).max(du[2].abs());
        let bodies = &du[..program.free.len()];
        let mut sizes: Vec<f64> = bodies.iter().map(size).collect();
        let last = sizes.len() - 1;
        let place = ((settings.fast_quantile * sizes.len() as f64) as usize).min(last);
        let (_, quantile, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
        let threshold = settings.fast * *quantile;
        let is_fast = |i: usize| {
            size(&du[i]) > threshold
                && !is_wall(adjacency, settings, i)
                && !program.images.is_cell(i)
        };
        let fast: Vec<bool> = (0..bodies.len()).map(is_fast).collect();
        fast.contains(&true).then(|| {
            let slow = |(du, fast): (&[f64; 3], &bool)| if *fast { [0.0; 3] } else { *du };
            let both_slow = |l: &Local| !program.pair(l).iter().any(|i| fast[*i]);
            let mut du: Vec<_> = du.iter().zip(&fast).map(slow).collect();
            program.images.extend(&mut du);
            let counted = |(de, l): (&[f64; F], &Local)| if both_slow(l) { *de } else { [0.0; F] };
            let de = de.iter().zip(&program.locals).map(counted).collect();
            Self { fast, du, de }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::column;
    use super::*;

    /// One of 100 bodies moves ten times further than all others, or none does.
    #[test]
    fn a_body_beyond_the_quantile_is_fast() {
        let natural: Vec<usize> = (0..100).collect();
        let scaled = Scaled::new(&column(99, 0.1), &natural);
        let adjacency = Adjacency::new(100, scaled.locals.iter().map(|l| l.bodies));
        let settings = LocalSettings::default();
        let mut step =
            Step { du: vec![[0.0, 1.0, 0.0]; 100], de: vec![[1.0, 0.0]; 99], length: 0.1 };
        assert!(SlowPart::of(&scaled, &adjacency, &settings, &step).is_none());
        step.du[7] = [0.0, 10.0, 0.0];
        let slow = SlowPart::of(&scaled, &adjacency, &settings, &step).unwrap();
        for i in 0..100 {
            assert_eq!(slow.fast[i], i == 7);
            assert_eq!(slow.du[i], if i == 7 { [0.0; 3] } else { step.du[i] });
        }
        // Interactions 6 and 7 join body 7 to its neighbours.
        for k in 0..99 {
            assert_eq!(slow.de[k][0], if k == 6 || k == 7 { 0.0 } else { 1.0 });
        }
    }
}
