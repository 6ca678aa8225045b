//! Columns of numbers in a page: whole columns behind one another, compressed, as base64.
//!
//! The bytes of a column are split into planes, all lowest bytes first: the higher bytes of
//! neighbours are alike and shrink well. Numbers with two bytes are either `float16` (11 bits:
//! three significant digits) or whole steps of a scale.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;

/// Largest number of steps that fits into this number of bytes. Its opposite less one marks a row
/// that is not in a frame.
pub fn most_steps(width: usize) -> i32 {
    (1 << (8 * width - 1)) - 1
}

/// Columns on their way into a page.
#[derive(Default)]
pub struct Columns(Vec<u8>);

impl Columns {
    fn planes<const N: usize>(&mut self, values: impl Iterator<Item = [u8; N]> + Clone) {
        for k in 0..N {
            self.0.extend(values.clone().map(|bytes| bytes[k]));
        }
    }

    /// Bytes.
    pub fn bytes(&mut self, values: &[u8]) {
        self.0.extend_from_slice(values);
    }

    /// Identities and indices.
    pub fn counts(&mut self, values: &[u32]) {
        self.planes(values.iter().map(|x| x.to_le_bytes()));
    }

    /// Numbers of single precision.
    pub fn numbers(&mut self, values: &[f32]) {
        self.planes(values.iter().map(|x| x.to_le_bytes()));
    }

    /// Numbers over `scale`, rounded to `float16`.
    pub fn halves(&mut self, values: &[f32], scale: f64) {
        let half = |x: &f32| f16::from_f64(f64::from(*x) / scale).to_bits().to_le_bytes();
        self.planes(values.iter().map(half));
    }

    /// Numbers in steps of `step`, of two or three bytes each. Not a number is a row that is not
    /// there; numbers beyond the range are at its end.
    pub fn steps(&mut self, values: &[f32], step: f64, width: usize) {
        let most = most_steps(width);
        let steps = |x: &f32| {
            let limit = f64::from(most);
            let steps = (f64::from(*x) / step).round().clamp(-limit, limit) as i32;
            let [a, b, c, _] = (if x.is_nan() { -most - 1 } else { steps }).to_le_bytes();
            [a, b, c]
        };
        match width {
            2 => self.planes(values.iter().map(|x| [steps(x)[0], steps(x)[1]])),
            _ => self.planes(values.iter().map(steps)),
        }
    }

    /// The text in the page.
    pub fn text(self) -> String {
        // Writing to memory does not fail.
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
        let done = encoder.write_all(&self.0).and_then(|()| encoder.finish());
        BASE64_STANDARD.encode(done.unwrap_or_default())
    }
}

/// Level of the compression. Level 6 takes three times as long and gains 2 %.
const LEVEL: u32 = 1;

/// A scale with which `float16` holds numbers up to `largest`: a power of two, so that it changes
/// no digit. Numbers down to 2e-9 of the largest keep three digits.
pub fn scale(largest: f32) -> f64 {
    if largest > 0.0 && largest.is_finite() {
        2.0_f64.powi(f64::from(largest).log2().ceil() as i32 - 15)
    } else {
        1.0
    }
}
