//! Random numbers that depend only on a seed, by which a failed test can name its scene.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Random choices.
pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A number with uniform distribution of its logarithm.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    /// An integer below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        (self.unit() * f64::from(n)) as u32
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    pub fn pick<T: Clone>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u32) as usize].clone()
    }

    pub fn maybe<T>(&mut self, probability: f64, value: impl FnOnce(&mut Self) -> T) -> Option<T> {
        self.chance(probability).then(|| value(self))
    }
}

/// Number of cases: `CLASTIC_CASES` if it is set.
pub fn cases(default: u64) -> u64 {
    match std::env::var("CLASTIC_CASES") {
        Ok(text) => text.parse().expect("CLASTIC_CASES is a number of cases"),
        Err(_) => default,
    }
}

/// Seeds of the cases: `CLASTIC_SEED` if it is set, else the numbers of the cases.
pub fn seeds(default: u64) -> std::ops::Range<u64> {
    match std::env::var("CLASTIC_SEED") {
        Ok(text) => {
            let seed = text.parse().expect("CLASTIC_SEED is a number");
            seed..seed + 1
        }
        Err(_) => 0..cases(default),
    }
}

/// A number for every run of the tests, or a larger one if `CLASTIC_FULL` is set.
pub fn full(short: u32, long: u32) -> u32 {
    if std::env::var_os("CLASTIC_FULL").is_some() { long } else { short }
}
