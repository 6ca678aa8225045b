//! Random numbers of a scene, which depend on its seeds alone and not on the machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::scene::format::Sizes;

/// A sequence of random numbers.
pub(super) struct Random(ChaCha8Rng);

impl Random {
    /// One of the independent sequences of a seed. Those of a specimen are 0 and 1.
    pub(super) fn stream(seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Self(random)
    }

    /// A sequence of a seed that belongs to a key of up to 32 bytes, such as those of a place.
    pub(super) fn keyed(key: &[u8], seed: u64) -> Self {
        let mut bytes = [0; 32];
        bytes[..key.len()].copy_from_slice(key);
        let mut random = ChaCha8Rng::from_seed(bytes);
        random.set_stream(seed);
        Self(random)
    }

    pub(super) fn integer(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1): the upper 53 bits.
    pub(super) fn unit(&mut self) -> f64 {
        (self.integer() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(super) fn radius(&mut self, sizes: &Sizes) -> f64 {
        match *sizes {
            Sizes::Equal { radius } => radius,
            Sizes::Uniform { radius: (low, high) } => self.between(low, high),
            Sizes::LogNormal { radius, deviation, limits: (low, high) } => {
                // Box-Muller transform. Values outside the limits are drawn again. After many
                // rejections, when the limits are far from the median, the value is set to the
                // nearest limit.
                for _ in 0..1000 {
                    let (u, v) = (1.0 - self.unit(), self.unit());
                    let normal = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
                    let r = radius * (deviation * normal).exp();
                    if (low..=high).contains(&r) {
                        return r;
                    }
                }
                radius.clamp(low, high)
            }
            // Listed at once, so that the whole packing has the curve.
            Sizes::Sieve { .. } => f64::NAN,
        }
    }
}
